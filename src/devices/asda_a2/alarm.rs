//! Alarms with their numbers, error codes and texts (guide, chapter 5).

use core::fmt;

/// What an alarm does to the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Effect {
    /// The servo goes off, after the reaction of 605Eh.
    Fault,
    /// The servo stays on; the alarm ends with its cause.
    Warning,
}

/// How an alarm is cleared once its cause is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Clearing {
    /// By a fault reset or a reset of the node.
    Reset,
    /// By P2-08 = 10, or 30 and then 28.
    SpecialWrite,
}

/// Declares every alarm once: name, number on the panel, error code, effect, text.
macro_rules! alarms {
    ($($name:ident = $number:literal, $code:literal, $effect:ident, $text:literal;)*) => {
        /// An alarm of the drive.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Alarm {
            $(#[doc = $text] $name,)*
        }

        impl Alarm {
            /// Every alarm by ascending number.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// The number on the panel, its digits as hexadecimal digits: AL011 is 0011h.
            pub const fn number(self) -> u16 {
                match self { $(Self::$name => $number,)* }
            }

            /// The error code of 603Fh and EMCY.
            pub const fn code(self) -> u16 {
                match self { $(Self::$name => $code,)* }
            }

            /// What it does.
            pub const fn effect(self) -> Effect {
                match self { $(Self::$name => Effect::$effect,)* }
            }

            /// What it means.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }
        }
    };
}

alarms! {
    Overcurrent = 0x001, 0x2310, Fault, "overcurrent";
    Overvoltage = 0x002, 0x3110, Fault, "overvoltage";
    Undervoltage = 0x003, 0x3120, Fault, "undervoltage";
    Motor = 0x004, 0x7122, Fault, "motor error";
    Regeneration = 0x005, 0x3210, Fault, "regeneration error";
    Overload = 0x006, 0x3230, Fault, "overload";
    Overspeed = 0x007, 0x8400, Fault, "overspeed";
    PulseCommand = 0x008, 0x8600, Fault, "abnormal pulse command";
    Deviation = 0x009, 0x8611, Fault, "excessive deviation of the position";
    Encoder = 0x011, 0x7305, Fault, "encoder error";
    Adjustment = 0x012, 0x6320, Fault, "adjustment error";
    EmergencyStop = 0x013, 0x5441, Fault, "emergency stop";
    ReverseLimit = 0x014, 0x5443, Warning, "reverse limit switch";
    ForwardLimit = 0x015, 0x5442, Warning, "forward limit switch";
    Temperature = 0x016, 0x4210, Fault, "temperature of the IGBT";
    Memory = 0x017, 0x5330, Fault, "memory error";
    EncoderOutput = 0x018, 0x7306, Fault, "encoder output error";
    Serial = 0x019, 0x7510, Fault, "serial communication error";
    SerialTimeout = 0x020, 0x7520, Warning, "serial communication time-out";
    PhaseLoss = 0x022, 0x3130, Warning, "input phase loss";
    OverloadWarning = 0x023, 0x3231, Warning, "overload comes near";
    EncoderField = 0x024, 0x7305, Fault, "encoder initial magnetic field";
    EncoderInternal = 0x025, 0x7305, Fault, "encoder internal error";
    EncoderInternal2 = 0x026, 0x7305, Fault, "encoder internal error";
    EncoderData = 0x027, 0x7305, Fault, "encoder data error";
    MotorProtection = 0x030, 0x7121, Fault, "motor protection";
    Wiring = 0x031, 0x3300, Fault, "wiring of U, V, W";
    FullClosedLoop = 0x040, 0x8610, Fault, "full-closed loop deviation";
    FirmwareUpgrade = 0x099, 0x5500, Fault, "DSP firmware upgrade";
    SdoOverrun = 0x111, 0x8110, Fault, "SDO receive overrun";
    PdoOverrun = 0x112, 0x8110, Fault, "PDO receive overrun";
    PdoIndex = 0x121, 0x8200, Fault, "PDO: index";
    PdoSubIndex = 0x122, 0x8200, Fault, "PDO: sub-index";
    PdoLength = 0x123, 0x8200, Fault, "PDO: length of data";
    PdoRange = 0x124, 0x8200, Fault, "PDO: range of data";
    PdoReadOnly = 0x125, 0x8200, Fault, "PDO: object is read-only";
    PdoNotMappable = 0x126, 0x8200, Fault, "PDO: object cannot be mapped";
    PdoServoOn = 0x127, 0x8200, Fault, "PDO: object is write-protected while the servo is on";
    EepromRead = 0x128, 0x8200, Fault, "EEPROM: read error";
    EepromWrite = 0x129, 0x8200, Fault, "EEPROM: write error";
    EepromAddress = 0x130, 0x8200, Fault, "EEPROM: address range";
    EepromChecksum = 0x131, 0x8200, Fault, "EEPROM: checksum";
    EepromZone = 0x132, 0x8200, Fault, "EEPROM: zone or password";
    GuardingServoOn = 0x170, 0x8130, Fault, "node guarding or heartbeat failed, servo on";
    GuardingServoOff = 0x180, 0x8130, Fault, "node guarding or heartbeat failed, servo off";
    CanErrors = 0x185, 0x8120, Warning, "many errors on the CAN bus";
    BusOff = 0x186, 0x8100, Fault, "CAN bus off";
    CanopenData = 0x201, 0x6310, Fault, "initialisation of CANopen data";
    ForwardSoftLimit = 0x283, 0x5444, Warning, "forward software limit";
    ReverseSoftLimit = 0x285, 0x5445, Warning, "reverse software limit";
    SyncFailed = 0x301, 0x6200, Fault, "SYNC failed, servo on";
    SyncEarly = 0x302, 0x6200, Fault, "SYNC too early, servo on";
    SyncTimeout = 0x303, 0x6200, Fault, "SYNC time-out, servo on";
    IpCommand = 0x304, 0x6200, Fault, "interpolation command failed, servo on";
    SyncPeriod = 0x305, 0x6200, Fault, "SYNC period not valid, servo on";
    SyncFailedOff = 0x3E1, 0x6200, Fault, "SYNC failed, servo off";
    SyncEarlyOff = 0x3E2, 0x6200, Fault, "SYNC too early, servo off";
    SyncTimeoutOff = 0x3E3, 0x6200, Fault, "SYNC time-out, servo off";
    IpCommandOff = 0x3E4, 0x6200, Fault, "interpolation command failed, servo off";
    SyncPeriodOff = 0x3E5, 0x6200, Fault, "SYNC period not valid, servo off";
    NmtWhileOn = 0x401, 0x8100, Fault, "NMT reset or stop while the servo is on";
}

impl Alarm {
    /// The alarm with that number, digits as hexadecimal digits.
    pub(crate) fn of(number: u16) -> Option<Self> {
        Self::ALL.iter().copied().find(|alarm| alarm.number() == number)
    }

    /// The alarm as the panel writes it, with or without `AL`: `"011"`, `"3E1"`.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let digits = text.strip_prefix("AL").unwrap_or(text);
        if digits.len() != 3 || !digits.bytes().all(|octet| octet.is_ascii_hexdigit()) {
            return None;
        }
        Self::of(u16::from_str_radix(digits, 16).ok()?)
    }

    /// Whether it is an error of the bus, whose effect P3-10.Y chooses.
    pub(crate) const fn is_of_bus(self) -> bool {
        matches!(self, Self::GuardingServoOn | Self::GuardingServoOff | Self::CanErrors | Self::BusOff)
    }

    /// How it is cleared.
    pub(crate) const fn clearing(self) -> Clearing {
        match self.number() {
            0x201 => Clearing::SpecialWrite,
            0.. => Clearing::Reset,
        }
    }

    /// Its bits of the error register (CN-214; CiA 301: 1 current, 2 voltage, 3 temperature, 4 communication,
    /// 5 profile, 7 manufacturer).
    pub const fn register(self) -> u8 {
        match self.code() {
            0x2000..=0x2FFF => 1 << 1,
            0x3000..=0x3FFF => 1 << 2,
            0x4000..=0x4FFF => 1 << 3,
            0x6200 | 0x8100..=0x82FF => 1 << 4,
            0x7000..=0x7FFF | 0x8400..=0x86FF => 1 << 5,
            0.. => 1 << 7,
        }
    }
}

/// An alarm with what it means: `AL009, excessive deviation of the position`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InWords(pub(crate) Alarm);

impl fmt::Display for InWords {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.0, self.0.text())
    }
}

impl fmt::Display for Alarm {
    /// As on the panel: `AL011`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "AL{:03X}", self.number())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_ascend_and_are_read_back_from_the_panel() {
        assert!(Alarm::ALL.windows(2).all(|pair| pair[0].number() < pair[1].number()));
        for &alarm in Alarm::ALL {
            let text = std::format!("{alarm}");
            assert_eq!(text.len(), 5);
            assert_eq!(Alarm::parse(&text), Some(alarm));
            assert_eq!(Alarm::parse(&text[2..]), Some(alarm));
        }
        for wrong in ["", "11", "0011", "010", "ABC", "+11", "ALAL1"] {
            assert_eq!(Alarm::parse(wrong), None, "{wrong}");
        }
    }
}
