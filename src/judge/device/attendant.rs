//! Who does by hand what the bus cannot: switches the device off and on, sets its inputs.

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
