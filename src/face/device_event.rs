//! What happened in a device, in the words of the device, for those who do not know which one it is.

use core::any::Any;
use core::fmt;
use core::ops::Deref;

use super::{ErrorKind, EventKind, Reason};

/// Something that happened in a device. `Display` is one line of plain English.
pub trait DeviceEvent: Any + fmt::Debug + fmt::Display + Send + Sync {
    /// What it is about, for filters.
    fn kind(&self) -> EventKind;

    /// Which error it tells, for counters; `None`: it tells none.
    fn error(&self) -> Option<ErrorKind> {
        self.kind().error()
    }

    /// Whether it is cyclic detail: a log leaves it out unless asked for more.
    fn is_detail(&self) -> bool {
        false
    }

    /// Each reason, if it is a command that was refused.
    fn each_reason(&self, _tell: &mut dyn FnMut(Reason<'_>)) {}
}

#[cfg(feature = "std")]
type Held = std::sync::Arc<dyn DeviceEvent>;
#[cfg(not(feature = "std"))]
type Held = &'static dyn DeviceEvent;

/// An event of any device.
#[derive(Clone)]
pub struct AnyDeviceEvent {
    event: Held,
    is_same: fn(&dyn DeviceEvent, &dyn DeviceEvent) -> bool,
}

impl AnyDeviceEvent {
    /// This event of a device.
    #[cfg(feature = "std")]
    pub fn new<E: DeviceEvent + PartialEq>(event: E) -> Self {
        Self { event: std::sync::Arc::new(event), is_same: is_same::<E> }
    }

    /// The event, if it is one of that type.
    pub fn of<E: DeviceEvent>(&self) -> Option<&E> {
        event_of(self.as_dyn())
    }

    fn as_dyn(&self) -> &dyn DeviceEvent {
        Deref::deref(&self.event)
    }
}

fn event_of<E: DeviceEvent>(event: &dyn DeviceEvent) -> Option<&E> {
    (event as &dyn Any).downcast_ref()
}

#[cfg(feature = "std")]
fn is_same<E: DeviceEvent + PartialEq>(one: &dyn DeviceEvent, other: &dyn DeviceEvent) -> bool {
    event_of::<E>(one).is_some_and(|one| event_of(other) == Some(one))
}

impl DeviceEvent for AnyDeviceEvent {
    fn kind(&self) -> EventKind {
        self.event.kind()
    }

    fn error(&self) -> Option<ErrorKind> {
        self.event.error()
    }

    fn is_detail(&self) -> bool {
        self.event.is_detail()
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        self.event.each_reason(tell);
    }
}

impl PartialEq for AnyDeviceEvent {
    fn eq(&self, other: &Self) -> bool {
        (self.is_same)(self.as_dyn(), other.as_dyn())
    }
}

impl fmt::Debug for AnyDeviceEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_dyn(), f)
    }
}

impl fmt::Display for AnyDeviceEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self.as_dyn(), f)
    }
}

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq)]
    struct Sign(u8);

    impl fmt::Display for Sign {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "sign {}", self.0)
        }
    }

    impl DeviceEvent for Sign {
        fn kind(&self) -> EventKind {
            EventKind::Fault
        }
    }

    #[derive(Debug, PartialEq)]
    struct Other;

    impl fmt::Display for Other {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("sign 1")
        }
    }

    impl DeviceEvent for Other {
        fn kind(&self) -> EventKind {
            EventKind::Drive
        }
    }

    #[test]
    fn an_event_is_told_and_compared_whichever_device_it_is_of() {
        let event = AnyDeviceEvent::new(Sign(1));
        assert_eq!((event.to_string(), event.error()), ("sign 1".to_owned(), Some(ErrorKind::Fault)));
        assert_eq!(event.of(), Some(&Sign(1)));
        assert_eq!(event.of::<Other>(), None);
        assert_eq!(event, event.clone());
        assert_ne!(event, AnyDeviceEvent::new(Sign(2)));
        assert_ne!(event, AnyDeviceEvent::new(Other), "the same words of another device");
    }
}
