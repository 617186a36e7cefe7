//! Slave_Diag.

use super::*;

pub(super) static DIAGNOSIS: &[Mistake] = &[
    Mistake {
        name: "a slave without master says master 0",
        rows: &["S-D01"],
        says: |slave, reply| {
            diag(slave, &reply, |octets| {
                if octets[3] == 255 {
                    octets[3] = 0;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Station_Not_Ready ends with Set_Prm",
        rows: &["S-D02"],
        says: |slave, reply| {
            let early = slave.state() == State::WaitCfg;
            diag(slave, &reply, |octets| octets[0] &= if early { !0x02 } else { 0xFF })
        },
        ..RIGHT
    },
    Mistake {
        name: "the diagnosis is sent with DH",
        rows: &["S-D02"],
        says: |slave, reply| {
            if Slave::dsap(&slave.request) == SLAVE_DIAG && data(&reply).len() > 5 {
                return changed(&reply, |data, _| data.fc = FunctionCode::from_octet(0x0A));
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "a new diagnosis is not announced",
        rows: &["S-D03"],
        says: |slave, reply| {
            if is_exchange(&slave.request) && reply.get(6) == Some(&0x0A) {
                return changed(&reply, |data, _| data.fc = FunctionCode::from_octet(0x08));
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "a new diagnosis is announced once",
        rows: &["S-D03"],
        says: |slave, reply| {
            if !is_exchange(&slave.request) {
                slave.count = 0;
                return reply;
            }
            if reply.get(6) != Some(&0x0A) {
                return reply;
            }
            slave.count += 1;
            if slave.count == 1 {
                reply
            } else {
                changed(&reply, |data, _| data.fc = FunctionCode::from_octet(0x08))
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "a diagnosis is announced for ever",
        rows: &["S-D04"],
        acts: |slave, action| {
            slave.count = u32::from(action.starts_with("set-diag 0"));
            false
        },
        says: |slave, reply| {
            if is_exchange(&slave.request) && slave.count > 0 && reply.get(6) == Some(&0x08) {
                return changed(&reply, |data, _| data.fc = FunctionCode::from_octet(0x0A));
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "another master's reading counts",
        rows: &["S-D04"],
        acts: |slave, _| {
            slave.count = 0;
            false
        },
        says: |slave, reply| {
            slave.count +=
                u32::from(Slave::dsap(&slave.request) == SLAVE_DIAG && sa(&slave.request) == OTHER);
            if is_exchange(&slave.request) && slave.count > 0 && reply.get(6) == Some(&0x0A) {
                return changed(&reply, |data, _| data.fc = FunctionCode::from_octet(0x08));
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "a fault that goes away is not told",
        rows: &["S-D05"],
        acts: |slave, action| {
            slave.count = u32::from(action == "set-diag none");
            false
        },
        says: |slave, reply| {
            if is_exchange(&slave.request) && slave.count > 0 && reply.get(6) == Some(&0x0A) {
                return changed(&reply, |data, _| data.fc = FunctionCode::from_octet(0x08));
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "Ext_Diag stays when the fault has gone",
        rows: &["S-D05"],
        acts: |slave, action| {
            slave.count = u32::from(action == "set-diag none");
            false
        },
        says: |slave, reply| {
            let stays = slave.count > 0 && slave.state() == State::DataExch;
            diag(slave, &reply, |octets| octets[0] |= if stays { 0x08 } else { 0 })
        },
        ..RIGHT
    },
    Mistake {
        name: "the header of a block has another length",
        rows: &["S-D07"],
        says: |slave, reply| {
            diag(slave, &reply, |octets| {
                if octets.len() > 6 {
                    octets[6] += 1;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "a bit of masters is set",
        rows: &["S-D08"],
        says: |slave, reply| {
            let locked = sa(&slave.request) == OTHER && slave.state() == State::DataExch;
            diag(slave, &reply, |octets| octets[0] |= if locked { 0x80 } else { 0 })
        },
        ..RIGHT
    },
    Mistake {
        name: "the fixed bit is 0",
        rows: &["S-D09"],
        says: |slave, reply| diag(slave, &reply, |octets| octets[1] &= !0x04),
        ..RIGHT
    },
    Mistake {
        name: "without inputs a diagnosis is not announced",
        rows: &["S-D10"],
        file: MORE_INPUTS,
        says: |slave, reply| {
            if is_exchange(&slave.request) && reply.get(3) == Some(&0x0A) { vec![0xE5] } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a diagnosis is longer than the file says",
        rows: &["S-K03"],
        told: Some(
            "Freeze_Mode_supp=1\nSync_Mode_supp=1\nSet_Slave_Add_supp=1\nMax_Diag_Data_Len=6\nModule=\"2 words\" 0xF1\nEndModule\n",
        ),
        ..RIGHT
    },
];
