//! Any octets: no panic; what is accepted is encoded to the same octets; what is refused is dropped by at least one
//! octet and never by more than there are; every prefix of a telegram is incomplete.

use profidrive::fdl::telegram::{Decoded, MAX_TELEGRAM_LEN, Telegram, decode};

pub(crate) fn check(octets: &[u8]) {
    match decode(octets) {
        Decoded::Incomplete => assert!(octets.len() < MAX_TELEGRAM_LEN),
        Decoded::Invalid { skip, .. } => assert!((1..=octets.len()).contains(&skip)),
        Decoded::Telegram { telegram, len } => {
            let mut buf = [0xA5; MAX_TELEGRAM_LEN];
            assert_eq!(telegram.encode(&mut buf), Ok(&octets[..len]));
            assert!(buf[len..].iter().all(|octet| *octet == 0xA5), "wrote past its end");
            assert_eq!(decode(&octets[..len]), decode(octets), "octets behind it matter");
            for prefix in 0..len {
                assert_eq!(decode(&octets[..prefix]), Decoded::Incomplete);
            }
            if let Telegram::Data(data) = telegram {
                assert!(data.data.len() <= 246);
                assert!(
                    telegram.encode(&mut [0; MAX_TELEGRAM_LEN][..len - 1]).is_err(),
                    "fits where it cannot"
                );
            }
        }
    }
}
