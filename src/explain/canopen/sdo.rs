//! Service data: what a master asks of an entry, and what the node answers.

use super::Said;
use super::entry::{in_words, name, named, octets_of, read_refusal, refusal};
use super::node::{Asked, Learned, append};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::sdo::{FRAME_LEN, Response, SdoRequest};
use crate::can_bus::canopen::{Abort, Address};
use crate::explain::{Field, Mark};

const SERVICE: &str = "SDO";

/// A frame to the server of a node.
pub(super) fn request(node: &mut Learned, number: u8, frame: &Frame) -> Said {
    let to = |summary: String| Said::new(SERVICE, format!("SDO to {number}: {summary}"), frame).to(number);
    let octets = match whole(frame) {
        Ok(octets) => octets,
        Err(why) => return to("not valid".into()).ignored(why),
    };
    let decoded = SdoRequest::decode(octets);
    let (summary, fields, mistake) = match decoded {
        SdoRequest::Upload { at } => {
            node.asked = Some(Asked::Read(at));
            (
                format!("read {}", named(node, at)),
                addressed(node, octets, "read", at, &[]),
                read_refusal(node, at),
            )
        }
        SdoRequest::Expedited { at, octets: data, len } => {
            let len = len.map_or_else(|| own_len(node, at), usize::from);
            let data = data.get(..len).unwrap_or_default();
            node.asked = Some(Asked::Write(at, data.into()));
            let mistake = refusal(node, at, data);
            let fields = addressed(node, octets, "write", at, data);
            (format!("write {} = {}", named(node, at), in_words(node, at, data)), fields, mistake)
        }
        SdoRequest::Download { at, len } => {
            node.asked = Some(Asked::Writing(at, Vec::new(), false));
            let long = len.map_or_else(String::new, |len| format!(", {len} octets"));
            let summary = format!("begin to write {} in segments{long}", named(node, at));
            (summary, addressed(node, octets, "write in segments", at, &[]), None)
        }
        SdoRequest::DownloadSegment { toggle, octets: data, len, last } => {
            let data = data.get(..usize::from(len)).unwrap_or_default();
            let (of, mistake) = write_segment(node, toggle, data);
            let end = if last { ", the last" } else { "" };
            (format!("segment{of}, {}{end}", octets_of(data.len())), segment(octets, data), mistake)
        }
        SdoRequest::UploadSegment { toggle } => {
            let (of, mistake) = match &node.asked {
                Some(Asked::Reading(at, _, expected)) => {
                    (format!(" of {}", named(node, *at)), wrong_toggle(*expected, toggle))
                }
                Some(Asked::Read(_) | Asked::Write(..) | Asked::Writing(..)) | None => {
                    (String::new(), Some("no read in segments is under way".into()))
                }
            };
            (format!("read the next segment{of}"), segment(octets, &[]), mistake)
        }
        SdoRequest::Abort(code) => {
            let of = node.asked.take().map(|asked| format!(" of {}", named(node, asked.at())));
            let summary = format!("the client aborts{}: {code}", of.unwrap_or_default());
            let fields = Vec::from([whole_field(octets, format!("abort: {code}")).marked(Mark::Trouble)]);
            (summary, fields, None)
        }
        SdoRequest::Block { at } => {
            let why = "block transfer is optional: a device that lacks it aborts".into();
            (
                format!("block transfer of {}", named(node, at)),
                Vec::from([whole_field(octets, "")]),
                Some(why),
            )
        }
        SdoRequest::Unknown { .. } => {
            let why = "no command of CiA 301: the node aborts with 05040001h or a code of its own".into();
            ("unknown command".into(), Vec::from([whole_field(octets, "")]), Some(why))
        }
    };
    finish(node, to(summary).with(fields), mistake, "STOPPED: it answers no SDO")
}

/// A frame from the server of a node.
pub(super) fn response(node: &mut Learned, number: u8, frame: &Frame) -> Said {
    let from =
        |summary: String| Said::new(SERVICE, format!("SDO from {number}: {summary}"), frame).from(number);
    let octets = match whole(frame) {
        Ok(octets) => octets,
        Err(why) => return from("not valid".into()).ignored(why),
    };
    let Some(decoded) = Response::decode(octets) else {
        return from("unknown answer".into()).ignored("no answer of CiA 301");
    };
    let asked = node.asked.take();
    let (summary, fields) = match decoded {
        Response::Expedited { at, octets: data, len } => {
            let data = data.get(..usize::from(len)).unwrap_or_default();
            node.hear(at, data);
            let fields = addressed(node, octets, "value", at, data);
            (format!("{} = {}", named(node, at), in_words(node, at, data)), fields)
        }
        Response::Downloaded { at } => {
            match asked {
                Some(Asked::Write(of, data)) if of == at => node.hear(at, &data),
                Some(Asked::Writing(of, data, _)) if of == at => {
                    node.asked = Some(Asked::Writing(at, data, false))
                }
                Some(Asked::Read(_) | Asked::Write(..) | Asked::Reading(..) | Asked::Writing(..)) | None => {}
            }
            (format!("{} written", named(node, at)), addressed(node, octets, "written", at, &[]))
        }
        Response::Upload { at, len } => {
            node.asked = Some(Asked::Reading(at, Vec::new(), false));
            let summary = format!("{} comes in segments, {len} octets", named(node, at));
            (summary, addressed(node, octets, "value in segments", at, &[]))
        }
        Response::Segment { octets: data, len, last, .. } => {
            let data = data.get(..usize::from(len)).unwrap_or_default();
            (read_segment(node, asked, data, last), segment(octets, data))
        }
        Response::SegmentTaken { .. } => {
            let of = asked.as_ref().map(|asked| format!(" of {}", named(node, asked.at())));
            node.asked = asked;
            (
                format!("segment{} taken", of.unwrap_or_default()),
                Vec::from([whole_field(octets, "segment taken")]),
            )
        }
        Response::Abort { at, code } => {
            let what = match asked {
                Some(Asked::Write(of, _) | Asked::Writing(of, _, _)) if of == at => "write refused",
                Some(Asked::Read(of) | Asked::Reading(of, _, _)) if of == at => "read refused",
                Some(Asked::Read(_) | Asked::Write(..) | Asked::Reading(..) | Asked::Writing(..)) | None => {
                    "refused"
                }
            };
            let fields = refused(node, octets, at, code);
            (format!("{what}, {}: {code}", named(node, at)), fields)
        }
    };
    from(summary).with(fields)
}

/// The eight octets, or why nobody takes the frame.
fn whole(frame: &Frame) -> Result<[u8; FRAME_LEN], &'static str> {
    if frame.is_remote() {
        return Err("a remote request of an SDO identifier is ignored");
    }
    frame.octets().try_into().map_err(|_| "an SDO frame has 8 octets; others are ignored")
}

fn finish(node: &Learned, said: Said, mistake: Option<String>, stopped: &str) -> Said {
    use crate::can_bus::canopen::NmtState;
    let said = match mistake {
        Some(why) => said.ignored(why),
        None => said,
    };
    match node.nmt {
        Some(NmtState::Stopped) => said.ignored(format!("the node is {stopped}")),
        Some(NmtState::Operational | NmtState::PreOperational) | None => said,
    }
}

/// How many octets count if a write does not say it.
fn own_len(node: &Learned, at: Address) -> usize {
    node.entry(at).ok().and_then(|entry| entry.data.octets()).unwrap_or(4).min(4)
}

fn write_segment(node: &mut Learned, toggle: bool, data: &[u8]) -> (String, Option<String>) {
    match node.asked.take() {
        Some(Asked::Writing(at, mut octets, expected)) => {
            append(&mut octets, data);
            node.asked = Some(Asked::Writing(at, octets, !expected));
            (format!(" of {}", named(node, at)), wrong_toggle(expected, toggle))
        }
        other @ (Some(Asked::Read(_) | Asked::Write(..) | Asked::Reading(..)) | None) => {
            node.asked = other;
            (String::new(), Some("no write in segments is under way".into()))
        }
    }
}

fn read_segment(node: &mut Learned, asked: Option<Asked>, data: &[u8], last: bool) -> String {
    match asked {
        Some(Asked::Reading(at, mut octets, toggle)) => {
            append(&mut octets, data);
            if last {
                return format!("{} = {}", named(node, at), in_words(node, at, &octets));
            }
            node.asked = Some(Asked::Reading(at, octets, !toggle));
            format!("segment of {}, {}", named(node, at), octets_of(data.len()))
        }
        other @ (Some(Asked::Read(_) | Asked::Write(..) | Asked::Writing(..)) | None) => {
            node.asked = other;
            format!("segment, {}", octets_of(data.len()))
        }
    }
}

fn wrong_toggle(expected: bool, got: bool) -> Option<String> {
    (expected != got).then(|| "the toggle bit has not alternated: the node aborts with 05030000h".into())
}

/// Command, address, value, and octets that are not used.
fn addressed(
    node: &Learned,
    octets: [u8; FRAME_LEN],
    command: &str,
    at: Address,
    value: &[u8],
) -> Vec<Field> {
    let (mut fields, rest) = head(node, octets, command, at);
    let (_, unused) = rest.split_at_checked(value.len()).unwrap_or((&[], &rest));
    if !value.is_empty() {
        fields.push(super::entry::field(node, at, 4, value));
    }
    if !unused.is_empty() {
        fields.push(Field::octets("not used", FRAME_LEN - unused.len(), unused, ""));
    }
    fields
}

fn refused(node: &Learned, octets: [u8; FRAME_LEN], at: Address, code: Abort) -> Vec<Field> {
    let (mut fields, rest) = head(node, octets, "abort", at);
    fields.push(Field::octets("abort code", 4, &rest, format!("{code}")).marked(Mark::Trouble));
    fields
}

fn head(node: &Learned, octets: [u8; FRAME_LEN], command: &str, at: Address) -> (Vec<Field>, [u8; 4]) {
    let [first, a, b, c, rest @ ..] = octets;
    let object = node.object(at).map_or("", |object| object.name);
    let of_sub = match node.object(at).map(|object| object.entries) {
        Some([_]) | None => String::new(),
        Some([..]) => name(node, at)
            .and_then(|name| name.split_once(": ").map(|(_, sub)| sub.into()))
            .unwrap_or_default(),
    };
    let fields = Vec::from([
        Field::octet("command", 0, first, command),
        Field::octets("index", 1, &[a, b], format!("{} {object}", at.index).trim_end()),
        Field::octet("sub-index", 3, c, of_sub),
    ]);
    (fields, rest)
}

fn segment(octets: [u8; FRAME_LEN], data: &[u8]) -> Vec<Field> {
    let [first, rest @ ..] = octets;
    let (_, unused) = rest.split_at_checked(data.len()).unwrap_or((&[], &rest));
    let mut fields = Vec::from([Field::octet("command", 0, first, "segment")]);
    if !data.is_empty() {
        fields.push(Field::octets("data", 1, data, ""));
    }
    if !unused.is_empty() {
        fields.push(Field::octets("not used", FRAME_LEN - unused.len(), unused, ""));
    }
    fields
}

fn whole_field(octets: [u8; FRAME_LEN], meaning: impl Into<String>) -> Field {
    Field::octets("data", 0, &octets, meaning)
}
