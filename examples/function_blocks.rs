//! Function blocks of a PLC in front of a drive of PROFIdrive 4 (docs/profidrive.md), in virtual time: one for telegram 1, a
//! speed, and one for telegram 111, a position. They have the inputs and outputs that the blocks SINA_SPEED and SINA_POS of PLC
//! libraries have by their public description, and each makes its process data as those do.
//!
//!     cargo run --example function_blocks

#![allow(dead_code, reason = "the example uses a part of the blocks, its test another")]

use profidrive::devices::ppo_drive::profile::{StwBit, ZswBit};
use profidrive::devices::profidrive4::profibus::bits::{
    PosStw1Bit, PosStw2Bit, PositionStwBit, PositionZswBit,
};
use profidrive::devices::profidrive4::profibus::{
    Family, IDENT_NUMBER, ProfidriveDevice, Signal, Telegram, TelegramOnly,
};
use profidrive::profibus::dp::{Description, Fixed};
use profidrive::profibus::dpv1::{Identification, Offer};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service, Telegram as Frame,
};
use profidrive::time::{BaudRate, Instant};

/// 4000h, 100 %.
const FULL: f64 = 16384.0;
/// 40000000h, 100 %.
const FULL_DOUBLE: f64 = 1_073_741_824.0;

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
    /// Bits 0 to 5: no OFF2, no OFF3, enable operation, ramp generator, ramp runs, setpoint.
    pub(crate) config_axis: u16,
    /// The axis is on and follows.
    pub(crate) axis_enabled: bool,
    /// Switching on is inhibited.
    pub(crate) lockout: bool,
    /// rpm.
    pub(crate) act_velocity: f64,
    /// The drive has a fault.
    pub(crate) error: bool,
}

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
    };

    /// One call: the newest actual values in, the setpoints out.
    #[expect(clippy::cast_possible_truncation, reason = "float to integer saturates")]
    pub(crate) fn call(&mut self, telegram: &Telegram, inputs: &[u8]) -> Vec<u16> {
        let actual = |signal| low(telegram.actual_value(inputs, signal).unwrap_or_default());
        let zsw1 = actual(Signal::Zsw1);
        self.axis_enabled = ZswBit::OperationEnabled.is_set(zsw1);
        self.lockout = ZswBit::SwitchingOnInhibited.is_set(zsw1);
        self.error = ZswBit::Fault.is_set(zsw1);
        self.act_velocity = f64::from(actual(Signal::NistA).cast_signed()) / FULL * self.ref_speed;
        let configured = [
            StwBit::NoOff2,
            StwBit::NoOff3,
            StwBit::EnableOperation,
            StwBit::EnableRamp,
            StwBit::RunRamp,
            StwBit::EnableSetpoint,
        ];
        let of_config =
            configured.iter().enumerate().map(|(at, bit)| bit.when(self.config_axis >> at & 1 == 1));
        let stw1 = of_config.fold(0, |word, bit| word | bit)
            | StwBit::On.when(self.enable_axis)
            | StwBit::Acknowledge.when(self.ack_error)
            | StwBit::ByPlc.mask();
        let setpoint = (self.speed_sp / self.ref_speed * FULL).round() as i16;
        vec![stw1, setpoint.cast_unsigned()]
    }
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

/// The block for telegram 111.
#[derive(Clone, Debug)]
pub(crate) struct PositionBlock {
    pub(crate) mode_pos: ModePos,
    pub(crate) enable_axis: bool,
    /// Not: the task is rejected.
    pub(crate) cancel_traversing: bool,
    /// Not: the axis stops and goes on later.
    pub(crate) intermediate_stop: bool,
    pub(crate) positive: bool,
    pub(crate) negative: bool,
    pub(crate) jog_1: bool,
    pub(crate) jog_2: bool,
    pub(crate) ack_error: bool,
    /// The edge begins the task.
    pub(crate) execute_mode: bool,
    /// LU, or the number of the traversing block.
    pub(crate) position: i32,
    /// 1000 LU/min.
    pub(crate) velocity: u32,
    /// Percent.
    pub(crate) over_v: u16,
    pub(crate) over_acc: u16,
    pub(crate) over_dec: u16,
    /// Bits 0 to 3: no OFF2, no OFF3, software limits, limit switches; 8: a change is taken over at once.
    pub(crate) config_epos: u32,
    pub(crate) axis_enabled: bool,
    pub(crate) axis_pos_ok: bool,
    pub(crate) axis_ref: bool,
    pub(crate) axis_warn: bool,
    pub(crate) axis_error: bool,
    pub(crate) lockout: bool,
    /// LU.
    pub(crate) act_position: i32,
    /// Parts of the reference speed.
    pub(crate) act_velocity: f64,
    pub(crate) act_fault: u16,
    pub(crate) act_warn: u16,
}

impl PositionBlock {
    pub(crate) const NEW: Self = Self {
        mode_pos: ModePos::Absolute,
        enable_axis: false,
        cancel_traversing: true,
        intermediate_stop: true,
        positive: false,
        negative: false,
        jog_1: false,
        jog_2: false,
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
        axis_ref: false,
        axis_warn: false,
        axis_error: false,
        lockout: true,
        act_position: 0,
        act_velocity: 0.0,
        act_fault: 0,
        act_warn: 0,
    };

    /// One call: the newest actual values in, the setpoints out.
    pub(crate) fn call(&mut self, telegram: &Telegram, inputs: &[u8]) -> Vec<u16> {
        self.look(telegram, inputs);
        let mode = self.mode_pos;
        let begins = matches!(mode, ModePos::Relative | ModePos::Absolute | ModePos::SetUp | ModePos::Block);
        let jogs = matches!(mode, ModePos::Jog | ModePos::JogIncremental);
        let mdi = matches!(mode, ModePos::Relative | ModePos::Absolute | ModePos::SetUp);
        let of_config = |bit: u32| self.config_epos >> bit & 1 == 1;
        let stw1 = StwBit::On.when(self.enable_axis)
            | StwBit::NoOff2.when(of_config(0))
            | StwBit::NoOff3.when(of_config(1))
            | StwBit::EnableOperation.mask()
            | PositionStwBit::NoRejection.when(self.cancel_traversing)
            | PositionStwBit::NoStop.when(self.intermediate_stop)
            | PositionStwBit::Begin.when(begins && self.execute_mode)
            | StwBit::Acknowledge.when(self.ack_error)
            | StwBit::Inching1.when(jogs && self.jog_1)
            | StwBit::Inching2.when(jogs && self.jog_2)
            | StwBit::ByPlc.mask()
            | PositionStwBit::Home.when(mode == ModePos::Home && self.execute_mode);
        let block = u16::try_from(self.position.clamp(0, 63)).unwrap_or_default();
        let pos_stw1 = PosStw1Bit::Mdi.when(mdi)
            | PosStw1Bit::Absolute.when(mode == ModePos::Absolute)
            | PosStw1Bit::SetUp.when(mode == ModePos::SetUp)
            | PosStw1Bit::Continuous.when(of_config(8))
            | PosStw1Bit::Forward.when(self.positive)
            | PosStw1Bit::Backward.when(self.negative)
            | if mode == ModePos::Block { block } else { 0 };
        let pos_stw2 = PosStw2Bit::SetReference.when(mode == ModePos::SetReference && self.execute_mode)
            | PosStw2Bit::Incremental.when(mode == ModePos::JogIncremental)
            | PosStw2Bit::HomeBackward.when(mode == ModePos::Home && self.negative)
            | PosStw2Bit::SoftwareLimits.when(of_config(2))
            | PosStw2Bit::LimitSwitches.when(of_config(3));
        let [target_high, target_low] = words(self.position.cast_unsigned());
        let [velocity_high, velocity_low] = words(self.velocity);
        let part = |percent: u16| low(u32::from(percent) * 0x4000 / 100);
        vec![
            stw1,
            pos_stw1,
            pos_stw2,
            0,
            part(self.over_v),
            target_high,
            target_low,
            velocity_high,
            velocity_low,
            part(self.over_acc),
            part(self.over_dec),
            0,
        ]
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
        self.act_position = actual(Signal::XistA).cast_signed();
        self.act_velocity = f64::from(actual(Signal::NistB).cast_signed()) / FULL_DOUBLE;
        self.act_fault = low(actual(Signal::FaultCode));
        self.act_warn = low(actual(Signal::WarnCode));
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the low word is meant")]
const fn low(value: u32) -> u16 {
    value as u16
}

const fn words(value: u32) -> [u16; 2] {
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
    (axis.enable_axis, axis.mode_pos) = (true, ModePos::SetReference);
    for (mode, position) in
        [(ModePos::SetReference, 0), (ModePos::Absolute, 25_000), (ModePos::Relative, -5_000)]
    {
        (axis.mode_pos, axis.position, axis.execute_mode) = (mode, position, false);
        line.run(20, |telegram, inputs| axis.call(telegram, inputs));
        axis.execute_mode = true;
        line.run(1500, |telegram, inputs| axis.call(telegram, inputs));
        println!("telegram 111: {mode:?}, {} LU, reached {}", axis.act_position, axis.axis_pos_ok);
    }
}
