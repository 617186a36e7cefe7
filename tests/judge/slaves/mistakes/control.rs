//! Global_Control.

use super::*;

pub(super) static CONTROLLED: &[Mistake] = &[
    Mistake {
        name: "Sync lets outputs through",
        rows: &["S-S01"],
        hears: |slave, octets| {
            if is_exchange(&octets) && slave.state() == State::DataExch {
                let sync = changed(&prm(0, [0, 0]), |telegram, data| {
                    telegram.fc = FunctionCode::from_octet(0x46);
                    telegram.dsap = Sap::new(58);
                    *data = vec![0x20, 0];
                });
                slave.memory = sync;
            }
            octets
        },
        does: |slave, octets| {
            let synced = slave.framed.station().slave().diagnosis().sync_mode;
            if is_exchange(octets) && synced && data(octets).first() != Some(&0) {
                let sync = slave.memory.clone();
                slave.framed.handle_bytes(slave.now, &sync);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "Unsync keeps the old outputs",
        rows: &["S-S01"],
        hears: |slave, octets| {
            if is_exchange(&octets) {
                slave.count = 0;
            }
            if controls(&octets) && data(&octets).first() == Some(&0x10) {
                slave.count = 1;
                slave.memory = slave.framed.station().slave().outputs().to_vec();
            }
            octets
        },
        says: |slave, reply| {
            let old = slave.memory.clone();
            if slave.count == 1 && Slave::dsap(&slave.request) == RD_OUTP && data(&reply).len() == 4 {
                return changed(&reply, |_, data| *data = old);
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "Freeze holds nothing",
        rows: &["S-S02"],
        says: |slave, reply| {
            if is_exchange(&slave.request) && data(&reply).len() == 4 && slave.state() == State::DataExch {
                let now = slave.framed.station().slave().outputs().to_vec();
                return changed(&reply, |_, data| *data = now);
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "Sync wins over Unsync",
        rows: &["S-S03"],
        hears: |_, octets| {
            if controls(&octets) && data(&octets).first() == Some(&0x30) {
                return changed(&octets, |_, data| data[0] = 0x20);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Freeze wins over Unfreeze",
        rows: &["S-S03"],
        hears: |_, octets| {
            if controls(&octets) && data(&octets).first() == Some(&0x0C) {
                return changed(&octets, |_, data| data[0] = 0x08);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Clear_Data is ignored",
        rows: &["S-S04"],
        hears: |_, octets| {
            let is_dropped = controls(&octets) && data(&octets).first() == Some(&0x02);
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "Clear_Data ends data exchange",
        rows: &["S-S04"],
        does: |slave, octets| {
            if controls(octets) && data(octets).first() == Some(&0x02) {
                leaves(slave);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "groups are not looked at",
        rows: &["S-S05"],
        hears: |_, octets| {
            if controls(&octets) && data(&octets).len() == 2 {
                return changed(&octets, |_, data| data[1] = 0);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "only one group is known",
        rows: &["S-S05"],
        hears: |_, octets| {
            let is_dropped = controls(&octets) && data(&octets).get(1) == Some(&0x04);
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "Global_Control of any master counts",
        rows: &["S-S06"],
        hears: |_, octets| {
            if controls(&octets) {
                return changed(&octets, |data, _| data.sa = Address::from_octet(OWNER));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Sync in WAIT-CFG counts",
        rows: &["S-S07"],
        does: |slave, octets| {
            if controls(octets) && slave.state() == State::WaitCfg && data(octets).first() == Some(&0x20) {
                slave.count = 1;
            }
            if is_exchange(octets) || Slave::dsap(octets) == SET_PRM {
                slave.count = 0;
            }
        },
        says: |slave, reply| {
            let synced = slave.count > 0;
            diag(slave, &reply, |octets| octets[1] |= if synced { 0x20 } else { 0 })
        },
        ..RIGHT
    },
    Mistake {
        name: "reserved bits of Global_Control are not looked at",
        rows: &["S-S08"],
        policy: |policy| policy.check_reserved_control_bits = false,
        ..RIGHT
    },
    Mistake {
        name: "Global_Control with three octets is carried out",
        rows: &["S-S08"],
        hears: |_, octets| {
            if controls(&octets) && data(&octets).len() == 3 {
                return changed(&octets, |_, data| data.truncate(2));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Global_Control to its own address is ignored",
        rows: &["S-S09"],
        hears: |_, octets| {
            let own = parsed(&octets).is_some_and(|data| data.da.number() == SLAVE);
            let is_dropped = controls(&octets) && own;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "Sync without Sync_Req counts",
        rows: &["S-S10"],
        hears: |_, octets| {
            let locks = data(&octets).first().is_some_and(|status| status & 0xC0 == 0x80);
            if Slave::dsap(&octets) == SET_PRM && locks {
                return changed(&octets, |_, data| data[0] |= 0x20);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Sync outlives its master",
        rows: &["S-S11"],
        does: |slave, octets| {
            let command = data(octets).first().copied().unwrap_or(0);
            if controls(octets) && slave.state() == State::DataExch && command & 0x30 != 0 {
                let on = command & 0x30 == 0x20;
                slave.count = u32::from(on && slave.framed.station().slave().diagnosis().sync_mode);
            }
        },
        says: |slave, reply| {
            let synced = slave.count > 0 && slave.state() == State::DataExch;
            diag(slave, &reply, |octets| octets[1] |= if synced { 0x20 } else { 0 })
        },
        ..RIGHT
    },
    Mistake {
        name: "Freeze that the file promises is not there",
        rows: &["S-K05"],
        says: |slave, reply| diag(slave, &reply, |octets| octets[1] &= !0x10),
        ..RIGHT
    },
];
