//! Start-up, Data_Exchange, RD_Inp, RD_Outp.

use super::*;

pub(super) static EXCHANGE: &[Mistake] = &[
    Mistake {
        name: "Set_Prm is never accepted",
        rows: &["S-P01"],
        does: |slave, octets| {
            if Slave::dsap(octets) == SET_PRM {
                leaves(slave);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "Chk_Cfg never leads to data exchange",
        rows: &["S-G01"],
        does: |slave, octets| {
            if Slave::dsap(octets) == CHK_CFG {
                leaves(slave);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange has an octet too few",
        rows: &["S-X01"],
        says: |slave, reply| {
            if is_exchange(&slave.request) && data(&reply).len() == 4 {
                return changed(&reply, |_, data| data.truncate(3));
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "a wrong length is not answered",
        rows: &["S-X02"],
        hears: |slave, octets| {
            let wrong = is_exchange(&octets) && sa(&octets) == OWNER && data(&octets).len() != 4;
            let is_dropped = wrong && slave.state() == State::DataExch;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "a wrong length is taken",
        rows: &["S-X02"],
        hears: |slave, octets| {
            if is_exchange(&octets) && slave.state() == State::DataExch {
                return changed(&octets, |_, data| data.resize(4, 0));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange without outputs is taken without Fail_Safe",
        rows: &["S-X02"],
        hears: |slave, octets| {
            if is_exchange(&octets) && slave.state() == State::DataExch && data(&octets).is_empty() {
                return changed(&octets, |_, data| data.resize(4, 0));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "Fail_Safe of the file is not there",
        rows: &["S-X03"],
        told: Some(
            "Fail_Safe=1\nFreeze_Mode_supp=1\nSync_Mode_supp=1\nSet_Slave_Add_supp=1\nModule=\"2 words\" 0xF1\nEndModule\n",
        ),
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange of another master is answered",
        rows: &["S-X04"],
        says: |slave, reply| {
            let by_other = is_exchange(&slave.request) && sa(&slave.request) == OTHER;
            if !by_other || slave.state() != State::DataExch {
                return reply;
            }
            changed(&RS, |telegram, data| {
                telegram.da = Address::from_octet(OTHER);
                telegram.fc = FunctionCode::from_octet(0x08);
                *data = vec![0; 4];
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange of another master is not answered",
        rows: &["S-X04"],
        hears: |_, octets| {
            let is_dropped = is_exchange(&octets) && sa(&octets) == OTHER;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange of another master ends it",
        rows: &["S-X04"],
        does: |slave, octets| {
            if is_exchange(octets) && sa(octets) == OTHER {
                leaves(slave);
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange in WAIT-CFG is answered",
        rows: &["S-X05"],
        says: |slave, reply| {
            if !is_exchange(&slave.request) || slave.state() != State::WaitCfg {
                return reply;
            }
            changed(&RS, |telegram, data| {
                telegram.fc = FunctionCode::from_octet(0x08);
                *data = vec![0; 4];
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange in WAIT-PRM is not answered",
        rows: &["S-X05"],
        hears: |slave, octets| {
            let is_dropped = is_exchange(&octets) && slave.state() == State::WaitPrm;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "without inputs a status is sent, and not SC",
        rows: &["S-X06"],
        file: MORE_INPUTS,
        says: |slave, reply| {
            if is_exchange(&slave.request) && reply == [0xE5] {
                return changed(&RS, |telegram, _| telegram.fc = FunctionCode::from_octet(0x08));
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "RD_Outp is not there",
        rows: &["S-X07"],
        says: |slave, reply| if Slave::dsap(&slave.request) == RD_OUTP { refused(slave) } else { reply },
        ..RIGHT
    },
    Mistake {
        name: "RD_Inp is open in WAIT-PRM",
        rows: &["S-X07"],
        says: |slave, reply| {
            if Slave::dsap(&slave.request) != RD_INP || slave.state() == State::DataExch {
                return reply;
            }
            let to = sa(&slave.request);
            changed(&RS, |telegram, data| {
                telegram.da = Address::from_octet(to);
                (telegram.dsap, telegram.ssap) = (Sap::new(62), Sap::new(56));
                telegram.fc = FunctionCode::from_octet(0x08);
                *data = vec![0; 4];
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "RD_Inp may have data",
        rows: &["S-X07"],
        hears: |_, octets| {
            if Slave::dsap(&octets) == RD_INP && !data(&octets).is_empty() {
                return changed(&octets, |_, data| data.clear());
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "inputs are half old",
        rows: &["S-X08"],
        says: |slave, reply| {
            if !is_exchange(&slave.request) {
                return reply;
            }
            let inputs = data(&reply);
            let torn = (inputs.len() == 4 && slave.memory.len() == 4 && matches!(inputs[0], 0x55 | 0xAA))
                .then(|| changed(&reply, |_, data| data[2..].copy_from_slice(&slave.memory[2..])));
            slave.memory = inputs;
            torn.unwrap_or(reply)
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange as SD3 is not heard",
        rows: &["S-X09"],
        file: EIGHT,
        hears: |_, octets| {
            let is_dropped = octets.first() == Some(&0xA2) && is_exchange(&octets);
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "inputs are three exchanges old",
        rows: &["S-K04"],
        says: |slave, reply| {
            if !is_exchange(&slave.request) || data(&reply).len() != 4 {
                return reply;
            }
            slave.memory.extend(data(&reply));
            if slave.memory.len() > 16 {
                slave.memory.drain(..4);
            }
            let old = slave.memory.first().copied().unwrap_or(0);
            changed(&reply, |_, data| data.fill(old))
        },
        ..RIGHT
    },
    Mistake {
        name: "many exchanges without a pause are too many",
        rows: &["S-T04"],
        hears: |slave, octets| {
            slave.count = if is_exchange(&octets) { slave.count + 1 } else { 0 };
            let is_dropped = slave.count > 150;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
];
