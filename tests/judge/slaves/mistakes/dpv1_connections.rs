//! DP-V1: connections.

use super::dpv1::{SC, V1, all_of_v1, is_poll, is_rs, prm_octet, said, status, v1};
use super::*;

const NO_MS2: &str = v1!("C1_Read_Write_supp=1");

/// The telegram is for a connection.
fn on_connection(slave: &Slave) -> bool {
    Slave::dsap(&slave.request).is_some_and(|sap| sap < 49)
}

/// The reply on a connection with other data, if it has any.
fn said_there(slave: &Slave, reply: Vec<u8>, change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let sap = Slave::dsap(&slave.request).filter(|sap| *sap < 49);
    if sap.is_none() { reply } else { said(slave, reply, sap, change) }
}

fn is_initiate(octets: &[u8]) -> bool {
    Slave::dsap(octets) == Some(49) && data(octets).first() == Some(&0x57)
}

fn is_abort(slave: &Slave) -> bool {
    on_connection(slave) && data(&slave.request).first() == Some(&0x58)
}

pub(super) static CONNECTIONS: &[Mistake] = &[
    Mistake {
        name: "SAP 49 answers although the file has no MS2",
        rows: &["V1-R68"],
        file: NO_MS2,
        says: |slave, reply| if Slave::dsap(&slave.request) == Some(49) { SC.to_vec() } else { reply },
        ..RIGHT
    },
    Mistake {
        name: "the SAP of a connection is none",
        rows: &["V1-R69"],
        file: V1,
        says: |slave, reply| said(slave, reply, Some(49), |data| data[1] = 60),
        ..RIGHT
    },
    Mistake {
        name: "Max_Len_Data_Unit is another than in the file",
        rows: &["V1-R70"],
        file: V1,
        told: Some(all_of_v1!("C2_Max_Data_Len=100")),
        ..RIGHT
    },
    Mistake {
        name: "errors on a connection are others",
        rows: &["V1-R71"],
        file: V1,
        says: |slave, reply| {
            said_there(slave, reply, |data| {
                if data[0] == 0xDE {
                    data[2] ^= 1;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Idle is answered with something else",
        rows: &["V1-R72"],
        file: V1,
        says: |slave, reply| said_there(slave, reply, |data| data[0] |= u8::from(data[0] == 0x48)),
        ..RIGHT
    },
    Mistake {
        name: "Abort leaves the SAP open",
        rows: &["V1-R73"],
        file: V1,
        says: |slave, reply| {
            if is_abort(slave) {
                slave.count = 1;
            } else if is_initiate(&slave.request) {
                slave.count = 0;
            }
            let left = slave.count == 1 && on_connection(slave) && is_poll(slave);
            if left && is_rs(&reply) { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a connection ends before Send_Timeout",
        rows: &["V1-R74"],
        file: V1,
        hears: |slave, octets| {
            let now = slave.now.as_nanos();
            if Slave::dsap(&octets).is_some_and(|sap| sap < 49) {
                let silent = now - before(slave) > 150_000_000 && !slave.memory.is_empty();
                slave.memory = now.to_be_bytes().to_vec();
                if silent {
                    return changed(&octets, |telegram, _| telegram.dsap = Sap::new(20));
                }
            } else if is_initiate(&octets) {
                slave.memory.clear();
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "fewer connections than the file has",
        rows: &["V1-R75"],
        file: V1,
        told: Some(all_of_v1!("C2_Max_Count_Channels=3")),
        ..RIGHT
    },
    Mistake {
        name: "more connections than the file has",
        rows: &["V1-R75"],
        file: V1,
        told: Some(all_of_v1!("C2_Max_Count_Channels=1")),
        ..RIGHT
    },
    Mistake {
        name: "any master may use a connection",
        rows: &["V1-R76"],
        file: V1,
        says: |slave, reply| {
            // Those that are handed out.
            let is_connection = Slave::dsap(&slave.request).is_some_and(|sap| (47..49).contains(&sap));
            let foreign = is_connection && sa(&slave.request) == OWNER;
            if foreign && is_rs(&reply) { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "Unlock of the owner ends connections",
        rows: &["V1-R77"],
        file: V1,
        says: |slave, reply| {
            if prm_octet(&slave.request, 0) & 0x40 != 0 {
                slave.count = 1;
            } else if is_initiate(&slave.request) {
                slave.count = 0;
            }
            if on_connection(slave) && slave.count == 1 { status(slave, 3) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "any Send_Timeout is taken",
        rows: &["V1-R78"],
        file: V1,
        hears: |_, octets| {
            if is_initiate(&octets) {
                return changed(&octets, |_, data| data[5] = data[5].max(10));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Initiate without read and write is accepted",
        rows: &["V1-R79"],
        file: V1,
        hears: |_, octets| {
            if is_initiate(&octets) && data(&octets).len() > 12 {
                return changed(&octets, |_, data| data[6] = 1);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Transport is answered with a Read",
        rows: &["V1-R80"],
        file: V1,
        says: |slave, reply| {
            said_there(slave, reply, |data| {
                if data[0] & 0x7F == 0x51 {
                    data[0] = 0x5E;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "every SAP below 49 is open",
        rows: &["V1-R81"],
        file: V1,
        says: |slave, reply| {
            let sap = Slave::dsap(&slave.request).filter(|sap| *sap < 47);
            if sap.is_some() && is_rs(&reply) && sa(&slave.request) == OTHER { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a connection waits for SAP 51",
        rows: &["V1-R82"],
        file: V1,
        says: |slave, reply| {
            if on_connection(slave) && slave.framed.acyclic.is_busy() { status(slave, 2) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a connection takes longer than C2_Response_Timeout",
        rows: &["V1-K02"],
        file: V1,
        told: Some(all_of_v1!("C2_Response_Timeout=0")),
        ..RIGHT
    },
];
