//! Numbers of stations in words.

use core::fmt;

/// The numbers whose bits are 1, as `3, 5 to 8`.
pub(super) struct Ranges(pub(super) u128);

impl fmt::Display for Ranges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rest = self.0;
        let mut first = true;
        while rest != 0 {
            let begin = rest.trailing_zeros();
            let count = (!(rest >> begin)).trailing_zeros();
            let gap = if core::mem::take(&mut first) { "" } else { ", " };
            let end = begin + count - 1;
            match count {
                1 => write!(f, "{gap}{begin}")?,
                2 => write!(f, "{gap}{begin}, {end}")?,
                _more => write!(f, "{gap}{begin} to {end}")?,
            }
            rest = rest.checked_shr(end + 1).unwrap_or(0).checked_shl(end + 1).unwrap_or(0);
        }
        Ok(())
    }
}
