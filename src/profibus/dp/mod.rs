//! Layers 2 and 3, DP: what the service access points of a DP-V0 slave mean, and the slave behind them.
//!
//! ```text
//! SAP        service          request             reply        who may ask, and when
//! none       Data_Exchange    outputs             inputs, SC   the owner in DATA-EXCH
//! 55 (0x37)  Set_Slave_Add    4..=244 octets      SC           everybody in WAIT-PRM, where the description allows
//! 56 (0x38)  RD_Inp           -                   inputs       everybody in DATA-EXCH
//! 57 (0x39)  RD_Outp          -                   outputs      everybody in DATA-EXCH
//! 58 (0x3A)  Global_Control   command, groups     never        the owner in DATA-EXCH
//! 59 (0x3B)  Get_Cfg          -                   cfg          everybody, always
//! 60 (0x3C)  Slave_Diag       -                   diagnosis    everybody, always
//! 61 (0x3D)  Set_Prm          7..=244 octets      SC           everybody, always; the owner alone has effect
//! 62 (0x3E)  Chk_Cfg          1..=244 octets      SC           the owner in WAIT-CFG and DATA-EXCH
//! ```
//!
//! Source: `dp-v0.md` 4 (DIN 19245 part 3 / EN 50170 part 8 and slave ASIC manuals, read at second hand). What a
//! service is not allowed to do now is answered with RS, a read service with data in its request with RR.
//!
//! The slave answers each telegram from buffers, as the ASIC of a real device does: a Data_Exchange reply carries
//! the inputs that were ready before its outputs were seen.
//!
//! Any device is served: a [`Description`] says what it is, a [`Policy`] how it behaves where the sources are
//! silent, an [`Application`] judges user parameters and configurations, and talks to a [`Station`]: inputs, outputs,
//! diagnosis. The drives are one user.

pub mod application;
mod buffer;
pub mod chk_cfg;
pub(crate) mod description;
mod diag_bit;
pub mod dpv1_status;
pub(crate) mod event;
pub mod ext_diag;
pub mod framed;
pub mod global_control;
mod octet_bits;
pub mod policy;
mod process_data;
pub(crate) mod set_prm;
pub(crate) mod set_slave_add;
pub(crate) mod slave;
pub(crate) mod slave_diag;
pub(crate) mod state;
pub mod station;
mod watchdog;

pub use crate::profibus::fdl::Rates;
pub use application::{Application, Fixed, Reason, Refusal};
pub use chk_cfg::{CfgFault, CfgSyntax, Identifier, IoLengths};
pub use description::Description;
pub use diag_bit::{DiagBit, Tells};
pub use event::{Configuration, Event, NotServed};
pub use ext_diag::ExtDiag;
pub use framed::Framed;
pub use global_control::{ControlBit, GlobalControl};
pub use policy::Policy;
pub use set_prm::{PrmBit, PrmFault, SetPrm};
pub use set_slave_add::{AddressFault, SetSlaveAdd, StoredAddress};
pub use slave::{CfgTicket, Slave};
pub use slave_diag::Diagnosis;
pub use state::{State, Stimulus};
pub use station::{Outcome, Station};

use crate::profibus::fdl::Sap;
use policy::NoEffect;

macro_rules! services {
    ($($service:ident = $sap:literal: $name:literal, $what:literal;)*) => {
        /// A service of a DP-V0 slave.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Service {
            $(
                #[doc = concat!("SAP ", $sap, ": ", $what, ".")]
                $service,
            )*
            /// No SAP: exchange outputs and inputs.
            DataExchange,
        }

        impl Service {
            /// Every service, by its SAP, Data_Exchange last.
            pub const ALL: &[Self] = &[$(Self::$service,)* Self::DataExchange];

            /// The standard's name: `Chk_Cfg`.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$service => $name,)*
                    Self::DataExchange => "Data_Exchange",
                }
            }

            /// The service access point where the slave listens for it.
            pub const fn sap(self) -> Option<Sap> {
                match self {
                    $(Self::$service => Sap::new($sap),)*
                    Self::DataExchange => None,
                }
            }

            /// The service of a request, `None` where nothing listens.
            pub const fn of(dsap: Option<Sap>, ssap: Option<Sap>) -> Option<Self> {
                match (dsap, ssap) {
                    (None, None) => Some(Self::DataExchange),
                    (Some(dsap), _) => match dsap.number() {
                        $($sap => Some(Self::$service),)*
                        ..=54 | 63.. => None,
                    },
                    (None, Some(_)) => None,
                }
            }
        }
    };
}

services! {
    SetSlaveAdd = 55: "Set_Slave_Add", "take another station address";
    RdInp = 56: "RD_Inp", "read the inputs";
    RdOutp = 57: "RD_Outp", "read the outputs";
    GlobalControl = 58: "Global_Control", "clear, sync, freeze";
    GetCfg = 59: "Get_Cfg", "read the configuration";
    SlaveDiag = 60: "Slave_Diag", "read the diagnosis";
    SetPrm = 61: "Set_Prm", "set the parameters of the slave";
    ChkCfg = 62: "Chk_Cfg", "check the configuration";
}

/// The service access point of a master, from which it asks.
pub(crate) const MASTER_SAP: Option<Sap> = Sap::new(62);

impl Service {
    /// Whether the service may run now, for this caller (`dp-v0.md` 4.1).
    pub(crate) const fn access(self, state: State, caller: Caller, policy: &Policy) -> Access {
        match (self, state, caller) {
            (Self::SlaveDiag | Self::GetCfg | Self::SetPrm, _, _) => Access::Run,
            (Self::RdInp | Self::RdOutp, State::DataExch, _) => Access::Run,
            (Self::RdInp | Self::RdOutp, State::WaitPrm | State::WaitCfg, _) => Access::NotActivated,
            (Self::ChkCfg, State::WaitCfg | State::DataExch, Caller::Owner) => Access::Run,
            (Self::ChkCfg, State::WaitCfg | State::DataExch, Caller::Other) => {
                policy.foreign_chk_cfg.access()
            }
            (Self::ChkCfg, State::WaitPrm, _) => policy.chk_cfg_in_wait_prm.access(),
            (Self::DataExchange, State::DataExch, Caller::Owner) => Access::Run,
            (Self::DataExchange, State::DataExch, Caller::Other) => Access::NotActivated,
            (Self::DataExchange, State::WaitPrm | State::WaitCfg, _) => Access::NotActivated,
            (Self::GlobalControl, State::DataExch, Caller::Owner) => Access::Run,
            (Self::GlobalControl, State::DataExch, Caller::Other) => Access::Ignored,
            (Self::GlobalControl, State::WaitPrm | State::WaitCfg, _) => Access::Ignored,
            (Self::SetSlaveAdd, State::WaitPrm, _) => Access::Run,
            (Self::SetSlaveAdd, State::WaitCfg | State::DataExch, _) => policy.late_set_slave_add.access(),
        }
    }
}

/// Who asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Caller {
    /// The master whose Set_Prm was accepted: Master_Add.
    Owner,
    /// Any other master, or any while there is no owner.
    Other,
}

/// What becomes of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Access {
    /// The service runs.
    Run,
    /// It is refused with RS.
    NotActivated,
    /// It has no effect and is answered with SC.
    Acknowledged,
    /// It has no effect and, being an SDN service, no reply.
    Ignored,
}

impl NoEffect {
    const fn access(self) -> Access {
        match self {
            Self::Acknowledged => Access::Acknowledged,
            Self::NotActivated => Access::NotActivated,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sap_opens_what_the_table_says_and_nothing_else() {
        let open = [
            (55, Service::SetSlaveAdd),
            (56, Service::RdInp),
            (57, Service::RdOutp),
            (58, Service::GlobalControl),
            (59, Service::GetCfg),
            (60, Service::SlaveDiag),
            (61, Service::SetPrm),
            (62, Service::ChkCfg),
        ];
        for number in 0..64 {
            let expected = open.iter().find(|row| row.0 == number).map(|row| row.1);
            assert_eq!(Service::of(Sap::new(number), Sap::new(62)), expected, "SAP {number}");
        }
        assert_eq!(Service::of(None, None), Some(Service::DataExchange));
        assert_eq!(Service::of(None, Sap::new(62)), None);
    }

    #[test]
    fn access_is_the_table_of_the_reference() {
        use Access::{Ignored as Ign, NotActivated as Rs, Run};
        use Caller::{Other, Owner};
        use State::{DataExch, WaitCfg, WaitPrm};
        let columns = [
            (WaitPrm, Owner),
            (WaitPrm, Other),
            (WaitCfg, Owner),
            (WaitCfg, Other),
            (DataExch, Owner),
            (DataExch, Other),
        ];
        for (service, row) in [
            (Service::SlaveDiag, [Run, Run, Run, Run, Run, Run]),
            (Service::GetCfg, [Run, Run, Run, Run, Run, Run]),
            (Service::SetPrm, [Run, Run, Run, Run, Run, Run]),
            (Service::SetSlaveAdd, [Run, Run, Rs, Rs, Rs, Rs]),
            (Service::ChkCfg, [Rs, Rs, Run, Rs, Run, Rs]),
            (Service::RdInp, [Rs, Rs, Rs, Rs, Run, Run]),
            (Service::RdOutp, [Rs, Rs, Rs, Rs, Run, Run]),
            (Service::GlobalControl, [Ign, Ign, Ign, Ign, Run, Ign]),
            (Service::DataExchange, [Rs, Rs, Rs, Rs, Run, Rs]),
        ] {
            for ((state, caller), expected) in columns.into_iter().zip(row) {
                let access = service.access(state, caller, &Policy::PROPOSED);
                assert_eq!(access, expected, "{service:?} {state:?} {caller:?}");
            }
        }
    }
}
