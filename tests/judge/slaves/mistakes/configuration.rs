//! Chk_Cfg and Get_Cfg.

use super::*;

pub(super) static CONFIGURATION: &[Mistake] = &[
    Mistake {
        name: "every configuration is accepted",
        rows: &["S-G02"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == CHK_CFG && !data(&octets).is_empty() && octets[0] == 0x68 {
                return changed(&octets, |_, data| *data = vec![0xF1]);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "a configuration may be longer",
        rows: &["S-G02"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == CHK_CFG && data(&octets).first() == Some(&0xF1) {
                return changed(&octets, |_, data| data.truncate(1));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Cfg_Fault is never set",
        rows: &["S-G02"],
        says: |slave, reply| diag(slave, &reply, |octets| octets[0] &= !0x04),
        ..RIGHT
    },
    Mistake {
        name: "Cfg_Fault stays after a good Chk_Cfg",
        rows: &["S-G02"],
        says: |slave, reply| {
            let sticks = slave.count > 0 && slave.state() == State::DataExch;
            let said = diag(slave, &reply, |octets| octets[0] |= if sticks { 0x04 } else { 0 });
            if Slave::dsap(&slave.request) == SLAVE_DIAG {
                slave.count = u32::from(data(&said).first().is_some_and(|octet| octet & 0x04 != 0));
            }
            said
        },
        ..RIGHT
    },
    Mistake {
        name: "an empty configuration leads to data exchange",
        rows: &["S-G02"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == CHK_CFG && data(&octets).is_empty() {
                return changed(&octets, |_, data| *data = vec![0xF1]);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Chk_Cfg without Set_Prm leads to data exchange",
        rows: &["S-G03"],
        hears: |slave, octets| {
            if Slave::dsap(&octets) == CHK_CFG && slave.state() == State::WaitPrm {
                slave.takes(&prm(0x80, [0, 0]));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Chk_Cfg of any master counts",
        rows: &["S-G04"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == CHK_CFG && sa(&octets) == OTHER {
                return changed(&octets, |data, _| data.sa = Address::from_octet(OWNER));
            }
            octets
        },
        says: |slave, reply| {
            let sa = sa(&slave.request);
            changed(&reply, |data, _| data.da = Address::from_octet(sa))
        },
        ..RIGHT
    },
    Mistake {
        name: "a good Chk_Cfg in data exchange ends it",
        rows: &["S-G05"],
        hears: |slave, octets| {
            let checks = Slave::dsap(&octets) == CHK_CFG && sa(&octets) == OWNER;
            if checks && slave.state() == State::DataExch && octets != slave.memory {
                slave.takes(&prm(0x40, [0, 0]));
            }
            slave.memory.clone_from(&octets);
            octets
        },
        policy: |policy| policy.chk_cfg_in_wait_prm = NoEffect::Acknowledged,
        ..RIGHT
    },
    Mistake {
        name: "a bad Chk_Cfg in data exchange is ignored",
        rows: &["S-G05"],
        hears: |slave, octets| {
            if Slave::dsap(&octets) == CHK_CFG && slave.state() == State::DataExch {
                return changed(&octets, |_, data| *data = vec![0xF1]);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Get_Cfg is for the owner only",
        rows: &["S-G08"],
        says: |slave, reply| {
            let owner = slave.framed.station().slave().owner().map(Address::number);
            let asks = Slave::dsap(&slave.request) == GET_CFG && owner.is_some();
            if asks && owner != Some(sa(&slave.request)) { refused(slave) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "Get_Cfg is closed in data exchange",
        rows: &["S-G08"],
        says: |slave, reply| {
            let asks = Slave::dsap(&slave.request) == GET_CFG && slave.state() == State::DataExch;
            if asks { refused(slave) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "Get_Cfg may have data",
        rows: &["S-G09"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == GET_CFG && !data(&octets).is_empty() {
                return changed(&octets, |_, data| data.clear());
            }
            octets
        },
        ..RIGHT
    },
];
