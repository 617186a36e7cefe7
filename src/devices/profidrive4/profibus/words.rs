//! The words of the telegrams: how they become a [`Command`] and come from a [`Status`].
//!
//! A word that is all the drive has to say of a warning or fault is its number.

use super::bits::{
    BLOCK, BlockBit, EncoderStwBit, EncoderZswBit, MdiModeBit, MeldwBit, NamurBit, PosStw1Bit, PosStw2Bit,
    PosStwBit, PosZsw1Bit, PosZsw2Bit, PosZswBit, PositionStwBit, PositionZswBit, Zsw1MakerBit, Zsw2Bit,
    has_message_word,
};
use super::signal::Signal;
use super::telegram::Telegram;
use crate::devices::ppo_drive::{State, profile};
use crate::devices::profidrive4::{
    AxisStatus, Command, Drive, EncoderCommand, EncoderStatus, Fault, Mdi, Origin, Setpoint, Setting,
    Settings, Status, Task,
};
use crate::profibus::ppo::Stw;

/// 4000h, 100 %.
const FULL_WORD: f64 = 16384.0;
/// 40000000h, 100 %.
const FULL_DOUBLE: f64 = 1_073_741_824.0;
/// KPC counts 1/1000 1/s.
const KPC: f64 = 0.001;
/// Steps of XERR in a revolution, those of XIST1.
const XERR_STEPS: f64 = 4_194_304.0;

/// Bits of the sign of life.
const LIFE: u32 = 12;

/// The sign of life in a word.
pub(super) const fn life(word: u16) -> u8 {
    (word >> LIFE) as u8
}

/// A word with this sign of life.
const fn with_life(word: u16, life: u8) -> u16 {
    word | (life as u16) << LIFE
}

/// What a number of 16 bits is of 100 %.
pub(super) fn part(word: u16) -> f64 {
    f64::from(word.cast_signed()) / FULL_WORD
}

/// 16 bits of a part of 100 %; too much is the most.
#[expect(clippy::cast_possible_truncation, reason = "float to integer saturates")]
fn word(part: f64) -> u32 {
    u32::from((libm::round(part * FULL_WORD) as i16).cast_unsigned())
}

/// 32 bits of a part of 100 %.
#[expect(clippy::cast_possible_truncation, reason = "float to integer saturates")]
fn double(part: f64) -> u32 {
    (libm::round(part * FULL_DOUBLE) as i32).cast_unsigned()
}

/// 32 bits of a whole number with sign.
#[expect(clippy::cast_possible_truncation, reason = "float to integer saturates")]
fn whole(number: f64) -> u32 {
    (libm::round(number) as i32).cast_unsigned()
}

/// The low word.
#[expect(clippy::cast_possible_truncation, reason = "a signal of one word")]
const fn low(value: u32) -> u16 {
    value as u16
}

/// What the process data command; `None`: bit 10 of STW1 is 0, and what was commanded before holds.
pub(super) fn command(telegram: &Telegram, outputs: &[u8], settings: &Settings) -> Option<Command> {
    let signal = |signal| telegram.setpoint(outputs, signal);
    let stw1 = Stw::from_raw(low(signal(Signal::Stw1)?));
    let control = profile::command(stw1, 0)?;
    let whole = |value: u32| f64::from(value.cast_signed());
    let speed = match (signal(Signal::NsollA), signal(Signal::NsollB)) {
        (Some(speed), _) => part(low(speed)),
        (None, Some(speed)) => whole(speed) / FULL_DOUBLE,
        (None, None) => 0.0,
    };
    // The position controller of the master runs in the drive.
    let more = match (signal(Signal::Xerr), signal(Signal::Kpc)) {
        (Some(deviation), Some(gain)) => {
            let revolutions = whole(deviation) / XERR_STEPS;
            let rpm = 60.0 * whole(gain) * KPC * revolutions;
            rpm / settings.of(Setting::ReferenceSpeed)
        }
        _ => 0.0,
    };
    let setpoint = match telegram.positions() {
        true => Setpoint::Position(task(telegram, outputs)),
        false => Setpoint::Speed(speed + more),
    };
    let torque_reduction = signal(Signal::Momred).map_or(0.0, |reduction| part(low(reduction)));
    Some(Command { control, setpoint, torque_reduction })
}

/// What a positioning drive shall do.
fn task(telegram: &Telegram, outputs: &[u8]) -> Task {
    let signal = |signal| telegram.setpoint(outputs, signal);
    let word_of = |wanted| signal(wanted).map_or(0, low);
    let stw1 = word_of(Signal::Stw1);
    let (choice, mode, stw) = (word_of(Signal::Satzanw), word_of(Signal::MdiMod), word_of(Signal::PosStw));
    let (of_111, stw2) = (word_of(Signal::PosStw1), word_of(Signal::PosStw2));
    let either = |one: bool, other: bool| one || other;
    let part_of = |wanted| signal(wanted).map_or(1.0, |value| part(low(value)).max(0.0));
    let mdi = either(BlockBit::Mdi.is_set(choice), PosStw1Bit::Mdi.is_set(of_111)).then(|| Mdi {
        absolute: either(MdiModeBit::Absolute.is_set(mode), PosStw1Bit::Absolute.is_set(of_111)),
        forward: either(MdiModeBit::Forward.is_set(mode), PosStw1Bit::Forward.is_set(of_111)),
        backward: either(MdiModeBit::Backward.is_set(mode), PosStw1Bit::Backward.is_set(of_111)),
        set_up: PosStw1Bit::SetUp.is_set(of_111),
        continuous: PosStw1Bit::Continuous.is_set(of_111),
        target: signal(Signal::MdiTarpos).map_or(0, u32::cast_signed),
        velocity: signal(Signal::MdiVelocity).map_or(0.0, f64::from),
        acceleration: part_of(Signal::MdiAcc),
        deceleration: part_of(Signal::MdiDec),
    });
    Task {
        home: PositionStwBit::Home.is_set(stw1),
        change_block: PositionStwBit::ChangeBlock.is_set(stw1),
        set_reference: either(PosStwBit::SetReference.is_set(stw), PosStw2Bit::SetReference.is_set(stw2)),
        cam: either(PosStwBit::Cam.is_set(stw), PosStw2Bit::Cam.is_set(stw2)),
        track: either(PosStwBit::Track.is_set(stw), PosStw2Bit::Track.is_set(stw2)),
        incremental: either(PosStwBit::Incremental.is_set(stw), PosStw2Bit::Incremental.is_set(stw2)),
        software_limits: PosStw2Bit::SoftwareLimits.is_set(stw2),
        limit_switches: PosStw2Bit::LimitSwitches.is_set(stw2),
        home_backward: PosStw2Bit::HomeBackward.is_set(stw2),
        fly: PosStw2Bit::Flying.is_set(stw2),
        second_probe: PosStw2Bit::SecondProbe.is_set(stw2),
        falling_edge: PosStw2Bit::FallingEdge.is_set(stw2),
        block: u8::try_from((choice | of_111) & BLOCK).unwrap_or_default(),
        mdi,
        velocity_part: part_of(Signal::Override),
    }
}

/// What a control word asks of an encoder.
pub(super) fn encoder_command(word: u16) -> EncoderCommand {
    let functions = [
        EncoderStwBit::Function1,
        EncoderStwBit::Function2,
        EncoderStwBit::Function3,
        EncoderStwBit::Function4,
    ];
    let actions = [EncoderStwBit::Action0, EncoderStwBit::Action1, EncoderStwBit::Action2];
    let number = |bits: &[EncoderStwBit]| {
        bits.iter().enumerate().fold(0, |all, (at, bit)| all | u8::from(bit.is_set(word)) << at)
    };
    EncoderCommand {
        functions: number(&functions),
        action: number(&actions),
        on_the_fly: EncoderStwBit::OnTheFly.is_set(word),
        absolute: EncoderStwBit::Absolute.is_set(word),
        park: EncoderStwBit::Park.is_set(word),
        acknowledge: EncoderStwBit::Acknowledge.is_set(word),
    }
}

fn encoder_zsw(status: EncoderStatus) -> u16 {
    EncoderZswBit::Running1.when(status.running != 0)
        | EncoderZswBit::Ready1.when(status.ready != 0)
        | EncoderZswBit::Acknowledging.when(status.acknowledging)
        | EncoderZswBit::Absolute.when(status.absolute)
        | EncoderZswBit::Parked.when(status.parked)
        | EncoderZswBit::Error.when(status.error)
}

/// ZSW1 in a telegram; none is a standard one.
pub(super) fn zsw1(telegram: Option<&Telegram>, drive: &Drive) -> u16 {
    let status = &drive.status();
    if telegram.is_some_and(Telegram::positions) {
        return position_zsw1(status, drive);
    }
    let bits = zsw1_of_profile(status);
    if telegram.is_some_and(has_message_word) {
        return bits;
    }
    bits | Zsw1MakerBit::BelowLimit.when(!status.at_limit)
        | Zsw1MakerBit::MotorCool.mask()
        | Zsw1MakerBit::Forward.when(status.speed > -0.5)
        | Zsw1MakerBit::NoOverload.mask()
}

/// The bits of ZSW1 that version 2 has.
fn zsw1_of_profile(status: &Status) -> u16 {
    let Status { no_off2, no_off3, warning, in_tolerance, speed_reached, .. } = *status;
    let of_profile = crate::devices::ppo_drive::Status {
        state: status.state,
        no_off2,
        no_off3,
        warning,
        in_tolerance,
        speed_reached,
        actual: 0,
    };
    profile::zsw(&of_profile).raw() | profile::ZswBit::Fault.when(status.fault)
}

/// ZSW1 of a positioning drive.
fn position_zsw1(status: &Status, drive: &Drive) -> u16 {
    let axis = drive.axis();
    let other = PositionZswBit::ALL.iter().fold(0, |word, bit| word | bit.mask());
    zsw1_of_profile(status) & !other
        | PositionZswBit::Follows.when(axis.follows)
        | PositionZswBit::TargetReached.when(axis.target_reached)
        | PositionZswBit::Referenced.when(axis.referenced)
        | PositionZswBit::Accepted.when(axis.accepted)
        | PositionZswBit::Stands.when(is_below_threshold_3(drive))
        | PositionZswBit::Accelerates.when(axis.accelerates)
        | PositionZswBit::Decelerates.when(axis.decelerates)
}

/// The speed is that of a shaft at rest.
fn is_below_threshold_3(drive: &Drive) -> bool {
    drive.status().speed.abs() < drive.settings().of(Setting::SpeedThreshold3)
}

/// The number of the block that runs.
fn running_block(axis: &AxisStatus) -> u16 {
    if let Some(Origin::Block(number)) = axis.by { u16::from(number) & BLOCK } else { 0 }
}

fn aktsatz(axis: &AxisStatus) -> u16 {
    running_block(axis) | BlockBit::Mdi.when(axis.by == Some(Origin::Mdi))
}

fn pos_zsw(axis: &AxisStatus) -> u16 {
    let (minus, plus) = axis.at_software_limits;
    PosZswBit::Tracks.when(axis.tracks)
        | PosZswBit::VelocityLimited.when(axis.velocity_limited)
        | PosZswBit::SetpointStands.when(axis.setpoint_stands)
        | PosZswBit::AtTarget.when(axis.target_reached)
        | PosZswBit::Forward.when(axis.direction > 0)
        | PosZswBit::Backward.when(axis.direction < 0)
        | PosZswBit::LimitMinus.when(minus)
        | PosZswBit::LimitPlus.when(plus)
}

fn pos_zsw1(axis: &AxisStatus) -> u16 {
    let (minus, plus) = axis.limit_switches;
    let mdi = axis.by == Some(Origin::Mdi);
    running_block(axis)
        | PosZsw1Bit::SwitchMinus.when(minus)
        | PosZsw1Bit::SwitchPlus.when(plus)
        | PosZsw1Bit::Jog.when(axis.by == Some(Origin::Jog))
        | PosZsw1Bit::Homing.when(axis.homing)
        | PosZsw1Bit::Flying.when(axis.flying)
        | PosZsw1Bit::Blocks.when(matches!(axis.by, Some(Origin::Block(_))))
        | PosZsw1Bit::SetUp.when(mdi && axis.endless)
        | PosZsw1Bit::Mdi.when(mdi && !axis.endless)
}

fn pos_zsw2(drive: &Drive) -> u16 {
    let axis = drive.axis();
    let (minus, plus) = axis.at_software_limits;
    let output = |bit: u8| axis.outputs >> bit & 1 != 0;
    let is_up_to = |cam| axis.position <= drive.settings().of(cam);
    PosZsw2Bit::Tracks.when(axis.tracks)
        | PosZsw2Bit::VelocityLimited.when(axis.velocity_limited)
        | PosZsw2Bit::SetpointStands.when(axis.setpoint_stands)
        | PosZsw2Bit::MarkOutside.when(axis.mark_outside)
        | PosZsw2Bit::Forward.when(axis.direction > 0)
        | PosZsw2Bit::Backward.when(axis.direction < 0)
        | PosZsw2Bit::LimitMinus.when(minus)
        | PosZsw2Bit::LimitPlus.when(plus)
        | PosZsw2Bit::Cam1.when(is_up_to(Setting::CamPosition1))
        | PosZsw2Bit::Cam2.when(is_up_to(Setting::CamPosition2))
        | PosZsw2Bit::Output1.when(output(0))
        | PosZsw2Bit::Output2.when(output(1))
        | PosZsw2Bit::Travels.when(axis.by.is_some() || axis.homing)
}

fn meldw(status: &Status, drive: &Drive) -> u16 {
    let speed = status.speed.abs();
    let is_supplied = status.state.is_supplied();
    let is_ready = !status.fault && status.state != State::SwitchingOnInhibited;
    MeldwBit::RampDone.when(status.ramp_done)
        | MeldwBit::BelowTorqueLimit.when(!status.at_limit)
        | MeldwBit::BelowThreshold3.when(is_below_threshold_3(drive))
        | MeldwBit::BelowThreshold2.when(speed <= drive.settings().of(Setting::SpeedThreshold2))
        | MeldwBit::NoOvertemperature.mask()
        | MeldwBit::NoOverload.mask()
        | MeldwBit::InTolerance.when(status.in_tolerance)
        | MeldwBit::Enabled.when(is_supplied)
        | MeldwBit::Ready.when(is_ready)
        | MeldwBit::Pulses.when(is_supplied)
}

fn namur(drive: &Drive) -> u16 {
    let bit = |number| match Fault::numbered(number) {
        Fault::MainCircuit => NamurBit::Mains,
        Fault::Overload => NamurBit::Overload,
        Fault::Communication | Fault::SignOfLife => NamurBit::Bus,
        Fault::Blocked
        | Fault::FollowingError
        | Fault::LimitSwitch
        | Fault::Homing
        | Fault::Block
        | Fault::Raised(_) => NamurBit::Other,
    };
    let faults = drive.standing_faults().map(|fault| bit(fault.number).mask());
    faults.fold(0, |word, mask| word | mask)
}

/// The value of a signal to the master. `life` is the sign of life of the drive.
pub(super) fn actual(telegram: &Telegram, drive: &Drive, life: u8, signal: Signal) -> u32 {
    let (status, settings) = (drive.status(), drive.settings());
    let speed = status.speed / settings.of(Setting::ReferenceSpeed);
    let encoder = drive.encoder();
    match signal {
        Signal::Zsw1 => zsw1(Some(telegram), drive).into(),
        Signal::XistA => whole(drive.axis().position),
        Signal::Aktsatz => aktsatz(&drive.axis()).into(),
        Signal::PosZsw => pos_zsw(&drive.axis()).into(),
        Signal::PosZsw1 => pos_zsw1(&drive.axis()).into(),
        Signal::PosZsw2 => pos_zsw2(drive).into(),
        Signal::NistA | Signal::NistAGlatt => word(speed),
        Signal::NistB => double(speed),
        Signal::Zsw2 => with_life(Zsw2Bit::Pulses.when(status.state.is_supplied()), life).into(),
        // Both encoders are on the one shaft.
        Signal::G1Zsw | Signal::G2Zsw => encoder_zsw(encoder).into(),
        Signal::G1Xist1 | Signal::G2Xist1 => encoder.xist1,
        Signal::G1Xist2 | Signal::G2Xist2 => encoder.xist2,
        Signal::IaistGlatt => word(status.current / settings.of(Setting::ReferenceCurrent)),
        Signal::MistGlatt => word(status.torque / settings.of(Setting::ReferenceTorque)),
        Signal::PistGlatt => word(status.power / settings.of(Setting::ReferencePower)),
        Signal::MeldNamur => namur(drive).into(),
        Signal::Meldw => meldw(&status, drive).into(),
        Signal::FaultCode => drive.standing_faults().next().map_or(0, |fault| fault.number.into()),
        Signal::WarnCode => drive.warnings().standing().first().copied().unwrap_or_default().into(),
        // Setpoints.
        Signal::Free
        | Signal::Stw1
        | Signal::Stw2
        | Signal::NsollA
        | Signal::NsollB
        | Signal::G1Stw
        | Signal::G2Stw
        | Signal::Xerr
        | Signal::Kpc
        | Signal::Satzanw
        | Signal::MdiTarpos
        | Signal::MdiVelocity
        | Signal::MdiAcc
        | Signal::MdiDec
        | Signal::MdiMod
        | Signal::PosStw
        | Signal::Override
        | Signal::PosStw1
        | Signal::PosStw2
        | Signal::Momred => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Instant;

    #[test]
    fn the_words_of_a_drive_that_waits_and_one_that_runs() {
        let mut drive = Drive::new(Instant::ZERO);
        let telegram = Telegram::numbered(1).unwrap();
        let mut step = |outputs: &[u8], millis: u64| {
            let command = command(telegram, outputs, drive.settings());
            for at in 0..millis {
                drive.step(Instant::from_millis(at), command.as_ref());
            }
            telegram.inputs(crate::profibus::ppo::Pkw::ZERO, |signal| actual(telegram, &drive, 0, signal))
        };
        assert_eq!(step(&[0x04, 0x7E, 0, 0], 1), [0xEB, 0x31, 0, 0]);
        assert_eq!(step(&[0x04, 0x7F, 0, 0], 1), [0xEB, 0x33, 0, 0]);
        assert_eq!(step(&[0x04, 0x7F, 0x40, 0], 1200), [0xEF, 0x37, 0x40, 0]);
        assert_eq!(step(&[0x04, 0x7D, 0x40, 0], 1)[..2], [0xEF, 0x60]);
    }

    #[test]
    fn setpoints_count_from_their_full_value() {
        let settings = Settings::default();
        let of = |number, outputs: &[u8]| {
            let command = command(Telegram::numbered(number).unwrap(), outputs, &settings)?;
            let Setpoint::Speed(speed) = command.setpoint else { panic!("telegram {number}") };
            Some((speed, command.torque_reduction))
        };
        assert_eq!(of(1, &[0x04, 0x7F, 0xC0, 0x00]), Some((-1.0, 0.0)));
        assert_eq!(of(1, &[0x00, 0x7F, 0x40, 0x00]), None, "bit 10 is 0");
        let tele102 = [0x04, 0x7F, 0x20, 0, 0, 0, 0, 0, 0x10, 0, 0, 0];
        assert_eq!(of(102, &tele102), Some((0.5, 0.25)));
        // A deviation of a revolution at 10 1/s is 600 rpm.
        let tele5 = [0x04, 0x7F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40, 0, 0, 0, 0, 0x27, 0x10];
        let (speed, _) = of(5, &tele5).unwrap();
        assert!((speed * 3000.0 - 600.0).abs() < 1e-6, "{speed}");
    }

    #[test]
    fn the_sign_of_life_is_in_the_highest_four_bits() {
        assert_eq!((life(0xA01F), with_life(0x0400, 0xF)), (0xA, 0xF400));
    }

    #[test]
    fn limit_switches_are_told_once_they_hold() {
        let mut drive = Drive::new(Instant::ZERO);
        drive.inputs_mut().pressed.positive_limit = true;
        assert_eq!(pos_zsw1(&drive.axis()), 0);
        let mut outputs = [0; 24];
        (outputs[0], outputs[4]) = (0x04, 0x80);
        let command = command(Telegram::numbered(111).unwrap(), &outputs, drive.settings());
        drive.step(Instant::ZERO, command.as_ref());
        assert_eq!(pos_zsw1(&drive.axis()), PosZsw1Bit::SwitchPlus.mask());
    }
}
