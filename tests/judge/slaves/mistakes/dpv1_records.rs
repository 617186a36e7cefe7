//! DP-V1: records, the life of MS1, identification.

use super::dpv1::{
    MS1, SC, V1, all_of_v1, is_poll_51, is_request, is_rs, prm_octet, response, said, status, v1,
};
use super::*;

/// A job at SAP 51 on record 10 of slot 1.
fn is_of_10(slave: &Slave, function: u8) -> bool {
    slave.job.starts_with(&[function, 1, 10])
}

/// The data of the record of this index in slot 1.
fn record(slave: &mut Slave, index: u8) -> &mut crate::record_table::Record {
    slave.framed.records.records.get_mut(&(1, index)).unwrap()
}

pub(super) static RECORDS: &[Mistake] = &[
    Mistake {
        name: "Read gives one octet less",
        rows: &["V1-R18"],
        file: V1,
        says: |slave, reply| {
            let is_it = is_of_10(slave, 0x5E);
            said(slave, reply, MS1, |data| {
                if is_it && data[0] == 0x5E {
                    data.pop();
                    data[3] -= 1;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Read gives the octets of another record",
        rows: &["V1-R18"],
        file: V1,
        says: |slave, reply| {
            let is_it = is_of_10(slave, 0x5E);
            said(slave, reply, MS1, |data| data[2] += u8::from(is_it))
        },
        ..RIGHT
    },
    Mistake {
        name: "Read with 240 is refused where the record is shorter",
        rows: &["V1-R19"],
        file: V1,
        says: |slave, reply| {
            let is_it = slave.job == [0x5E, 1, 10, 240];
            said(slave, reply, MS1, |data| {
                if is_it {
                    *data = vec![0xDE, 0x80, 0xB7, 0];
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Read with less gives the last octets",
        rows: &["V1-R20"],
        file: V1,
        says: |slave, reply| {
            let is_it = slave.job == [0x5E, 1, 10, 1];
            said(slave, reply, MS1, |data| {
                if is_it && data[0] == 0x5E {
                    data[4] += 3;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "an unknown index is an unknown slot",
        rows: &["V1-R21"],
        file: V1,
        says: |slave, reply| {
            let sap = Slave::dsap(&slave.request).filter(|sap| *sap <= 51);
            said(slave, reply, sap, |data| {
                if data.starts_with(&[0xDE, 0x80, 0xB0]) {
                    data[2] = 0xB2;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "an unknown slot is an unknown index",
        rows: &["V1-R22"],
        file: V1,
        says: |slave, reply| {
            let sap = Slave::dsap(&slave.request).filter(|sap| *sap <= 51);
            said(slave, reply, sap, |data| {
                if data.starts_with(&[0xDE, 0x80, 0xB2]) {
                    data[2] = 0xB0;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "a Write is acknowledged and not done",
        rows: &["V1-R23"],
        file: V1,
        does: |slave, _| record(slave, 10).data = vec![1, 2, 3, 4],
        ..RIGHT
    },
    Mistake {
        name: "a Write is answered with length 0",
        rows: &["V1-R23"],
        file: V1,
        says: |slave, reply| {
            let is_it = is_of_10(slave, 0x5F);
            said(slave, reply, MS1, |data| data[3] *= u8::from(!is_it))
        },
        ..RIGHT
    },
    Mistake {
        name: "a Write may be shorter than the record",
        rows: &["V1-R24"],
        file: V1,
        hears: |_, octets| {
            if data(&octets).starts_with(&[0x5F, 1, 10, 3]) {
                return changed(&octets, |_, data| {
                    data[3] = 4;
                    data.push(0);
                });
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "a record that can only be read is written",
        rows: &["V1-R25"],
        file: V1,
        does: |slave, _| record(slave, 11).read_only = false,
        ..RIGHT
    },
    Mistake {
        name: "a record that can only be written is read",
        rows: &["V1-R26"],
        file: V1,
        does: |slave, _| record(slave, 12).write_only = false,
        ..RIGHT
    },
    Mistake {
        name: "Read with length 0 gives all",
        rows: &["V1-R27"],
        file: V1,
        hears: |_, octets| {
            if data(&octets) == [0x5E, 1, 10, 0] {
                return changed(&octets, |_, data| data[3] = 240);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "239 octets are the most",
        rows: &["V1-R28"],
        file: V1,
        says: |slave, reply| {
            said(slave, reply, MS1, |data| {
                if data.len() == 244 {
                    data.pop();
                    data[3] -= 1;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "C1_Max_Data_Len is not kept",
        rows: &["V1-R29"],
        file: V1,
        told: Some(all_of_v1!("C1_Max_Data_Len=32")),
        ..RIGHT
    },
    Mistake {
        name: "an unknown function is acknowledged as if it were one",
        rows: &["V1-R30"],
        file: V1,
        says: |slave, reply| {
            let is_it = slave.job.first() == Some(&0x4D);
            said(slave, reply, MS1, |data| data[0] &= if is_it { 0x7F } else { 0xFF })
        },
        ..RIGHT
    },
    Mistake {
        name: "a Read of two octets is not answered",
        rows: &["V1-R30"],
        file: V1,
        hears: |_, octets| {
            let is_dropped = Slave::dsap(&octets) == MS1 && data(&octets).len() == 2;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "a negative response has three octets",
        rows: &["V1-R31"],
        file: V1,
        says: |slave, reply| {
            let sap = Slave::dsap(&slave.request).filter(|sap| *sap <= 51);
            said(slave, reply, sap, |data| {
                if data[0] & 0x80 != 0 {
                    data.truncate(3);
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Error_Decode is 0",
        rows: &["V1-R31"],
        file: V1,
        says: |slave, reply| {
            let sap = Slave::dsap(&slave.request).filter(|sap| *sap <= 51);
            said(slave, reply, sap, |data| {
                if data[0] & 0x80 != 0 {
                    data[1] = 0;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "RR while a slow record is read",
        rows: &["V1-R32"],
        file: V1,
        says: |slave, reply| {
            if is_poll_51(slave) && slave.job.starts_with(&[0x5E, 1, 14]) && reply == SC {
                status(slave, 2)
            } else {
                reply
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "a record keeps what it had at power on",
        rows: &["V1-R33"],
        file: V1,
        acts: |_, action| action.starts_with("set-record"),
        ..RIGHT
    },
    Mistake {
        name: "a record takes longer than C1_Response_Timeout",
        rows: &["V1-K01"],
        file: V1,
        told: Some(all_of_v1!("C1_Response_Timeout=5")),
        ..RIGHT
    },
];

pub(super) static LIFE: &[Mistake] = &[
    Mistake {
        name: "the response comes behind a new start",
        rows: &["V1-R34"],
        file: V1,
        does: |slave, octets| {
            if is_request(slave) {
                slave.memory = vec![1];
            } else if prm_octet(octets, 0) & 0x40 != 0 && slave.memory == [1] {
                slave.memory = vec![2];
            }
        },
        says: |slave, reply| {
            if is_poll_51(slave) && !is_rs(&reply) {
                let is_old = slave.memory == [2];
                slave.memory.clear();
                if is_old {
                    return response(slave, &[0xDE, 0x80, 0xB0, 0]);
                }
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "SAP 51 stays open behind the watchdog",
        rows: &["V1-R35"],
        file: V1,
        does: |slave, octets| {
            if Slave::dsap(octets) == SET_PRM {
                slave.count = u32::from(prm_octet(octets, 0) & 0x88 == 0x88);
            }
        },
        says: |slave, reply| {
            let left =
                slave.count == 1 && slave.state() == State::WaitPrm && Slave::dsap(&slave.request) == MS1;
            if left && is_rs(&reply) { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "SAP 51 stays open behind a wrong Set_Prm",
        rows: &["V1-R36"],
        file: V1,
        does: |slave, octets| {
            if Slave::dsap(octets) == SET_PRM {
                slave.count = u32::from(prm_octet(octets, 4) == 0xED);
            }
        },
        says: |slave, reply| {
            let left = slave.count == 1 && Slave::dsap(&slave.request) == MS1;
            if left && is_rs(&reply) { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "the response comes behind a new Set_Prm",
        rows: &["V1-R37"],
        file: V1,
        does: |slave, octets| {
            if is_request(slave) {
                slave.memory = vec![1];
            } else if prm_octet(octets, 0) & 0xC0 == 0x80 && slave.memory == [1] {
                slave.memory = vec![2];
            } else if prm_octet(octets, 0) & 0x40 != 0 {
                slave.memory.clear();
            }
        },
        says: |slave, reply| {
            if is_poll_51(slave) && !is_rs(&reply) {
                let is_old = slave.memory == [2];
                slave.memory.clear();
                if is_old {
                    return response(slave, &[0xDE, 0x80, 0xB0, 0]);
                }
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "Clear closes SAP 51",
        rows: &["V1-R38"],
        file: V1,
        does: |slave, octets| {
            if controls(octets) {
                slave.count = u32::from(data(octets).first() == Some(&0x02));
            }
        },
        says: |slave, reply| {
            if slave.count == 1 && Slave::dsap(&slave.request) == MS1 { status(slave, 3) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "RR in WAIT-CFG",
        rows: &["V1-R39"],
        file: V1,
        says: |slave, reply| {
            let waits = slave.state() == State::WaitCfg && Slave::dsap(&slave.request) == MS1;
            if waits { status(slave, 2) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "its first master is served for ever",
        rows: &["V1-R40"],
        file: V1,
        says: |slave, reply| {
            let owner = slave.framed.station().slave().owner().map(|owner| owner.number());
            let old =
                owner == Some(OTHER) && sa(&slave.request) == OWNER && Slave::dsap(&slave.request) == MS1;
            if old && is_rs(&reply) { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
];

pub(super) static IDENTIFIED: &[Mistake] = &[
    Mistake {
        name: "ORDER_ID of I&M0 is no text",
        rows: &["V1-R83"],
        file: V1,
        says: |slave, reply| {
            said(slave, reply, MS1, |data| {
                if data.starts_with(&[0x5E, 0, 255]) && data.len() == 72 {
                    data[22] = 1;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "record 255 is read without a call",
        rows: &["V1-R84"],
        file: V1,
        says: |slave, reply| {
            let is_it = slave.job.starts_with(&[0x5E, 0, 255]);
            said(slave, reply, MS1, |data| {
                if is_it && data[0] == 0xDE {
                    *data = vec![0x5E, 0, 255, 1, 0];
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "every call is one of I&M0",
        rows: &["V1-R85"],
        file: V1,
        hears: |_, octets| {
            if data(&octets) == [0x5F, 0, 255, 4, 8, 0, 0xFE, 0xAF] {
                return changed(&octets, |_, data| (data[6], data[7]) = (0xFD, 0xE8));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "I&M2 is named and not there",
        rows: &["V1-I01"],
        file: V1,
        hears: |_, octets| {
            if data(&octets) == [0x5F, 0, 255, 4, 8, 0, 0xFD, 0xEA] {
                return changed(&octets, |_, data| (data[6], data[7]) = (0xFE, 0x80));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "I&M1 is not kept",
        rows: &["V1-R86"],
        file: V1,
        does: |slave, _| slave.framed.records.kept.clear(),
        ..RIGHT
    },
    Mistake {
        name: "a plain station has a record 47",
        rows: &["V1-R87"],
        file: V1,
        says: |slave, reply| {
            let is_it = slave.job.starts_with(&[0x5E, 0, 47]);
            said(slave, reply, MS1, |data| {
                if is_it {
                    *data = vec![0x5E, 0, 47, 1, 0];
                }
            })
        },
        ..RIGHT
    },
];
