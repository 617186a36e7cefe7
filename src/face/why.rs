//! Why something does not move: one form for every device on either bus, and for a master that looks at one.

use core::fmt;

/// One thing that keeps a device from moving. `Display` is its sentence.
#[derive(Clone, Copy)]
pub struct Reason<'a> {
    /// A name that stays, for programs: `SyncHolds`.
    pub name: &'static str,
    /// What, where it shows on this bus, and what to do about it.
    pub text: &'a dyn fmt::Display,
}

impl<'a> Reason<'a> {
    /// A reason of that name, in these words.
    pub const fn new(name: &'static str, text: &'a dyn fmt::Display) -> Self {
        Self { name, text }
    }
}

impl fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.text.fmt(f)
    }
}

/// What can be asked why it does not move.
///
/// `Display` of `dyn Why` is one line with every reason: `it does not move: ...; ...; next: ...`.
pub trait Why {
    /// What it does when nothing keeps it from that: `move`, or `turn` where there are no positions.
    fn verb(&self) -> &'static str {
        "move"
    }

    /// Whether it moves, so that nothing keeps it from that; `None`: it does not say.
    fn is_moving(&self) -> Option<bool> {
        None
    }

    /// Each reason why it does not move, the most important first. None: it moves, or waits for a start.
    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>));

    /// What to send until it moves. Nothing: it moves, or nothing that is sent helps before the reasons are removed.
    fn next(&self, _say: &mut dyn FnMut(&dyn fmt::Display)) {}

    /// What it waits for where it has no reason; `None`: for nothing.
    fn waits(&self) -> Option<&dyn fmt::Display> {
        None
    }
}

impl fmt::Display for dyn Why + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verb = self.verb();
        if self.is_moving() == Some(true) {
            return write!(f, "it {verb}s");
        }
        let mut result = Ok(());
        let mut told = false;
        self.each_reason(&mut |reason| {
            let written = match told {
                false => write!(f, "it does not {verb}: {reason}"),
                true => write!(f, "; {reason}"),
            };
            told = true;
            result = result.and(written);
        });
        result?;
        if !told {
            match self.waits() {
                Some(waits) => waits.fmt(f)?,
                None => write!(f, "nothing keeps it from {}ing", verb.trim_end_matches('e'))?,
            }
        }
        self.next(&mut |next| result = result.and(write!(f, "; next: {next}")));
        result
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    struct Shaft {
        moving: Option<bool>,
        reasons: &'static [&'static str],
        next: Option<&'static str>,
    }

    impl Why for Shaft {
        fn is_moving(&self) -> Option<bool> {
            self.moving
        }

        fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
            self.reasons.iter().for_each(|text| tell(Reason::new("Reason", text)));
        }

        fn next(&self, say: &mut dyn FnMut(&dyn fmt::Display)) {
            if let Some(next) = self.next {
                say(&next);
            }
        }
    }

    #[test]
    fn one_line_has_every_reason_and_what_to_send() {
        let line = |moving, reasons, next| (&Shaft { moving, reasons, next } as &dyn Why).to_string();
        assert_eq!(line(Some(true), &[], None), "it moves");
        assert_eq!(line(None, &[], None), "nothing keeps it from moving");
        assert_eq!(line(Some(false), &["a", "b"], None), "it does not move: a; b");
        assert_eq!(line(None, &["a"], Some("send 6")), "it does not move: a; next: send 6");
        assert_eq!(line(None, &[], Some("send 6")), "nothing keeps it from moving; next: send 6");
    }
}
