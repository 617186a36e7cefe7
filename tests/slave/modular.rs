//! A modular station that reads its modules at run time: what the application judges, and its words.

use core::fmt;
use std::time::Duration;

use crate::slave_line::{Answer, IO, MASTER, OTHER, SlaveLine};
use profidrive::profibus::dp::application::Expected;
use profidrive::profibus::dp::policy::ApplicationReady;
use profidrive::profibus::dp::{Application, Description, Event, Policy, Reason, Refusal, State};

/// A module as the station's file describes it.
struct Module {
    name: String,
    identifiers: Vec<u8>,
    /// The greatest value of its parameter, one octet in the user parameters for each plugged module.
    most: u8,
}

/// A station with plugged modules, all of it read from a file.
struct Modular {
    modules: Vec<Module>,
    /// Places in `modules`, by slot.
    plugged: Vec<usize>,
    identifiers: Vec<u8>,
}

impl Modular {
    /// Lines like `4DI 13 3`: name, identifiers in hex, greatest parameter.
    fn read(file: &str, plugged: &[usize]) -> Self {
        let modules = file.lines().map(|line| {
            let words: Vec<&str> = line.split(' ').collect();
            let [name, identifiers, most] = words[..] else { panic!("{line}") };
            let identifiers = (0..identifiers.len() / 2)
                .map(|octet| u8::from_str_radix(&identifiers[2 * octet..2 * octet + 2], 16).unwrap());
            Module { name: name.into(), identifiers: identifiers.collect(), most: most.parse().unwrap() }
        });
        let mut station =
            Self { modules: modules.collect(), plugged: plugged.to_vec(), identifiers: Vec::new() };
        station.identifiers = station.slots().flat_map(|module| module.identifiers.clone()).collect();
        station
    }

    fn slots(&self) -> impl Iterator<Item = &Module> {
        self.plugged.iter().map(|place| &self.modules[*place])
    }

    fn pull_last(&mut self) {
        let pulled = self.plugged.pop().map(|place| self.modules[place].identifiers.len());
        self.identifiers.truncate(self.identifiers.len() - pulled.unwrap_or(0));
    }
}

/// The number of words: the slot, and what is wrong with it.
const PARAMETER: u16 = 0x100;
const MODULE: u16 = 0x200;

impl Application for Modular {
    fn judge_prm(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        // Three octets of DPV1_Status come first.
        for (slot, module) in self.slots().enumerate() {
            let got = user_prm.get(3 + slot).copied();
            if got.is_none_or(|got| got > module.most) {
                let reason = Reason::Numbered(PARAMETER + slot as u16);
                return Err(Refusal {
                    index: 3 + slot,
                    expected: Expected::Range(0, module.most),
                    got,
                    reason,
                });
            }
        }
        Ok(())
    }

    fn judge_cfg(&self, configuration: &[u8], user_prm: &[u8]) -> Result<(), Refusal> {
        assert_eq!(user_prm.len(), 3 + self.plugged.len(), "the parameters that were accepted");
        let mut index = 0;
        for (slot, module) in self.slots().enumerate() {
            if configuration.get(index..).is_none_or(|rest| !rest.starts_with(&module.identifiers)) {
                let (got, reason) =
                    (configuration.get(index).copied(), Reason::Numbered(MODULE + slot as u16));
                return Err(Refusal { index, expected: Expected::AsReasoned, got, reason });
            }
            index += module.identifiers.len();
        }
        match configuration.get(index).copied() {
            None => Ok(()),
            got => Err(Refusal {
                index,
                expected: Expected::End,
                got,
                reason: Reason::Text("more modules than slots"),
            }),
        }
    }

    fn configuration<'a>(&'a self, _: Option<&'a [u8]>) -> &'a [u8] {
        &self.identifiers
    }

    fn words(&self, number: u16, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slot = usize::from(number & 0xFF);
        let name = self.slots().nth(slot).map_or("nothing", |module| &module.name);
        match number & 0xFF00 {
            PARAMETER => write!(f, "parameter of '{name}' in slot {}", slot + 1),
            _ => write!(f, "'{name}' is plugged in slot {}", slot + 1),
        }
    }
}

const FILE: &str = "4DI 13 3\n2AO C0C101 1\nEMPTY 00 0";
const PLUGGED: [u8; 5] = [0x13, 0xC0, 0xC1, 0x01, 0x00];

const DESCRIPTION: Description =
    Description { user_prm_len: 0, max_user_prm_len: 60, dpv1_status: Some([0x40, 0, 0]), ..IO };

fn prm(parameters: &[u8]) -> Vec<u8> {
    [&[0x88, 10, 1, 11, 0x12, 0x34, 0, 0x40, 0, 0], parameters].concat()
}

fn station(policy: Policy) -> SlaveLine<Modular> {
    SlaveLine::judged_by(Modular::read(FILE, &[0, 1, 2]), DESCRIPTION, policy)
}

#[test]
fn the_modules_of_a_file_are_configured_in_their_slots() {
    let mut line = station(Policy::PROPOSED);
    assert_eq!(line.request(OTHER, Some(59), &[]), Answer::Low(PLUGGED.to_vec()), "before anything else");
    assert_eq!(line.request(MASTER, Some(61), &prm(&[3, 1, 0])), Answer::Sc);
    assert_eq!(line.request(MASTER, Some(62), &PLUGGED), Answer::Sc);
    assert_eq!(line.station.slave().accepted_configuration(), Some(&PLUGGED[..]));
    line.station.set_inputs(&[1, 2, 3, 4, 5, 6, 7, 8]);
    // Four inputs of 4DI; C0 C1 01 is two octets of output as a word pair, two of input.
    let lengths = (line.station.slave().outputs().len(), line.station.slave().inputs().len());
    assert_eq!(lengths, (4, 6));
    assert_eq!(line.exchange(&[9; 4]), Answer::Low(vec![1, 2, 3, 4, 5, 6]));
}

#[test]
fn get_cfg_reports_what_is_plugged_and_not_what_the_master_chose() {
    let mut line = station(Policy::PROPOSED);
    line.request(MASTER, Some(61), &prm(&[0, 0, 0]));
    line.request(MASTER, Some(62), &PLUGGED);
    line.station.application_mut().pull_last();
    line.station.application_mut().pull_last();
    assert_eq!(line.request(OTHER, Some(59), &[]), Answer::Low(vec![0x13]));
    assert_eq!(line.station.slave().accepted_configuration(), Some(&PLUGGED[..]));
    assert!(matches!(line.exchange(&[9; 4]), Answer::Low(_)), "what is exchanged stays");
}

#[test]
fn a_refusal_says_octet_expected_got_and_the_module_by_its_name() {
    for (parameters, configuration, words) in [
        (
            &[4, 0, 0][..],
            &[][..],
            "refused the parameters of master 2: Set_Prm octet 11: 0x04, expected 0x00..0x03: parameter of '4DI' in slot 1",
        ),
        (
            &[3, 1],
            &[],
            "refused the parameters of master 2: Set_Prm octet 13: the end, expected 0x00..0x00: parameter of 'EMPTY' in slot 3",
        ),
        (
            &[3, 1, 0],
            &[0x13, 0xC0, 0xC1, 0x03, 0x00],
            "refused the configuration of master 2: Chk_Cfg octet 2: 0xC0: '2AO' is plugged in slot 2",
        ),
        (
            &[3, 1, 0],
            &[],
            "refused the configuration of master 2: Chk_Cfg octet 1: the end: '4DI' is plugged in slot 1",
        ),
        (
            &[3, 1, 0],
            &[0x13, 0xC0, 0xC1, 0x01, 0x00, 0x20],
            "refused the configuration of master 2: Chk_Cfg octet 6: 0x20, expected the end: more modules than slots",
        ),
    ] {
        let mut line = station(Policy::PROPOSED);
        assert_eq!(line.request(MASTER, Some(61), &prm(parameters)), Answer::Sc);
        let fault = if line.station.slave().state() == State::WaitCfg {
            assert_eq!(line.request(MASTER, Some(62), configuration), Answer::Sc);
            0x06
        } else {
            0x42
        };
        assert_eq!(line.diagnosis(MASTER)[..4], [fault, 0x05, 0x00, 0xFF]);
        let event = line.events.last().unwrap();
        assert_eq!(line.station.explain(event).to_string(), words);
        assert_eq!(line.request(OTHER, Some(59), &[]), Answer::Low(PLUGGED.to_vec()));
    }
}

#[test]
fn g_10_a_configuration_that_is_right_at_once_can_still_be_judged_later() {
    let judged = Policy { application_ready: ApplicationReady::WhenJudged, ..Policy::PROPOSED };
    for good in [true, false] {
        let mut line = station(judged);
        line.request(MASTER, Some(61), &prm(&[3, 1, 0]));
        line.request(MASTER, Some(62), &PLUGGED);
        let (ticket, pending) = line.station.slave().pending_configuration().unwrap();
        assert_eq!(pending, PLUGGED);
        assert_eq!(line.station.slave().accepted_configuration(), None);
        let reason = Reason::Numbered(MODULE + 1);
        let refusal = Refusal { index: 1, expected: Expected::AsReasoned, got: Some(0xC0), reason };
        let verdict = if good { Ok(()) } else { Err(refusal) };
        let event = line.station.judge_cfg(line.now, ticket, verdict).unwrap();
        assert_eq!(matches!(event, Event::DataExchange { .. }), good);
        assert_eq!(line.station.explain(&event).to_string().ends_with("'2AO' is plugged in slot 2"), !good);
        let expected = if good { State::DataExch } else { State::WaitPrm };
        assert_eq!(line.station.slave().state(), expected);
    }
}

#[test]
fn a_new_set_prm_with_a_fault_leaves_the_master_and_keeps_what_get_cfg_reports() {
    let mut line = station(Policy::PROPOSED);
    line.request(MASTER, Some(61), &prm(&[3, 1, 0]));
    line.request(MASTER, Some(62), &PLUGGED);
    line.exchange(&[9; 4]);
    line.request(MASTER, Some(61), &prm(&[3, 2, 0]));
    assert_eq!((line.station.slave().state(), line.outputs()), (State::WaitPrm, &[0; 4][..]));
    assert_eq!(line.request(OTHER, Some(59), &[]), Answer::Low(PLUGGED.to_vec()));
    line.wait(Duration::from_secs(1));
    assert_eq!(line.happened(|event| matches!(event, Event::WatchdogExpired { .. })), 0);
}
