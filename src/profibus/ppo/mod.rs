//! The user data of one Data_Exchange: parameter channel and process data, without their meaning.
//!
//! PROFIDRIVE version 2 calls it a *Parameter Process data Object*, and knows five types of it ([`PpoType`]).
//! Beside them there is one of seven words in each direction (`ag03.md` 1.1). Every word is big-endian, of a double word
//! the high word comes first:
//!
//! ```text
//! octet             0  1    2  3    4  5       6  7      8  9   10 11       12 13
//! word              1       2       3          4         5      6           7
//! master -> slave   PKE     IND     PWE high   PWE low   STW    HSW high    HSW low
//! slave -> master   PKE     IND     PWE high   PWE low   ZSW    HIW high    HIW low
//!                   '------------- PKW -------------'    '--------- PZD ---------'
//! ```
//!
//! | name | what |
//! | --- | --- |
//! | [`Pkw`] | parameter channel: job of the master, reply of the slave |
//! | [`Stw`], [`Zsw`] | control word and status word, bits without names |
//! | HSW, HIW | main setpoint and main actual value, two's complement: `i32` here, `i16` in PPO 1 to 5 |
//!
//! [`Outputs`] and [`Inputs`] look at 14 octets where they lie and copy nothing; [`Outputs::octets`] and
//! [`Inputs::octets`] build them. The modules [`ppo1`] to [`ppo5`] have the same two views for the types of the profile.
//! As in the standard, *outputs* go from the master to the slave, *inputs* to the master.
//!
//! ```
//! use profidrive::profibus::ppo::{Inputs, Outputs, Pkw, Stw, Zsw};
//!
//! let octets = [0x13, 0xFA, 0, 0, 0, 0, 0, 0, 0x00, 0x7B, 0xFF, 0xFF, 0xEC, 0x78];
//! let outputs = Outputs::parse(&octets)?;
//! assert_eq!(outputs.pkw().pke.pnu(), 1018);
//! assert_eq!(outputs.stw(), Stw::from_raw(0x007B));
//! assert_eq!(outputs.hsw(), -5000);
//!
//! let reply = Inputs::octets(Pkw::ZERO, Zsw::from_raw(0x2B23), 42);
//! assert_eq!(Inputs::new(&reply).hiw(), 42);
//! # Ok::<(), profidrive::profibus::ppo::LengthError>(())
//! ```

mod kind;
mod pattern;
mod pkw;
pub mod ppo1;
pub mod ppo2;
pub mod ppo3;
pub mod ppo4;
pub mod ppo5;
mod pzd;
mod views;

pub use kind::PpoType;
pub(crate) use pattern::ZswPattern;
pub use pkw::{Ind, JobId, Pke, Pkw, ReplyId, ReservedId};
pub use pzd::{Stw, Zsw};

use nom::Parser;
use nom::bytes::complete::take;
use nom::combinator::{all_consuming, map_opt};
use thiserror::Error;

use views::ppo_views;

ppo_views! {
    /// A view of the PPO of seven words from the master to the slave.
    Outputs,
    /// A view of the PPO of seven words from the slave to the master.
    Inputs,
    /// Octets of the PPO of seven words, the same in both directions.
    PPO_LEN = 14,
    with pkw, word at 8, main i32 at 10
}

/// User data that is no PPO of its type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the PPO has {expected} octets, got {got}")]
pub struct LengthError {
    /// Octets of the type.
    pub expected: usize,
    /// Octets found.
    pub got: usize,
}

fn whole<const LEN: usize>(octets: &[u8]) -> Result<&[u8; LEN], LengthError> {
    let ppo = map_opt(take::<_, _, ()>(LEN), |octets: &[u8]| octets.first_chunk());
    match all_consuming(ppo).parse(octets) {
        Ok((_, ppo)) => Ok(ppo),
        Err(_) => Err(LengthError { expected: LEN, got: octets.len() }),
    }
}

#[cfg(test)]
mod tests {

    use proptest::prelude::*;

    use super::*;

    const COUNTING: [u8; PPO_LEN] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14];

    #[test]
    fn every_octet_has_its_place() {
        let pkw = Pkw::from_octets([1, 2, 3, 4, 5, 6, 7, 8]);
        let outputs = Outputs::new(&COUNTING);
        assert_eq!((outputs.pkw(), outputs.stw().raw(), outputs.hsw()), (pkw, 0x090A, 0x0B0C_0D0E));
        let inputs = Inputs::new(&COUNTING);
        assert_eq!((inputs.pkw(), inputs.zsw().raw(), inputs.hiw()), (pkw, 0x090A, 0x0B0C_0D0E));
    }

    #[test]
    fn the_process_data_of_the_reference_vectors() {
        // `ag03.md` 2.6, the three PZD rows.
        for (stw, hsw, tail) in [
            (0x000B, 5000, [0x00, 0x0B, 0x00, 0x00, 0x13, 0x88]),
            (0x007B, -5000, [0x00, 0x7B, 0xFF, 0xFF, 0xEC, 0x78]),
            (0x004B, -72, [0x00, 0x4B, 0xFF, 0xFF, 0xFF, 0xB8]),
        ] {
            let octets = Outputs::octets(Pkw::ZERO, Stw::from_raw(stw), hsw);
            assert_eq!(octets[..8], [0; 8]);
            assert_eq!(octets[8..], tail);
            assert_eq!(Outputs::new(&octets).hsw(), hsw);
        }
    }

    #[test]
    fn every_word_of_every_type_has_its_place() {
        // Octets that count, ahead of the process data the parameter channel.
        let octets: [u8; 28] = core::array::from_fn(|n| u8::try_from(n + 1).unwrap());
        let pkw = Pkw::from_octets([1, 2, 3, 4, 5, 6, 7, 8]);
        let (stw, zsw) = (Stw::from_raw(0x090A), Zsw::from_raw(0x090A));
        assert_eq!(ppo1::Outputs::octets(pkw, stw, 0x0B0C), octets[..12]);
        assert_eq!(ppo1::Inputs::octets(pkw, zsw, 0x0B0C), octets[..12]);
        let rest = [0x0D0E, 0x0F10, 0x1112, 0x1314, 0x1516, 0x1718, 0x191A, 0x1B1C];
        let four = *rest.first_chunk().unwrap();
        assert_eq!(ppo2::Outputs::octets(pkw, stw, 0x0B0C, four), octets[..20]);
        assert_eq!(ppo2::Inputs::octets(pkw, zsw, 0x0B0C, four), octets[..20]);
        assert_eq!(ppo5::Outputs::octets(pkw, stw, 0x0B0C, rest), octets);
        assert_eq!(ppo5::Inputs::octets(pkw, zsw, 0x0B0C, rest), octets);
        let (stw, zsw) = (Stw::from_raw(0x0102), Zsw::from_raw(0x0102));
        assert_eq!(ppo3::Outputs::octets(stw, 0x0304), octets[..4]);
        assert_eq!(ppo3::Inputs::octets(zsw, 0x0304), octets[..4]);
        let four = [0x0506, 0x0708, 0x090A, 0x0B0C];
        assert_eq!(ppo4::Outputs::octets(stw, 0x0304, four), octets[..12]);
        assert_eq!(ppo4::Inputs::octets(zsw, 0x0304, four), octets[..12]);
    }

    #[test]
    fn the_lengths_are_those_of_the_types() {
        let lengths = [ppo1::LEN, ppo2::LEN, ppo3::LEN, ppo4::LEN, ppo5::LEN, PPO_LEN];
        assert_eq!(PpoType::ALL.map(PpoType::len), lengths);
        let refused = ppo2::Inputs::parse(&[0; ppo5::LEN]).unwrap_err();
        assert_eq!(refused.to_string(), "the PPO has 20 octets, got 28");
    }

    #[test]
    fn every_other_length_is_refused() {
        let octets = [0xA5; 32];
        for len in 0..=octets.len() {
            let expected =
                if len == PPO_LEN { Ok(()) } else { Err(LengthError { expected: PPO_LEN, got: len }) };
            assert_eq!(Outputs::parse(&octets[..len]).map(drop), expected);
            assert_eq!(Inputs::parse(&octets[..len]).map(drop), expected);
        }
        assert_eq!(LengthError { expected: PPO_LEN, got: 12 }.to_string(), "the PPO has 14 octets, got 12");
    }

    proptest! {
        #[test]
        fn what_a_view_of_any_type_shows_builds_its_octets(octets: [u8; 28]) {
            let view = ppo1::Outputs::parse(&octets[..12]).unwrap();
            prop_assert_eq!(ppo1::Outputs::octets(view.pkw(), view.stw(), view.hsw()), &octets[..12]);
            let view = ppo2::Inputs::parse(&octets[..20]).unwrap();
            let built = ppo2::Inputs::octets(view.pkw(), view.zsw(), view.hiw(), view.pzd());
            prop_assert_eq!(built, &octets[..20]);
            let view = ppo3::Inputs::parse(&octets[..4]).unwrap();
            prop_assert_eq!(ppo3::Inputs::octets(view.zsw(), view.hiw()), &octets[..4]);
            let view = ppo4::Outputs::parse(&octets[..12]).unwrap();
            prop_assert_eq!(ppo4::Outputs::octets(view.stw(), view.hsw(), view.pzd()), &octets[..12]);
            let view = ppo5::Outputs::parse(&octets).unwrap();
            prop_assert_eq!(ppo5::Outputs::octets(view.pkw(), view.stw(), view.hsw(), view.pzd()), octets);
        }

        #[test]
        fn octets_survive_the_round_trip(octets: [u8; PPO_LEN]) {
            let outputs = Outputs::parse(&octets).unwrap();
            prop_assert_eq!(Outputs::octets(outputs.pkw(), outputs.stw(), outputs.hsw()), octets);
            let inputs = Inputs::parse(&octets).unwrap();
            prop_assert_eq!(Inputs::octets(inputs.pkw(), inputs.zsw(), inputs.hiw()), octets);
        }

        #[test]
        fn fields_survive_the_round_trip(pkw: [u8; 8], word: u16, value: i32) {
            let pkw = Pkw::from_octets(pkw);
            let octets = Inputs::octets(pkw, Zsw::from_raw(word), value);
            let inputs = Inputs::new(&octets);
            prop_assert_eq!((inputs.pkw(), inputs.zsw().raw(), inputs.hiw()), (pkw, word, value));
        }
    }
}
