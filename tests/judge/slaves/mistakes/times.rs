//! Times, and the device file.

use super::*;

pub(super) static TIMES: &[Mistake] = &[
    Mistake {
        name: "it answers after max T_SDR",
        rows: &["S-T01"],
        late: |slave| if slave.request.len() == 6 { Duration::from_micros(250) } else { Duration::ZERO },
        ..RIGHT
    },
    Mistake {
        name: "it answers after T_SL",
        rows: &["S-T02"],
        late: |slave| {
            if Slave::dsap(&slave.request) == GET_CFG { Duration::from_micros(600) } else { Duration::ZERO }
        },
        ..RIGHT
    },
    Mistake {
        name: "it answers twice",
        rows: &["S-T02"],
        does: |slave, octets| {
            let asks = Slave::dsap(octets) == GET_CFG && data(octets).is_empty();
            if asks && service(octets) == Some(Service::SrdHigh) {
                slave.say(Duration::from_micros(290), &[0xE5]);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "the configuration has a module that is not in the file",
        rows: &["S-K02"],
        told: Some(
            "Freeze_Mode_supp=1\nSync_Mode_supp=1\nSet_Slave_Add_supp=1\nModule=\"other\" 0xF2\nEndModule\n",
        ),
        ..RIGHT
    },
    Mistake {
        name: "the ident number is not that of the file",
        rows: &["S-K01"],
        says: |slave, reply| diag(slave, &reply, |octets| octets[5] = 0x35),
        ..RIGHT
    },
    Mistake {
        name: "the rate is not that of the file",
        rows: &["S-K07"],
        told: Some(
            "500_supp=0\n9.6_supp=1\nFreeze_Mode_supp=1\nSync_Mode_supp=1\nSet_Slave_Add_supp=1\nModule=\"2 words\" 0xF1\nEndModule\n",
        ),
        ..RIGHT
    },
    Mistake {
        name: "a module of the file is not accepted",
        rows: &["S-K08"],
        file: MODULAR,
        hears: |_, octets| {
            if Slave::dsap(&octets) == CHK_CFG && data(&octets) == [0xF0] {
                return changed(&octets, |_, data| *data = vec![0x7F]);
            }
            octets
        },
        ..RIGHT
    },
];
