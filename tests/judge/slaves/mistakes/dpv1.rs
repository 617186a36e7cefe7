//! DP-V1 at SAP 51: who is served, and how a job runs.

use super::*;

/// A device file of DP-V1 with these lines besides.
macro_rules! v1 {
    ($($line:literal),*) => {
        concat!(
            "DPV1_Slave=1\nMax_User_Prm_Data_Len=5\nExt_User_Prm_Data_Const(0)=0x80,0,0,1,2\nFreeze_Mode_supp=1\n",
            "Sync_Mode_supp=1\nModule=\"2 words\" 0xF1\nEndModule\n", $($line, "\n"),*
        )
    };
}
pub(super) use v1;

pub(super) const MS1: Option<u8> = Some(51);

/// Everything that DP-V1 offers.
macro_rules! all_of_v1 {
    ($($line:literal),*) => {
        v1!(
            "C1_Read_Write_supp=1", "C1_Max_Data_Len=240", "C1_Response_Timeout=100", "C2_Read_Write_supp=1",
            "C2_Max_Data_Len=240", "C2_Response_Timeout=100", "C2_Max_Count_Channels=2", "Max_Initiate_PDU_Length=52",
            "Process_Alarm_supp=1", "Diagnostic_Alarm_supp=1", "Alarm_Type_Mode_supp=1", "Alarm_Sequence_Mode_Count=4",
            "Extra_Alarm_SAP_supp=1", "Ident_Maintenance_supp=1", "WD_Base_1ms_supp=1", "Prm_Block_Structure_supp=1"
            $(, $line)*
        )
    };
}
pub(super) use all_of_v1;

pub(in super::super) const V1: &str = all_of_v1!();
/// Without C1 and alarms.
const NO_MS1: &str = v1!("C2_Read_Write_supp=1", "C2_Max_Count_Channels=2");
/// DP-V1 without any service.
const NOTHING: &str = v1!();
/// With MS1 and nothing else.
const PLAIN_MS1: &str = v1!("C1_Read_Write_supp=1");

/// The data of the request are empty: a poll.
pub(super) fn is_poll(slave: &Slave) -> bool {
    data(&slave.request).is_empty()
}

/// The reply to this SAP with other data, if it has any.
pub(super) fn said(
    slave: &Slave,
    reply: Vec<u8>,
    sap: Option<u8>,
    change: impl FnOnce(&mut Vec<u8>),
) -> Vec<u8> {
    if sap.is_some() && Slave::dsap(&slave.request) == sap && !data(&reply).is_empty() {
        return changed(&reply, |_, octets| change(octets));
    }
    reply
}

/// Whether the reply is RS.
pub(super) fn is_rs(reply: &[u8]) -> bool {
    parsed(reply).is_some_and(|data| data.fc.octet() & 0x0F == 3)
}

/// A short reply with this function code to whoever has asked: 02 RR, 03 RS.
pub(super) fn status(slave: &Slave, code: u8) -> Vec<u8> {
    changed(&refused(slave), |telegram, _| telegram.fc = FunctionCode::from_octet(code))
}

/// A reply with these data.
pub(super) fn response(slave: &Slave, octets: &[u8]) -> Vec<u8> {
    let saps = parsed(&slave.request).map(|request| (request.ssap, request.dsap)).unwrap_or_default();
    changed(&refused(slave), |telegram, data| {
        (telegram.dsap, telegram.ssap) = saps;
        telegram.fc = FunctionCode::from_octet(0x08);
        *data = octets.to_vec();
    })
}

pub(super) const SC: [u8; 1] = [0xE5];

/// A request at SAP 51, not a poll.
pub(super) fn is_request(slave: &Slave) -> bool {
    Slave::dsap(&slave.request) == MS1 && !is_poll(slave)
}

pub(super) fn is_poll_51(slave: &Slave) -> bool {
    Slave::dsap(&slave.request) == MS1 && is_poll(slave)
}

/// Octet of Set_Prm, of a Lock.
pub(super) fn prm_octet(octets: &[u8], place: usize) -> u8 {
    if Slave::dsap(octets) == SET_PRM { data(octets).get(place).copied().unwrap_or_default() } else { 0 }
}

pub(super) static CHANNEL: &[Mistake] = &[
    Mistake {
        name: "SAP 51 is open in WAIT-PRM",
        rows: &["V1-R01"],
        file: V1,
        says: |slave, reply| {
            let is_early = slave.state() == State::WaitPrm && Slave::dsap(&slave.request) == MS1;
            if is_early && is_rs(&reply) { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "MS1 that the file promises is not there",
        rows: &["V1-R02"],
        file: NOTHING,
        told: Some(PLAIN_MS1),
        ..RIGHT
    },
    Mistake {
        name: "SAP 51 is open without DPV1_Enable",
        rows: &["V1-R03"],
        file: V1,
        hears: |_, octets| {
            if prm_octet(&octets, 0) & 0x80 != 0 && data(&octets).len() > 9 {
                return changed(&octets, |_, data| data[7] |= 0x80);
            }
            octets
        },
        ..RIGHT
    },
    Mistake {
        name: "another master is served at SAP 51",
        rows: &["V1-R04"],
        file: V1,
        says: |slave, reply| {
            let foreign = Slave::dsap(&slave.request) == MS1 && sa(&slave.request) == OTHER;
            if foreign && is_rs(&reply) { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "the response is the reply to the request",
        rows: &["V1-R05"],
        file: V1,
        says: |slave, reply| {
            if is_request(slave) && reply == SC { response(slave, &[0xDE, 0x80, 0xB0, 0]) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "the response is one of another service",
        rows: &["V1-R06"],
        file: V1,
        says: |slave, reply| said(slave, reply, MS1, |data| data[0] = data[0] & 0x80 | 0x5F),
        ..RIGHT
    },
    Mistake {
        name: "the response is handed over twice",
        rows: &["V1-R07"],
        file: V1,
        says: |slave, reply| {
            if is_poll_51(slave) && reply == SC && !slave.memory.is_empty() {
                let octets = core::mem::take(&mut slave.memory);
                return response(slave, &octets);
            }
            slave.memory = if is_poll_51(slave) { data(&reply) } else { Vec::new() };
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "a poll without a job: RR",
        rows: &["V1-R08"],
        file: V1,
        says: |slave, reply| {
            if is_request(slave) {
                slave.count = 1;
            } else if is_poll_51(slave) && !data(&reply).is_empty() {
                slave.count = 0;
            } else if is_poll_51(slave) && slave.count == 0 && reply == SC {
                return status(slave, 2);
            }
            reply
        },
        ..RIGHT
    },
    Mistake {
        name: "a second request is taken and forgotten",
        rows: &["V1-R09"],
        file: V1,
        says: |slave, reply| {
            if is_request(slave) && reply != SC && !is_rs(&reply) { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a repeated request: RR",
        rows: &["V1-R10"],
        file: V1,
        says: |slave, reply| {
            let again = slave.memory == slave.request && is_request(slave);
            slave.memory = slave.request.clone();
            if again { status(slave, 2) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a repeated poll: SC",
        rows: &["V1-R11"],
        file: V1,
        says: |slave, reply| {
            let again = slave.memory == slave.request && is_poll_51(slave);
            slave.memory = slave.request.clone();
            if again { SC.to_vec() } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "SRD high is not taken at SAP 51",
        rows: &["V1-R12"],
        file: V1,
        says: |slave, reply| {
            let high = service(&slave.request) == Some(Service::SrdHigh);
            if high && Slave::dsap(&slave.request) == MS1 { status(slave, 3) } else { reply }
        },
        ..RIGHT
    },
    Mistake {
        name: "a Write as SD3 is not taken",
        rows: &["V1-R13"],
        file: V1,
        says: |slave, reply| {
            if slave.request[0] == 0xA2 && Slave::dsap(&slave.request) == MS1 {
                status(slave, 3)
            } else {
                reply
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "Data_Exchange makes it forget a job",
        rows: &["V1-R14"],
        file: V1,
        does: |slave, octets| {
            if is_exchange(octets) {
                slave.count = 1;
            } else if is_request(slave) {
                slave.count = 0;
            }
        },
        says: |slave, reply| {
            if is_poll_51(slave) && slave.count == 1 && !data(&reply).is_empty() {
                SC.to_vec()
            } else {
                reply
            }
        },
        ..RIGHT
    },
    Mistake {
        name: "SAP 51 answers although the file has no MS1",
        rows: &["V1-R15"],
        file: NO_MS1,
        says: |slave, reply| if Slave::dsap(&slave.request) == MS1 { SC.to_vec() } else { reply },
        ..RIGHT
    },
    Mistake {
        name: "SAP 51 answers although the file has no DP-V1",
        rows: &["V1-R16"],
        says: |slave, reply| if Slave::dsap(&slave.request) == MS1 { SC.to_vec() } else { reply },
        ..RIGHT
    },
    Mistake {
        name: "SAP 50 answers although the file does not offer it",
        rows: &["V1-R17"],
        file: PLAIN_MS1,
        says: |slave, reply| if Slave::dsap(&slave.request) == Some(50) { SC.to_vec() } else { reply },
        ..RIGHT
    },
];
