//! Any octets: no panic; what is accepted is encoded to the same octets; what is refused is dropped by at least one
//! octet and never by more than there are; every prefix of a telegram is incomplete; what is refused stays refused
//! for the same reason, whatever follows.

use profidrive::profibus::fdl::telegram::{
    Decoded, EncodeError, MAX_PDU_LEN, MAX_TELEGRAM_LEN, Telegram, decode,
};

pub(crate) fn check(octets: &[u8]) {
    match decode(octets) {
        Decoded::Incomplete => {
            assert!(octets.len() < MAX_TELEGRAM_LEN);
            for prefix in 0..octets.len() {
                assert_eq!(decode(&octets[..prefix]), Decoded::Incomplete);
            }
        }
        Decoded::Invalid { skip, error } => {
            assert!((1..=octets.len()).contains(&skip));
            let first = (0..octets.len()).find(|end| decode(&octets[..*end]) != Decoded::Incomplete);
            for end in first.unwrap_or(octets.len())..octets.len() {
                assert!(
                    matches!(decode(&octets[..end]), Decoded::Invalid { error: same, skip } if same == error && skip <= end)
                );
            }
            // The message can be written.
            assert!(!error.to_string().is_empty());
        }
        Decoded::Telegram { telegram, len } => {
            let mut buf = [0xA5; MAX_TELEGRAM_LEN];
            assert_eq!(telegram.encode(&mut buf), Ok(&octets[..len]));
            assert!(buf[len..].iter().all(|octet| *octet == 0xA5), "wrote past its end");
            assert_eq!(decode(&octets[..len]), decode(octets), "octets behind it matter");
            for prefix in 0..len {
                assert_eq!(decode(&octets[..prefix]), Decoded::Incomplete);
            }
            let mut short = [0xA5; MAX_TELEGRAM_LEN];
            let refused = telegram.encode(&mut short[..len - 1]);
            assert_eq!(refused, Err(EncodeError::BufferTooSmall { needed: len, got: len - 1 }));
            assert!(short.iter().all(|octet| *octet == 0xA5), "refused and written");
            if let Telegram::Data(data) = telegram {
                let saps = usize::from(data.dsap.is_some()) + usize::from(data.ssap.is_some());
                assert!(data.data.len() + saps <= MAX_PDU_LEN);
            }
        }
    }
}
