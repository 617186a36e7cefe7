//! The slave of a GSD: what it accepts of its master.

use core::cell::RefCell;
use core::fmt;
use std::collections::VecDeque;

use thiserror::Error;

use super::agreement::{Agreement, UserPrm};
use super::split::{Plugged, Reading, admits, fixed_presets, hex, slot_count, split};
use super::{Gsd, Parameter, PrmPart};
use crate::profibus::dp::application::Expected;
use crate::profibus::dp::dpv1_status::{self, Status1, Status2, Status3};
use crate::profibus::dp::{Application, CfgSyntax, Description, IoLengths, Reason, Refusal};

/// Refusals whose words are kept: an event is explained soon after it came.
const KEPT_WORDS: usize = 16;

/// The identifier of an empty slot (G-01).
const EMPTY_SLOT: u8 = 0x00;

/// The most octets of user parameters.
const MAX_USER_PRM_LEN: u8 = 237;

/// How a station behaves where the format is silent (`gsd.md` 3.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Policy {
    /// G-01: 00 is an empty slot of a modular station even if its file has no such module.
    pub free_slots: bool,
    /// G-14: a parameter out of its range is refused; if not, it is one of the [`Station::remarks`].
    pub refuse_values: bool,
    /// User parameters whose length is not that of the configured modules are refused with Chk_Cfg, the first
    /// request that shows it; if not, they are one of the [`Station::remarks`].
    pub refuse_prm_length: bool,
    /// User parameters are taken from a master although the file has none.
    pub any_user_prm: bool,
}

impl Policy {
    /// What `gsd.md` proposes.
    pub const PROPOSED: Self =
        Self { free_slots: true, refuse_values: false, refuse_prm_length: false, any_user_prm: false };

    /// Nothing but what the file says.
    pub const STRICT: Self =
        Self { free_slots: false, refuse_values: true, refuse_prm_length: true, any_user_prm: false };
}

/// Why no station can be what its file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Contradiction {
    /// A compact station whose modules are too long together.
    #[error(
        "the configuration of the compact station cannot be exchanged: {0}; correct its modules or set Modular_Station = 1"
    )]
    Compact(CfgSyntax),
    /// More octets of configuration than Chk_Cfg has.
    #[error("the fixed configuration has {got} octets, expected at most 244; correct the modules")]
    TooLong {
        /// Octets.
        got: usize,
    },
    /// More fixed modules than slots.
    #[error("{presets} modules are Preset with FixPresetModules, Max_Module is {slots}; raise it")]
    Presets {
        /// Preset modules.
        presets: usize,
        /// Max_Module.
        slots: u16,
    },
}

/// Why a station cannot have the modules that it is to have.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the station cannot have these modules: {words}")]
pub struct NotPluggable {
    /// Why, in the words of a refusal.
    pub words: String,
}

/// The application of a [`dp::Station`](crate::profibus::dp::Station) that is what a GSD describes.
///
/// ```
/// use profidrive::profibus::dp;
/// use profidrive::profibus::fdl::Address;
/// use profidrive::gsd::{Gsd, Policy, Station};
/// use profidrive::time::BaudRate;
///
/// let gsd = Gsd::read(b"#Profibus_DP\nIdent_Number=0x0ABC\nModule=\"io\" 0x30\nEndModule\n")?;
/// let application = Station::new(gsd, Policy::PROPOSED)?;
/// let description = application.description();
/// let station = dp::Station::new(Address::station(7)?, BaudRate::K500, None, description, application);
/// assert_eq!(station.slave().configuration(), [0x30]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Station {
    gsd: Gsd,
    policy: Policy,
    modular: bool,
    /// The station's part of the user parameters, and its length.
    part: PrmPart,
    part_len: usize,
    default_prm: Vec<u8>,
    prm_lengths: (u8, u8),
    /// The configuration of a compact station, else what Get_Cfg reports at first (G-11).
    configuration: Vec<u8>,
    /// It has these modules, slot by slot; `None` in an empty slot.
    plugged: Option<Vec<Option<usize>>>,
    /// It takes a configuration of other modules than it has, and the diagnosis reports them.
    reports: bool,
    /// The words of the last refusals, by number.
    said: RefCell<(u16, VecDeque<(u16, String)>)>,
}

impl Station {
    /// The station of a file.
    ///
    /// # Errors
    /// [`Contradiction`] if no configuration could ever be exchanged.
    pub fn new(gsd: Gsd, policy: Policy) -> Result<Self, Contradiction> {
        const MOST: usize = crate::profibus::dp::chk_cfg::MAX_IO_LEN;
        let modular = gsd.is_modular();
        let (presets, slots) = (fixed_presets(&gsd).len(), slot_count(&gsd));
        let concatenated = |wanted: &dyn Fn(&super::Module) -> bool| -> Vec<u8> {
            gsd.modules
                .iter()
                .filter(|module| wanted(module))
                .flat_map(|module| module.identifiers.clone())
                .collect()
        };
        let mut configuration = concatenated(&|module| !modular || module.preset);
        if modular {
            if presets > usize::from(slots) {
                return Err(Contradiction::Presets { presets, slots });
            }
            if configuration.is_empty() {
                let first = gsd.modules.iter().find(|module| module.lengths != IoLengths::default());
                configuration = first
                    .or(gsd.modules.first())
                    .map(|module| module.identifiers.clone())
                    .unwrap_or_default();
            }
        } else if let Err(syntax) = IoLengths::of(&configuration) {
            return Err(Contradiction::Compact(syntax));
        }
        if configuration.len() > MOST {
            return Err(Contradiction::TooLong { got: configuration.len() });
        }
        let part = if gsd.has_new_user_prm() { gsd.user_prm.clone() } else { PrmPart::default() };
        let default_prm = gsd.default_user_prm(&[]);
        let (part_len, prm_lengths) = (default_prm.len(), gsd.user_prm_lengths());
        let said = RefCell::default();
        Ok(Self {
            gsd,
            policy,
            modular,
            part,
            part_len,
            default_prm,
            prm_lengths,
            configuration,
            plugged: None,
            reports: false,
            said,
        })
    }

    /// The same station with these modules plugged in, slot by slot: places in [`Gsd::modules`].
    /// Get_Cfg reports them. Another configuration is refused, or with [`Station::reporting`] taken.
    ///
    /// # Errors
    /// [`NotPluggable`] if the file does not admit them.
    pub fn plugged(self, modules: &[usize]) -> Result<Self, NotPluggable> {
        let modules: Vec<_> = modules.iter().copied().map(Some).collect();
        self.with_slots(&modules)
    }

    /// The same with empty slots: `None`.
    ///
    /// # Errors
    /// As [`Station::plugged`].
    pub fn with_slots(mut self, modules: &[Option<usize>]) -> Result<Self, NotPluggable> {
        let identifiers = |place: &Option<usize>| match place {
            Some(place) => self.gsd.modules.get(*place).map(|module| module.identifiers.clone()),
            None => Some(vec![EMPTY_SLOT]),
        };
        let configuration: Vec<u8> = modules.iter().filter_map(identifiers).flatten().collect();
        if let Err(refusal) = self.modules(&configuration, None) {
            return Err(NotPluggable { words: self.words_of(&refusal) });
        }
        if self.modular {
            admits(&self.gsd, modules).map_err(|words| NotPluggable { words })?;
            self.plugged = Some(modules.to_vec());
        }
        self.configuration = configuration;
        Ok(self)
    }

    /// The same station, which takes a configuration of other modules than those plugged in, and reports them as wrong or
    /// missing.
    #[must_use]
    pub fn reporting(self, reports: bool) -> Self {
        Self { reports, ..self }
    }

    /// What is plugged in the slot at this place of the configuration; `None`: what the master says.
    pub(crate) fn in_slot(&self, place: usize) -> Option<Option<usize>> {
        self.plugged.as_ref().map(|plugged| plugged.get(place).copied().flatten())
    }

    /// Whether it takes one configuration only, which Get_Cfg reports.
    pub(crate) const fn is_fixed(&self) -> bool {
        self.plugged.is_some() || !self.modular
    }

    /// The words of a refusal, while they are kept.
    fn words_of(&self, refusal: &Refusal) -> String {
        let said = self.said.borrow();
        let words =
            |number: u16| said.1.iter().find(|(kept, _)| *kept == number).map(|(_, words)| words.clone());
        if let Reason::Numbered(number) = refusal.reason {
            words(number).unwrap_or_default()
        } else {
            String::new()
        }
    }

    /// The file.
    pub const fn gsd(&self) -> &Gsd {
        &self.gsd
    }

    /// What the slave is, for [`dp::Station::new`](crate::profibus::dp::Station::new).
    pub fn description(&self) -> Description {
        let flags = self.gsd.flags;
        let (least, most) = self.prm_lengths;
        let most = if self.policy.any_user_prm && most == 0 { MAX_USER_PRM_LEN } else { most };
        let status_len = if flags.dpv1 { 3 } else { 0 };
        Description {
            ident: self.gsd.ident,
            rates: self.gsd.rates,
            user_prm_len: least.saturating_sub(status_len),
            max_user_prm_len: most.saturating_sub(status_len),
            dpv1_status: flags.dpv1.then(|| self.status_bits()),
            max_diag_len: self.gsd.max_diag_len,
            sync_mode: flags.sync,
            freeze_mode: flags.freeze,
            fail_safe: flags.fail_safe || flags.fail_safe_required,
            fail_safe_optional: !flags.fail_safe_required,
            set_slave_add: flags.set_slave_add,
            user_watchdog: None,
        }
    }

    /// The bits of DPV1_Status that a master may set: all but those that the file excludes. What its own defaults
    /// set is taken, too.
    fn status_bits(&self) -> [u8; dpv1_status::LEN] {
        let flags = self.gsd.flags;
        let without = |bit: u8, supported: bool| if supported { 0xFF } else { !bit };
        let [one, two, three] = self.gsd.acyclic.lacks();
        let mut bits = [
            without(Status1::WdBase1ms.mask(), flags.watchdog_1ms)
                & without(Status1::FailSafe.mask(), flags.fail_safe || flags.fail_safe_required)
                & !one,
            !two,
            without(Status3::PrmStructure.mask(), flags.prm_blocks) & !three,
        ];
        for (bits, default) in bits.iter_mut().zip(&self.default_prm) {
            *bits |= *default;
        }
        bits
    }

    /// The modules of a configuration that is accepted, slot by slot: places in [`Gsd::modules`]. Modules with equal
    /// identifiers are all there, unless the modules are plugged in by name or the user parameters are those of some of them
    /// only; a slot without any is 00 that the file does not have.
    ///
    /// # Errors
    /// As [`Application::judge_cfg`], but for the user parameters.
    pub fn modules(&self, configuration: &[u8], user_prm: Option<&[u8]>) -> Result<Plugged, Refusal> {
        self.read(configuration, user_prm).map(|reading| reading.plugged)
    }

    fn read(&self, configuration: &[u8], user_prm: Option<&[u8]>) -> Result<Reading, Refusal> {
        let refuse = |index: usize, expected: Expected, words: String| {
            self.refusal(index, expected, configuration.get(index).copied(), words)
        };
        if configuration.is_empty() {
            return Err(refuse(0, Expected::AsReasoned, "a configuration has 1 to 244 octets".into()));
        }
        let lengths = IoLengths::of(configuration).map_err(|syntax| match syntax {
            CfgSyntax::CutOff => {
                let words = "an identifier ends too early: the length octets or manufacturer octets it announces are missing";
                refuse(configuration.len(), Expected::AsReasoned, words.into())
            }
            CfgSyntax::TooLong { got } => {
                refuse(0, Expected::AsReasoned, format!("{got} octets in one direction, expected at most 244"))
            }
        })?;
        let prm = user_prm.map(|octets| UserPrm { octets, start: self.part_len });
        if !self.modular && !self.gsd.modules.is_empty() {
            self.compact(configuration)?;
            let all: Vec<_> = (0..self.gsd.modules.len()).map(Some).collect();
            return Ok(Reading::of(&self.gsd, &all, prm));
        }
        let reading = if self.gsd.modules.is_empty() {
            // G-09: whatever fits.
            Reading::of(&self.gsd, &[], prm)
        } else {
            split(&self.gsd, self.policy.free_slots, configuration, prm).map_err(|stuck| {
                let expected = stuck.expected.map_or(Expected::AsReasoned, Expected::Octet);
                refuse(stuck.index, expected, stuck.words)
            })?
        };
        let (inputs, outputs) = (u16::from(lengths.inputs), u16::from(lengths.outputs));
        for (keyword, got, most) in [
            ("Max_Input_Len", inputs, self.gsd.max_input_len),
            ("Max_Output_Len", outputs, self.gsd.max_output_len),
            ("Max_Data_Len", inputs + outputs, self.gsd.max_data_len),
        ] {
            if let Some(most) = most.filter(|most| got > *most) {
                let words = format!("the modules have {got} octets, {keyword} is {most}: take modules out");
                return Err(refuse(configuration.len(), Expected::AsReasoned, words));
            }
        }
        match &self.plugged {
            Some(modules) if configuration == self.configuration => Ok(Reading::of(&self.gsd, modules, prm)),
            Some(_) if !self.reports => Err(self.otherwise_plugged(configuration)),
            Some(_) | None => Ok(reading),
        }
    }

    /// The refusal of a configuration that is not that of the modules plugged in.
    fn otherwise_plugged(&self, configuration: &[u8]) -> Refusal {
        let agrees =
            configuration.iter().zip(&self.configuration).take_while(|(got, own)| got == own).count();
        let expected = self.configuration.get(agrees).map_or(Expected::End, |octet| Expected::Octet(*octet));
        let layout = self.layout(&self.configuration, None);
        let words = match layout.iter().find(|placed| placed.octets.contains(&agrees)) {
            Some(placed) => {
                format!("module '{}' is plugged in slot {}", placed.name(&self.gsd), placed.slot.number)
            }
            None => format!("{} modules are plugged in: take the others out", layout.len()),
        };
        self.refusal(agrees, expected, configuration.get(agrees).copied(), words)
    }

    fn compact(&self, configuration: &[u8]) -> Result<(), Refusal> {
        if configuration == self.configuration {
            return Ok(());
        }
        let agrees =
            configuration.iter().zip(&self.configuration).take_while(|(got, own)| got == own).count();
        let expected = self.configuration.get(agrees).map_or(Expected::End, |octet| Expected::Octet(*octet));
        let mut behind = agrees;
        let module = self.gsd.modules.iter().find(|module| {
            let is_in = behind < module.identifiers.len();
            behind = behind.saturating_sub(module.identifiers.len());
            is_in
        });
        let own = hex(&self.configuration);
        let words = match module {
            Some(module) => {
                format!("module '{}' stands here; the station has the one configuration {own}", module.name)
            }
            None => format!("the station has the one configuration {own}"),
        };
        Err(self.refusal(agrees, expected, configuration.get(agrees).copied(), words))
    }

    /// What is odd in user parameters that are accepted, for the modules of this configuration: values out of range, a length
    /// that is not that of the modules, services that are not emulated. What is right for one reading is not odd.
    pub fn remarks(&self, configuration: &[u8], user_prm: &[u8]) -> Vec<String> {
        let mut remarks = Vec::new();
        self.wrong_values(&self.part, 0, user_prm, None, |_, words| remarks.push(words));
        if let Ok(reading) = self.read(configuration, Some(user_prm)) {
            let len = self.part_len + reading.extent(&self.gsd);
            match reading.agreement {
                Agreement::Open if ![len, self.part_len].contains(&user_prm.len()) => {
                    let got = user_prm.len();
                    remarks.push(format!("{got} octets of user parameters, the modules have {len}"));
                }
                Agreement::Open | Agreement::Values | Agreement::Constants => {}
                Agreement::Length => {
                    self.wrong_in_modules(&reading, user_prm, |_, words| remarks.push(words));
                }
            }
        }
        if let (true, Some([_, status, _])) = (self.gsd.flags.dpv1, user_prm.first_chunk()) {
            let never = |bit: &&Status2| bit.is_set(*status) && !bit.is_set(self.gsd.acyclic.alarms);
            let alarms = Status2::ALL.iter().filter(|bit| **bit != Status2::CheckCfgMode).filter(never);
            let names: Vec<_> = alarms.map(|bit| bit.name()).collect();
            if !names.is_empty() {
                let names = names.join(", ");
                remarks.push(format!(
                    "the master enables alarms that the GSD does not have: {names}; they never come"
                ));
            }
        }
        remarks
    }

    /// The user parameters by parameter and text, as far as they have the length of the modules of this configuration.
    pub(crate) fn prm_values(&self, configuration: &[u8], user_prm: &[u8]) -> Vec<super::PrmValue<'_>> {
        match self.read(configuration, Some(user_prm)) {
            Ok(reading) if reading.agreement != Agreement::Open => {
                let modules: Vec<_> = reading.known().collect();
                self.gsd.prm_values(&modules, user_prm)
            }
            Ok(_) | Err(_) => self.gsd.prm_values(&[], user_prm),
        }
    }

    /// The values out of their ranges in the parts of the modules of one reading.
    fn wrong_in_modules(&self, reading: &Reading, user_prm: &[u8], mut each: impl FnMut(usize, String)) {
        let mut start = self.part_len;
        for module in reading.modules(&self.gsd) {
            self.wrong_values(&module.prm, start, user_prm, Some(&module.name), &mut each);
            start += module.prm.extent(&self.gsd);
        }
    }

    /// Calls `each` with the octet and words of every value of a part that is out of its range.
    fn wrong_values(
        &self,
        part: &PrmPart,
        start: usize,
        user_prm: &[u8],
        module: Option<&str>,
        mut each: impl FnMut(usize, String),
    ) {
        for (offset, parameter) in part.fields(&self.gsd) {
            let Parameter { name, field, allowed, .. } = parameter;
            let got = field.read(user_prm, start + offset).filter(|got| !allowed.contains(*got));
            if let Some(got) = got {
                let of = module.map(|module| format!(" of module '{module}'")).unwrap_or_default();
                each(start + offset, format!("parameter '{name}'{of} is {got}, expected {allowed}"));
            }
        }
    }

    /// What the GSD requires a master to enable.
    fn judge_status(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        let status = user_prm.first_chunk().filter(|_| self.gsd.flags.dpv1);
        let Some((index, bit)) = status.and_then(|status| self.gsd.acyclic.missing(*status)) else {
            return Ok(());
        };
        let words = format!("{bit} is 0, and the GSD requires it: enable it in the master's project");
        Err(self.refusal(index, Expected::AsReasoned, user_prm.get(index).copied(), words))
    }

    fn judge_blocks(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        let structured = user_prm.get(2).is_some_and(|status| Status3::PrmStructure.is_set(*status));
        if !self.gsd.flags.dpv1 || !structured {
            return Ok(());
        }
        let blocks = user_prm.get(dpv1_status::LEN..).unwrap_or_default();
        let Some(at) = dpv1_status::first_wrong_block(blocks) else { return Ok(()) };
        let words = "the length of a parameter block, its four octets of head included, does not end with the user parameters";
        let most = u8::try_from(blocks.len().saturating_sub(at)).unwrap_or(u8::MAX);
        let expected = Expected::Range(dpv1_status::BLOCK_LEAST, most);
        Err(self.refusal(dpv1_status::LEN + at, expected, blocks.get(at).copied(), words.into()))
    }

    /// Keeps the words until so many refusals have followed.
    fn refusal(&self, index: usize, expected: Expected, got: Option<u8>, words: String) -> Refusal {
        let mut said = self.said.borrow_mut();
        let (last, kept) = &mut *said;
        *last = last.wrapping_add(1);
        if kept.len() >= KEPT_WORDS {
            kept.pop_front();
        }
        kept.push_back((*last, words));
        Refusal { index, expected, got, reason: Reason::Numbered(*last) }
    }
}

impl Application for Station {
    fn judge_prm(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        self.judge_status(user_prm)?;
        self.judge_blocks(user_prm)?;
        let mut wrong = None;
        if self.policy.refuse_values {
            self.wrong_values(&self.part, 0, user_prm, None, |octet, words| {
                _ = wrong.get_or_insert((octet, words))
            });
        }
        wrong.map_or(Ok(()), |(index, words)| {
            Err(self.refusal(index, Expected::AsReasoned, user_prm.get(index).copied(), words))
        })
    }

    fn judge_cfg(&self, configuration: &[u8], user_prm: &[u8]) -> Result<(), Refusal> {
        let reading = self.read(configuration, Some(user_prm))?;
        let mut wrong = None;
        match reading.agreement {
            Agreement::Open if self.policy.refuse_prm_length => {
                let (got, len) = (user_prm.len(), self.part_len + reading.extent(&self.gsd));
                wrong =
                    Some(format!("Set_Prm had {got} octets of user parameters, these modules have {len}"));
            }
            Agreement::Length if self.policy.refuse_values => {
                self.wrong_in_modules(&reading, user_prm, |_, words| _ = wrong.get_or_insert(words));
            }
            Agreement::Open | Agreement::Length | Agreement::Values | Agreement::Constants => {}
        }
        wrong.map_or(Ok(()), |words| {
            Err(self.refusal(0, Expected::AsReasoned, configuration.first().copied(), words))
        })
    }

    fn configuration<'a>(&'a self, accepted: Option<&'a [u8]>) -> &'a [u8] {
        accepted.unwrap_or(&self.configuration)
    }

    fn words(&self, number: u16, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said = self.said.borrow();
        match said.1.iter().rev().find(|(said, _)| *said == number) {
            Some((_, words)) => f.write_str(words),
            None => f.write_str("the text of this refusal is no longer kept"),
        }
    }
}
