//! Where octets and frames come from: arguments, text, raw octets, captures.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Write};
use std::path::PathBuf;

use crate::can_bus::can::Frame;
use crate::explain::canopen::{FrameTextError, Network, frame_in};
use crate::explain::{Explanation, HexText};
use crate::host::capture::{LinkType, Packet, Reader, can};

use super::Buses;
use super::output::{Output, Place, Stopped};
use super::utf16::Utf16;
use crate::command::Failure;

/// What the arguments ask to read.
#[derive(Debug, PartialEq)]
pub(super) enum Input {
    /// Lines of octets.
    Octets(Vec<Vec<u8>>),
    /// Frames of CAN.
    Frames(Vec<Frame>),
    File(PathBuf),
    Stdin,
}

/// The longest piece of a line that is read at once. Longer lines are cut between octets.
const MOST_TEXT: usize = 64 * 1024;

/// The beginnings of pcapng, and of the older format in both orders of octets and with both units of time.
const CAPTURES: [[u8; 4]; 5] = [
    [0x0A, 0x0D, 0x0D, 0x0A],
    [0xA1, 0xB2, 0xC3, 0xD4],
    [0xD4, 0xC3, 0xB2, 0xA1],
    [0xA1, 0xB2, 0x3C, 0x4D],
    [0x4D, 0x3C, 0xB2, 0xA1],
];

impl Input {
    /// Octets if the arguments are hexadecimal, else the file that the only one names.
    pub(super) fn of(arguments: &[OsString]) -> Result<Self, Failure> {
        let lines: Vec<&str> = arguments.iter().filter_map(|argument| argument.to_str()).collect();
        if let Some(frames) = frames(&lines).filter(|_| lines.len() == arguments.len()) {
            return frames.map(Self::Frames).map_err(|error| Failure::Usage(error.to_string()));
        }
        let error = match (arguments, octets(&lines)) {
            ([], _) => return Ok(Self::Stdin),
            ([argument], _) if argument == "-" => return Ok(Self::Stdin),
            (_, Ok(octets)) if lines.len() == arguments.len() => return Ok(Self::Octets(octets)),
            (_, Ok(_)) => "it is no text".into(),
            (_, Err(error)) => error,
        };
        match arguments {
            [path] if PathBuf::from(path).exists() => Ok(Self::File(path.into())),
            [path] if resembles_path(&path.to_string_lossy()) => {
                Err(Failure::Other(format!("there is no file {}", PathBuf::from(path).display())))
            }
            [argument] => {
                let argument = argument.to_string_lossy();
                Err(Failure::Usage(format!("'{argument}' is neither a file nor hexadecimal: {error}")))
            }
            [..] => Err(Failure::Usage(format!("{error}; give octets in hexadecimal, or one file"))),
        }
    }

    /// Whether an octet has a line or packet worth naming.
    pub(super) const fn has_places(&self) -> bool {
        match self {
            Self::Octets(_) | Self::Frames(_) => false,
            Self::File(_) | Self::Stdin => true,
        }
    }

    /// Decodes all of it.
    pub(super) fn read<W: Write>(self, decoder: &mut Buses, output: &mut Output<W>) -> Result<(), Stopped> {
        match self {
            Self::Octets(lines) => {
                for octets in lines {
                    output.explain(Place::Nowhere, |sink| decoder.telegrams.line(&octets, sink))?;
                }
                output.explain(Place::Nowhere, |sink| decoder.telegrams.finish(sink))
            }
            Self::Frames(frames) => frames.iter().try_for_each(|frame| {
                output.explain(Place::Nowhere, |sink| sink(0, decoder.network.frame(frame)))
            }),
            Self::File(path) => {
                let cannot = |error: io::Error| {
                    Stopped::In(Failure::Other(format!("cannot open {}: {error}", path.display())))
                };
                any(File::open(&path).map_err(cannot)?, decoder, output)
            }
            Self::Stdin => any(io::stdin().lock(), decoder, output),
        }
    }
}

/// Whether who wrote this meant a file: a dot among words is none of a file's name.
fn resembles_path(argument: &str) -> bool {
    argument.contains('/') || (argument.contains('.') && !argument.contains(char::is_whitespace))
}

/// The frames of arguments; `None` if the first is none.
fn frames(arguments: &[&str]) -> Option<Result<Vec<Frame>, FrameTextError>> {
    let first = frame_in(arguments.first()?)?;
    let others = arguments.iter().skip(1).map(|line| match frame_in(line) {
        Some(frame) => frame,
        None => Err(FrameTextError::Data { found: (*line).into() }),
    });
    Some(core::iter::once(first).chain(others).collect())
}

/// The octets of arguments: one with spaces is a line, those without make one together.
fn octets(arguments: &[&str]) -> Result<Vec<Vec<u8>>, String> {
    let mut text = HexText::default();
    let mut line_of = |line: &str| text.octets(line).map_err(|error| error.to_string());
    let mut lines: Vec<Vec<u8>> = Vec::new();
    let mut together = String::new();
    for argument in arguments {
        if argument.trim().contains(char::is_whitespace) {
            lines.push(line_of(&core::mem::take(&mut together))?);
            lines.push(line_of(argument)?);
        } else {
            together.push_str(argument);
            together.push(' ');
        }
    }
    lines.push(line_of(&together)?);
    lines.retain(|line| !line.is_empty());
    if lines.is_empty() { Err("it holds no octets".into()) } else { Ok(lines) }
}

/// A capture, raw octets or text, as its beginning tells.
fn any<W: Write>(mut source: impl Read, decoder: &mut Buses, output: &mut Output<W>) -> Result<(), Stopped> {
    let mut head = [0; 1024];
    let mut len = 0;
    while len < 4 {
        match source.read(head.get_mut(len..).unwrap_or_default()) {
            Ok(0) => break,
            Ok(more) => len += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(unreadable(&error)),
        }
    }
    let head = Vec::from(head.get(..len).unwrap_or_default());
    let is_capture = head.first_chunk().is_some_and(|magic| CAPTURES.contains(magic));
    let (raw, order) = (is_raw(&head), Utf16::order(&head));
    let source = Cursor::new(head).chain(source);
    if let Some(order) = order {
        lines(BufReader::new(Utf16::new(source, order)), decoder, output)
    } else if is_capture {
        packets(source, decoder, output)
    } else if raw {
        raw_octets(source, decoder, output)
    } else {
        lines(BufReader::new(source), decoder, output)
    }
}

/// Whether these octets are no text.
fn is_raw(head: &[u8]) -> bool {
    let control = |octet: &u8| octet.is_ascii_control() && !octet.is_ascii_whitespace();
    // A character may be cut at the end.
    let broken = core::str::from_utf8(head).is_err_and(|error| error.error_len().is_some());
    broken || head.iter().any(control)
}

fn packets<W: Write>(source: impl Read, decoder: &mut Buses, output: &mut Output<W>) -> Result<(), Stopped> {
    let wrong = |error| Stopped::In(Failure::from_error(&error));
    for (number, packet) in (1..).zip(Reader::of_any(source).map_err(wrong)?) {
        // What came before is told before what is wrong with the rest.
        let packet = packet.map_err(wrong);
        if packet.is_err() {
            output.flush()?;
        }
        let packet = packet?;
        let place = Place::Packet { number, time: packet.time };
        output.explain(place, |sink| match packet.link {
            // A packet is whole: what is unfinished in it was broken off.
            LinkType::ProfibusDl => {
                decoder.telegrams.line(&packet.octets, sink);
                decoder.telegrams.finish(sink);
            }
            LinkType::CanSocketCan => sink(0, frame_of(&packet, &mut decoder.network)),
        })?;
    }
    output.flush()
}

/// A packet of a CAN bus.
fn frame_of(packet: &Packet, network: &mut Network) -> Explanation {
    match can::frame(&packet.octets) {
        Some(frame) => network.frame(&frame),
        None if can::is_error(&packet.octets) => {
            Network::error_frame(packet.comment.as_deref().unwrap_or("an error on the bus"))
        }
        None => Network::no_frame(&packet.octets, "no frame of CAN 2.0"),
    }
}

fn raw_octets<W: Write>(
    mut source: impl Read,
    decoder: &mut Buses,
    output: &mut Output<W>,
) -> Result<(), Stopped> {
    let mut octets = [0; 4096];
    loop {
        let len = match source.read(&mut octets) {
            Ok(0) => break,
            Ok(len) => len,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(unreadable(&error)),
        };
        let octets = octets.get(..len).unwrap_or_default();
        output.explain(Place::Stream, |sink| decoder.telegrams.octets(octets, sink))?;
        output.flush()?;
    }
    output.explain(Place::Stream, |sink| decoder.telegrams.finish(sink))?;
    output.flush()
}

fn lines<W: Write>(
    mut source: BufReader<impl Read>,
    decoder: &mut Buses,
    output: &mut Output<W>,
) -> Result<(), Stopped> {
    let mut text = HexText::default();
    let mut line = Vec::new();
    let mut number = 1;
    // Octets before this line, and the line of the last of them.
    let (mut from, mut before) = (0, 1);
    loop {
        // The next line may take a while.
        if source.buffer().is_empty() {
            output.flush()?;
        }
        let most = u64::try_from(MOST_TEXT - line.len()).unwrap_or(0);
        let read = source.by_ref().take(most).read_until(b'\n', &mut line);
        if read.map_err(|error| unreadable(&error))? == 0 && line.is_empty() {
            break;
        }
        let ended = line.ends_with(b"\n");
        let rest = if ended || line.len() < MOST_TEXT { Vec::new() } else { line.split_off(cut(&line)) };
        let written = String::from_utf8_lossy(&line);
        if let Some(what) = device_file(&written) {
            output.unreadable(number, &what)?;
            break;
        }
        match frame_in(&written) {
            Some(Ok(frame)) => {
                let place = Place::Line { number, from: 0, before: number };
                output.explain(place, |sink| sink(0, decoder.network.frame(&frame)))?;
            }
            Some(Err(error)) => output.unreadable(number, &error)?,
            None => match text.octets(&written) {
                Ok(octets) if octets.is_empty() => {}
                Ok(octets) => {
                    let place = Place::Line { number, from, before };
                    output.explain(place, |sink| decoder.telegrams.line(&octets, sink))?;
                    from += u64::try_from(octets.len()).unwrap_or(0);
                    before = number;
                }
                Err(error) => output.unreadable(number, &error)?,
            },
        }
        number += u64::from(ended);
        line = rest;
    }
    let place = Place::Line { number: before, from, before };
    output.explain(place, |sink| decoder.telegrams.finish(sink))?;
    output.flush()
}

/// Where to cut a line that is too long: behind its last separator; without one where it is full, which is between
/// two digits.
fn cut(line: &[u8]) -> usize {
    let separates = |octet: &u8| octet.is_ascii_whitespace() || matches!(octet, b',' | b'-' | b':');
    line.iter().rposition(separates).map_or(line.len(), |at| at + 1)
}

fn unreadable(error: &io::Error) -> Stopped {
    Stopped::In(Failure::Other(format!("cannot read the input: {error}")))
}

/// What a line of a device file is, which has no telegrams.
fn device_file(line: &str) -> Option<&'static str> {
    let line = line.trim().to_ascii_lowercase();
    match line.as_str() {
        "[fileinfo]" | "[deviceinfo]" => {
            Some("this is an EDS of a CANopen node and has no frames; see 'profidrive eds --help'")
        }
        line if line.starts_with("#profibus_dp") => {
            Some("this is a GSD of a PROFIBUS slave and has no telegrams; see 'profidrive gsd --help'")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(arguments: &[&str]) -> Result<Input, Failure> {
        Input::of(&arguments.iter().map(OsString::from).collect::<Vec<_>>())
    }

    #[test]
    fn arguments_are_octets_lines_a_file_or_stdin() {
        assert_eq!(input(&[]).unwrap(), Input::Stdin);
        assert_eq!(input(&["-"]).unwrap(), Input::Stdin);
        let octets = |lines: &[&[u8]]| Input::Octets(lines.iter().map(|line| line.to_vec()).collect());
        assert_eq!(input(&["10", "05", "0x02"]).unwrap(), octets(&[&[0x10, 5, 2]]));
        assert_eq!(input(&["1005", "00 0B", "E5"]).unwrap(), octets(&[&[0x10, 5], &[0, 0x0B], &[0xE5]]));
        assert_eq!(input(&["Cargo.toml"]).unwrap(), Input::File("Cargo.toml".into()));
    }

    #[test]
    fn what_is_neither_says_what_it_should_be() {
        for (arguments, usage, says) in [
            (&["68", "0G"][..], true, "'0G' is no hexadecimal octet"),
            (&["hello"], true, "'hello' is neither a file nor hexadecimal"),
            (&["68 0"], true, "odd number of digits"),
            (&["missing.txt"], false, "there is no file missing.txt"),
            (&["/missing"], false, "there is no file /missing"),
            (&[""], true, "it holds no octets"),
            (&["10.05 02"], true, "'10.05' is no hexadecimal octet"),
        ] {
            let (line, is_usage) = match input(arguments).unwrap_err() {
                Failure::Usage(line) => (line, true),
                Failure::Other(line) => (line, false),
            };
            assert!(line.contains(says) && is_usage == usage, "{arguments:?}: {line}");
        }
    }

    #[test]
    fn text_is_told_from_raw_octets() {
        for (head, raw) in [
            (&b"68 05\n\t# caf\xC3\xA9\r\n"[..], false),
            (b"# cut \xC3", false),
            (b"", false),
            (&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16], true),
            (&[0xE5], false),
            (&[0xE5, 0x41], true),
        ] {
            assert_eq!(is_raw(head), raw, "{head:02X?}");
        }
    }

    #[test]
    fn a_long_line_is_cut_between_octets() {
        assert_eq!(cut(b"68 05 0"), 6);
        assert_eq!(cut(b"0x68,0x0"), 5);
        assert_eq!(cut(b"68050568"), 8);
    }
}
