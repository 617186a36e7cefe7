//! `profidrive decode`: octets and frames from anywhere to stdout, explained.

mod input;
mod output;
mod utf16;

use std::io::{self, IsTerminal};

use crate::explain::canopen::Network;
use crate::explain::{Context, Decoder};

use super::Failure;
use super::args::Decode;
use input::Input;
use output::{Output, Stopped};

/// What explains telegrams, and what explains frames: lines and packets of both may be in one input.
struct Buses {
    telegrams: Decoder,
    network: Network,
}

/// Explains everything there is and says at the end whether all of it was valid.
pub(crate) fn decode(args: &Decode) -> Result<(), Failure> {
    let input = Input::of(&args.input)?;
    if matches!(input, Input::Stdin) && io::stdin().is_terminal() {
        eprintln!("profidrive: reads hexadecimal lines from this terminal; Ctrl-D ends");
    }
    let context = args.mode.map_or_else(Context::default, Context::with_mode);
    let mut network = args.device.map_or_else(Network::default, |device| Network::of(device.vocabulary));
    for (node, device) in &args.node {
        network.know(*node, device.vocabulary);
    }
    let mut decoder = Buses { telegrams: Decoder::new(context, args.taking.into()), network };
    let mut output = Output::new(io::stdout().lock(), args, input.has_places());
    match input.read(&mut decoder, &mut output) {
        Ok(()) => {}
        // Whoever reads may have seen enough (`| head`).
        Err(Stopped::Out(error)) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(()),
        Err(Stopped::Out(error)) => return Err(Failure::Other(format!("cannot write to stdout: {error}"))),
        Err(Stopped::In(failure)) => return Err(failure),
    }
    output.verdict(args.strict)
}
