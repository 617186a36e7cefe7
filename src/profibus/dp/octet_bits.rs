//! The bits of one octet as an enum: number, name, and what 1 and 0 mean, each once. A bit without a row is reserved.

macro_rules! octet_bits {
    ($(#[$doc:meta])* $name:ident { $($bit:ident = $n:literal: $text:literal, $one:literal, $zero:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name {
            $(
                #[doc = concat!("Bit ", $n, ", ", $text, ": ", $one, ".")]
                $bit,
            )*
        }

        impl $name {
            /// Every used bit, the highest first.
            pub const ALL: &[Self] = &[$(Self::$bit),*];

            /// The bits that are not used.
            pub const RESERVED: u8 = !(0 $(| 1 << $n)*);

            /// Its number in the octet, 0 to 7.
            pub const fn number(self) -> u8 {
                match self { $(Self::$bit => $n,)* }
            }

            /// The name in the standard.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$bit => $text,)* }
            }

            /// What 1 means, in a few words.
            pub const fn one(self) -> &'static str {
                match self { $(Self::$bit => $one,)* }
            }

            /// What 0 means, in a few words.
            pub const fn zero(self) -> &'static str {
                match self { $(Self::$bit => $zero,)* }
            }

            /// The octet in which it alone is 1.
            pub const fn mask(self) -> u8 {
                1 << self.number()
            }

            /// Whether it is 1 in this octet.
            pub const fn is_set(self, octet: u8) -> bool {
                octet & self.mask() != 0
            }

            /// The bit of this number; `None` if it is reserved.
            pub fn at(number: u8) -> Option<Self> {
                Self::ALL.iter().copied().find(|bit| bit.number() == number)
            }
        }
    };
}

pub(super) use octet_bits;
