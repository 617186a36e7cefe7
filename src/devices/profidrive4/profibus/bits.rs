//! The bits of the words of the telegrams, and what each is called.
//!
//! STW1 and ZSW1 bits 0 to 10 are those of version 2, [`profile`]; bits 11 to 15 and all other words are here.

use super::signal::Signal;
use super::telegram::Telegram;
use crate::devices::ppo_drive::profile;
use crate::face::bits_of_word;

bits_of_word! {
    /// A bit of ZSW1 that the profile leaves to the maker, in standard telegrams.
    Zsw1MakerBit {
        /// The torque is below its limit.
        BelowLimit = 11: "torque limit not reached";
        /// The motor is not too warm.
        MotorCool = 13: "no overtemperature of the motor";
        /// The shaft turns forward or stands.
        Forward = 14: "actual speed is 0 or more";
        /// The drive is not overloaded.
        NoOverload = 15: "no overload of the converter";
    }
}

bits_of_word! {
    /// A bit of STW1 of a positioning drive that is another one than of a speed drive.
    PositionStwBit {
        NoRejection = 4: "do not reject the task";
        NoStop = 5: "no intermediate stop";
        Begin = 6: "begin the task (edge)";
        Home = 11: "reference the axis";
        ChangeBlock = 13: "take the next block (edge)";
    }
}

bits_of_word! {
    /// A bit of ZSW1 of a positioning drive that is another one than of a speed drive.
    PositionZswBit {
        Follows = 8: "no following error";
        TargetReached = 10: "target reached";
        Referenced = 11: "the position has a reference";
        Accepted = 12: "task accepted";
        Stands = 13: "the shaft stands";
        Accelerates = 14: "the axis gets faster";
        Decelerates = 15: "the axis gets slower";
    }
}

bits_of_word! {
    /// A bit of SATZANW and AKTSATZ; bits 0 to 5 are the number of the block.
    BlockBit {
        Block0 = 0: "block, bit 0";
        Block1 = 1: "block, bit 1";
        Block2 = 2: "block, bit 2";
        Block3 = 3: "block, bit 3";
        Block4 = 4: "block, bit 4";
        Block5 = 5: "block, bit 5";
        Mdi = 15: "MDI";
    }
}

bits_of_word! {
    /// A bit of MDI_MOD.
    MdiModeBit {
        Absolute = 0: "absolute";
        Forward = 1: "forward";
        Backward = 2: "backward";
    }
}

bits_of_word! {
    /// A bit of POS_STW.
    PosStwBit {
        Track = 0: "follow the shaft";
        SetReference = 1: "set the reference (edge)";
        Cam = 2: "on the reference cam";
        Incremental = 5: "jog a way";
    }
}

bits_of_word! {
    /// A bit of POS_ZSW.
    PosZswBit {
        Tracks = 0: "follows the shaft";
        VelocityLimited = 1: "velocity limited";
        SetpointStands = 2: "the setpoint stands";
        AtTarget = 3: "setpoint reached";
        Forward = 4: "forward";
        Backward = 5: "backward";
        LimitMinus = 6: "software limit minus";
        LimitPlus = 7: "software limit plus";
    }
}

bits_of_word! {
    /// A bit of POS_STW1; bits 0 to 5 are the number of the block.
    PosStw1Bit {
        Block0 = 0: "block, bit 0";
        Block1 = 1: "block, bit 1";
        Block2 = 2: "block, bit 2";
        Block3 = 3: "block, bit 3";
        Block4 = 4: "block, bit 4";
        Block5 = 5: "block, bit 5";
        Absolute = 8: "absolute";
        Forward = 9: "forward";
        Backward = 10: "backward";
        Continuous = 12: "take changes over at once";
        SetUp = 14: "set up";
        Mdi = 15: "MDI";
    }
}

bits_of_word! {
    /// A bit of POS_STW2.
    PosStw2Bit {
        Track = 0: "follow the shaft";
        SetReference = 1: "set the reference (edge)";
        Cam = 2: "on the reference cam";
        Incremental = 5: "jog a way";
        Flying = 8: "flying referencing";
        HomeBackward = 9: "reference backward first";
        SecondProbe = 10: "flying referencing by probe 2";
        FallingEdge = 11: "flying referencing by the falling edge";
        SoftwareLimits = 14: "software limits on";
        LimitSwitches = 15: "limit switches on";
    }
}

bits_of_word! {
    /// A bit of POS_ZSW1; bits 0 to 5 are the number of the block that runs.
    PosZsw1Bit {
        Block0 = 0: "block, bit 0";
        Block1 = 1: "block, bit 1";
        Block2 = 2: "block, bit 2";
        Block3 = 3: "block, bit 3";
        Block4 = 4: "block, bit 4";
        Block5 = 5: "block, bit 5";
        SwitchMinus = 8: "limit switch minus";
        SwitchPlus = 9: "limit switch plus";
        Jog = 10: "jogging";
        Homing = 11: "referencing";
        Flying = 12: "flying referencing";
        Blocks = 13: "traversing blocks";
        SetUp = 14: "set up";
        Mdi = 15: "MDI";
    }
}

bits_of_word! {
    /// A bit of POS_ZSW2.
    PosZsw2Bit {
        Tracks = 0: "follows the shaft";
        VelocityLimited = 1: "velocity limited";
        SetpointStands = 2: "the setpoint stands";
        MarkOutside = 3: "the probe is outside of the outer window";
        Forward = 4: "forward";
        Backward = 5: "backward";
        LimitMinus = 6: "software limit minus";
        LimitPlus = 7: "software limit plus";
        Cam1 = 8: "up to cam position 1";
        Cam2 = 9: "up to cam position 2";
        Output1 = 10: "direct output 1";
        Output2 = 11: "direct output 2";
        Travels = 15: "a task runs";
    }
}

/// The bits of a word that number a block.
pub(super) const BLOCK: u16 = 0x3F;

bits_of_word! {
    /// A bit of STW2; bits 12 to 15 are the sign of life.
    Stw2Bit {
        Dds0 = 0: "drive data set, bit 0";
        Dds1 = 1: "drive data set, bit 1";
        Dds2 = 2: "drive data set, bit 2";
        Dds3 = 3: "drive data set, bit 3";
        Dds4 = 4: "drive data set, bit 4";
        Parking = 7: "parking axis";
        FixedStop = 8: "travel to fixed stop";
        Life0 = 12: "sign of life of the master, bit 0";
        Life1 = 13: "sign of life of the master, bit 1";
        Life2 = 14: "sign of life of the master, bit 2";
        Life3 = 15: "sign of life of the master, bit 3";
    }
}

bits_of_word! {
    /// A bit of ZSW2; bits 12 to 15 are the sign of life.
    Zsw2Bit {
        AlarmClass0 = 5: "class of the warning, bit 0";
        AlarmClass1 = 6: "class of the warning, bit 1";
        FixedStop = 8: "travel to fixed stop is active";
        Pulses = 10: "pulses enabled";
        Life0 = 12: "sign of life of the drive, bit 0";
        Life1 = 13: "sign of life of the drive, bit 1";
        Life2 = 14: "sign of life of the drive, bit 2";
        Life3 = 15: "sign of life of the drive, bit 3";
    }
}

bits_of_word! {
    /// A bit of G1_STW.
    EncoderStwBit {
        Function1 = 0: "function 1";
        Function2 = 1: "function 2";
        Function3 = 2: "function 3";
        Function4 = 3: "function 4";
        Action0 = 4: "action, bit 0";
        Action1 = 5: "action, bit 1";
        Action2 = 6: "action, bit 2";
        OnTheFly = 7: "measure on the fly";
        Absolute = 13: "absolute value in XIST2";
        Park = 14: "park the encoder";
        Acknowledge = 15: "acknowledge an error";
    }
}

bits_of_word! {
    /// A bit of G1_ZSW.
    EncoderZswBit {
        Running1 = 0: "function 1 runs";
        Ready1 = 4: "value 1 is there";
        Acknowledging = 11: "an error is being acknowledged";
        Absolute = 13: "absolute value in XIST2";
        Parked = 14: "the encoder is parked";
        Error = 15: "error, its number in XIST2";
    }
}

bits_of_word! {
    /// A bit of MELDW.
    MeldwBit {
        RampDone = 0: "ramp-up and ramp-down ended";
        BelowTorqueLimit = 1: "torque below its limit";
        BelowThreshold3 = 2: "speed below threshold 3 (the shaft stands)";
        BelowThreshold2 = 3: "speed up to threshold 2";
        NoOvertemperature = 6: "no overtemperature of the motor";
        NoOverload = 7: "no overload of the converter";
        InTolerance = 8: "setpoint and actual value within tolerance";
        Enabled = 11: "the controller is enabled";
        Ready = 12: "the drive is ready";
        Pulses = 13: "pulses enabled";
    }
}

bits_of_word! {
    /// A bit of MELD_NAMUR.
    NamurBit {
        Mains = 1: "fault of the mains";
        Overload = 6: "overload of the motor";
        Bus = 7: "fault of the bus";
        Other = 15: "another fault";
    }
}

/// What a bit of a signal is called; `None`: nothing, or the signal is a number.
pub(super) fn bit_name(telegram: &Telegram, signal: Signal, number: u8) -> Option<&'static str> {
    fn of<B: Copy>(all: &[B], number: u8, of: fn(B) -> (u8, &'static str)) -> Option<&'static str> {
        all.iter().map(|bit| of(*bit)).find(|(own, _)| *own == number).map(|(_, name)| name)
    }
    match signal {
        Signal::Stw1 if telegram.positions() => {
            let of_positions = of(PositionStwBit::ALL, number, |bit| (bit.number(), bit.name()));
            of_positions.or_else(|| of(profile::StwBit::ALL, number, |bit| (bit.number(), bit.name())))
        }
        Signal::Zsw1 if telegram.positions() => {
            let of_positions = of(PositionZswBit::ALL, number, |bit| (bit.number(), bit.name()));
            of_positions.or_else(|| of(profile::ZswBit::ALL, number, |bit| (bit.number(), bit.name())))
        }
        Signal::Satzanw | Signal::Aktsatz => of(BlockBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::MdiMod => of(MdiModeBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::PosStw => of(PosStwBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::PosZsw => of(PosZswBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::PosStw1 => of(PosStw1Bit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::PosZsw1 => of(PosZsw1Bit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::PosStw2 => of(PosStw2Bit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::PosZsw2 => of(PosZsw2Bit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::Stw1 => of(profile::StwBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::Zsw1 => of(profile::ZswBit::ALL, number, |bit| (bit.number(), bit.name())).or_else(|| {
            let maker = of(Zsw1MakerBit::ALL, number, |bit| (bit.number(), bit.name()));
            maker.filter(|_| !has_message_word(telegram))
        }),
        Signal::Stw2 => of(Stw2Bit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::Zsw2 => of(Zsw2Bit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::G1Stw | Signal::G2Stw => of(EncoderStwBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::G1Zsw | Signal::G2Zsw => of(EncoderZswBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::Meldw => of(MeldwBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::MeldNamur => of(NamurBit::ALL, number, |bit| (bit.number(), bit.name())),
        Signal::Free
        | Signal::NsollA
        | Signal::NistA
        | Signal::NsollB
        | Signal::NistB
        | Signal::G1Xist1
        | Signal::G1Xist2
        | Signal::G2Xist1
        | Signal::G2Xist2
        | Signal::Xerr
        | Signal::Kpc
        | Signal::IaistGlatt
        | Signal::MistGlatt
        | Signal::PistGlatt
        | Signal::NistAGlatt
        | Signal::XistA
        | Signal::MdiTarpos
        | Signal::MdiVelocity
        | Signal::MdiAcc
        | Signal::MdiDec
        | Signal::Override
        | Signal::Momred
        | Signal::FaultCode
        | Signal::WarnCode => None,
    }
}

/// In telegrams with MELDW the bits of the maker in ZSW1 are classes of warnings, of which this drive has none.
pub(super) fn has_message_word(telegram: &Telegram) -> bool {
    telegram.actual_values.contains(&Signal::Meldw)
}
