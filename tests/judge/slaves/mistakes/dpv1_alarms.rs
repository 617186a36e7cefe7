//! DP-V1: Set_Prm, alarms.

use super::dpv1::{MS1, SC, V1, all_of_v1, prm_octet, said, status, v1};
use super::*;

/// The octets of Set_Prm with Lock, changed.
fn lock(octets: Vec<u8>, change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    if prm_octet(&octets, 0) & 0xC0 == 0x80 {
        return changed(&octets, |_, data| change(data));
    }
    octets
}

/// Without WD_Base_1ms, blocks, Fail_Safe.
const BARE: &str = v1!("C1_Read_Write_supp=1", "Process_Alarm_supp=1");
/// What a master must enable.
pub(super) const REQUIRED: &str = concat!(
    "DPV1_Slave=1\nC1_Read_Write_supp=1\nC1_Read_Write_required=1\nProcess_Alarm_supp=1\nProcess_Alarm_required=1\n",
    "Max_User_Prm_Data_Len=5\nExt_User_Prm_Data_Const(0)=0x80,0x40,0,1,2\nFreeze_Mode_supp=1\nSync_Mode_supp=1\n",
    "Module=\"2 words\" 0xF1\nEndModule\n"
);

pub(super) static PARAMETERS_V1: &[Mistake] = &[
    Mistake {
        name: "nine octets of Set_Prm are enough",
        rows: &["V1-R41"],
        file: V1,
        hears: |_, octets| {
            if Slave::dsap(&octets) == SET_PRM && data(&octets).len() == 9 {
                return changed(&octets, |_, data| data.extend([0, 1, 2]));
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "WD_Base_1ms is taken and does nothing",
        rows: &["S-P17"],
        file: V1,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 {
                    data[7] &= !0x04
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "with WD_Base_1ms the second factor does not count",
        rows: &["V1-R42"],
        file: V1,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 && data[7] & 0x04 != 0 {
                    data[2] = 1;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "WD_Base_1ms is taken although the file does not have it",
        rows: &["V1-R43"],
        file: BARE,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 {
                    data[7] &= !0x04
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Fail_Safe is taken although the file does not have it",
        rows: &["V1-R44"],
        file: V1,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 {
                    data[7] &= !0x40
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Publisher_Enable is taken although the file does not have it",
        rows: &["V1-R45"],
        file: V1,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 {
                    data[7] &= !0x20
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "IsoM_Req is taken although the file does not have it",
        rows: &["V1-R45"],
        file: V1,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 {
                    data[9] &= !0x10
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Alarm_Mode 3 is a fault",
        rows: &["V1-P02"],
        file: V1,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 && data[9] & 7 == 3 {
                    data[4] = 0;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "the lengths of blocks are not looked at",
        rows: &["V1-R46"],
        file: V1,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 {
                    data[9] &= !0x08
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "alarms that are not offered are a fault",
        rows: &["V1-R47"],
        file: BARE,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 && data[8] & 0x04 != 0 {
                    data[4] = 0;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "DPV1_Enable is required and not looked at",
        rows: &["V1-R48"],
        file: REQUIRED,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 {
                    data[7] |= 0x80
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "an alarm is required and its bit is not looked at",
        rows: &["V1-R49"],
        file: REQUIRED,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 {
                    data[8] |= 0x40
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "Set_Ext_Prm is taken in data exchange",
        rows: &["V1-R50"],
        file: V1,
        says: |slave, reply| {
            let late = Slave::dsap(&slave.request) == Some(53) && slave.state() == State::DataExch;
            if late { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
];

/// How many alarms are open.
fn open(slave: &Slave) -> usize {
    slave.framed.acyclic.alarms().len()
}

/// The block of a process alarm of slot 0.
const BLOCK: [u8; 5] = [5, 2, 0, 1, 0x50];

/// The octets of a diagnosis behind its head, changed.
fn block(slave: &Slave, reply: &[u8], change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let is_open = open(slave) > 0;
    diag(slave, reply, |octets| {
        if is_open && octets.len() > 10 {
            change(octets);
        }
    })
}

pub(super) static ALARMS: &[Mistake] = &[
    Mistake {
        name: "an alarm names another slot",
        rows: &["V1-R51"],
        file: V1,
        says: |slave, reply| block(slave, &reply, |octets| octets[8] += 1),
        ..RIGHT
    },
    Mistake {
        name: "Alarm_Ack is answered with another slot",
        rows: &["V1-R52"],
        file: V1,
        says: |slave, reply| said(slave, reply, MS1, |data| data[1] += u8::from(data[0] == 0x5C)),
        ..RIGHT
    },
    Mistake {
        name: "Alarm_Ack is not taken at SAP 50",
        rows: &["V1-R53"],
        file: V1,
        says: |slave, reply| if Slave::dsap(&slave.request) == Some(50) { status(slave, 3) } else { reply },
        ..RIGHT
    },
    Mistake {
        name: "every Alarm_Ack is taken",
        rows: &["V1-R54"],
        file: V1,
        says: |slave, reply| {
            let job = slave.job.clone();
            said(slave, reply, MS1, |data| {
                if data[0] == 0xDC {
                    *data = job;
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "alarms come without being enabled",
        rows: &["V1-R55"],
        file: V1,
        hears: |_, octets| {
            lock(octets, |data| {
                if data.len() > 9 && data[7] & 0x80 != 0 {
                    data[8] |= 0x60
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "alarms come that the file does not offer",
        rows: &["V1-R56"],
        file: all_of_v1!("Pull_Plug_Alarm_supp=1"),
        told: Some(V1),
        ..RIGHT
    },
    Mistake {
        name: "alarms come without DPV1_Enable",
        rows: &["V1-R57"],
        file: V1,
        acts: |slave, action| {
            let enabled =
                slave.framed.station().slave().user_prm().first().is_some_and(|one| one & 0x80 != 0);
            slave.count = u32::from(action.starts_with("raise-alarm") && !enabled);
            false
        },
        says: |slave, reply| {
            let comes = core::mem::take(&mut slave.count) == 1;
            let said = diag(slave, &reply, |octets| {
                if comes {
                    octets.extend(BLOCK)
                }
            });
            slave.count = u32::from(comes && said == reply);
            said
        },
        ..RIGHT
    },
    Mistake {
        name: "a second alarm comes before the acknowledgement",
        rows: &["V1-R58"],
        file: V1,
        acts: |slave, action| {
            slave.count = u32::from(action.contains("disappears") && open(slave) > 0);
            false
        },
        says: |slave, reply| {
            let comes = slave.count == 1 && open(slave) > 0;
            diag(slave, &reply, |octets| {
                if comes {
                    octets.extend([5, 1, 0, 2, 0x50])
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "an alarm of another type waits, too",
        rows: &["V1-R59"],
        file: V1,
        acts: |slave, action| action.starts_with("raise-alarm process") && open(slave) > 0,
        ..RIGHT
    },
    Mistake {
        name: "every alarm has the number 0",
        rows: &["V1-R60"],
        file: V1,
        says: |slave, reply| block(slave, &reply, |octets| octets[9] &= 0x07),
        ..RIGHT
    },
    Mistake {
        name: "alarms can be acknowledged in their order only",
        rows: &["V1-R61"],
        file: V1,
        says: |slave, reply| {
            let number = slave.job.get(3).copied().unwrap_or_default() >> 3;
            let waits = slave.framed.acyclic.alarms().iter().any(|alarm| alarm.head.sequence < number);
            said(slave, reply, MS1, |data| {
                if data[0] == 0x5C && waits {
                    *data = vec![0xDC, 0x80, 0xB5, 0];
                }
            })
        },
        ..RIGHT
    },
    Mistake {
        name: "an alarm comes again behind a new start",
        rows: &["V1-R62"],
        file: V1,
        hears: |slave, octets| {
            if prm_octet(&octets, 0) & 0x40 != 0 && open(slave) > 0 {
                slave.count = 1;
            }
            octets
        },
        does: |slave, octets| {
            if is_exchange(octets) && slave.count == 1 && slave.state() == State::DataExch {
                slave.count = 2;
            }
        },
        says: |slave, reply| {
            let comes = slave.count == 2;
            let said = diag(slave, &reply, |octets| {
                if comes {
                    octets.extend(BLOCK)
                }
            });
            if said != reply {
                slave.count = 0;
            }
            said
        },
        ..RIGHT
    },
    Mistake {
        name: "Add_Ack is lost",
        rows: &["V1-R63"],
        file: V1,
        says: |slave, reply| block(slave, &reply, |octets| octets[9] &= !0x04),
        ..RIGHT
    },
    Mistake {
        name: "the block of an alarm stays behind its acknowledgement",
        rows: &["V1-R64"],
        file: V1,
        does: |slave, octets| {
            if Slave::dsap(octets) == SET_PRM {
                slave.memory.clear();
            }
        },
        says: |slave, reply| {
            let (is_open, kept) = (open(slave) > 0, slave.memory.clone());
            let said = diag(slave, &reply, |octets| {
                if octets.len() == 6 {
                    octets.extend(&kept)
                }
            });
            if is_open && Slave::dsap(&slave.request) == SLAVE_DIAG && data(&said).len() > 6 {
                slave.memory = data(&said)[6..].to_vec();
            }
            said
        },
        ..RIGHT
    },
    Mistake {
        name: "whoever reads an alarm has it",
        rows: &["V1-R65"],
        file: V1,
        hears: |slave, octets| {
            if Slave::dsap(&octets) == SLAVE_DIAG && sa(&octets) == OTHER && open(slave) > 0 {
                let of_owner = changed(&octets, |telegram, _| {
                    telegram.sa = Address::from_octet(OWNER);
                    telegram.fc = FunctionCode::from_octet(0x6D);
                });
                slave.takes(&of_owner);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "status messages do not come",
        rows: &["V1-R66"],
        file: V1,
        acts: |_, action| action.starts_with("send-status"),
        ..RIGHT
    },
    Mistake {
        name: "SAP 50 waits for SAP 51",
        rows: &["V1-R67"],
        file: V1,
        says: |slave, reply| {
            let waits = slave.framed.acyclic.is_busy() && Slave::dsap(&slave.request) == Some(50);
            if waits { status(slave, 2) } else { reply }
        },
        ..RIGHT
    },
];
