//! Rows about the profile PROFIDRIVE version 2 (`docs/reference/profidrive-v2.md`): parameter channel and states.

use core::ops::RangeInclusive;
use core::time::Duration;

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::tester::pkw;
use crate::judge::requirement::Confidence::{B, C, U};
use crate::profibus::ppo::{JobId, Pkw, ReplyId, Stw};

pub(super) const GROUP: Group<Tester> = Group {
    title: "PROFIDRIVE version 2",
    rows: &[
        row(
            "P-L01",
            "inputs and outputs have the length of the PPO",
            "PPO 1: 12 octets, 2: 20, 3: 4, 4: 12, 5: 28 (profidrive-v2 1)",
            &["S-X01"],
            By::Trial(l01),
        ),
        row(
            "P-K01",
            "without a job there is no reply",
            "job 0: reply 0 (profidrive-v2 3)",
            &["P-L01"],
            By::Trial(k01),
        ),
        row(
            "P-K02",
            "a parameter that is there is read: a word or a double word, with its PNU",
            "job 1: reply 1 or 2; the reply names the parameter of the job (profidrive-v2 3, 4 rule 3)",
            &["P-K01"],
            By::Trial(k02),
        ),
        row(
            "P-K03",
            "a parameter that is not there is refused with error 0",
            "reply 7, and word 4 is the error number; 0 illegal PNU (profidrive-v2 4 rule 7, 5)",
            &["P-K01"],
            By::Trial(k03),
        ),
        row(
            "P-K04",
            "the reply stays until there is another job, and goes with no job",
            "the slave provides the reply until a new job is formulated (profidrive-v2 4 rule 2)",
            &["P-K02"],
            By::Trial(k04),
        ),
        softer(
            row(
                "P-K05",
                "an element that is not there is refused with error 3",
                "3 sub-index (profidrive-v2 5)",
                &["P-K02"],
                By::Trial(k05),
            ),
            1,
            B,
        ),
        softer(
            row(
                "P-K06",
                "the number of elements of an array is told, and none of a parameter that is none",
                "job 9: reply 6; 4 no array (profidrive-v2 3, 5)",
                &["P-K02"],
                By::Trial(k06),
            ),
            2,
            B,
        ),
        softer(
            row(
                "P-K07",
                "a parameter that can only be read is not written: error 1",
                "1 not changeable (profidrive-v2 5)",
                &["P-K02"],
                By::Trial(k07),
            ),
            1,
            B,
        ),
        softer(
            row(
                "P-K08",
                "every PNU of the list 980 can be read",
                "980 to 989: lists of all defined PNUs (profidrive-v2 7)",
                &["P-K05"],
                By::Trial(k08),
            ),
            2,
            B,
        ),
        softer(
            row(
                "P-K09",
                "jobs 10 to 15 are refused, where the drive has none of its own",
                "10 to 15 are reserved in version 2 (profidrive-v2 3)",
                &["P-K03"],
                By::Trial(k09),
            ),
            2,
            U,
        ),
        softer(
            row(
                "P-K10",
                "a parameter of the list that is written with the value it has takes it and says it, or is refused for a reason",
                "a successful write mirrors the value as a read would; 1, 2, 11, 12, 17, 18, 101.. refuse one (profidrive-v2 4 rule 8, 5)",
                &["P-K08"],
                By::Trial(k10),
            ),
            1,
            B,
        ),
        softer(
            row(
                "P-K11",
                "a description of a parameter is told, or refused with error 9",
                "job 4: reply 3; 9 no description (profidrive-v2 3, 5)",
                &["P-K02"],
                By::Trial(k11),
            ),
            2,
            C,
        ),
        row(
            "P-S01",
            "without ON the drive is not in operation",
            "S1, S2: ZSW bits 1 and 2 are 0 (profidrive-v2 8)",
            &["P-L01"],
            By::Trial(s01),
        ),
        softer(
            row(
                "P-S02",
                "ON at once does not switch it on: OFF1 comes first",
                "S1 to S2 when STW bit 0 = 0, bits 1 and 2 = 1 (profidrive-v2 8)",
                &["P-S01"],
                By::Trial(s02),
            ),
            1,
            C,
        ),
        softer(
            row(
                "P-S03",
                "OFF1, ON, enable: ready to switch on, switched on, operation; and back",
                "S2: bit 0; S3: bits 0 and 1; S4: bits 0 to 2 of ZSW (profidrive-v2 8)",
                &["P-S02"],
                By::Trial(s03),
            ),
            1,
            B,
        ),
        softer(
            row(
                "P-S04",
                "OFF2 and OFF3 end operation with switching-on inhibited",
                "OFF2 from any state to S1, OFF3 through S5 to S1 (profidrive-v2 8)",
                &["P-S03"],
                By::Trial(s04),
            ),
            1,
            B,
        ),
    ],
};

fn l01(tester: &mut Tester) -> Course {
    let kind = tester.profile()?;
    let got = (usize::from(tester.lengths.outputs), usize::from(tester.lengths.inputs));
    if got == (kind.len(), kind.len()) {
        return Ok(());
    }
    broken(format!("{} octets of outputs and {} of inputs; {kind} has {}", got.0, got.1, kind.len()))
}

fn k01(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    for _ in 0..4 {
        tester.exchange_ppo(Pkw::ZERO, Stw::from_raw(0))?;
    }
    let (reply, _) = tester.exchange_ppo(Pkw::ZERO, Stw::from_raw(0))?;
    if reply.pke.reply() == ReplyId::NoReply {
        return Ok(());
    }
    broken(format!("without a job the reply is '{}' of PNU {}", reply.pke.reply(), reply.pke.pnu()))
}

/// The list of PNUs, and parameters that many drives have.
const LIST: u16 = 980;
const USUAL: [u16; 8] = [918, 930, 947, 952, 961, 963, 964, 965];

/// A reply, in words.
fn words(reply: Pkw) -> String {
    let id = reply.pke.reply();
    if id == ReplyId::NotExecutable { format!("'{id}', error {}", reply.pwe_low) } else { format!("'{id}'") }
}

/// A parameter that is no array and can be read, with its reply.
fn readable(tester: &mut Tester) -> Course<Option<Pkw>> {
    for pnu in USUAL {
        let reply = tester.read(pnu, None)?;
        if matches!(reply.pke.reply(), ReplyId::Word | ReplyId::DoubleWord) {
            return Ok(Some(reply));
        }
    }
    Ok(None)
}

fn must_read(tester: &mut Tester) -> Course<Pkw> {
    match readable(tester)? {
        Some(reply) => Ok(reply),
        None => inapplicable("none of PNU 918, 930, 947, 952, 961, 963, 964, 965 can be read"),
    }
}

fn k02(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    if readable(tester)?.is_some() {
        return Ok(());
    }
    // Every drive has one of these, but the list says more.
    let reply = tester.read(LIST, Some(1))?;
    if reply.pke.reply() != ReplyId::ElementWord {
        return broken("none of PNU 918, 930, 947, 952, 961, 963, 964, 965 and 980 can be read");
    }
    let reply = tester.read(reply.word(), None)?;
    if matches!(reply.pke.reply(), ReplyId::Word | ReplyId::DoubleWord | ReplyId::NotExecutable) {
        return Ok(());
    }
    broken(format!("a parameter of the list 980 is read with {}", words(reply)))
}

/// A PNU that no drive has.
const NONE: u16 = 2046;

fn k03(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    for pnu in [NONE, 899] {
        let reply = tester.read(pnu, None)?;
        let is_there = matches!(reply.pke.reply(), ReplyId::Word | ReplyId::DoubleWord);
        if pnu != NONE && is_there {
            continue;
        }
        if reply.pke.reply() != ReplyId::NotExecutable || reply.pwe_low != 0 {
            return broken(format!("PNU {pnu} is read with {}, expected error 0", words(reply)));
        }
    }
    Ok(())
}

fn k04(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    let first = must_read(tester)?;
    let job = pkw(JobId::Read, first.pke.pnu(), 0, 0);
    for _ in 0..20 {
        let (reply, _) = tester.exchange_ppo(job, Stw::from_raw(0))?;
        if reply.pke != first.pke {
            return broken(format!("the reply to a job that stays becomes {}", words(reply)));
        }
    }
    for _ in 0..5 {
        tester.exchange_ppo(Pkw::ZERO, Stw::from_raw(0))?;
    }
    let (reply, _) = tester.exchange_ppo(Pkw::ZERO, Stw::from_raw(0))?;
    if reply.pke.reply() == ReplyId::NoReply {
        return Ok(());
    }
    broken(format!("the reply {} stays without a job", words(reply)))
}

/// An array: of what number its elements are; `None`: the drive has no list.
fn elements(tester: &mut Tester) -> Course<u32> {
    let reply = tester.job(pkw(JobId::ReadElementCount, LIST, 0, 0))?;
    let id = reply.pke.reply();
    if id == ReplyId::ElementCount {
        return Ok(reply.double_word() & 0xFFFF);
    }
    if id == ReplyId::NotExecutable && matches!(reply.pwe_low, 0 | 106) {
        return inapplicable("the drive has no list of parameters (PNU 980)");
    }
    broken(format!("the number of elements of PNU 980 is told with {}", words(reply)))
}

fn k05(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    let count = elements(tester)?;
    let Ok(beyond) = u8::try_from(count + 1) else {
        return inapplicable("the array has too many elements for one that is not there");
    };
    let reply = tester.read(LIST, Some(beyond))?;
    if reply.pke.reply() == ReplyId::NotExecutable && reply.pwe_low == 3 {
        return Ok(());
    }
    broken(format!("element {beyond} of {count} is read with {}, expected error 3", words(reply)))
}

fn k06(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    let count = elements(tester)?;
    if count == 0 {
        return broken("the list of parameters has no elements");
    }
    let plain = must_read(tester)?;
    let reply = tester.job(pkw(JobId::ReadElementCount, plain.pke.pnu(), 0, 0))?;
    if matches!(reply.pke.reply(), ReplyId::NotExecutable | ReplyId::ElementCount) {
        return Ok(());
    }
    broken(format!("the number of elements of PNU {} is told with {}", plain.pke.pnu(), words(reply)))
}

/// Parameters that can only be read, wherever they are.
const READ_ONLY: [u16; 4] = [964, 963, 968, 944];

fn k07(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    for pnu in READ_ONLY {
        let read = tester.read(pnu, None)?;
        if read.pke.reply() != ReplyId::Word {
            continue;
        }
        // The value that it has: whoever takes it is as before.
        let reply = tester.job(pkw(JobId::WriteWord, pnu, 0, read.word().into()))?;
        let id = reply.pke.reply();
        // Without rights, or in this state, nothing is written either.
        let is_refused = id == ReplyId::NotExecutable && matches!(reply.pwe_low, 1 | 11 | 17);
        if is_refused || id == ReplyId::NoControlRights {
            return Ok(());
        }
        return broken(format!("PNU {pnu} is written with {}, expected error 1", words(reply)));
    }
    inapplicable("none of PNU 964, 963, 968, 944 is a word")
}

/// So many elements of the list are read.
const LISTED: u8 = 100;

fn k08(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    let count =
        u8::try_from(elements(tester)?).unwrap_or(LISTED).min(if tester.setup.quick { 5 } else { LISTED });
    for element in 1..=count {
        let listed = tester.read(LIST, Some(element))?;
        if listed.pke.reply() != ReplyId::ElementWord {
            return broken(format!("element {element} of PNU 980 is read with {}", words(listed)));
        }
        let pnu = listed.word();
        if pnu == 0 {
            break;
        }
        let reply = tester.read(pnu, None)?;
        if reply.pke.reply() == ReplyId::NotExecutable && matches!(reply.pwe_low, 0 | 106) {
            return broken(format!("PNU {pnu} is in the list 980 and is read with {}", words(reply)));
        }
    }
    Ok(())
}

fn k09(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    for ak in 10..=15_u16 {
        // A parameter that is not there: no job of the drive's own changes it.
        let job =
            Pkw::new(crate::profibus::ppo::Pke::from_raw(ak << 12 | NONE), pkw(JobId::NoJob, 0, 0, 0).ind, 0);
        let reply = tester.job(job)?;
        if !matches!(reply.pke.reply(), ReplyId::NotExecutable | ReplyId::NoControlRights) {
            return broken(format!("job {ak} is answered with {}", words(reply)));
        }
    }
    Ok(())
}

/// Writing them is a command, whatever the value: loading, storing, resetting.
const COMMANDS: RangeInclusive<u16> = 970..=979;

fn k10(tester: &mut Tester) -> Course {
    tester.profile()?;
    if !tester.setup.writes_allowed {
        return inapplicable("needs --write: parameters are written with the values that they have");
    }
    tester.start_channel()?;
    let count =
        u8::try_from(elements(tester)?).unwrap_or(LISTED).min(if tester.setup.quick { 5 } else { LISTED });
    for element in 1..=count {
        let pnu = tester.read(LIST, Some(element))?.word();
        if pnu == 0 {
            break;
        }
        let read = tester.read(pnu, None)?;
        let id = read.pke.reply();
        if COMMANDS.contains(&pnu) || !matches!(id, ReplyId::Word | ReplyId::DoubleWord) {
            continue;
        }
        let job = if id == ReplyId::Word { JobId::WriteWord } else { JobId::WriteDoubleWord };
        let reply = tester.job(pkw(job, pnu, 0, read.double_word()))?;
        let is_taken = reply.pke.reply() == id && reply.double_word() == read.double_word();
        let is_refused = reply.pke.reply() == ReplyId::NotExecutable
            && matches!(reply.pwe_low, 1 | 2 | 11 | 12 | 17 | 18 | 101..);
        if !is_taken && !is_refused && reply.pke.reply() != ReplyId::NoControlRights {
            let value = reply.double_word();
            return broken(format!(
                "PNU {pnu}, which is {}, is written with it: {} with the value {value}",
                read.double_word(),
                words(reply)
            ));
        }
    }
    Ok(())
}

fn k11(tester: &mut Tester) -> Course {
    tester.start_channel()?;
    let read = must_read(tester)?;
    let reply = tester.job(pkw(JobId::ReadDescription, read.pke.pnu(), 1, 0))?;
    let has_none = reply.pke.reply() == ReplyId::NotExecutable && reply.pwe_low == 9;
    if has_none || reply.pke.reply() == ReplyId::Description {
        return Ok(());
    }
    broken(format!("the description of PNU {} is told with {}", read.pke.pnu(), words(reply)))
}

/// Bits of ZSW: ready to switch on, ready, operation enabled, switching-on inhibited.
const READY_TO_SWITCH_ON: u16 = 0x01;
const READY: u16 = 0x02;
const OPERATION: u16 = 0x04;
const INHIBITED: u16 = 0x40;

/// Control words: OFF1, OFF2, OFF3, ON without enable, enabled. Setpoint zero.
const OFF1: u16 = 0x047E;
const OFF2: u16 = 0x047D;
const OFF3: u16 = 0x047B;
const ON: u16 = 0x0477;
const ENABLED: u16 = 0x047F;

/// A drive follows within so long.
const FOLLOWS: Duration = Duration::from_millis(500);
/// And stays so.
const STAYS: Duration = Duration::from_millis(50);

/// With this control word these bits of the status word become 1, and those 0.
fn becomes(tester: &mut Tester, stw: u16, ones: u16, zeros: u16) -> Course {
    let is_it = |zsw: u16| zsw & ones == ones && zsw & zeros == 0;
    // What only must not come is waited for.
    if ones != 0 {
        tester.hold(stw, FOLLOWS, is_it)?;
    }
    let zsw = tester.hold(stw, if ones == 0 { FOLLOWS } else { STAYS }, |_| false)?;
    if is_it(zsw) {
        return Ok(());
    }
    broken(format!("with STW {stw:04X} ZSW is {zsw:04X}, expected {ones:04X} set and {zeros:04X} not"))
}

fn s01(tester: &mut Tester) -> Course {
    tester.profile()?;
    tester.start()?;
    becomes(tester, 0, 0, READY | OPERATION)?;
    becomes(tester, OFF1, 0, READY | OPERATION)
}

/// The drive may be switched on.
fn may_move(tester: &Tester) -> Course {
    tester.profile()?;
    if tester.setup.moves_allowed {
        return Ok(());
    }
    inapplicable("needs --moves-allowed: the drive is switched on, with a setpoint of zero")
}

fn s02(tester: &mut Tester) -> Course {
    may_move(tester)?;
    tester.start()?;
    becomes(tester, 0, 0, READY | OPERATION)?;
    becomes(tester, ENABLED, 0, READY | OPERATION)?;
    becomes(tester, OFF1, READY_TO_SWITCH_ON, READY | OPERATION | INHIBITED)
}

fn s03(tester: &mut Tester) -> Course {
    may_move(tester)?;
    tester.start()?;
    becomes(tester, 0, 0, READY | OPERATION)?;
    becomes(tester, OFF1, READY_TO_SWITCH_ON, READY | OPERATION | INHIBITED)?;
    becomes(tester, ON, READY_TO_SWITCH_ON | READY, OPERATION | INHIBITED)?;
    becomes(tester, ENABLED, READY_TO_SWITCH_ON | READY | OPERATION, INHIBITED)?;
    becomes(tester, ON, READY_TO_SWITCH_ON | READY, OPERATION | INHIBITED)?;
    becomes(tester, ENABLED, READY_TO_SWITCH_ON | READY | OPERATION, INHIBITED)?;
    becomes(tester, OFF1, READY_TO_SWITCH_ON, READY | OPERATION | INHIBITED)
}

fn s04(tester: &mut Tester) -> Course {
    may_move(tester)?;
    tester.start()?;
    for off in [OFF2, OFF3] {
        becomes(tester, OFF1, READY_TO_SWITCH_ON, OPERATION)?;
        becomes(tester, ENABLED, OPERATION, INHIBITED)?;
        becomes(tester, off, INHIBITED, READY_TO_SWITCH_ON | READY | OPERATION)?;
        becomes(tester, ENABLED, 0, OPERATION)?;
    }
    becomes(tester, 0, 0, OPERATION)
}
