//! What is known of the slave under test.

use core::time::Duration;

use crate::gsd::Gsd;
use crate::host::StationRecords;
use crate::judge::device::Soak;
use crate::profibus::fdl::Address;
use crate::profibus::ppo::PpoType;
use crate::time::BaudRate;

/// The slave under test, and how it is judged.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Its address.
    pub address: Address,
    /// Its ident number; `None`: it says it itself.
    pub ident: Option<u16>,
    /// Its configuration, as Chk_Cfg has it; `None`: that of Get_Cfg.
    pub cfg: Option<Vec<u8>>,
    /// The user parameters of Set_Prm, DPV1_Status included; `None`: those of its device file, else none.
    pub prm: Option<Vec<u8>>,
    /// Its device file.
    pub gsd: Option<Box<Gsd>>,
    /// Its modules, places in [`Gsd::modules`]; empty: as Get_Cfg says.
    pub modules: Vec<usize>,
    /// It is a drive of PROFIDRIVE version 2 with this PPO.
    pub profile: Option<PpoType>,
    /// It is a drive of PROFIdrive 3 or 4: record 47 has its parameters.
    pub profidrive: bool,
    /// What is known of its records; `None`: nothing.
    pub records: Option<Box<StationRecords>>,
    /// Its inputs follow its outputs.
    pub mirror: bool,
    /// The master that owns it while it is judged.
    pub owner: Address,
    /// T_SL; `None`: the customary one of the rate.
    pub slot: Option<Duration>,
    /// Outputs other than zero may be sent, and its address may be changed.
    pub moves_allowed: bool,
    /// Records and parameters may be written. What was in them is written back.
    pub writes_allowed: bool,
    /// Whether what takes long is left out.
    pub quick: bool,
    /// Other rates than that of the line, at which it is tried too.
    pub rates: Vec<BaudRate>,
    /// How long rows are tried again at random; `None`: each is tried once.
    pub soak: Option<Soak>,
    /// The whole may take so long.
    pub limit: Option<Duration>,
}

/// The owner where nobody says which.
const OWNER: u8 = 2;

impl Setup {
    /// A slave of which nothing is known but its address: it says its ident number and configuration itself.
    pub fn new(address: Address) -> Self {
        let owner = if address.number() == OWNER { OWNER + 1 } else { OWNER };
        Self {
            address,
            ident: None,
            cfg: None,
            prm: None,
            gsd: None,
            modules: Vec::new(),
            profile: None,
            profidrive: false,
            records: None,
            mirror: false,
            owner: Address::from_octet(owner),
            slot: None,
            moves_allowed: false,
            writes_allowed: false,
            quick: false,
            rates: Vec::new(),
            soak: None,
            limit: None,
        }
    }

    /// The address of another master.
    pub(super) fn other(&self) -> u8 {
        let taken = [self.address.number(), self.owner.number()];
        (1..=5).rev().find(|address| !taken.contains(address)).unwrap_or(1)
    }

    /// An address at which nobody is.
    pub(super) fn nobody(&self) -> u8 {
        let taken = [self.address.number(), self.owner.number(), self.other()];
        (100..=125).rev().find(|address| !taken.contains(address)).unwrap_or(125)
    }

    /// The user parameters that are sent.
    pub(super) fn user_prm(&self) -> Vec<u8> {
        let of_file = || self.gsd.as_ref().map(|gsd| gsd.default_user_prm(&self.modules));
        self.prm.clone().or_else(of_file).unwrap_or_default()
    }
}
