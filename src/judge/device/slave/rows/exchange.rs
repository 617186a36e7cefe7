//! Data_Exchange, RD_Inp and RD_Outp.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Bench;
use crate::judge::device::slave::answer::Answer;
use crate::judge::requirement::Confidence::B;
use crate::profibus::dp::Service;
use crate::profibus::fdl::ReplyStatus;

pub(super) const GROUP: Group<Bench> = Group {
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

fn x02(bench: &mut Bench) -> Course {
    let right = usize::from(bench.lengths.outputs);
    let fail_safe = bench.setup.gsd.as_ref().map(|gsd| gsd.flags.fail_safe || gsd.flags.fail_safe_required);
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
        bench.release()?;
        bench.must_start()?;
        let outputs = vec![0; len];
        bench.serve(bench.owner(), Service::DataExchange, &outputs)?;
        bench.waits_for_prm(&format!("a Data_Exchange with {len} octets, expected {right},"))?;
    }
    Ok(())
}

fn x03(bench: &mut Bench) -> Course {
    let Some(gsd) = bench.setup.gsd.as_ref() else {
        return inapplicable("needs the device file: gsd=");
    };
    if !gsd.flags.fail_safe && !gsd.flags.fail_safe_required {
        return inapplicable("the device file has no Fail_Safe");
    }
    if bench.lengths.outputs == 0 {
        return inapplicable("the slave has no outputs");
    }
    bench.start()?;
    for _ in 0..2 {
        let answer = bench.serve(bench.owner(), Service::DataExchange, &[])?;
        bench.inputs_of(answer)?;
    }
    bench.still_exchanges("Data_Exchange without outputs")
}

fn x04(bench: &mut Bench) -> Course {
    bench.start()?;
    let zeros = bench.zeros();
    let answer = bench.serve(bench.other(), Service::DataExchange, &zeros)?;
    if !answer.is_status(ReplyStatus::NotActivated) {
        return broken(format!(
            "Data_Exchange of another master is answered with {}, expected RS",
            answer.words()
        ));
    }
    bench.still_exchanges("a Data_Exchange of another master")
}

fn x05(bench: &mut Bench) -> Course {
    for state in ["WAIT-PRM", "WAIT-CFG"] {
        let zeros = bench.zeros();
        let answer = bench.serve(bench.owner(), Service::DataExchange, &zeros)?;
        if !answer.is_status(ReplyStatus::NotActivated) {
            return broken(format!(
                "Data_Exchange in {state} is answered with {}, expected RS",
                answer.words()
            ));
        }
        let prm = bench.prm();
        bench.set_prm(&prm)?;
    }
    Ok(())
}

fn x06(bench: &mut Bench) -> Course {
    bench.start()?;
    let (zeros, inputs) = (bench.zeros(), bench.lengths.inputs);
    for _ in 0..5 {
        let answer = bench.serve(bench.owner(), Service::DataExchange, &zeros)?;
        if inputs == 0 && answer != Answer::Acknowledged && !answer.is_status(ReplyStatus::DataHigh) {
            return broken(format!("a slave without inputs answers with {}, expected SC", answer.words()));
        }
        bench.inputs_of(answer)?;
    }
    Ok(())
}

fn x07(bench: &mut Bench) -> Course {
    let refused = |bench: &mut Bench, data: &[u8], expected: ReplyStatus, what: &str| -> Course {
        for service in [Service::RdInp, Service::RdOutp] {
            let answer = bench.serve(bench.other(), service, data)?;
            if !answer.is_status(expected) {
                return broken(format!("{} {what} is answered with {}", service.name(), answer.words()));
            }
        }
        Ok(())
    };
    refused(bench, &[], ReplyStatus::NotActivated, "in WAIT-PRM")?;
    bench.start()?;
    for sa in [bench.owner(), bench.other()] {
        for (service, expected) in
            [(Service::RdInp, bench.lengths.inputs), (Service::RdOutp, bench.lengths.outputs)]
        {
            let answer = bench.serve(sa, service, &[])?;
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
    refused(bench, &[0x00], ReplyStatus::NoResource, "with an octet of data")?;
    bench.still_exchanges("RD_Inp and RD_Outp")
}

/// How often the outputs change.
const CHANGES: u8 = 100;

fn x08(bench: &mut Bench) -> Course {
    if !bench.setup.mirror {
        return inapplicable("needs a slave whose inputs follow its outputs: mirror");
    }
    bench.may_set_outputs()?;
    if bench.lengths.inputs < 2 {
        return inapplicable("the slave has fewer than two octets of inputs");
    }
    bench.start()?;
    let mirrored = usize::from(bench.lengths.inputs.min(bench.lengths.outputs));
    for change in 1..=CHANGES {
        let pattern = bench.pattern(if change % 2 == 0 { 0xAA } else { 0x55 });
        let inputs = bench.exchanged(&pattern)?;
        let seen = inputs.get(..mirrored).unwrap_or_default();
        if seen.windows(2).any(|two| two.first() != two.last()) {
            return broken(format!("inputs of two exchanges in one reply: {}", crate::explain::hex(&inputs)));
        }
    }
    let zeros = bench.zeros();
    bench.exchanged(&zeros).map(|_| ())
}

fn x09(bench: &mut Bench) -> Course {
    if bench.lengths.outputs != 8 {
        return inapplicable("the slave has no eight octets of outputs");
    }
    bench.start()?;
    let zeros = bench.zeros();
    for as_sd3 in [false, true, false] {
        let mut request = bench.request(bench.owner(), Service::DataExchange, &zeros);
        request.as_sd3 = as_sd3;
        let answer = bench.must_answer(&request)?;
        bench.inputs_of(answer)?;
    }
    Ok(())
}
