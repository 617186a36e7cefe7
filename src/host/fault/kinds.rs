//! Every kind of fault: one row for its name, its value, and what it does in words. Where it acts it has one arm.

use core::fmt;

use super::BusKind;
use super::parameter::{
    AbortCode, Diagnosis, Exchanges, Few, FramePart, HexOctet, Nothing, Octets, Other, Parameter, Time,
};
use crate::can_bus::canopen::faults;
use crate::can_bus::canopen::faults::{BootUpFault, HeartbeatFault, SdoFault, TpdoFault};
use crate::host::can::fault::FrameFault;
use crate::host::link::fault::{PkwFault, ReplyFault, RequestFault, ShapeFault};

/// What goes wrong, by where it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// What the stations of a line hear.
    Request(RequestFault),
    /// What the stations of a line send.
    Reply(ReplyFault),
    /// What a CANopen node sends.
    Node(faults::Kind),
    /// A frame on a bus of CAN.
    Frame(FrameFault),
}

/// Where a kind of fault acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// On the way from the masters of PROFIBUS to the stations.
    Request,
    /// On the way from the stations to the masters.
    Reply,
    /// Between a CANopen node and the bus.
    Node,
    /// On the bus of CAN, whoever sends.
    Frame,
}

impl Way {
    /// The bus.
    pub(crate) const fn bus(self) -> BusKind {
        match self {
            Self::Request | Self::Reply => BusKind::Profibus,
            Self::Node | Self::Frame => BusKind::Can,
        }
    }
}

/// A kind of fault in words.
#[derive(Debug)]
pub struct Row {
    /// As it is written.
    pub name: &'static str,
    /// How its value is written, with its `=`; empty if it has none.
    pub form: &'static str,
    /// What its value must be.
    pub expected: &'static str,
    /// Where it acts.
    pub way: Way,
    /// What it counts.
    pub occasion: &'static str,
    /// What the master gets.
    pub effect: &'static str,
    pub(super) read: fn(Option<&str>) -> Option<Kind>,
}

impl Row {
    /// Every kind of fault.
    pub const fn all() -> &'static [Self] {
        ROWS
    }

    /// How it may be written: `late=20ms`.
    pub(crate) fn example(&self) -> String {
        let value = match self.form {
            "=TIME" => "=20ms",
            "=N" => "=10",
            "=HH" => "=05",
            "=CODE" => "=08000022",
            "=PART" => "=length",
            "=OCTETS" => "=020C",
            // What may be left out.
            _ => "",
        };
        format!("{}{value}", self.name)
    }

    /// The one with this name, or with a name that it had once.
    pub(super) fn named(name: &str) -> Option<&'static Self> {
        let renamed = RENAMED.iter().find(|(once, _)| *once == name);
        let name = renamed.map_or(name, |(_, now)| now);
        ROWS.iter().find(|row| row.name == name)
    }

    /// Those of a bus.
    pub(super) fn of(bus: BusKind) -> impl Iterator<Item = &'static Self> {
        ROWS.iter().filter(move |row| row.way.bus() == bus)
    }
}

/// What was written once, and what is written now.
const RENAMED: [(&str, &str); 2] = [("diag-storm", "diag-announced"), ("emcy-storm", "emcy-repeated")];

impl fmt::Display for Row {
    /// `late=TIME`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.name, self.form)
    }
}

/// The parameter of a row.
macro_rules! parameter {
    () => {
        Nothing
    };
    ($parameter:ty) => {
        $parameter
    };
}

/// `"name" (value: Parameter) { Way(kind) } "occasion", "effect";`
macro_rules! kinds {
    ($($name:literal $(($value:ident: $parameter:ty))? { $way:ident ($($kind:tt)*) } $occasion:literal, $effect:literal;)*) => {
        const ROWS: &[Row] = &[$(Row {
            name: $name,
            form: <parameter!($($parameter)?)>::FORM,
            expected: <parameter!($($parameter)?)>::EXPECTED,
            way: Way::$way,
            occasion: $occasion,
            effect: $effect,
            read: |text| {
                let read = <parameter!($($parameter)?)>::read(text);
                read.map(|_value| {
                    $(let $value = _value;)?
                    Kind::$way($($kind)*)
                })
            },
        }),*];

        impl Kind {
            /// How it is written: its name, and its value if it has one.
            fn written(self) -> (&'static str, Option<String>) {
                match self {
                    $(Self::$way($($kind)*) => {
                        let written = [$(<$parameter>::write($value))?];
                        ($name, written.into_iter().next().flatten())
                    })*
                }
            }
        }
    };
}

kinds! {
    "no-reply" { Reply(ReplyFault::Lost) }
        "a reply", "nothing";
    "late" (time: Time) { Reply(ReplyFault::Late(time)) }
        "a reply", "the reply this time later; telegrams that are sent meanwhile come first";
    "duplicate" { Reply(ReplyFault::Duplicate) }
        "a reply", "the reply twice";
    "truncated" { Reply(ReplyFault::Truncated) }
        "a reply", "only its beginning, 0 octets or more";
    "bit-errors" (bits: Few<1>) { Reply(ReplyFault::BitErrors(bits)) }
        "a reply", "the reply with N inverted bits (1)";
    "wrong-fcs" { Reply(ReplyFault::Shape(ShapeFault::WrongFcs)) }
        "a reply with FCS (not SC)", "FCS one too high";
    "wrong-length" { Reply(ReplyFault::Shape(ShapeFault::WrongLength)) }
        "an SD2 reply", "LE and LEr one too high, so that an octet is missing (LE 249: one too low)";
    "wrong-source" (of: Other) { Reply(ReplyFault::Shape(ShapeFault::WrongSource(of))) }
        "a reply with SA", "a correct telegram of another station (the next one)";
    "noise" (octets: Few<4>) { Reply(ReplyFault::Noise(octets)) }
        "a reply", "N octets (4) of noise between request and reply";
    "drop-request" { Request(RequestFault::Drop) }
        "a request", "nothing: no drive hears the request, broadcasts included";
    "diag-announced" { Reply(ReplyFault::Shape(ShapeFault::DiagAnnounced)) }
        "a Data_Exchange reply with inputs", "DH: a diagnosis is announced, and Slave_Diag is as always";
    "not-ready" (time: Time) { Request(RequestFault::NotReady(time)) }
        "a Chk_Cfg", "the slave stays in WAIT-CFG for this time, as if its application needs time for the check: \
         Station_Not_Ready in Slave_Diag, RS to Data_Exchange and to reading, Global_Control without effect";
    "refuse-prm" { Request(RequestFault::RefusePrm) }
        "a Set_Prm", "SC, then Prm_Fault: the drive sees another ident number";
    "refuse-cfg" { Request(RequestFault::RefuseCfg) }
        "a Chk_Cfg", "SC, then Cfg_Fault: the drive sees another configuration";
    "lose-prm" { Request(RequestFault::LosePrm) }
        "a Data_Exchange", "RS, then Prm_Req: just before it the slave leaves its master and waits for Set_Prm";
    "reject" { Request(RequestFault::Reject) }
        "an SRD request", "RS: the drive gets a request for a service that is not active";
    "function-code" (octet: HexOctet<2>) { Reply(ReplyFault::Shape(ShapeFault::FunctionCode(octet))) }
        "a reply", "the reply with this FC octet, without data if this code has none; also in place of SC";
    "short-ack" { Reply(ReplyFault::Shape(ShapeFault::ShortAck)) }
        "a reply", "SC in place of the reply";
    "input-length" (octets: Octets) { Reply(ReplyFault::Shape(ShapeFault::InputLength(octets))) }
        "a Data_Exchange reply", "N octets of inputs, cut off or filled with zeros";
    "wrong-destination" (of: Other) { Reply(ReplyFault::Shape(ShapeFault::WrongDestination(of))) }
        "a reply with DA", "a correct telegram to another master (the next address)";
    "no-saps" { Reply(ReplyFault::Shape(ShapeFault::NoSaps)) }
        "a reply with SAPs", "the reply without its SAPs";
    "wrong-saps" { Reply(ReplyFault::Shape(ShapeFault::WrongSaps)) }
        "a reply with SAPs", "the reply from the next SAP number";
    "broken-frame" (part: FramePart) { Reply(ReplyFault::Shape(ShapeFault::BrokenFrame(part))) }
        "an SD2 reply",
        "one part wrong: `length` (LE and LEr 3), `repeated` (LEr), `start` (second 68), `end` (ED)";
    "sd3" { Reply(ReplyFault::Shape(ShapeFault::Sd3)) }
        "a reply with 8 octets and no SAPs", "the reply as SD3";
    "diag" (octets: Diagnosis) { Reply(ReplyFault::Shape(ShapeFault::Diagnosis(octets))) }
        "a Slave_Diag reply", "these first octets in hex, `..` for an octet that is not changed: `diag=..0D`";
    "diag-length" (octets: Octets) { Reply(ReplyFault::Shape(ShapeFault::DiagLength(octets))) }
        "a Slave_Diag reply", "N octets, cut off or filled with device-related blocks";
    "pkw-delay" (exchanges: Exchanges) { Reply(ReplyFault::Pkw(PkwFault::Delay(exchanges))) }
        "a PKW answer", "the answer N exchanges later, until then the answer of before";
    "pkw-wrong-ak" { Reply(ReplyFault::Pkw(PkwFault::WrongAk)) }
        "a PKW answer", "reply 1 and 2, 4 and 5, 7 and 8 exchanged; in others the lowest bit of AK inverted";
    "pkw-wrong-pnu" { Reply(ReplyFault::Pkw(PkwFault::WrongPnu)) }
        "a PKW answer", "the PNU with its lowest bit inverted";
    "pkw-torn" { Reply(ReplyFault::Pkw(PkwFault::Torn)) }
        "a PKW answer", "for one exchange the old PKE and IND with the new PWE";
    "boot-up-missing" { Node(faults::Kind::BootUp(BootUpFault::Missing)) }
        "a boot-up", "no boot-up";
    "boot-up-twice" { Node(faults::Kind::BootUp(BootUpFault::Twice)) }
        "a boot-up", "two";
    "sdo-late" (time: Time) { Node(faults::Kind::Sdo(SdoFault::Late(time))) }
        "an SDO answer", "the answer this time later";
    "sdo-lost" { Node(faults::Kind::Sdo(SdoFault::Lost)) }
        "an SDO answer", "no answer";
    "sdo-twice" { Node(faults::Kind::Sdo(SdoFault::Twice)) }
        "an SDO answer", "the answer twice";
    "sdo-other-index" { Node(faults::Kind::Sdo(SdoFault::OtherIndex)) }
        "an SDO answer that is no segment", "the answer of another object: bit 0 of the index is inverted";
    "sdo-wrong-toggle" { Node(faults::Kind::Sdo(SdoFault::WrongToggle)) }
        "an SDO answer to a segment", "the wrong toggle bit";
    "sdo-abort" (code: AbortCode) { Node(faults::Kind::Sdo(SdoFault::Abort(code))) }
        "an SDO answer", "this abort code (hexadecimal) in its place";
    "heartbeat-jitter" (time: Time) { Node(faults::Kind::Heartbeat(HeartbeatFault::Jitter(time))) }
        "every second heartbeat", "the heartbeat this time later";
    "heartbeat-lost" { Node(faults::Kind::Heartbeat(HeartbeatFault::Lost)) }
        "a heartbeat", "no heartbeat";
    "heartbeat-stuck" (octet: HexOctet<1>) { Node(faults::Kind::Heartbeat(HeartbeatFault::Stuck(octet))) }
        "a heartbeat", "always this octet";
    "guarding-toggle-stuck" { Node(faults::Kind::GuardingToggleStuck) }
        "a guarding answer", "bit 7 is 0";
    "tpdo-short" { Node(faults::Kind::Tpdo(TpdoFault::Short)) }
        "a TPDO", "the TPDO without its last octet";
    "tpdo-stale" { Node(faults::Kind::Tpdo(TpdoFault::Stale)) }
        "a TPDO", "the data of the first TPDO with this fault";
    "tpdo-swapped" { Node(faults::Kind::Tpdo(TpdoFault::Swapped)) }
        "a TPDO", "the TPDO after the next TPDO of the node";
    "emcy-repeated" (period: Time) { Node(faults::Kind::EmcyEach(period)) }
        "the end of each such period", "EMCY FF00h";
    "pre-operational" { Node(faults::Kind::LeaveOperational) }
        "a TPDO", "after it the node is in PRE-OPERATIONAL, without a command";
    "brown-out" (time: Time) { Node(faults::Kind::BrownOut(time)) }
        "a frame of the node",
        "no frame, nothing for this time, then a boot-up: the supply has failed and returned";
    "frame-lost" { Frame(FrameFault::Lose) }
        "a frame", "no station receives it";
    "frame-late" (time: Time) { Frame(FrameFault::Delay(time)) }
        "a frame", "it comes this time later";
    "frame-twice" { Frame(FrameFault::Double) }
        "a frame", "it comes twice";
    "frame-damaged" { Frame(FrameFault::Damage) }
        "a frame, and each repetition",
        "an error frame, and its sender sends it again: `count=32` makes the sender bus off";
    "frame-not-acknowledged" { Frame(FrameFault::NotAcknowledged) }
        "a frame, and each repetition",
        "the same without an acknowledge: `count=16` makes the sender error passive";
}

impl Kind {
    /// Where it acts.
    pub(crate) const fn way(&self) -> Way {
        match self {
            Self::Request(_) => Way::Request,
            Self::Reply(_) => Way::Reply,
            Self::Node(_) => Way::Node,
            Self::Frame(_) => Way::Frame,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.written() {
            (name, Some(value)) => write!(f, "{name}={value}"),
            (name, None) => f.write_str(name),
        }
    }
}
