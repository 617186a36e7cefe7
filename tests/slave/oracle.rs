//! Our codecs against others: telegrams against profirust's decoder, PPO and PKW words against a model that looks at
//! single bits.
//!
//! Everything we accept, profirust accepts alike in all fields, but for function codes the standard reserves; what it
//! accepts and we refuse is one of [`Stricter`]. `PROFIDRIVE_LONG` draws a hundred times as many cases, and
//! `PROPTEST_CASES` any number.

use std::cell::RefCell;
use std::collections::BTreeMap;

use profidrive::profibus::fdl::telegram::{Decoded, Format, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameError, Function, FunctionCode, MAX_TELEGRAM_LEN, Sap, Telegram,
};
use profidrive::profibus::ppo::{Ind, Inputs, JobId, Outputs, PPO_LEN, Pke, Pkw, ReplyId, Stw, Zsw};
use profirust::fdl as theirs;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use crate::long::long;

/// Why we refuse what profirust accepts: each a rule of the format that it does not check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Stricter {
    /// The fourth octet of SD2 must be 68 again (`dp-v0.md` F-03): it looks at three.
    SecondStartDelimiter,
    /// LE is 4..=249 (`dp-v0.md` F-04): it takes 3, a telegram without data that must be SD1, and up to 255.
    Length,
    /// Bits 7 and 6 of an extension octet are 0 in DP: it takes any octet as SAP.
    Extension,
    /// A token is for a station, from a station: it takes any two octets as addresses.
    TokenAddress,
}

impl Stricter {
    const ALL: [Self; 4] = [Self::SecondStartDelimiter, Self::Length, Self::Extension, Self::TokenAddress];

    /// `None` if profirust checks that too, so that both must refuse.
    fn of(error: FrameError) -> Option<Self> {
        match error {
            FrameError::SecondStartDelimiter { .. } => Some(Self::SecondStartDelimiter),
            FrameError::Length { .. } => Some(Self::Length),
            FrameError::Extension { .. } => Some(Self::Extension),
            FrameError::TokenAddress { .. } => Some(Self::TokenAddress),
            FrameError::StartDelimiter { .. }
            | FrameError::RepeatedLength { .. }
            | FrameError::EndDelimiter { .. }
            | FrameError::Checksum { .. }
            | FrameError::ExtensionMissing
            | FrameError::BrokenOff { .. }
            | FrameError::Parity => None,
            _ => panic!("is {error} checked by profirust?"),
        }
    }
}

/// What the two decoders made of the same octets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    BothAccept,
    BothRefuse,
    BothWait,
    /// The function code is reserved: ours keeps it for an analyser to show, profirust has no value for it.
    ReservedFunctionCode,
    /// We refuse the first wrong octet, profirust waits for the whole telegram.
    RefusedEarlier,
    Stricter(Stricter),
}

/// Compares; panics where they must agree and do not.
fn judge(octets: &[u8]) -> Verdict {
    match (decode(octets), theirs::Telegram::deserialize(octets)) {
        (Decoded::Telegram { telegram, len }, Some(Ok((other, other_len)))) => {
            assert_eq!(len, other_len, "{octets:02X?}");
            assert_alike(&telegram, &other, octets);
            Verdict::BothAccept
        }
        (Decoded::Telegram { telegram: Telegram::Data(data), .. }, Some(Err(()))) => {
            assert_eq!(data.fc.function(), Function::Reserved, "{octets:02X?}");
            Verdict::ReservedFunctionCode
        }
        (Decoded::Incomplete, None) => Verdict::BothWait,
        (Decoded::Invalid { .. }, Some(Err(()))) => Verdict::BothRefuse,
        (Decoded::Invalid { .. }, None) => Verdict::RefusedEarlier,
        (Decoded::Invalid { error, .. }, Some(Ok((other, _)))) => Verdict::Stricter(
            Stricter::of(error)
                .unwrap_or_else(|| panic!("{octets:02X?}: {error}, and they accept {other:?}")),
        ),
        (ours, theirs) => panic!("{octets:02X?}: ours {ours:?}, theirs {theirs:?}"),
    }
}

fn assert_alike(ours: &Telegram<'_>, theirs: &theirs::Telegram<'_>, octets: &[u8]) {
    match (ours, theirs) {
        (Telegram::ShortAcknowledge, theirs::Telegram::ShortConfirmation(_)) => {}
        (Telegram::Token { da, sa }, theirs::Telegram::Token(token)) => {
            assert_eq!((da.number(), sa.number()), (token.da, token.sa));
        }
        (Telegram::Data(ours), theirs::Telegram::Data(theirs)) => {
            let fields =
                (ours.da.number(), ours.sa.number(), ours.dsap.map(Sap::number), ours.ssap.map(Sap::number));
            assert_eq!(fields, (theirs.h.da, theirs.h.sa, theirs.h.dsap, theirs.h.ssap), "{octets:02X?}");
            assert_eq!(ours.data, theirs.pdu, "{octets:02X?}");
            assert_function(ours.fc, theirs.h.fc);
            let format = match octets[0] {
                0x10 => Format::Sd1,
                0x68 => Format::Sd2,
                _ => Format::Sd3,
            };
            assert_eq!(ours.format, format);
        }
        (ours, theirs) => panic!("{octets:02X?}: ours {ours:?}, theirs {theirs:?}"),
    }
}

/// The same meaning; profirust has more of them, and drops bit 7 of responses.
fn assert_function(ours: FunctionCode, theirs: theirs::FunctionCode) {
    let octet = ours.octet();
    match (ours.function(), theirs) {
        (Function::Request(service, count), theirs::FunctionCode::Request { fcb, req }) => {
            assert_eq!(theirs.to_byte(), octet);
            assert_eq!(service as u8, req as u8);
            assert_eq!(service.wants_reply(), req.expects_reply(), "{service:?}");
            assert_eq!(FunctionCode::request(service, count).octet(), octet);
            assert_eq!((fcb.fcv(), fcb.fcb()), (octet & 0x10 != 0, octet & 0x20 != 0));
        }
        (Function::Response(station, status), theirs::FunctionCode::Response { state, status: other }) => {
            assert_eq!(theirs.to_byte(), octet);
            assert_eq!((station as u8, status as u8), (state as u8, other as u8));
        }
        (Function::Reserved, _) => assert!(octet & 0x80 != 0, "{octet:02X} is reserved, they say {theirs:?}"),
        (ours, _) => panic!("{octet:02X}: ours {ours:?}, theirs {theirs:?}"),
    }
}

fn cases(usual: u32) -> Config {
    let times = if long() { 100 } else { 1 };
    let config = Config::with_cases(usual * times);
    match std::env::var("PROPTEST_CASES") {
        Ok(_) => Config { failure_persistence: None, ..Config::default() },
        Err(_) => Config { failure_persistence: None, ..config },
    }
}

/// A telegram in order of any format, with likely and unlikely contents.
fn telegram() -> impl Strategy<Value = Vec<u8>> {
    let sap = || prop_oneof![Just(None), (50_u8..64).prop_map(Some), (0_u8..64).prop_map(Some)];
    let data = prop_oneof![vec(any::<u8>(), 0..20), vec(any::<u8>(), 8), vec(any::<u8>(), 0..=246)];
    let fc = prop_oneof![Just(0x6D), Just(0x5D), Just(0x7D), Just(0x49), Just(0x08), any::<u8>()];
    (any::<bool>(), 0_u8..128, 0_u8..128, sap(), sap(), fc, data).prop_map(
        |(sd3, da, sa, dsap, ssap, fc, data)| {
            let (dsap, ssap) = (dsap.and_then(Sap::new), ssap.and_then(Sap::new));
            let saps = usize::from(dsap.is_some()) + usize::from(ssap.is_some());
            let data = &data[..data.len().min(246 - saps)];
            let format = if sd3 && data.len() + saps == 8 {
                Format::Sd3
            } else {
                DataTelegram::customary_format(dsap, ssap, data)
            };
            let (da, sa, fc) =
                (Address::from_octet(da), Address::from_octet(sa), FunctionCode::from_octet(fc));
            let telegram = DataTelegram { format, da, sa, dsap, ssap, fc, data };
            telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec()
        },
    )
}

/// Sets FCS and ED right again behind what was changed, where the octets still announce a length.
fn seal(octets: &mut [u8]) {
    let (head, end) = match *octets {
        [0x10, ..] => (1, 4),
        [0xA2, ..] => (1, 12),
        [0x68, le, ..] => (4, 4 + usize::from(le)),
        _ => return,
    };
    if octets.len() >= end + 2 {
        octets[end] = octets[head..end].iter().fold(0, |sum, octet| sum.wrapping_add(*octet));
        octets[end + 1] = 0x16;
    }
}

/// Telegrams, damaged telegrams, damaged telegrams whose checksum holds, tokens, and noise.
fn octets() -> impl Strategy<Value = Vec<u8>> {
    let damage = (any::<prop::sample::Index>(), any::<u8>(), 0_u8..3);
    let damaged = (telegram(), vec(damage, 1..4), any::<bool>()).prop_map(|(mut octets, damages, sealed)| {
        for (at, octet, kind) in damages {
            let at = at.index(octets.len());
            match kind {
                0 => octets[at] = octet,
                1 => octets[at] ^= 1 << (octet % 8),
                _ => octets.insert(at, octet),
            }
        }
        if sealed {
            seal(&mut octets);
        }
        octets
    });
    // A length octet that both places repeat, with as many octets behind it.
    let any_length =
        (any::<u8>(), vec(any::<u8>(), 262), any::<bool>()).prop_map(|(le, mut octets, head)| {
            let second = if head { 0x68 } else { octets[3] };
            octets[..4].copy_from_slice(&[0x68, le, le, second]);
            octets.truncate(usize::from(le) + 6);
            seal(&mut octets);
            octets
        });
    let cut = (telegram(), any::<prop::sample::Index>()).prop_map(|(mut octets, at)| {
        octets.truncate(at.index(octets.len()));
        octets
    });
    let starts = prop_oneof![Just(0x10), Just(0x68), Just(0xA2), Just(0xDC), Just(0xE5), any::<u8>()];
    let noise = (starts, vec(any::<u8>(), 0..40)).prop_map(|(start, mut octets)| {
        octets.insert(0, start);
        octets
    });
    prop_oneof![4 => telegram(), 6 => damaged, 2 => any_length, 1 => cut, 3 => noise]
}

#[test]
fn what_we_accept_profirust_accepts_alike_and_what_it_accepts_besides_has_a_listed_reason() {
    let verdicts = RefCell::new(BTreeMap::new());
    let mut runner = TestRunner::new(cases(20_000));
    runner
        .run(&octets(), |octets| {
            *verdicts.borrow_mut().entry(judge(&octets)).or_insert(0_u64) += 1;
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
    let verdicts = verdicts.into_inner();
    println!("{verdicts:?}");
    // A reason nothing falls in is no reason.
    if std::env::var_os("PROPTEST_CASES").is_none() {
        for reason in Stricter::ALL {
            assert!(verdicts.contains_key(&Verdict::Stricter(reason)), "{reason:?}: {verdicts:?}");
        }
        let accepted = verdicts.get(&Verdict::BothAccept).copied().unwrap_or(0);
        assert!(accepted > 4_000, "{verdicts:?}");
    }
}

#[test]
fn every_function_code_means_the_same_to_both() {
    let mut reserved = Vec::new();
    for fc in 0..=u8::MAX {
        let octets = [0x10, 5, 2, fc, fc.wrapping_add(7), 0x16];
        match judge(&octets) {
            Verdict::BothAccept => {}
            Verdict::ReservedFunctionCode => reserved.push(fc),
            other => panic!("{fc:02X}: {other:?}"),
        }
    }
    assert!(reserved.contains(&0x41) && !reserved.contains(&0x49));
}

#[test]
fn each_listed_reason_by_the_shortest_telegram_of_its_kind() {
    for (octets, reason) in [
        (&[0x68, 4, 4, 0x00, 5, 2, 0x5D, 0x01, 0x65, 0x16][..], Stricter::SecondStartDelimiter),
        (&[0x68, 3, 3, 0x68, 5, 2, 0x5D, 0x64, 0x16], Stricter::Length),
        (&[0x68, 4, 4, 0x68, 0x85, 2, 0x5D, 0x40, 0x24, 0x16], Stricter::Extension),
        (&[0xDC, 0x7F, 2], Stricter::TokenAddress),
    ] {
        assert_eq!(judge(octets), Verdict::Stricter(reason), "{octets:02X?}");
    }
}

/// Words as rows of bits, most significant first: slow, and nothing to get wrong.
struct Bits(Vec<bool>);

impl Bits {
    fn of(octets: &[u8]) -> Self {
        Self(octets.iter().flat_map(|octet| (0..8).rev().map(move |bit| octet >> bit & 1 == 1)).collect())
    }

    /// The number in the bits from `first` on.
    fn number(&self, first: usize, count: usize) -> u64 {
        self.0[first..first + count].iter().fold(0, |number, bit| 2 * number + u64::from(*bit))
    }

    /// The number in two's complement.
    fn signed(&self, first: usize, count: usize) -> i64 {
        let number = i64::try_from(self.number(first, count)).unwrap();
        if self.0[first] { number - (1 << count) } else { number }
    }
}

/// Jobs and replies by their numbers (`ag03.md` 2.2 and 2.3).
const JOBS: [JobId; 10] = [
    JobId::NoJob,
    JobId::Read,
    JobId::WriteWord,
    JobId::WriteDoubleWord,
    JobId::ReadDescription,
    JobId::WriteDescription,
    JobId::ReadElement,
    JobId::WriteElementWord,
    JobId::WriteElementDoubleWord,
    JobId::ReadElementCount,
];
const REPLIES: [ReplyId; 9] = [
    ReplyId::NoReply,
    ReplyId::Word,
    ReplyId::DoubleWord,
    ReplyId::Description,
    ReplyId::ElementWord,
    ReplyId::ElementDoubleWord,
    ReplyId::ElementCount,
    ReplyId::NotExecutable,
    ReplyId::NoControlRights,
];

/// A PKW against its 64 bits: AK in 15..12 of PKE, SPM in 11, PNU in 10..0, IND, PWE.
fn assert_pkw(pkw: Pkw, bits: &Bits) {
    assert_eq!(u64::from(pkw.pke.raw()), bits.number(0, 16));
    assert_eq!(u64::from(pkw.pke.ak()), bits.number(0, 4));
    assert_eq!(pkw.pke.spm(), bits.0[4]);
    assert_eq!(u64::from(pkw.pke.pnu()), bits.number(5, 11));
    assert_eq!(u64::from(pkw.ind.raw()), bits.number(16, 16));
    assert_eq!(u64::from(pkw.ind.high_octet()), bits.number(16, 8));
    assert_eq!(u64::from(pkw.ind.low_octet()), bits.number(24, 8));
    assert_eq!(u64::from(pkw.double_word()), bits.number(32, 32));
    assert_eq!(u64::from(pkw.word()), bits.number(48, 16));
    let ak = usize::from(pkw.pke.ak());
    match JOBS.get(ak) {
        Some(job) => assert_eq!(pkw.pke.job(), *job),
        None => assert!(matches!(pkw.pke.job(), JobId::Reserved(id) if usize::from(id.ak()) == ak)),
    }
    match REPLIES.get(ak) {
        Some(reply) => assert_eq!(pkw.pke.reply(), *reply),
        None => assert!(matches!(pkw.pke.reply(), ReplyId::Reserved(id) if usize::from(id.ak()) == ak)),
    }
}

#[test]
fn every_pke_is_what_its_bits_say_and_is_built_from_them() {
    for raw in 0..=u16::MAX {
        let octets = [raw.to_be_bytes(), [0, 0], [0, 0], [0, 0]].concat();
        let pkw = Pkw::from_octets(octets.clone().try_into().unwrap());
        assert_pkw(pkw, &Bits::of(&octets));
        let pke = Pke::from_raw(raw);
        assert_eq!(pke.without_spm().raw(), raw & !(1 << 11));
        assert_eq!(Pke::of_job(pke.job(), pke.pnu()).raw(), raw & !(1 << 11));
        assert_eq!(Pke::of_reply(pke.reply(), pke.pnu()).raw(), raw & !(1 << 11));
    }
}

#[test]
fn a_ppo_is_what_its_bits_say_and_is_built_from_them() {
    let mut runner = TestRunner::new(cases(5_000));
    runner
        .run(&any::<[u8; PPO_LEN]>(), |octets| {
            let bits = Bits::of(&octets);
            let (outputs, inputs) = (Outputs::new(&octets), Inputs::new(&octets));
            assert_pkw(outputs.pkw(), &bits);
            assert_pkw(inputs.pkw(), &bits);
            assert_eq!(outputs.pkw().to_octets(), octets[..8]);
            for bit in 0..16_u8 {
                let expected = bits.0[64 + 15 - usize::from(bit)];
                assert_eq!((outputs.stw().bit(bit), inputs.zsw().bit(bit)), (expected, expected));
                let flipped = Stw::from_raw(outputs.stw().raw()).with_bit(bit, !expected);
                assert_eq!(flipped.raw() ^ outputs.stw().raw(), 1 << bit);
            }
            assert_eq!(i64::from(outputs.hsw()), bits.signed(80, 32));
            assert_eq!(i64::from(inputs.hiw()), bits.signed(80, 32));
            // And back, each field from its bits.
            let field = |first, count| u32::try_from(bits.number(first, count)).unwrap();
            let word = |first| u16::try_from(field(first, 16)).unwrap();
            let pkw = Pkw::new(Pke::from_raw(word(0)), Ind::from_raw(word(16)), field(32, 32));
            let main = i32::try_from(bits.signed(80, 32)).unwrap();
            assert_eq!(Outputs::octets(pkw, Stw::from_raw(word(64)), main), octets);
            assert_eq!(Inputs::octets(pkw, Zsw::from_raw(word(64)), main), octets);
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
}
