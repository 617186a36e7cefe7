//! The text of a file.

use std::borrow::Cow;

use super::MAX_FILE_LEN;
use super::hint::ReadError;
use crate::device_file;

pub use crate::device_file::CodePage;

/// The text of a file.
pub(super) fn decode(octets: &[u8]) -> Result<(Cow<'_, str>, CodePage), ReadError> {
    if octets.len() > MAX_FILE_LEN {
        return Err(ReadError::TooLong { got: octets.len() });
    }
    device_file::decode(octets).map_err(|device_file::Utf16| ReadError::Utf16)
}

/// A string of the file without the blanks and signs that no display shows.
pub(super) fn trimmed(text: &str) -> String {
    text.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_file_is_longer_than_the_limit() {
        let long = std::vec![b' '; MAX_FILE_LEN + 1];
        assert_eq!(decode(&long), Err(ReadError::TooLong { got: MAX_FILE_LEN + 1 }));
        assert!(decode(&long[1..]).is_ok());
    }
}
