//! Set_Prm.

use super::*;

pub(super) static PARAMETERS: &[Mistake] = &[
    Mistake {
        name: "a wrong ident number is not answered",
        rows: &["S-P02"],
        hears: |slave, octets| {
            let wrong = Slave::dsap(&octets) == SET_PRM && data(&octets).get(4) == Some(&0xED);
            let is_dropped = wrong && slave.framed.station().slave().owner().is_none();
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "the ident number is not looked at",
        rows: &["S-P02"],
        hears: |_, octets| {
            if Slave::dsap(&octets) != SET_PRM {
                return octets;
            }
            changed(&octets, |_, data| {
                if data.len() > 5 {
                    (data[4], data[5]) = (0x12, 0x34);
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Prm_Fault is never set",
        rows: &["S-P02"],
        says: |slave, reply| diag(slave, &reply, |octets| octets[0] &= !0x40),
        ..RIGHT
    },
    Mistake {
        name: "six octets of Set_Prm are enough",
        rows: &["S-P03"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM && data(&octets).len() == 6 {
                return changed(&octets, |_, data| data.extend([0, 1, 2]));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "user parameters may be too short",
        rows: &["S-P03"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM && data(&octets).len() == 8 {
                return changed(&octets, |_, data| data.push(2));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "user parameters may be too long",
        rows: &["S-P03"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM && data(&octets).len() == 10 {
                return changed(&octets, |_, data| data.truncate(9));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Unlock is not carried out",
        rows: &["S-P04"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM && data(&octets).first() == Some(&0x40) {
                return changed(&octets, |_, data| data[0] = 0);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Lock wins over Unlock",
        rows: &["S-P04"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM && data(&octets).first() == Some(&0xC0) {
                return changed(&octets, |_, data| data[0] = 0x80);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "neither Lock nor Unlock releases",
        rows: &["S-P04"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM && data(&octets).first() == Some(&0) {
                return changed(&octets, |_, data| data[0] = 0x40);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "neither Lock nor Unlock, and the ident number must be right",
        rows: &["S-P05"],
        hears: |_, octets| {
            let wrong = data(&octets).get(4) == Some(&0xED) && data(&octets).first() == Some(&0);
            if Slave::dsap(&octets) == SET_PRM && wrong {
                return changed(&octets, |_, data| data[0] = 0x80);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "min T_SDR of 0 is 11",
        rows: &["S-P06"],
        hears: |_, octets| {
            let locks = data(&octets).first().is_some_and(|status| status & 0x80 != 0);
            if Slave::dsap(&octets) == SET_PRM && locks && data(&octets).get(3) == Some(&0) {
                return changed(&octets, |_, data| data[3] = 11);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "min T_SDR is not taken over",
        rows: &["S-P07"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM && data(&octets).len() > 6 {
                return changed(&octets, |_, data| data[3] = 11);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "another master takes a locked slave",
        rows: &["S-P08"],
        hears: |slave, octets| {
            if Slave::dsap(&octets) == SET_PRM && sa(&octets) == OTHER && data(&octets).first() == Some(&0x80)
            {
                slave.takes(&prm(0x40, [0, 0]));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "another master releases a locked slave",
        rows: &["S-P08"],
        hears: |slave, octets| {
            if Slave::dsap(&octets) == SET_PRM && sa(&octets) == OTHER && data(&octets).first() == Some(&0x40)
            {
                slave.takes(&prm(0x40, [0, 0]));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "after Unlock only the old master is accepted",
        rows: &["S-P09"],
        says: |slave, reply| {
            let by_other = Slave::dsap(&slave.request) == SET_PRM && sa(&slave.request) == OTHER;
            if by_other && slave.framed.station().slave().owner().is_some_and(|owner| owner.number() == OTHER)
            {
                slave.station().abort();
                return refused(slave);
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "a second Set_Prm in data exchange is a fault",
        rows: &["S-P10"],
        hears: |slave, octets| {
            let again = Slave::dsap(&octets) == SET_PRM && data(&octets).first() == Some(&0x80);
            if again
                && sa(&octets) == OWNER
                && slave.state() == State::DataExch
                && data(&octets).get(3) == Some(&11)
                && data(&octets).get(4) == Some(&0x12)
            {
                return changed(&octets, |_, data| data[4] = 0);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "in WAIT-CFG the last Set_Prm wins, whoever sends it",
        rows: &["S-P11"],
        hears: |slave, octets| {
            if Slave::dsap(&octets) == SET_PRM && sa(&octets) == OTHER && slave.state() == State::WaitCfg {
                slave.takes(&prm(0x40, [0, 0]));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Sync is not there, and Not_Supported is not said",
        rows: &["S-P12"],
        file: PLAIN,
        says: |slave, reply| diag(slave, &reply, |octets| octets[0] &= !0x10),
        ..RIGHT
    },
    Mistake {
        name: "reserved bits of Station_Status are not looked at",
        rows: &["S-P13"],
        policy: |policy| policy.check_reserved_prm_bits = false,
        ..RIGHT
    },
    Mistake {
        name: "a watchdog of zero is none",
        rows: &["S-P14"],
        policy: |policy| policy.watchdog_factor_zero = WatchdogFactorZero::Off,
        ..RIGHT
    },
    Mistake {
        name: "Prm_Fault stays",
        rows: &["S-P15"],
        says: |slave, reply| {
            let set = slave.count > 0;
            let said = diag(slave, &reply, |octets| octets[0] |= if set { 0x40 } else { 0 });
            if Slave::dsap(&slave.request) == SLAVE_DIAG {
                slave.count = u32::from(data(&said).first().is_some_and(|octet| octet & 0x40 != 0));
                if slave.state() == State::DataExch {
                    slave.count = 0;
                }
            }
            said
        },
        ..RIGHT
    },
    Mistake {
        name: "Group_Ident is taken over without Lock",
        rows: &["S-P16"],
        hears: |_, octets| {
            let none = data(&octets).first() == Some(&0) && data(&octets).get(6) == Some(&2);
            if Slave::dsap(&octets) == SET_PRM && none {
                return changed(&octets, |_, data| data[0] = 0xA0);
            }
            octets
        },
        does: |slave, octets| {
            // It stays in data exchange.
            if Slave::dsap(octets) == SET_PRM && data(octets).get(6) == Some(&2) {
                let cfg = changed(&prm(0, [0, 0]), |telegram, data| {
                    telegram.dsap = Sap::new(62);
                    *data = vec![0xF1];
                });
                let again = slave.reply.clone();
                slave.takes(&cfg);
                let _ = again;
                slave.say(Duration::from_micros(40), &[0xE5]);
            }
        },
        ..RIGHT
    },
];
