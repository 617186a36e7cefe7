//! Rows V about connections of a master of class 2: opened, kept and ended (`dp-v1.md` 4).

use core::time::Duration;
use std::collections::BTreeMap;

use super::Observer;
use super::cycle::Cycle;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::profibus::dpv1::connection::READ_WRITE;
use crate::profibus::dpv1::{RESOURCE_MANAGER_SAP, RequestPdu, ResponsePdu};
use crate::time::Instant;

/// The unit of Send_Timeout.
const UNIT: Duration = Duration::from_millis(10);
/// So many times Send_Timeout a master may be silent: its clock and that of the judge differ.
const MOST_SILENCE: u32 = 2;

/// The connections of a master to one slave, by their SAPs.
#[derive(Clone, Debug, Default)]
pub(super) struct Connections {
    open: BTreeMap<u8, Connection>,
    /// Send_Timeout of an Initiate whose SAP is not known yet.
    asked: Option<Duration>,
    /// What the slave has handed out or taken back may not be known.
    doubtful: bool,
}

#[derive(Clone, Copy, Debug)]
struct Connection {
    send_timeout: Duration,
    /// Max_Len_Data_Unit; `None`: not open yet.
    max_len: Option<u8>,
    /// When the master last showed life.
    lived: Instant,
    serial: u64,
}

impl Connections {
    /// It has ended.
    pub(super) fn end(&mut self, sap: u8) {
        self.open.remove(&sap);
    }

    /// A reply was lost.
    pub(super) fn doubt(&mut self) {
        self.doubtful |= self.asked.is_some() || !self.open.is_empty();
    }

    /// The most octets of data that the slave takes at a SAP.
    pub(super) fn most_data(&self, sap: u8) -> Option<u8> {
        self.open.get(&sap)?.max_len
    }
}

impl Observer {
    /// A request or a poll at SAP 0 to 49.
    pub(super) fn judge_connection(&mut self, cycle: &Cycle, sap: u8, data: &[u8]) {
        let recorded = self.is_recorded();
        let connections = &mut self.view(cycle.to).services.connections;
        if sap == RESOURCE_MANAGER_SAP {
            let Ok(RequestPdu::Initiate(initiate)) = RequestPdu::parse(data) else { return };
            connections.asked = Some(UNIT * u32::from(initiate.send_timeout));
            let reason = if initiate.terms.features & READ_WRITE == 0 {
                Some("Initiate without DPV1_RW in Features_Supported".to_owned())
            } else if initiate.send_timeout == 0 {
                Some("Initiate with a Send_Timeout of 0".to_owned())
            } else {
                None
            };
            return self.verdict_of(cycle, Row::V20, reason);
        }
        let Some(connection) = connections.open.get_mut(&sap) else {
            let excused = recorded || connections.doubtful;
            if !excused {
                let reason = format!(
                    "SAP {sap} is asked, and the slave has not handed it out, or the connection has ended"
                );
                self.verdict_of(cycle, Row::V18, Some(reason));
            }
            return;
        };
        // A poll alone shows no life, unless a job runs, which it waits for.
        connection.lived = cycle.end;
        connection.serial = cycle.serial;
        if matches!(RequestPdu::parse(data), Ok(RequestPdu::Abort(_))) {
            connections.end(sap);
        }
        self.held(Row::V18);
    }

    /// Any request to the station: how long its connections are silent.
    pub(super) fn judge_idle(&mut self, cycle: &Cycle) {
        let mut silent = None;
        let away = self.timing.away_since();
        let view = self.view(cycle.to);
        // Who has given the station up may not know whether its connections are there.
        if view.gave_up || view.over {
            view.services.connections.doubt();
        }
        let connections = &mut view.services.connections;
        if connections.doubtful {
            return;
        }
        for (sap, connection) in connections.open.iter_mut().filter(|(_, open)| open.max_len.is_some()) {
            // Who has not the token cannot send.
            if away.is_some_and(|away| away >= connection.lived) {
                connection.lived = cycle.end;
            }
            let time = cycle.end.saturating_since(connection.lived);
            if time > connection.send_timeout * MOST_SILENCE {
                connection.lived = cycle.end;
                silent = Some((*sap, time, connection.send_timeout, connection.serial));
            }
        }
        if let Some((sap, time, send_timeout, serial)) = silent {
            let reason = format!(
                "{} ms without a word at SAP {sap}; Send_Timeout of the connection is {} ms",
                time.as_millis(),
                send_timeout.as_millis()
            );
            self.broken(Row::V19, Weight::Once, serial, Some(cycle.to), reason);
        }
    }

    /// A response at SAP 0 to 49.
    pub(super) fn connection_answered(&mut self, cycle: &Cycle, sap: u8, octets: &[u8]) {
        if sap > RESOURCE_MANAGER_SAP {
            return;
        }
        let connections = &mut self.view(cycle.to).services.connections;
        match ResponsePdu::parse(octets) {
            Ok(ResponsePdu::ResourceManager { sap, .. }) => {
                let send_timeout = connections.asked.take().unwrap_or_default();
                let (lived, serial) = (cycle.end, cycle.serial);
                if core::mem::take(&mut connections.doubtful) {
                    connections.open.clear();
                }
                connections.open.insert(sap, Connection { send_timeout, max_len: None, lived, serial });
            }
            Ok(ResponsePdu::Initiate(response)) => {
                if let Some(connection) = connections.open.get_mut(&sap) {
                    connection.max_len = Some(response.max_len);
                }
            }
            Ok(ResponsePdu::Abort(_)) => connections.end(sap),
            Ok(ResponsePdu::Idle) => self.held(Row::V19),
            Ok(
                ResponsePdu::Read { .. }
                | ResponsePdu::Write { .. }
                | ResponsePdu::AlarmAck(_)
                | ResponsePdu::DataTransport { .. }
                | ResponsePdu::Negative { .. },
            )
            | Err(_) => {}
        }
    }
}
