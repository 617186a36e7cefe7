//! Words of bits: each bit once, with its number and its name.

/// An enum of the bits of a word: `Bit = number: name;`. A bit without a row has no meaning.
macro_rules! bits_of_word {
    ($(#[$doc:meta])* $name:ident { $($(#[$bit_doc:meta])* $bit:ident = $n:literal: $text:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum $name {
            $(
                #[doc = concat!("Bit ", $n, ": ", $text, ".")]
                $(#[doc = ""] #[$bit_doc])*
                $bit = $n,
            )*
        }

        impl $name {
            /// Every bit with a meaning, the lowest first.
            pub const ALL: &'static [Self] = &[$(Self::$bit),*];

            /// Its number in the word: the bit has the weight 2^n.
            pub const fn number(self) -> u8 {
                self as u8
            }

            /// What it is called, or what 1 means.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$bit => $text,)* }
            }

            /// The word in which it alone is 1.
            pub const fn mask(self) -> u16 {
                1 << self.number()
            }

            /// The word in which it alone is 1 if `set`, and nothing otherwise.
            pub const fn when(self, set: bool) -> u16 {
                (set as u16) << self.number()
            }

            /// Whether it is 1 in a word.
            pub fn is_set(self, word: impl Into<u16>) -> bool {
                word.into() & self.mask() != 0
            }
        }
    };
}

pub(crate) use bits_of_word;
