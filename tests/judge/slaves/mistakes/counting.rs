//! The frame count bit.

use super::*;

pub(super) static COUNTING: &[Mistake] = &[
    Mistake {
        name: "a second first request is taken for a retry",
        rows: &["S-C07"],
        says: |slave, reply| {
            let first = slave.request.get(6) == Some(&0x6D) && Slave::dsap(&slave.request).is_some();
            let same =
                slave.memory.first() == Some(&0x6D) && slave.memory.get(1) == Some(&sa(&slave.request));
            slave.memory = vec![slave.request.get(6).copied().unwrap_or(0), sa(&slave.request)];
            if first && same { slave.reply.clone() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a first request is not answered",
        rows: &["S-C01"],
        hears: |slave, octets| {
            let first = octets.get(6) == Some(&0x6D) && Slave::dsap(&octets) == SLAVE_DIAG;
            let is_dropped = first && sa(&octets) == OTHER && slave.state() == State::WaitPrm;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "FCB = 0 is not answered",
        rows: &["S-C02"],
        hears: |slave, octets| {
            let even = octets.get(6) == Some(&0x5D) && Slave::dsap(&octets) == GET_CFG;
            let is_it = even && slave.state() == State::WaitPrm;
            slave.count += u32::from(is_it);
            let is_dropped = is_it && slave.count > 1;
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "a retry is not answered",
        rows: &["S-C04"],
        hears: |slave, octets| {
            let is_dropped = octets == slave.memory && octets.get(6) != Some(&0x6D) && octets.len() > 6;
            slave.memory.clone_from(&octets);
            drops(octets, is_dropped)
        },
        ..RIGHT
    },
    Mistake {
        name: "a retry of Data_Exchange is refused",
        rows: &["S-C03"],
        says: |slave, reply| {
            let again = slave.request == slave.memory && is_exchange(&slave.request);
            slave.memory.clone_from(&slave.request);
            if again { refused(slave) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a retry of Slave_Diag has no extended diagnosis any more",
        rows: &["S-C04"],
        says: |slave, reply| {
            let again = slave.request == slave.memory;
            slave.memory.clone_from(&slave.request);
            diag(slave, &reply, |octets| {
                if again {
                    octets.truncate(6);
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "a retry of Set_Prm is a fault",
        rows: &["S-C05"],
        does: |slave, octets| {
            let again = octets == slave.memory && Slave::dsap(octets) == SET_PRM;
            slave.memory = octets.to_vec();
            if again {
                slave.station().abort();
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "the FCB of every master is one",
        rows: &["S-C06"],
        says: |slave, reply| {
            let fcb = slave.request.get(6).map(|fc| fc & 0x30);
            let is_it = fcb == Some(0x10)
                && slave.memory.first() == Some(&0x10)
                && slave.memory.get(1) != Some(&sa(&slave.request));
            slave.memory = vec![fcb.unwrap_or(0), sa(&slave.request)];
            if is_it && Slave::dsap(&slave.request) == GET_CFG { slave.reply.clone() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "the same FCB with another service gets the old reply",
        rows: &["S-C08"],
        says: |slave, reply| {
            let fcb = slave.request.get(6).copied().unwrap_or(0);
            let same = slave.memory.first() == Some(&fcb) && slave.memory.get(1) == Some(&sa(&slave.request));
            slave.memory = vec![fcb, sa(&slave.request)];
            if same && fcb == 0x5D { slave.reply.clone() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "after power on only a first request is heard",
        rows: &["S-C09"],
        acts: |slave, action| {
            slave.count += u32::from(action == "power-cycle");
            false
        },
        hears: |slave, octets| {
            if octets.get(6).is_some_and(|fc| fc & 0x30 == 0x20) && slave.count > 1 {
                slave.count = 0;
            }
            let counted = octets.get(6).is_some_and(|fc| fc & 0x10 != 0);
            drops(octets, counted && slave.count > 1)
        },
        ..RIGHT
    },
    Mistake {
        name: "a retry behind FDL status is refused",
        rows: &["S-C10"],
        says: |slave, reply| {
            let is_status = service(&slave.request) == Some(Service::FdlStatus);
            let counted = slave.request.get(6) == Some(&0x5D);
            let again = slave.request == slave.memory && slave.count == 1 && counted;
            if is_status {
                slave.count += 1;
            } else {
                slave.count = 0;
                slave.memory.clone_from(&slave.request);
            }
            if again { refused(slave) } else { reply }
        },
        ..RIGHT
    },
];
