//! Data_Exchange, RD_Inp and RD_Outp.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::requirement::Confidence::B;
use crate::profibus::dp::Service;
use crate::profibus::fdl::ReplyStatus;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Data_Exchange",
    rows: &[
        row(
            "S-X02",
            "a wrong length of outputs, without Fail_Safe also none: it leaves to WAIT-PRM, and is never silent",
            "wrong length: the data are not taken, Leave-Master; silence is not survivable (6.6)",
            &["S-X01"],
            By::Trial(x02),
        ),
        row(
            "S-X03",
            "no outputs to a slave with Fail_Safe: data exchange goes on",
            "a Fail_Safe slave accepts the empty frame as 'take safe state' and answers with inputs (6.3)",
            &["S-X01"],
            By::Trial(x03),
        ),
        row(
            "S-X04",
            "Data_Exchange of another master: RS, and nothing changes for its master",
            "Data_Exchange: own; another master: RS (4.1)",
            &["S-X01"],
            By::Trial(x04),
        ),
        row(
            "S-X05",
            "Data_Exchange in WAIT-PRM and WAIT-CFG: RS",
            "Data_Exchange: RS in WAIT-PRM and WAIT-CFG (4.1)",
            &["S-P01"],
            By::Trial(x05),
        ),
        row(
            "S-X06",
            "the reply has exactly the inputs; without inputs it is SC",
            "exactly the configured inputs; no inputs and no diagnosis pending: SC (6.6)",
            &["S-X01"],
            By::Trial(x06),
        ),
        row(
            "S-X07",
            "RD_Inp and RD_Outp of any master: data in data exchange, RS elsewhere, RR with data",
            "empty request from any master, valid in DATA-EXCH; else RS; with data RR (6.5)",
            &["S-X01"],
            By::Trial(x07),
        ),
        row(
            "S-X08",
            "outputs are taken and inputs given whole, never half old and half new",
            "octets inside one consistency unit are updated atomically (6.6)",
            &["S-X01"],
            By::Trial(x08),
        ),
        softer(
            row(
                "S-X09",
                "Data_Exchange with eight octets of outputs as SD2 and as SD3",
                "a master may send eight octets as SD3 (2 rule 4)",
                &["S-X01"],
                By::Trial(x09),
            ),
            2,
            B,
        ),
    ],
};

fn x02(tester: &mut Tester) -> Course {
    let right = usize::from(tester.lengths.outputs);
    let fail_safe = tester.setup.gsd.as_ref().map(|gsd| gsd.flags.fail_safe || gsd.flags.fail_safe_required);
    let mut wrong = vec![right + 1];
    if right > 1 {
        wrong.push(right - 1);
    }
    // A slave of which no file says it may have Fail_Safe.
    if right > 0 && fail_safe == Some(false) {
        wrong.push(0);
    }
    for len in wrong {
        if len > 244 {
            continue;
        }
        tester.release()?;
        tester.must_start()?;
        let outputs = vec![0; len];
        tester.serve(tester.owner(), Service::DataExchange, &outputs)?;
        tester.waits_for_prm(&format!("a Data_Exchange with {len} octets, expected {right},"))?;
    }
    Ok(())
}

fn x03(tester: &mut Tester) -> Course {
    let Some(gsd) = tester.setup.gsd.as_ref() else {
        return inapplicable("needs the device file: gsd=");
    };
    if !gsd.flags.fail_safe && !gsd.flags.fail_safe_required {
        return inapplicable("the device file has no Fail_Safe");
    }
    if tester.lengths.outputs == 0 {
        return inapplicable("the slave has no outputs");
    }
    tester.start()?;
    for _ in 0..2 {
        let answer = tester.serve(tester.owner(), Service::DataExchange, &[])?;
        tester.inputs_of(answer)?;
    }
    tester.still_exchanges("Data_Exchange without outputs")
}

fn x04(tester: &mut Tester) -> Course {
    tester.start()?;
    let zeros = tester.zeros();
    let answer = tester.serve(tester.other(), Service::DataExchange, &zeros)?;
    if !answer.is_status(ReplyStatus::NotActivated) {
        return broken(format!(
            "Data_Exchange of another master is answered with {}, expected RS",
            answer.words()
        ));
    }
    tester.still_exchanges("a Data_Exchange of another master")
}

fn x05(tester: &mut Tester) -> Course {
    for state in ["WAIT-PRM", "WAIT-CFG"] {
        let zeros = tester.zeros();
        let answer = tester.serve(tester.owner(), Service::DataExchange, &zeros)?;
        if !answer.is_status(ReplyStatus::NotActivated) {
            return broken(format!(
                "Data_Exchange in {state} is answered with {}, expected RS",
                answer.words()
            ));
        }
        let prm = tester.prm();
        tester.set_prm(&prm)?;
    }
    Ok(())
}

fn x06(tester: &mut Tester) -> Course {
    tester.start()?;
    let (zeros, inputs) = (tester.zeros(), tester.lengths.inputs);
    for _ in 0..5 {
        let answer = tester.serve(tester.owner(), Service::DataExchange, &zeros)?;
        if inputs == 0 && answer != Answer::Acknowledged && !answer.is_status(ReplyStatus::DataHigh) {
            return broken(format!("a slave without inputs answers with {}, expected SC", answer.words()));
        }
        tester.inputs_of(answer)?;
    }
    Ok(())
}

fn x07(tester: &mut Tester) -> Course {
    let refused = |tester: &mut Tester, data: &[u8], expected: ReplyStatus, what: &str| -> Course {
        for service in [Service::RdInp, Service::RdOutp] {
            let answer = tester.serve(tester.other(), service, data)?;
            if !answer.is_status(expected) {
                return broken(format!("{} {what} is answered with {}", service.name(), answer.words()));
            }
        }
        Ok(())
    };
    refused(tester, &[], ReplyStatus::NotActivated, "in WAIT-PRM")?;
    tester.start()?;
    for sa in [tester.owner(), tester.other()] {
        for (service, expected) in
            [(Service::RdInp, tester.lengths.inputs), (Service::RdOutp, tester.lengths.outputs)]
        {
            let answer = tester.serve(sa, service, &[])?;
            let is_right = match &answer {
                Answer::Data(ReplyStatus::DataLow, octets) => octets.len() == usize::from(expected),
                // Without such octets it is open.
                Answer::Acknowledged | Answer::Status(_) => expected == 0,
                Answer::Silence | Answer::Data(..) | Answer::Wrong(_) => false,
            };
            if !is_right {
                return broken(format!(
                    "{} of master {sa} is answered with {}, expected DL with {expected} octets",
                    service.name(),
                    answer.words()
                ));
            }
        }
    }
    refused(tester, &[0x00], ReplyStatus::NoResource, "with an octet of data")?;
    tester.still_exchanges("RD_Inp and RD_Outp")
}

/// How often the outputs change.
const CHANGES: u8 = 100;

fn x08(tester: &mut Tester) -> Course {
    if !tester.setup.mirror {
        return inapplicable("needs a slave whose inputs follow its outputs: mirror");
    }
    tester.may_set_outputs()?;
    if tester.lengths.inputs < 2 {
        return inapplicable("the slave has fewer than two octets of inputs");
    }
    tester.start()?;
    let mirrored = usize::from(tester.lengths.inputs.min(tester.lengths.outputs));
    for change in 1..=CHANGES {
        let pattern = tester.pattern(if change % 2 == 0 { 0xAA } else { 0x55 });
        let inputs = tester.exchanged(&pattern)?;
        let seen = inputs.get(..mirrored).unwrap_or_default();
        if seen.windows(2).any(|two| two.first() != two.last()) {
            return broken(format!("inputs of two exchanges in one reply: {}", crate::explain::hex(&inputs)));
        }
    }
    let zeros = tester.zeros();
    tester.exchanged(&zeros).map(|_| ())
}

fn x09(tester: &mut Tester) -> Course {
    if tester.lengths.outputs != 8 {
        return inapplicable("the slave has no eight octets of outputs");
    }
    tester.start()?;
    let zeros = tester.zeros();
    for as_sd3 in [false, true, false] {
        let mut request = tester.request(tester.owner(), Service::DataExchange, &zeros);
        request.as_sd3 = as_sd3;
        let answer = tester.must_answer(&request)?;
        tester.inputs_of(answer)?;
    }
    Ok(())
}
