//! Set_Slave_Add.

use super::*;

pub(super) static ADDRESSES: &[Mistake] = &[
    Mistake {
        name: "an ident number is as good as another",
        rows: &["S-A02"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_SLAVE_ADD && data(&octets).first() != Some(&SLAVE) {
                return changed(&octets, |_, data| (data[1], data[2]) = (0x12, 0x34));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "it moves in data exchange",
        rows: &["S-A02"],
        hears: |slave, octets| {
            if Slave::dsap(&octets) == SET_SLAVE_ADD && slave.state() == State::DataExch {
                slave.takes(&prm(0x40, [0, 0]));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "it answers at its old address, too",
        rows: &["S-A01"],
        hears: |slave, octets| {
            let old = parsed(&octets).is_some_and(|data| data.da.number() == SLAVE);
            if old && slave.address() != SLAVE && Slave::dsap(&octets) == SLAVE_DIAG {
                let reply = changed(&RS, |telegram, data| {
                    (telegram.dsap, telegram.ssap) = (Sap::new(62), Sap::new(60));
                    telegram.fc = FunctionCode::from_octet(0x08);
                    *data = vec![0x02, 0x05, 0x00, 0xFF, 0x12, 0x34];
                });
                slave.say(Duration::from_micros(40), &reply);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "No_Add_Chg is forgotten",
        rows: &["S-A03"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_SLAVE_ADD {
                return changed(&octets, |_, data| data[3] = 0);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Set_Slave_Add is acknowledged and not there",
        rows: &["S-A04"],
        file: PLAIN,
        says: |slave, reply| if Slave::dsap(&slave.request) == SET_SLAVE_ADD { vec![0xE5] } else { reply },
        ..RIGHT
    },
    Mistake {
        name: "the address is forgotten",
        rows: &["S-A05"],
        acts: |slave, action| {
            slave.forgets = action == "power-cycle";
            false
        },
        ..RIGHT
    },
    Mistake {
        name: "address 0 is none",
        rows: &["S-A06"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_SLAVE_ADD && data(&octets).first() == Some(&0) {
                return changed(&octets, |_, data| data[1] = 0);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Set_Slave_Add that the file promises is not there",
        rows: &["S-K06"],
        file: "Freeze_Mode_supp=1\nSync_Mode_supp=1\nModule=\"2 words\" 0xF1\nEndModule\n",
        told: Some(FULL),
        ..RIGHT
    },
];
