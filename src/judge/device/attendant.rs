//! Who does by hand what the bus cannot: switches the device off and on, sets its inputs.

use core::fmt;

use super::course::{Course, Halt, inapplicable};

/// Does an action at the device under test, and says what there is to say.
///
/// | action | does |
/// | --- | --- |
/// | `power-cycle` | switches it off and on |
/// | `new-device` | makes it as delivered |
/// | `set-input HEX` | sets its inputs, as Data_Exchange has them |
/// | `read-output` | says its outputs in hex |
/// | `set-diag HEX`, `set-diag none` | files this extended diagnosis, with Ext_Diag; takes it back |
/// | `set-fault NAME`, `set-fault none` | brings a fault about; mends it |
/// | `set-address N` | sets its switches to an address |
/// | `press KEY` | presses a key |
///
/// The effect must be there within a second.
pub trait Attendant {
    /// Does it: what it says, or `None` if it cannot.
    fn act(&mut self, action: &str) -> Option<String>;
}

impl<F: FnMut(&str) -> Option<String>> Attendant for F {
    fn act(&mut self, action: &str) -> Option<String> {
        self(action)
    }
}

/// The attendant of a judgement, if it has one.
pub(super) struct Attended(pub(super) Option<Box<dyn Attendant>>);

impl Attended {
    /// Has an action done; the row cannot be judged without.
    pub(super) fn act(&mut self, action: &str) -> Course<String> {
        let Some(attendant) = &mut self.0 else {
            return inapplicable(format!("needs --ask: a command that does '{action}'"));
        };
        let said = attendant.act(action);
        said.ok_or_else(|| Halt::Inapplicable(format!("--ask does not do '{action}'")))
    }
}

impl fmt::Debug for Attended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Attended").field(&self.0.is_some()).finish()
    }
}
