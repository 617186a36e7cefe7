//! The two words of bits in the process data. What a bit means is not known here.

use core::fmt;

macro_rules! word_of_bits {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
        pub struct $name(u16);

        impl $name {
            /// The word with these 16 bits, known or unknown.
            pub const fn from_raw(raw: u16) -> Self {
                Self(raw)
            }

            /// All 16 bits.
            pub const fn raw(self) -> u16 {
                self.0
            }

            /// Bit `n` of weight 2^n; `false` for the bits from 16 on, which no word has.
            pub const fn bit(self, n: u8) -> bool {
                self.0 & mask(n) != 0
            }

            /// The same word with bit `n` set or cleared; unchanged for the bits from 16 on.
            #[must_use]
            pub const fn with_bit(self, n: u8, on: bool) -> Self {
                if on { Self(self.0 | mask(n)) } else { Self(self.0 & !mask(n)) }
            }
        }

        impl From<$name> for u16 {
            fn from(word: $name) -> Self {
                word.0
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!(stringify!($name), "({:#06X})"), self.0)
            }
        }

        impl fmt::Display for $name {
            /// Four hexadecimal digits, as the manuals print it.
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{:04X}", self.0)
            }
        }
    };
}

word_of_bits! {
    /// Control word STW, word 5 from the master to the slave (manual tables 11 and 13).
    #[doc(alias = "control word")]
    Stw
}

word_of_bits! {
    /// Status word ZSW, word 5 from the slave to the master (manual tables 12 and 14).
    #[doc(alias = "status word")]
    Zsw
}

const fn mask(n: u8) -> u16 {
    if n < 16 { 1 << n } else { 0 }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn bits_count_from_the_lowest() {
        let stw = Stw::from_raw(0x820B);
        let set: std::vec::Vec<u8> = (0..=u8::MAX).filter(|&n| stw.bit(n)).collect();
        assert_eq!(set, [0, 1, 3, 9, 15]);
    }

    #[test]
    fn a_word_is_built_bit_by_bit() {
        let zsw = [0, 1, 5, 8, 9, 11, 13].into_iter().fold(Zsw::default(), |zsw, n| zsw.with_bit(n, true));
        assert_eq!(zsw.raw(), 0x2B23);
        assert_eq!(zsw.with_bit(0, false).raw(), 0x2B22);
        assert_eq!(zsw.with_bit(16, true), zsw);
    }

    #[test]
    fn words_print_as_in_the_manual() {
        assert_eq!(format!("{} {:?}", Stw::from_raw(0xB), Zsw::from_raw(0x2B23)), "000B Zsw(0x2B23)");
    }
}
