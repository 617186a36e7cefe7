//! The user data of one Data_Exchange: parameter channel and process data, without their meaning.
//!
//! PROFIDRIVE version 2 calls it a *Parameter Process data Object*. The AG03 and the AG03/1 use one of their
//! own, seven words in each direction (`ag03.md` 1.1, manual chapter 7.4.1). Every word is big-endian, of a
//! double word the high word comes first:
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
//! | HSW, HIW | main setpoint and main actual value, `i32` in two's complement |
//!
//! [`Outputs`] and [`Inputs`] look at 14 octets where they lie and copy nothing; [`Outputs::octets`] and
//! [`Inputs::octets`] build them. As in the standard, *outputs* go from the master to the slave, *inputs* to
//! the master.
//!
//! ```
//! use profidrive::ppo::{Inputs, Outputs, Pkw, Stw, Zsw};
//!
//! let octets = [0x13, 0xFA, 0, 0, 0, 0, 0, 0, 0x00, 0x7B, 0xFF, 0xFF, 0xEC, 0x78];
//! let outputs = Outputs::parse(&octets)?;
//! assert_eq!(outputs.pkw().pke.pnu(), 1018);
//! assert_eq!(outputs.stw(), Stw::from_raw(0x007B));
//! assert_eq!(outputs.hsw(), -5000);
//!
//! let reply = Inputs::octets(Pkw::ZERO, Zsw::from_raw(0x2B23), 42);
//! assert_eq!(Inputs::new(&reply).hiw(), 42);
//! # Ok::<(), profidrive::ppo::LengthError>(())
//! ```

mod pkw;
mod pzd;

pub use pkw::{Ind, JobId, Pke, Pkw, ReplyId, ReservedId};
pub use pzd::{Stw, Zsw};

use nom::Parser;
use nom::bytes::complete::take;
use nom::combinator::{all_consuming, map_opt};
use thiserror::Error;

/// Octets of the PPO, the same in both directions: seven words.
pub const PPO_LEN: usize = 14;

/// A view of the PPO from the master to the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Outputs<'a>(&'a [u8; PPO_LEN]);

impl<'a> Outputs<'a> {
    /// The outputs in 14 octets.
    pub const fn new(octets: &'a [u8; PPO_LEN]) -> Self {
        Self(octets)
    }

    /// The outputs in a slice that holds nothing else.
    ///
    /// # Errors
    /// [`LengthError`] unless the slice has exactly [`PPO_LEN`] octets.
    pub fn parse(octets: &'a [u8]) -> Result<Self, LengthError> {
        whole(octets).map(Self)
    }

    /// The octets of outputs with these fields.
    pub const fn octets(pkw: Pkw, stw: Stw, hsw: i32) -> [u8; PPO_LEN] {
        join(pkw, stw.raw(), hsw)
    }

    /// Words 1 to 4, the job of the parameter channel.
    pub const fn pkw(self) -> Pkw {
        pkw(self.0)
    }

    /// Word 5, the control word.
    pub const fn stw(self) -> Stw {
        Stw::from_raw(word_5(self.0))
    }

    /// Words 6 and 7, the main setpoint HSW (unit and meaning depend on the operating mode).
    pub const fn hsw(self) -> i32 {
        words_6_and_7(self.0)
    }
}

/// A view of the PPO from the slave to the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Inputs<'a>(&'a [u8; PPO_LEN]);

impl<'a> Inputs<'a> {
    /// The inputs in 14 octets.
    pub const fn new(octets: &'a [u8; PPO_LEN]) -> Self {
        Self(octets)
    }

    /// The inputs in a slice that holds nothing else.
    ///
    /// # Errors
    /// [`LengthError`] unless the slice has exactly [`PPO_LEN`] octets.
    pub fn parse(octets: &'a [u8]) -> Result<Self, LengthError> {
        whole(octets).map(Self)
    }

    /// The octets of inputs with these fields.
    pub const fn octets(pkw: Pkw, zsw: Zsw, hiw: i32) -> [u8; PPO_LEN] {
        join(pkw, zsw.raw(), hiw)
    }

    /// Words 1 to 4, the reply of the parameter channel.
    pub const fn pkw(self) -> Pkw {
        pkw(self.0)
    }

    /// Word 5, the status word.
    pub const fn zsw(self) -> Zsw {
        Zsw::from_raw(word_5(self.0))
    }

    /// Words 6 and 7, the main actual value HIW (unit and meaning depend on the operating mode).
    pub const fn hiw(self) -> i32 {
        words_6_and_7(self.0)
    }
}

/// User data that is no PPO of seven words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the PPO has {PPO_LEN} octets, got {got}")]
pub struct LengthError {
    /// Octets found; [`PPO_LEN`] were expected.
    pub got: usize,
}

fn whole(octets: &[u8]) -> Result<&[u8; PPO_LEN], LengthError> {
    let ppo = map_opt(take::<_, _, ()>(PPO_LEN), |octets: &[u8]| octets.first_chunk());
    match all_consuming(ppo).parse(octets) {
        Ok((_, ppo)) => Ok(ppo),
        Err(_) => Err(LengthError { got: octets.len() }),
    }
}

const fn pkw(octets: &[u8; PPO_LEN]) -> Pkw {
    let &[a, b, c, d, e, f, g, h, ..] = octets;
    Pkw::from_octets([a, b, c, d, e, f, g, h])
}

const fn word_5(octets: &[u8; PPO_LEN]) -> u16 {
    let &[_, _, _, _, _, _, _, _, high, low, ..] = octets;
    u16::from_be_bytes([high, low])
}

const fn words_6_and_7(octets: &[u8; PPO_LEN]) -> i32 {
    let &[.., a, b, c, d] = octets;
    i32::from_be_bytes([a, b, c, d])
}

const fn join(pkw: Pkw, word_5: u16, words_6_and_7: i32) -> [u8; PPO_LEN] {
    let [a, b, c, d, e, f, g, h] = pkw.to_octets();
    let [i, j] = word_5.to_be_bytes();
    let [k, l, m, n] = words_6_and_7.to_be_bytes();
    [a, b, c, d, e, f, g, h, i, j, k, l, m, n]
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

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
    fn every_other_length_is_refused() {
        let octets = [0xA5; 32];
        for len in 0..=octets.len() {
            let expected = if len == PPO_LEN { Ok(()) } else { Err(LengthError { got: len }) };
            assert_eq!(Outputs::parse(&octets[..len]).map(drop), expected);
            assert_eq!(Inputs::parse(&octets[..len]).map(drop), expected);
        }
        assert_eq!(LengthError { got: 12 }.to_string(), "the PPO has 14 octets, got 12");
    }

    proptest! {
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
