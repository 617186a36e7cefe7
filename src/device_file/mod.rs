//! What every kind of device file needs: octets as text, and what is odd in a file with its place.

mod hint;
mod text;

pub use hint::{Hint, Level, Place, did_you_mean};
pub use text::CodePage;

pub(crate) use text::{Utf16, decode};
