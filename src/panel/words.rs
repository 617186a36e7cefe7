//! The words of the PPO and the status registers, bit by bit and in words.

use serde::Serialize;
use utoipa::ToSchema;

use super::state::lengths;
use crate::devices::ag03::drive::{Mode, State};
use crate::devices::ag03::param;
use crate::devices::ag03::param::Pnu;
use crate::devices::ag03::profibus::bits;
use crate::devices::ag03::profibus::bits::{Role, bits};
use crate::devices::ag03::profibus::{Device, words};
use crate::explain;
use crate::profibus::ppo::{Inputs, Outputs, PPO_LEN, Pkw};

/// The words of bits, by the operating mode in effect.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Words {
    /// Control word, as the drive has seen it last (manual tables 11 and 13).
    stw: Word,
    /// Status word (manual tables 12 and 14).
    zsw: Word,
    /// System status word, PNU 1020 (manual table 1).
    ssw: Word,
    /// General status register, PNU 1031.
    general_status: Word,
}

/// A word of bits.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Word {
    #[schema(minimum = 0, maximum = 65535)]
    value: u16,
    /// Bit 0 first.
    bits: Vec<Bit>,
}

/// One bit with what it means in this operating mode.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct Bit {
    bit: u8,
    set: bool,
    /// A short name for programs; empty for a bit that is not used.
    key: &'static str,
    /// What the manual calls it.
    name: &'static str,
    /// What its value means.
    meaning: &'static str,
    /// What to know about it; may be empty.
    note: &'static str,
    /// Whether the bit means anything: `false` for bits that are fixed or not evaluated.
    used: bool,
}

/// The user data of Data_Exchange, raw and decoded.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Ppo {
    outputs: PpoOutputs,
    inputs: PpoInputs,
}

/// From the master, as the drive sees them; all zero before the first Data_Exchange.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct PpoOutputs {
    /// The seven words in hexadecimal.
    words_hex: String,
    pkw: PkwWords,
    #[schema(minimum = 0, maximum = 65535)]
    stw: u16,
    /// User units, or rpm in velocity mode.
    hsw: i32,
}

/// To the master, as the next Data_Exchange carries them.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct PpoInputs {
    /// The seven words in hexadecimal.
    words_hex: String,
    pkw: PkwWords,
    #[schema(minimum = 0, maximum = 65535)]
    zsw: u16,
    /// User units, or rpm in velocity mode.
    hiw: i32,
}

/// A job or a reply of the parameter channel.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
struct PkwWords {
    /// The four words in hexadecimal.
    words_hex: String,
    /// Job or reply identification, 0 to 15.
    ak: u8,
    pnu: u16,
    /// The name of the parameter, if the model has it.
    parameter: Option<&'static str>,
    ind: u16,
    /// The value as two words.
    pwe: u32,
    /// The job or reply in words.
    text: String,
}

impl Words {
    pub(super) fn of(device: &Device) -> Self {
        let status = device.status();
        let model = device.config().model;
        let word = |word, value| Word::of(word, status.mode, model, value);
        Self {
            stw: word(bits::Word::Stw, outputs(device).stw().raw()),
            zsw: word(bits::Word::Zsw, device.zsw().raw()),
            ssw: word(bits::Word::Ssw, device.system_status()),
            general_status: word(bits::Word::GeneralStatus, words::general_status(status)),
        }
    }
}

impl Word {
    fn of(word: bits::Word, mode: Mode, model: param::Model, value: u16) -> Self {
        let bit = |(bit, row): (u8, &bits::Bit)| {
            let set = value >> bit & 1 != 0;
            let used = match row.role {
                Role::Level | Role::Edge => true,
                Role::Fixed(_) | Role::Unused => false,
            };
            Bit { bit, set, key: row.key, name: row.name, meaning: row.meaning(set), note: row.note, used }
        };
        Self { value, bits: (0..).zip(bits(word, mode, Some(model))).map(bit).collect() }
    }
}

impl Ppo {
    pub(super) fn of(device: &Device) -> Self {
        let model = device.config().model;
        let outputs = outputs(device);
        let octets = first(device.slave().inputs());
        let inputs = Inputs::new(&octets);
        let (job, reply) = (outputs.pkw(), inputs.pkw());
        // One context: a reply is understood by its job.
        let mut context = explain::Context::of_drive(model, device.status().mode, lengths(device));
        let mut text = |pkw: Pkw, sender| {
            let explanation = context.bare(&pkw.to_octets(), Some(sender));
            explanation.map(|explanation| explanation.summary).unwrap_or_default()
        };
        Self {
            outputs: PpoOutputs {
                words_hex: hex(device.slave().outputs()),
                pkw: PkwWords::of(job, model, text(job, explain::Sender::Master)),
                stw: outputs.stw().raw(),
                hsw: outputs.hsw(),
            },
            inputs: PpoInputs {
                words_hex: hex(&octets),
                pkw: PkwWords::of(reply, model, text(reply, explain::Sender::Slave)),
                zsw: inputs.zsw().raw(),
                hiw: inputs.hiw(),
            },
        }
    }
}

impl PkwWords {
    fn of(pkw: Pkw, model: param::Model, text: String) -> Self {
        let pnu = pkw.pke.pnu();
        Self {
            words_hex: pkw.to_string(),
            ak: pkw.pke.ak(),
            pnu,
            parameter: param::entry(model, Pnu::from_low_bits(pnu)).map(|entry| entry.name),
            ind: pkw.ind.raw(),
            pwe: pkw.double_word(),
            text,
        }
    }
}

/// The outputs as the slave passes them; all zero if they are no PPO.
pub(super) fn outputs(device: &Device) -> Outputs<'_> {
    const NONE: &[u8; PPO_LEN] = &[0; PPO_LEN];
    Outputs::new(device.slave().outputs().first_chunk().unwrap_or(NONE))
}

fn first(octets: &[u8]) -> [u8; PPO_LEN] {
    octets.first_chunk().copied().unwrap_or_default()
}

/// Words in hexadecimal.
pub(super) fn hex(octets: &[u8]) -> String {
    let words: Vec<String> = octets
        .chunks(2)
        .map(|word| word.iter().map(|octet| format!("{octet:02X}")).collect::<String>())
        .collect();
    words.join(" ")
}

/// The state of the drive in words (`ag03.md` 8).
pub(super) const fn state(state: State) -> &'static str {
    match state {
        State::Off => "off",
        State::NotReady => "not ready: a supply is missing",
        State::ReadyToRun(_) => "ready-to-run",
        State::OperationEnabled(_) => "operation enabled",
        State::Disabling => "operation disabled, the shaft still brakes",
        State::TravelActive => "travel job active",
        State::Pausing { torque_tripped: false } => "travel job paused, brakes",
        State::Pausing { torque_tripped: true } => {
            "travel job interrupted by the torque deactivation, brakes"
        }
        State::Paused { torque_tripped: false } => "travel job paused",
        State::Paused { torque_tripped: true } => "travel job interrupted by the torque deactivation",
        State::Stopping => "travel job stopped, the shaft still brakes",
        State::Inching(_) => "inching",
        State::VelocityTravelling => "travelling with velocity",
        State::KeyInching(_) => "inching by key",
        State::KeyInchingEnding => "inching by key ends",
        State::Fault => "fault",
        State::TurnOnDisabled => "turn-on disabled",
    }
}
