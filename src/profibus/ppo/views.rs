//! Views and builders of every type of PPO, from one description each.

/// `Outputs`, `Inputs` and their length for a type with these parts:
///
/// - `with pkw` if it has the parameter channel;
/// - `main TYPE at OCTET..`: where the main setpoint and actual value lie, behind STW or ZSW;
/// - `more WORDS at OCTET..` if process data follow it.
macro_rules! ppo_views {
    (
        $(#[$outputs_doc:meta])* $outputs:ident,
        $(#[$inputs_doc:meta])* $inputs:ident,
        $(#[$len_doc:meta])* $len:ident = $octets:literal,
        $(with $pkw:ident,)?
        word at $word:literal, main $main:ident at $value:literal
        $(, more $more:literal at $rest:literal)?
    ) => {
        $(#[$len_doc])*
        pub const $len: usize = $octets;

        $crate::profibus::ppo::views::ppo_view! {
            $(#[$outputs_doc])* $outputs, $len = $octets,
            "Words 1 to 4, the job of the parameter channel.",
            stw: $crate::profibus::ppo::Stw, "The control word, ahead of the setpoint.",
            hsw, "The main setpoint HSW (unit and meaning depend on the drive and its operating mode).",
            ($($pkw)?), $word, $main, $value, ($($more, $rest)?)
        }

        $crate::profibus::ppo::views::ppo_view! {
            $(#[$inputs_doc])* $inputs, $len = $octets,
            "Words 1 to 4, the reply of the parameter channel.",
            zsw: $crate::profibus::ppo::Zsw, "The status word, ahead of the actual value.",
            hiw, "The main actual value HIW (unit and meaning depend on the drive and its operating mode).",
            ($($pkw)?), $word, $main, $value, ($($more, $rest)?)
        }
    };
}

macro_rules! ppo_view {
    (
        $(#[$doc:meta])* $view:ident, $len:ident = $octets:literal,
        $pkw_doc:literal,
        $word_name:ident: $word_type:ty, $word_doc:literal,
        $main_name:ident, $main_doc:literal,
        ($($pkw:ident)?), $word:literal, $main:ident, $value:literal, ($($more:literal, $rest:literal)?)
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct $view<'a>(&'a [u8; $octets]);

        impl<'a> $view<'a> {
            /// The view of octets that are known to be so many.
            pub const fn new(octets: &'a [u8; $octets]) -> Self {
                Self(octets)
            }

            /// The view of a slice that holds nothing else.
            ///
            /// # Errors
            #[doc = concat!(
                "[`LengthError`](crate::profibus::ppo::LengthError) unless the slice has exactly ", stringify!($octets), " octets."
            )]
            pub fn parse(octets: &'a [u8]) -> Result<Self, $crate::profibus::ppo::LengthError> {
                $crate::profibus::ppo::whole(octets).map(Self)
            }

            /// The octets with these fields.
            pub const fn octets(
                $($pkw: $crate::profibus::ppo::Pkw,)?
                $word_name: $word_type,
                $main_name: $main,
                $(pzd: [u16; $more],)?
            ) -> [u8; $octets] {
                let mut octets = [0; $octets];
                $($crate::profibus::ppo::views::put(&mut octets, 0, &$pkw.to_octets());)?
                $crate::profibus::ppo::views::put(&mut octets, $word, &$word_name.raw().to_be_bytes());
                $crate::profibus::ppo::views::put(&mut octets, $value, &$main_name.to_be_bytes());
                $(
                    let (mut at, mut words): (usize, &[u16]) = ($rest, &pzd);
                    while let [word, rest @ ..] = words {
                        $crate::profibus::ppo::views::put(&mut octets, at, &word.to_be_bytes());
                        (at, words) = (at + 2, rest);
                    }
                )?
                octets
            }

            $(
                #[doc = $pkw_doc]
                pub const fn $pkw(self) -> $crate::profibus::ppo::Pkw {
                    $crate::profibus::ppo::Pkw::from_octets($crate::profibus::ppo::views::part(self.0, 0))
                }
            )?

            #[doc = $word_doc]
            pub const fn $word_name(self) -> $word_type {
                <$word_type>::from_raw(u16::from_be_bytes($crate::profibus::ppo::views::part(self.0, $word)))
            }

            #[doc = $main_doc]
            pub const fn $main_name(self) -> $main {
                $main::from_be_bytes($crate::profibus::ppo::views::part(self.0, $value))
            }

            $(
                /// The words of process data behind the main value, PZD 3 and on. What they carry is set in the drive
                /// (PNU 915 and 916).
                pub fn pzd(self) -> [u16; $more] {
                    let word = |n| u16::from_be_bytes($crate::profibus::ppo::views::part(self.0, $rest + 2 * n));
                    core::array::from_fn(word)
                }
            )?
        }
    };
}

pub(super) use {ppo_view, ppo_views};

/// The octets from `at` on. The offsets of the views lie within their octets.
pub(super) const fn part<const LEN: usize, const PART: usize>(octets: &[u8; LEN], at: usize) -> [u8; PART] {
    if let Some((_, from)) = octets.split_at_checked(at)
        && let Some(part) = from.first_chunk()
    {
        return *part;
    }
    [0; PART]
}

/// Puts octets in from `at` on.
pub(super) const fn put<const LEN: usize, const PART: usize>(
    octets: &mut [u8; LEN],
    at: usize,
    part: &[u8; PART],
) {
    if let Some((_, from)) = octets.split_at_mut_checked(at)
        && let Some(to) = from.first_chunk_mut()
    {
        *to = *part;
    }
}
