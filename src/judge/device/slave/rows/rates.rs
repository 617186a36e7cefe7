//! Rows about rates: the slave must exchange data at each rate of its device file.

use core::time::Duration;

use super::row;
use crate::judge::device::Ending;
use crate::judge::device::course::{Course, Halt, broken, inapplicable};
use crate::judge::device::row::{By, Entry, Group, Judge};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::wire::Sight;
use crate::time::BaudRate;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Rates",
    rows: &[
        at("S-R01", "at 9.6 kbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K9_6)
        }),
        at("S-R02", "at 19.2 kbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K19_2)
        }),
        at("S-R03", "at 31.25 kbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K31_25)
        }),
        at("S-R04", "at 45.45 kbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K45_45)
        }),
        at("S-R05", "at 93.75 kbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K93_75)
        }),
        at("S-R06", "at 187.5 kbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K187_5)
        }),
        at("S-R07", "at 500 kbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K500)
        }),
        at("S-R08", "at 1.5 Mbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K1500)
        }),
        at("S-R09", "at 3 Mbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K3000)
        }),
        at("S-R10", "at 6 Mbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K6000)
        }),
        at("S-R11", "at 12 Mbit/s it is found, starts and exchanges data", |tester| {
            is_served(tester, BaudRate::K12000)
        }),
    ],
};

const fn at(id: &'static str, text: &'static str, judge: Judge<Tester>) -> Entry<Tester> {
    let rule =
        "each rate with <rate>_supp = 1; error-free telegrams lead a slave with Auto_Baud to it (8, 14)";
    row(id, text, rule, &["S-X01"], By::Trial(judge))
}

/// Exchanges at each rate.
const EXCHANGES: u8 = 20;

fn is_served(tester: &mut Tester, rate: BaudRate) -> Course {
    let home = tester.wire.baud;
    if rate != home && !tester.setup.rates.contains(&rate) {
        return inapplicable("it is none of the rates of --baud");
    }
    if tester.setup.gsd.as_ref().is_some_and(|gsd| !gsd.rates.contains(rate)) {
        return inapplicable("the device file does not have this rate");
    }
    if rate == home {
        if tester.wire.sight == Sight::Untimed && !tester.is_attended() {
            return inapplicable("there is no rate on this link");
        }
        return works(tester);
    }
    go(tester, rate)?;
    let course = found(tester, rate).and_then(|()| works(tester)).and_then(|()| tester.release());
    go(tester, home)?;
    match found(tester, home) {
        Ok(()) => course,
        Err(Halt::Broken { .. }) => Err(Halt::Over(Ending::Died { during: "" })),
        Err(halt) => Err(halt),
    }
}

/// The line has another rate; and the slave, if somebody stands beside it or it finds it by itself.
fn go(tester: &mut Tester, rate: BaudRate) -> Course {
    let finds = tester.setup.gsd.as_ref().is_none_or(|gsd| gsd.flags.auto_baud);
    let is_set = tester.wire.set_rate(rate)?;
    if tester.is_attended() {
        match tester.attend(&format!("rate {}", rate.bits_per_second())) {
            Ok(_) => return Ok(()),
            Err(Halt::Inapplicable(_)) if finds && is_set => return Ok(()),
            Err(halt) => return Err(halt),
        }
    }
    if !is_set {
        return inapplicable("the link cannot be set to this rate");
    }
    if !finds {
        return inapplicable("needs --ask: rate, as the device file has no Auto_Baud_supp");
    }
    Ok(())
}

/// Looks of ten seconds: a search stays some time at each rate.
const LOOKS: u8 = 3;

/// It answers in time.
fn found(tester: &mut Tester, rate: BaudRate) -> Course {
    for _ in 0..LOOKS {
        match tester.look() {
            Err(Halt::Over(Ending::NoDevice)) => {}
            course => return course,
        }
    }
    broken(format!("at {rate} nobody answers for 30 s"))
}

/// It is started with a watchdog, and exchanges data.
fn works(tester: &mut Tester) -> Course {
    let prm = tester.prm().watched([100, 1]);
    tester.start_with(&prm)?;
    for _ in 0..EXCHANGES {
        tester.exchanged_zeros()?;
        tester.pause(Duration::from_millis(1))?;
    }
    Ok(())
}
