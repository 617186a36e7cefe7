//! The stations the judge plays: our slaves, and what is done to them on purpose.

use core::time::Duration;

use super::played::{Judged, Mood, Played};
use super::setup::{Setup, Slave};
use crate::gsd;
use crate::host::{Bus, Participant};
use crate::profibus::dp::ext_diag::{Block, MAX_BLOCK_DATA};
use crate::profibus::dp::policy::{NoEffect, WatchdogFactorZero};
use crate::profibus::dp::{self, Description, ExtDiag, Policy};
use crate::profibus::fdl::{Address, DataTelegram, FrameCount, FunctionCode, Sap, Service, Telegram};
use crate::time::Instant;

/// The master that takes a station from the one under test.
pub(super) const OTHER_MASTER: u8 = 77;

/// The SAP of masters, of Set_Prm, and of Chk_Cfg, which have one number.
const MASTER_SAP: u8 = 62;
const SET_PRM_SAP: u8 = 61;
const CHK_CFG_SAP: u8 = 62;

/// The longest diagnosis: all of it but the six octets of the standard is extended.
const LONGEST_DIAG: u8 = 244;

/// What is done to a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// It is switched off and on.
    PowerOn,
    /// It has a fault to report.
    Diagnose,
    /// Its fault has gone.
    DiagnosisGone,
    /// It has 244 octets to report, blocks of every kind.
    LongDiagnosis,
    /// Another master parameterises it and exchanges data with it.
    Take,
    /// That master lets it go.
    Release,
    /// Jobs of DP-V1 take a while.
    SlowRecords,
    /// They never end.
    StuckRecords,
    /// They are refused.
    RefuseRecords,
    /// They are carried out at once again.
    UsualRecords,
    /// The next reply of a service of DP-V1 is lost.
    LoseResponse,
    /// It raises the alarms that the master takes.
    RaiseAlarms,
}

/// How long a job of DP-V1 takes at most.
pub(super) const SLOW: Duration = Duration::from_millis(300);

impl Act {
    /// As it is written in a scenario.
    pub(crate) const ALL: [(&'static str, Self); 12] = [
        ("power-on", Self::PowerOn),
        ("diagnose", Self::Diagnose),
        ("diagnosis-gone", Self::DiagnosisGone),
        ("long-diagnosis", Self::LongDiagnosis),
        ("take", Self::Take),
        ("release", Self::Release),
        ("slow-records", Self::SlowRecords),
        ("stuck-records", Self::StuckRecords),
        ("refuse-records", Self::RefuseRecords),
        ("usual-records", Self::UsualRecords),
        ("lose-response", Self::LoseResponse),
        ("raise-alarms", Self::RaiseAlarms),
    ];
}

/// Connects the stations that are there.
pub(super) fn connect(setup: &Setup, bus: &mut Bus) {
    for slave in setup.present() {
        // Two stations of one address are refused before.
        let _ = bus.add(played(slave, bus));
    }
}

fn played(slave: &Slave, bus: &Bus) -> Played {
    let described =
        slave.gsd.as_deref().and_then(|file| gsd::Station::new(file.clone(), gsd::Policy::PROPOSED).ok());
    let (description, application) = match described {
        Some(station) => (station.description(), Judged::Gsd(Box::new(station))),
        None => {
            let description = Description {
                ident: slave.ident,
                max_user_prm_len: 237,
                max_diag_len: LONGEST_DIAG,
                sync_mode: true,
                freeze_mode: true,
                fail_safe: slave.fail_safe,
                fail_safe_optional: true,
                dpv1_status: slave.dpv1.then_some([u8::MAX; dp::dpv1_status::LEN]),
                ..Description::PLAIN
            };
            (description, Judged::Numbers(slave.cfg.clone().unwrap_or_default()))
        }
    };
    let policy = Policy {
        // Acknowledged before DP looks: then the diagnosis alone says that Set_Prm was refused.
        chk_cfg_in_wait_prm: NoEffect::Acknowledged,
        watchdog_factor_zero: WatchdogFactorZero::Off,
        check_reserved_prm_bits: false,
        check_reserved_control_bits: false,
        ..Policy::PROPOSED
    };
    let baud = bus.baud();
    let station = dp::Station::new(slave.address, baud, None, description, application).with_policy(policy);
    Played::new(slave, station)
}

/// Does something to a station.
pub(super) fn act(act: Act, slave: &Slave, bus: &mut Bus, now: Instant) {
    let address = slave.address;
    match act {
        Act::PowerOn => {
            bus.remove(address);
            let _ = bus.add(played(slave, bus));
        }
        Act::Diagnose => file(bus, address, &fault()),
        Act::DiagnosisGone => file(bus, address, &ExtDiag::NONE),
        Act::LongDiagnosis => file(bus, address, &long()),
        Act::Take => {
            bus.with(address, |station: &mut Played| {
                let configuration = station.slave().configuration().to_vec();
                let ident = station.slave().description().ident.to_be_bytes();
                let user_prm = station.slave().user_prm().to_vec();
                station.abort();
                let prm = [&[0x80, 1, 1, 0, ident[0], ident[1], 0][..], &user_prm].concat();
                tell(station, now, SET_PRM_SAP, &prm);
                tell(station, now, CHK_CFG_SAP, &configuration);
            });
        }
        Act::Release => {
            bus.with(address, |station: &mut Played| station.abort());
        }
        Act::SlowRecords => {
            // A master gives up what takes longer than C1_Response_Timeout.
            let takes = slave.response_timeout().map_or(SLOW, |most| SLOW.min(most / 2));
            set_mood(bus, address, Mood::Slow(takes));
        }
        Act::StuckRecords => set_mood(bus, address, Mood::Stuck),
        Act::RefuseRecords => set_mood(bus, address, Mood::Refusing),
        Act::UsualRecords => set_mood(bus, address, Mood::Usual),
        Act::LoseResponse => {
            bus.with(address, Played::lose_response);
        }
        Act::RaiseAlarms => {
            bus.with(address, Played::raise_alarms);
        }
    }
}

fn set_mood(bus: &mut Bus, address: Address, mood: Mood) {
    bus.with(address, |station: &mut Played| station.set_mood(mood));
}

fn file(bus: &mut Bus, address: Address, diagnosis: &ExtDiag) {
    bus.with(address, |station: &mut Played| station.file_diagnosis(diagnosis));
}

fn fault() -> ExtDiag {
    let mut diagnosis = ExtDiag::fault();
    // One octet fits a block.
    let _ = diagnosis.push(Block::Device(&[0x01]));
    diagnosis
}

/// As many blocks as fit: of every kind, and 238 octets together.
fn long() -> ExtDiag {
    use crate::profibus::dp::ext_diag::{Channel, ChannelError, Direction, Width};
    let mut diagnosis = ExtDiag::NONE;
    let channel = Channel {
        module: 1,
        direction: Direction::Output,
        channel: 3,
        width: Width::Bit,
        error: ChannelError::SHORT_CIRCUIT,
    };
    let _ = diagnosis.push(Block::Modules(&[0x02]));
    let _ = diagnosis.push(Block::Channel(channel));
    let _ = diagnosis.push(Block::Revision(1));
    // 6 octets so far; three blocks of 63, one of 43.
    for data in [MAX_BLOCK_DATA, MAX_BLOCK_DATA, MAX_BLOCK_DATA, 42] {
        let _ = diagnosis.push(Block::Device(&std::vec![0x5A; data]));
    }
    diagnosis
}

/// A request of the other master, behind the back of the one under test. Nothing of it is on the line.
fn tell(station: &mut Played, now: Instant, sap: u8, data: &[u8]) {
    let sa = Address::from_octet(OTHER_MASTER);
    let fc = FunctionCode::request(Service::SrdHigh, FrameCount::First);
    let (dsap, ssap) = (Sap::new(sap), Sap::new(MASTER_SAP));
    let format = DataTelegram::customary_format(dsap, ssap, data);
    let telegram = DataTelegram { format, da: Participant::address(station), sa, dsap, ssap, fc, data };
    station.handle(now, &Telegram::Data(telegram));
    // The other master goes on: the reply is not sent.
    station.handle(now, &Telegram::Token { da: sa, sa });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_long_diagnosis_has_238_octets() {
        assert_eq!(long().octets().len(), 238);
        assert!(!long().overflow());
    }
}
