//! Function blocks of a PLC in front of a drive of PROFIdrive 4 (docs/profidrive.md), in virtual time: one for telegram 1, a
//! speed, and one for telegram 111, a position. They have the inputs and outputs that the blocks SINA_SPEED and SINA_POS of PLC
//! libraries have by their public description, and each makes its process data as those do.
//!
//!     cargo run --example function_blocks

#![allow(dead_code, reason = "the example uses a part of the blocks, its test another")]

use profidrive::devices::BusDrive as _;
use profidrive::devices::ppo_drive::profile::{StwBit, ZswBit};
use profidrive::devices::profidrive4::profibus::bits::{
    PosStw1Bit, PosStw2Bit, PosZsw1Bit, PosZsw2Bit, PositionStwBit, PositionZswBit,
};
use profidrive::devices::profidrive4::profibus::{
    Family, IDENT_NUMBER, ProfidriveDevice, Signal, Telegram, TelegramOnly,
};
use profidrive::face::Surroundings as _;
use profidrive::face::surroundings::Level;
use profidrive::profibus::dp::{Description, Fixed};
use profidrive::profibus::dpv1::{Identification, Offer};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service, Telegram as Frame,
};
use profidrive::time::{BaudRate, Instant};

/// 4000h, 100 %.
const FULL: f64 = 16384.0;

/// What a block says of itself: everything is right, or why not.
const WORKS: u16 = 0x7002;
const WRONG_MODE: u16 = 0x8202;
const WRONG_OVERRIDE: u16 = 0x8203;
const WRONG_BLOCK: u16 = 0x8204;
const FAULT: u16 = 0x8401;
const INHIBITED: u16 = 0x8402;
const NOT_FLYING: u16 = 0x8403;
const NO_DATA: u16 = 0x8600;

/// The code of reading data that are not there.
const NOT_READ: u16 = 0x80A0;

/// Calls in which flying referencing has begun.
const FLIES_AFTER: u32 = 20;

/// The block for telegram 1.
#[derive(Clone, Debug)]
pub(crate) struct SpeedBlock {
    /// ON.
    pub(crate) enable_axis: bool,
    /// Acknowledge a fault.
    pub(crate) ack_error: bool,
    /// Setpoint, rpm.
    pub(crate) speed_sp: f64,
    /// What 4000h is, rpm: PNU 2000 of the drive.
    pub(crate) ref_speed: f64,
    /// Bits of STW1: [`CONFIG_AXIS`].
    pub(crate) config_axis: u16,
    /// The axis is on and follows.
    pub(crate) axis_enabled: bool,
    /// Switching on is inhibited.
    pub(crate) lockout: bool,
    /// rpm.
    pub(crate) act_velocity: f64,
    /// Something is wrong: [`SpeedBlock::status`].
    pub(crate) error: bool,
    /// 7002h, 8401h, 8402h or 8600h.
    pub(crate) status: u16,
    /// Why the data were not read; 0: they were.
    pub(crate) diag_id: u16,
}

/// Where each bit of ConfigAxis is in STW1: no OFF2, no OFF3, enable operation, ramp generator, ramp runs, setpoint, brake
/// open, direction of rotation, motor potentiometer higher, lower, and three that are free.
const CONFIG_AXIS: [u8; 13] = [1, 2, 3, 4, 5, 6, 12, 11, 13, 14, 8, 9, 15];

impl SpeedBlock {
    pub(crate) const NEW: Self = Self {
        enable_axis: false,
        ack_error: false,
        speed_sp: 0.0,
        ref_speed: 3000.0,
        config_axis: 0x3F,
        axis_enabled: false,
        lockout: true,
        act_velocity: 0.0,
        error: false,
        status: WORKS,
        diag_id: 0,
    };

    /// One call: the newest actual values in, the setpoints out.
    #[expect(clippy::cast_possible_truncation, reason = "float to integer saturates")]
    pub(crate) fn call(&mut self, telegram: &Telegram, inputs: &[u8]) -> Vec<u16> {
        let actual = |signal| low(telegram.actual_value(inputs, signal).unwrap_or_default());
        let zsw1 = actual(Signal::Zsw1);
        self.axis_enabled = ZswBit::OperationEnabled.is_set(zsw1);
        self.lockout = ZswBit::SwitchingOnInhibited.is_set(zsw1);
        self.act_velocity = f64::from(actual(Signal::NistA).cast_signed()) / FULL * self.ref_speed;
        let faulty = ZswBit::Fault.is_set(zsw1);
        (self.status, self.diag_id) = status_of(telegram, inputs, faulty, self.lockout);
        self.error = self.status != WORKS;
        let of_config = CONFIG_AXIS.iter().enumerate().map(|(at, bit)| (self.config_axis >> at & 1) << bit);
        let stw1 = of_config.fold(0, |word, bit| word | bit)
            | StwBit::On.when(self.enable_axis)
            | StwBit::Acknowledge.when(self.ack_error)
            | StwBit::ByPlc.mask();
        let setpoint = (self.speed_sp / self.ref_speed * FULL).round() as i16;
        vec![stw1, setpoint.cast_unsigned()]
    }
}

/// Status and DiagID of the drive and of the data from it.
fn status_of(telegram: &Telegram, inputs: &[u8], faulty: bool, inhibited: bool) -> (u16, u16) {
    if inputs.len() < telegram.lengths().1 {
        return (NO_DATA, NOT_READ);
    }
    let status = match (faulty, inhibited) {
        (true, _) => FAULT,
        (false, true) => INHIBITED,
        (false, false) => WORKS,
    };
    (status, 0)
}

/// What the block for telegram 111 does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ModePos {
    Relative = 1,
    Absolute = 2,
    SetUp = 3,
    Home = 4,
    SetReference = 5,
    Block = 6,
    Jog = 7,
    JogIncremental = 8,
}

impl ModePos {
    const ALL: [Self; 8] = [
        Self::Relative,
        Self::Absolute,
        Self::SetUp,
        Self::Home,
        Self::SetReference,
        Self::Block,
        Self::Jog,
        Self::JogIncremental,
    ];

    /// The mode of this number.
    fn numbered(number: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| *mode as u16 == number)
    }
}

/// The block for telegram 111.
#[derive(Clone, Debug)]
pub(crate) struct PositionBlock {
    /// A [`ModePos`].
    pub(crate) mode_pos: u16,
    pub(crate) enable_axis: bool,
    /// Not: the task is rejected.
    pub(crate) cancel_traversing: bool,
    /// Not: the axis stops and goes on later.
    pub(crate) intermediate_stop: bool,
    pub(crate) positive: bool,
    pub(crate) negative: bool,
    pub(crate) jog_1: bool,
    pub(crate) jog_2: bool,
    /// Flying referencing, beside any mode but 4 and 5.
    pub(crate) fly_ref: bool,
    pub(crate) ack_error: bool,
    /// The edge begins the task.
    pub(crate) execute_mode: bool,
    /// LU, or the number of the traversing block.
    pub(crate) position: i32,
    /// 1000 LU/min.
    pub(crate) velocity: u32,
    /// Percent: 0 to 199, 100 and 100.
    pub(crate) over_v: i16,
    pub(crate) over_acc: i16,
    pub(crate) over_dec: i16,
    /// Bits of STW1, POS_STW1, POS_STW2 and STW2: [`CONFIG_EPOS`].
    pub(crate) config_epos: u32,
    pub(crate) axis_enabled: bool,
    pub(crate) axis_pos_ok: bool,
    /// The setpoint stands.
    pub(crate) axis_sp_fixed: bool,
    pub(crate) axis_ref: bool,
    pub(crate) axis_warn: bool,
    pub(crate) axis_error: bool,
    pub(crate) lockout: bool,
    /// 40000000h is the reference speed.
    pub(crate) act_velocity: i32,
    /// LU.
    pub(crate) act_position: i32,
    /// The mode of what runs; 0: nothing.
    pub(crate) act_mode: u16,
    pub(crate) epos_zsw1: u16,
    pub(crate) epos_zsw2: u16,
    pub(crate) act_warn: u16,
    pub(crate) act_fault: u16,
    pub(crate) error: bool,
    /// 7002h, 8202h to 8204h, 8401h to 8403h or 8600h.
    pub(crate) status: u16,
    pub(crate) diag_id: u16,
    /// How many calls flying referencing is wanted and does not run.
    grounded: u32,
}

/// Where a bit of ConfigEPos goes: in which of the first four words, and which bit of it.
#[derive(Clone, Copy, Debug)]
struct Place {
    word: usize,
    bit: u8,
}

const fn place(word: usize, bit: u8) -> Place {
    Place { word, bit }
}

/// STW1 is word 0, POS_STW1 1, POS_STW2 2, STW2 3. Bit 15 is free.
const CONFIG_EPOS: [Option<Place>; 32] = [
    Some(place(0, 1)),
    Some(place(0, 2)),
    Some(place(2, 14)),
    Some(place(2, 15)),
    Some(place(2, 11)),
    Some(place(2, 10)),
    Some(place(2, 2)),
    Some(place(0, 13)),
    Some(place(1, 12)),
    Some(place(3, 0)),
    Some(place(3, 1)),
    Some(place(3, 2)),
    Some(place(3, 3)),
    Some(place(3, 4)),
    Some(place(3, 7)),
    None,
    Some(place(0, 14)),
    Some(place(0, 15)),
    Some(place(1, 6)),
    Some(place(1, 7)),
    Some(place(1, 11)),
    Some(place(1, 13)),
    Some(place(2, 3)),
    Some(place(2, 4)),
    Some(place(2, 6)),
    Some(place(2, 7)),
    Some(place(2, 12)),
    Some(place(2, 13)),
    Some(place(3, 5)),
    Some(place(3, 6)),
    Some(place(3, 8)),
    Some(place(3, 9)),
];

impl PositionBlock {
    pub(crate) const NEW: Self = Self {
        mode_pos: ModePos::Absolute as u16,
        enable_axis: false,
        cancel_traversing: true,
        intermediate_stop: true,
        positive: false,
        negative: false,
        jog_1: false,
        jog_2: false,
        fly_ref: false,
        ack_error: false,
        execute_mode: false,
        position: 0,
        velocity: 6000,
        over_v: 100,
        over_acc: 100,
        over_dec: 100,
        config_epos: 0b11,
        axis_enabled: false,
        axis_pos_ok: false,
        axis_sp_fixed: false,
        axis_ref: false,
        axis_warn: false,
        axis_error: false,
        lockout: true,
        act_velocity: 0,
        act_position: 0,
        act_mode: 0,
        epos_zsw1: 0,
        epos_zsw2: 0,
        act_warn: 0,
        act_fault: 0,
        error: false,
        status: WORKS,
        diag_id: 0,
        grounded: 0,
    };

    /// One call: the newest actual values in, the setpoints out.
    pub(crate) fn call(&mut self, telegram: &Telegram, inputs: &[u8]) -> Vec<u16> {
        self.look(telegram, inputs);
        let mode = ModePos::numbered(self.mode_pos);
        self.judge(mode, telegram, inputs);
        let wrong = matches!(self.status, WRONG_MODE | WRONG_OVERRIDE | WRONG_BLOCK);
        let is = |wanted| mode == Some(wanted);
        let executes = self.execute_mode && !wrong;
        let mdi = is(ModePos::Relative) || is(ModePos::Absolute) || is(ModePos::SetUp);
        let jogs = is(ModePos::Jog) || is(ModePos::JogIncremental);
        let flies = self.flies(mode);
        let stw1 = StwBit::On.when(self.enable_axis)
            | StwBit::EnableOperation.mask()
            | PositionStwBit::NoRejection.when(self.cancel_traversing)
            | PositionStwBit::NoStop.when(self.intermediate_stop)
            | PositionStwBit::Begin.when((mdi || is(ModePos::Block)) && executes)
            | StwBit::Acknowledge.when(self.ack_error)
            | StwBit::Inching1.when(jogs && self.jog_1)
            | StwBit::Inching2.when(jogs && self.jog_2)
            | StwBit::ByPlc.mask()
            | PositionStwBit::Home.when(is(ModePos::Home) && executes || flies);
        let block = u16::try_from(self.position).unwrap_or_default();
        let pos_stw1 = PosStw1Bit::Mdi.when(mdi)
            | PosStw1Bit::Absolute.when(is(ModePos::Absolute))
            | PosStw1Bit::SetUp.when(is(ModePos::SetUp))
            | PosStw1Bit::Forward.when(self.positive)
            | PosStw1Bit::Backward.when(self.negative)
            | if is(ModePos::Block) && !wrong { block } else { 0 };
        let pos_stw2 = PosStw2Bit::SetReference.when(is(ModePos::SetReference) && executes)
            | PosStw2Bit::Incremental.when(is(ModePos::JogIncremental))
            | PosStw2Bit::Flying.when(flies)
            | PosStw2Bit::HomeBackward.when(is(ModePos::Home) && self.negative);
        let mut words = [stw1, pos_stw1, pos_stw2, 0];
        for (at, place) in CONFIG_EPOS.iter().enumerate() {
            if let Some(Place { word, bit }) = place
                && let Some(word) = words.get_mut(*word)
            {
                *word |= low(self.config_epos >> at & 1) << bit;
            }
        }
        let part = |percent: i16| low(u32::from(percent.max(0).unsigned_abs()) * 0x4000 / 100);
        let [target_high, target_low] = split(self.position.cast_unsigned());
        let [velocity_high, velocity_low] = split(self.velocity);
        let behind = [
            part(self.over_v),
            target_high,
            target_low,
            velocity_high,
            velocity_low,
            part(self.over_acc),
            part(self.over_dec),
            0,
        ];
        [&words[..], &behind].concat()
    }

    /// Flying referencing is not for the modes that reference themselves.
    fn flies(&self, mode: Option<ModePos>) -> bool {
        self.fly_ref && !matches!(mode, Some(ModePos::Home | ModePos::SetReference))
    }

    /// Error, Status and DiagID.
    fn judge(&mut self, mode: Option<ModePos>, telegram: &Telegram, inputs: &[u8]) {
        let flies = self.flies(mode) && self.axis_enabled;
        let runs = PosZsw1Bit::Flying.is_set(self.epos_zsw1);
        self.grounded = if flies && !runs { self.grounded.saturating_add(1) } else { 0 };
        let within = |percent: i16, most| (0..=most).contains(&percent);
        let overrides = within(self.over_v, 199) && within(self.over_acc, 100) && within(self.over_dec, 100);
        let block = mode != Some(ModePos::Block) || (0..=63).contains(&self.position);
        (self.status, self.diag_id) = match status_of(telegram, inputs, self.axis_error, self.lockout) {
            (WORKS, _) if mode.is_none() => (WRONG_MODE, 0),
            (WORKS, _) if !overrides => (WRONG_OVERRIDE, 0),
            (WORKS, _) if !block => (WRONG_BLOCK, 0),
            (WORKS, _) if self.grounded > FLIES_AFTER => (NOT_FLYING, 0),
            found => found,
        };
        self.error = self.status != WORKS;
    }

    fn look(&mut self, telegram: &Telegram, inputs: &[u8]) {
        let actual = |signal| telegram.actual_value(inputs, signal).unwrap_or_default();
        let zsw1 = low(actual(Signal::Zsw1));
        self.axis_enabled = ZswBit::OperationEnabled.is_set(zsw1);
        self.axis_error = ZswBit::Fault.is_set(zsw1);
        self.axis_warn = ZswBit::Warning.is_set(zsw1);
        self.lockout = ZswBit::SwitchingOnInhibited.is_set(zsw1);
        self.axis_pos_ok = PositionZswBit::TargetReached.is_set(zsw1);
        self.axis_ref = PositionZswBit::Referenced.is_set(zsw1);
        self.epos_zsw1 = low(actual(Signal::PosZsw1));
        self.epos_zsw2 = low(actual(Signal::PosZsw2));
        self.axis_sp_fixed = PosZsw2Bit::SetpointStands.is_set(self.epos_zsw2);
        self.act_position = actual(Signal::XistA).cast_signed();
        self.act_velocity = actual(Signal::NistB).cast_signed();
        self.act_fault = low(actual(Signal::FaultCode));
        self.act_warn = low(actual(Signal::WarnCode));
        let asked = self.mode_pos;
        let either = |one: ModePos, other: ModePos| if asked == other as u16 { other } else { one };
        let runs = [
            (PosZsw1Bit::Jog, either(ModePos::Jog, ModePos::JogIncremental)),
            (PosZsw1Bit::Homing, ModePos::Home),
            (PosZsw1Bit::Blocks, ModePos::Block),
            (PosZsw1Bit::SetUp, ModePos::SetUp),
            (PosZsw1Bit::Mdi, either(ModePos::Relative, ModePos::Absolute)),
        ];
        let found = runs.iter().find(|(bit, _)| bit.is_set(self.epos_zsw1));
        self.act_mode = found.map_or(0, |(_, mode)| *mode as u16);
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the low word is meant")]
const fn low(value: u32) -> u16 {
    value as u16
}

const fn split(value: u32) -> [u16; 2] {
    [low(value >> 16), low(value)]
}

/// A drive and the master in front of it.
pub(crate) struct Line {
    pub(crate) drive: ProfidriveDevice<TelegramOnly<Fixed<'static>>>,
    pub(crate) telegram: &'static Telegram,
    now: Instant,
    toggle: bool,
    inputs: Vec<u8>,
}

impl Line {
    /// In Data_Exchange with a drive of telegram 1 or 111.
    pub(crate) fn with(telegram: u16) -> Self {
        let configuration: &'static [u8] = match telegram {
            111 => &[0xC3, 0xCB, 0xCB, 0xFD, 0x00, 0x6F],
            _ => &[0xC3, 0xC1, 0xC1, 0xFD, 0x00, 0x01],
        };
        let telegram = Telegram::numbered(telegram).expect("one that the drive has");
        let application = Fixed { configurations: vec![configuration].leak(), ..Fixed::PLAIN };
        let description =
            Description { ident: IDENT_NUMBER, dpv1_status: Some([0xFB, 0xFF, 0xFF]), ..Description::PLAIN };
        let drive = ProfidriveDevice::new(
            Address::station(8).expect("a number of a station"),
            BaudRate::K500,
            (description, TelegramOnly { inner: application, only: None }),
            (Offer { ms1: Some(240), ..Offer::NONE }, Identification::PLAIN),
            Family::new(&[]).expect("no parameters of a file"),
            Instant::ZERO,
        );
        let mut line = Self { drive, telegram, now: Instant::ZERO, toggle: false, inputs: Vec::new() };
        let [high, low] = IDENT_NUMBER.to_be_bytes();
        line.ask(Some(61), &[0x88, 10, 10, 11, high, low, 0, 0x80, 0, 0]);
        line.ask(Some(62), configuration);
        line
    }

    /// The data of what comes back; a short acknowledgement has none.
    fn ask(&mut self, sap: Option<u8>, data: &[u8]) -> Vec<u8> {
        self.toggle = !self.toggle;
        let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
        let count = if self.toggle { FrameCount::Even } else { FrameCount::Odd };
        let request = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, data),
            da: self.drive.address(),
            sa: Address::from_octet(2),
            dsap,
            ssap,
            fc: FunctionCode::request(Service::SrdHigh, count),
            data,
        };
        let mut buf = [0; 255];
        let octets = request.encode(&mut buf).expect("it fits");
        let Decoded::Telegram { telegram, .. } = decode(octets) else { return Vec::new() };
        self.now = Instant::from_nanos(self.now.as_nanos() + 1_950_000);
        self.drive.handle_telegram(self.now, &telegram, &mut |_| {});
        self.now = Instant::from_nanos(self.now.as_nanos() + 50_000);
        let mut reply = [0; MAX_TELEGRAM_LEN];
        let len = self.drive.poll_transmit(self.now, &mut reply, &mut |_| {});
        match len.and_then(|len| reply.get(..len)).map(decode) {
            Some(Decoded::Telegram { telegram: Frame::Data(reply), .. }) => reply.data.to_vec(),
            _short_acknowledgement => Vec::new(),
        }
    }

    /// The axis passes measuring probe 1.
    pub(crate) fn close_probe(&mut self) {
        self.drive.set_input(self.now, "probe_1", Level::Switch(true));
    }

    /// Calls a block every 2 ms for so long.
    pub(crate) fn run(&mut self, millis: u32, mut call: impl FnMut(&Telegram, &[u8]) -> Vec<u16>) {
        for _ in 0..millis / 2 {
            let words = call(self.telegram, &self.inputs);
            let outputs: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
            self.inputs = self.ask(None, &outputs);
        }
    }
}

fn main() {
    let (mut line, mut speed) = (Line::with(1), SpeedBlock::NEW);
    line.run(20, |telegram, inputs| speed.call(telegram, inputs));
    (speed.enable_axis, speed.speed_sp) = (true, 750.0);
    for _ in 0..3 {
        line.run(200, |telegram, inputs| speed.call(telegram, inputs));
        println!("telegram 1: enabled {}, {:.0} rpm", speed.axis_enabled, speed.act_velocity);
    }
    let (mut line, mut axis) = (Line::with(111), PositionBlock::NEW);
    line.run(20, |telegram, inputs| axis.call(telegram, inputs));
    (axis.enable_axis, axis.mode_pos) = (true, ModePos::SetReference as u16);
    for (mode, position) in
        [(ModePos::SetReference, 0), (ModePos::Absolute, 25_000), (ModePos::Relative, -5_000)]
    {
        (axis.mode_pos, axis.position, axis.execute_mode) = (mode as u16, position, false);
        line.run(20, |telegram, inputs| axis.call(telegram, inputs));
        axis.execute_mode = true;
        line.run(1500, |telegram, inputs| axis.call(telegram, inputs));
        println!("telegram 111: {mode:?}, {} LU, reached {}", axis.act_position, axis.axis_pos_ok);
    }
}
