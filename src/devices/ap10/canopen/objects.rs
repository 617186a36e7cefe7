//! The object dictionary of the AP10 (manual 5.7; rows `ap10` of the project's reference, in its order).

use crate::can_bus::canopen::Address;
use crate::can_bus::canopen::dictionary::{Entry, Home, Limits, Object};
use crate::can_bus::canopen::value::DataType::{I32, U8, U16, U32, VisibleString};
use crate::devices::ap10::{RESOLUTION, Rule, Setting};
use crate::face::ObjectEntry;

/// Transmission types of the two RPDOs.
const RPDO_TYPES: &[(i64, i64)] = &[(0x00, 0xF0), (0xFE, 0xFF)];
/// Of the asynchronous TPDO1.
const TPDO1_TYPES: &[(i64, i64)] = &[(0xFD, 0xFF)];
/// Of the synchronous TPDO2; 00h, FEh and FFh are not listed (CN-128).
const TPDO2_TYPES: &[(i64, i64)] = &[(0x01, 0xF0), (0xFC, 0xFC)];
/// 1017h.
const HEARTBEAT: &[(i64, i64)] = &[(0, 0), (10, 65_535)];

/// Total of measuring steps at the factory resolution (6002h, CN-122).
pub(super) const TOTAL_STEPS: u32 = 0x0A00_0007;
/// The range of 6002h (CN-131).
pub(super) const TOTAL_STEPS_RANGE: (i64, i64) = (0x001E_DC52, 0x7FFF_FFFF);

const UNSUPPORTED: i64 = 0xFFFF_FFFF;

const fn largest(sub: i64) -> Entry {
    Entry::ro(0, "Largest sub-index", U8).number(sub)
}

const fn setting(setting: Setting) -> Entry {
    let (Rule { default, ranges }, ObjectEntry { at: (_, sub), data, name }) =
        (setting.rule(), setting.object());
    Entry::rw(sub, name, data).number(default as i64).ranges(ranges).stored()
}

const fn cob_id(name: &'static str, base: u32) -> Entry {
    Entry::rw(1, name, U32).node_id(base).pre_operational().node().stored()
}

const fn kind(default: i64, types: &'static [(i64, i64)]) -> Entry {
    Entry::rw(2, "Transmission type", U8).number(default).ranges(types).node().stored()
}

const fn unused(sub: u8, name: &'static str) -> Entry {
    Entry::ro(sub, name, U16).number(0)
}

const fn mapping(words: [i64; 3]) -> [Entry; 4] {
    let [a, b, c] = words;
    [
        Entry::ro(0, "Mapped objects", U8).number(3).node(),
        Entry::ro(1, "Mapping 1", U32).number(a).node(),
        Entry::ro(2, "Mapping 2", U32).number(b).node(),
        Entry::ro(3, "Mapping 3", U32).number(c).node(),
    ]
}

const fn volatile(entry: Entry) -> Entry {
    Entry { stored: false, ..entry }
}

/// Bits of the alarms 6503h and of the warnings 6505h.
pub(super) struct Alarm;

impl Alarm {
    pub(super) const POSITION: u16 = 1 << 0;
    pub(super) const BATTERY_CRITICAL: u16 = 1 << 12;
    pub(super) const BATTERY_EMPTY: u16 = 1 << 13;
    const SUPPORTED: u16 = Self::POSITION | Self::BATTERY_CRITICAL | Self::BATTERY_EMPTY;
}

/// The only bit of the warnings 6505h.
pub(super) const BATTERY_WARNING: u16 = 1 << 4;

/// The dictionary, sorted by index.
pub const OBJECTS: &[Object] = &[
    Object::var(0x1000, &[Entry::ro(0, "Device type", U32).number(0x0005_0196)]),
    Object::var(0x1001, &[Entry::ro(0, "Error register", U8).number(0).node()]),
    Object::var(0x1002, &[Entry::ro(0, "Manufacturer status (CAN counters)", U32).number(0)]),
    Object::array(
        0x1003,
        "Error field",
        &[
            Entry::rw(0, "Number of errors", U8).number(0).range(0, 8).node().stored(),
            Entry::ro(1, "Error entry", U32).number(0).node().stored(),
            Entry::ro(2, "Error entry", U32).number(0).node().stored(),
            Entry::ro(3, "Error entry", U32).number(0).node().stored(),
            Entry::ro(4, "Error entry", U32).number(0).node().stored(),
            Entry::ro(5, "Error entry", U32).number(0).node().stored(),
            Entry::ro(6, "Error entry", U32).number(0).node().stored(),
            Entry::ro(7, "Error entry", U32).number(0).node().stored(),
            Entry::ro(8, "Error entry", U32).number(0).node().stored(),
        ],
    ),
    Object::var(0x1005, &[Entry::rw(0, "COB-ID SYNC", U32).number(0x80).pre_operational().node().stored()]),
    Object::var(0x1008, &[Entry::constant(0, "Manufacturer device name", VisibleString).text("AP10")]),
    Object::var(0x1009, &[Entry::constant(0, "Hardware version", VisibleString).text("V001")]),
    // 6507h says V301 and so do we; "V100" is printed here (CN-114).
    Object::var(0x100A, &[Entry::constant(0, "Software version", VisibleString).text("V301").live()]),
    Object::var(0x100C, &[Entry::rw(0, "Guard time ms", U16).number(0).node().stored()]),
    Object::var(0x100D, &[Entry::rw(0, "Life time factor", U8).number(0).node().stored()]),
    Object::array(
        0x1010,
        "Store parameters",
        &[
            largest(4),
            Entry::rw(1, "Save all", U32).number(1).node(),
            Entry::rw(2, "Save communication (1000h-1FFFh)", U32).number(1).node(),
            Entry::rw(3, "Save application (6000h-9FFFh)", U32).number(1).node(),
            Entry::rw(4, "Save manufacturer (2000h-5FFFh)", U32).number(1).node(),
        ],
    ),
    Object::array(
        0x1011,
        "Restore parameters",
        &[
            largest(4),
            Entry::rw(1, "Load all defaults", U32).number(1).node(),
            Entry::rw(2, "Load communication defaults", U32).number(1).node(),
            Entry::rw(3, "Load application defaults", U32).number(1).node(),
            Entry::rw(4, "Load manufacturer defaults", U32).number(1).node(),
        ],
    ),
    Object::var(0x1014, &[Entry::rw(0, "COB-ID EMCY", U32).node_id(0x80).pre_operational().node().stored()]),
    Object::var(
        0x1017,
        &[Entry::rw(0, "Producer heartbeat ms", U16).number(0).ranges(HEARTBEAT).node().stored()],
    ),
    Object::record(
        0x1018,
        "Identity",
        &[
            largest(4),
            Entry::ro(1, "Vendor ID", U32).number(0x195),
            Entry::ro(2, "Product code", U32).number(UNSUPPORTED),
            Entry::ro(3, "Revision number", U32).number(0),
            Entry::ro(4, "Serial number", U32).number(UNSUPPORTED),
        ],
    ),
    Object::record(
        0x1200,
        "SDO server",
        &[
            largest(2),
            Entry::ro(1, "COB-ID rx", U32).node_id(0x600),
            Entry::ro(2, "COB-ID tx", U32).node_id(0x580),
        ],
    ),
    Object::record(
        0x1400,
        "RPDO1 communication",
        &[
            largest(5),
            cob_id("COB-ID RPDO1", 0x200),
            kind(0xFF, RPDO_TYPES),
            unused(3, "Inhibit time (unused)"),
            unused(5, "Event timer (unused)"),
        ],
    ),
    Object::record(
        0x1401,
        "RPDO2 communication",
        &[
            largest(5),
            cob_id("COB-ID RPDO2", 0x300),
            kind(0xFF, RPDO_TYPES),
            unused(3, "Inhibit time (unused)"),
            unused(5, "Event timer (unused)"),
        ],
    ),
    Object::record(0x1600, "RPDO1 mapping", &mapping([0x5F16_0320, 0x5F16_0410, 0x5F0C_0010])),
    Object::record(0x1601, "RPDO2 mapping", &mapping([0x5F16_0120, 0x5F16_0210, 0x5F0C_0010])),
    Object::record(
        0x1800,
        "TPDO1 communication",
        &[
            largest(5),
            cob_id("COB-ID TPDO1", 0x180),
            kind(0xFE, TPDO1_TYPES),
            unused(3, "Inhibit time (unused)"),
            Entry::rw(5, "Event timer ms (= 6200h)", U16).number(0).node().stored(),
        ],
    ),
    Object::record(
        0x1801,
        "TPDO2 communication",
        &[
            largest(5),
            cob_id("COB-ID TPDO2", 0x280),
            kind(1, TPDO2_TYPES),
            unused(3, "Inhibit time (unused)"),
            unused(5, "Event timer (unused)"),
        ],
    ),
    Object::record(0x1A00, "TPDO1 mapping", &mapping([0x6004_0020, 0x5F1D_0010, 0x5F19_0010])),
    Object::record(0x1A01, "TPDO2 mapping", &mapping([0x6004_0020, 0x5F1D_0010, 0x5F19_0010])),
    Object::var(0x2001, &[setting(Setting::ApplicationOffset)]),
    Object::var(0x2002, &[Entry::rw(0, "Calibrate", U8).number(0).stored()]),
    Object::var(0x2003, &[setting(Setting::CalibrationByKey)]),
    Object::var(0x2004, &[setting(Setting::IncrementalByKey)]),
    Object::record(
        0x2005,
        "Configuration by key",
        &[
            largest(3),
            setting(Setting::ConfigurationByKey),
            setting(Setting::KeyEnableTime),
            setting(Setting::Internal),
        ],
    ),
    Object::var(0x5000, &[Entry::ro(0, "CAN bus error ranking", U32).number(0)]),
    Object::record(
        0x5F09,
        "External heartbeat",
        &[largest(2), setting(Setting::ExternalHeartbeatTime), setting(Setting::ExternalHeartbeatSource)],
    ),
    Object::record(
        0x5F0A,
        "Node-ID and baud rate",
        &[
            largest(3),
            setting(Setting::NodeId),
            // Its range is judged by the device: an illegal number also ends Auto-ID.
            Entry { limits: Limits::Type, ..setting(Setting::AutoId) },
            setting(Setting::BaudRate),
        ],
    ),
    Object::var(0x5F0B, &[volatile(setting(Setting::RowTwo))]),
    Object::var(0x5F0C, &[Entry::ro(0, "Control word", U16).number(0).live().to_rpdo()]),
    Object::record(
        0x5F0D,
        "Differential value",
        &[
            largest(2),
            Entry::ro(1, "Differential value", U32).number(0).live(),
            setting(Setting::DifferenceFormation),
        ],
    ),
    Object::var(0x5F10, &[setting(Setting::Window1)]),
    Object::var(0x5F11, &[setting(Setting::DecimalPlaces)]),
    Object::record(
        0x5F12,
        "Display orientation and LEDs",
        &[
            largest(9),
            setting(Setting::Orientation),
            setting(Setting::Led1),
            setting(Setting::Led2),
            setting(Setting::Led3),
            setting(Setting::Led4),
            setting(Setting::LedFlashing),
            setting(Setting::WhiteBacklight),
            setting(Setting::RedBacklight),
            setting(Setting::BacklightFlashing),
        ],
    ),
    Object::record(
        0x5F13,
        "Display divisor",
        &[largest(2), setting(Setting::Divisor), setting(Setting::DivisorUse)],
    ),
    Object::var(0x5F14, &[setting(Setting::LoopLength)]),
    Object::var(0x5F15, &[setting(Setting::Positioning)]),
    Object::record(
        0x5F16,
        "Set points",
        &[
            largest(4),
            Entry::ro(1, "Set point 2, low 4 bytes", U32).number(0).live().to_pdo(),
            Entry::ro(2, "Set point 2, high 2 bytes", U32).number(0).live().to_pdo(),
            Entry::ro(3, "Set point 1, low 4 bytes", U32).number(0).live().to_pdo(),
            Entry::ro(4, "Set point 1, high 2 bytes", U32).number(0).live().to_pdo(),
        ],
    ),
    Object::var(0x5F19, &[Entry::ro(0, "Status word", U16).number(0).live().to_tpdo()]),
    // The EEPROM columns of the two are swapped in the manual (CN-118): the mode is kept.
    Object::record(
        0x5F1B,
        "Sensor type and operating mode",
        &[largest(2), Entry::ro(1, "Sensor type", U8).number(2), setting(Setting::OperatingMode)],
    ),
    // Sub-index 0 is data (CN-119).
    Object::record(
        0x5F1C,
        "Acknowledgement settings",
        &[setting(Setting::AcknowledgeKey), setting(Setting::PendingSteady)],
    ),
    Object::var(0x5F1D, &[Entry::ro(0, "Dummy", U16).number(0).to_tpdo()]),
    Object::var(0x5F1F, &[setting(Setting::Arrows)]),
    Object::record(
        0x5F21,
        "Target window 2",
        &[largest(2), setting(Setting::Window2), setting(Setting::Window2Visible)],
    ),
    Object::var(0x6000, &[setting(Setting::OperatingParameters)]),
    Object::var(0x6001, &[setting(Setting::StepsPerRevolution)]),
    Object::var(
        0x6002,
        &[Entry::rw(0, "Total measuring steps", U32)
            .number(TOTAL_STEPS as i64)
            .range(TOTAL_STEPS_RANGE.0, TOTAL_STEPS_RANGE.1)
            .stored()],
    ),
    Object::var(0x6003, &[setting(Setting::Preset)]),
    Object::var(0x6004, &[Entry::ro(0, "Position value", I32).number(0).live().to_tpdo()]),
    Object::var(
        0x6200,
        &[Entry::rw(0, "Cyclic timer ms (= 1800h:5)", U16)
            .number(0)
            .home(Home::Alias(Address::new(0x1800, 5)))
            .stored()],
    ),
    Object::var(0x6500, &[Entry::ro(0, "Operating status", U16).number(4).live()]),
    Object::var(0x6501, &[Entry::ro(0, "Single-turn resolution", U32).number(RESOLUTION as i64)]),
    Object::var(0x6502, &[Entry::ro(0, "Distinguishable revolutions", U16).number(0xE8BA)]),
    Object::var(0x6503, &[Entry::ro(0, "Alarms", U16).number(0).live()]),
    Object::var(0x6504, &[Entry::ro(0, "Supported alarms", U16).number(Alarm::SUPPORTED as i64)]),
    Object::var(0x6505, &[Entry::ro(0, "Warnings", U16).number(0).live()]),
    Object::var(0x6506, &[Entry::ro(0, "Supported warnings", U16).number(BATTERY_WARNING as i64)]),
    Object::var(0x6507, &[Entry::ro(0, "Profile and software version", U32).number(0x012D_0302)]),
    Object::var(0x6508, &[Entry::ro(0, "Operating time", U32).number(UNSUPPORTED)]),
    Object::var(0x6509, &[Entry::ro(0, "Encoder calibration value", I32).number(0).live().stored()]),
    Object::record(
        0x650A,
        "Module identification",
        &[
            largest(3),
            Entry::ro(1, "Manufacturer offset", I32).number(0),
            Entry::ro(2, "Minimum position", I32).number(-83_886_080),
            Entry::ro(3, "Maximum position", I32).number(83_886_080),
        ],
    ),
    Object::var(0x650B, &[Entry::ro(0, "Serial number", U32).number(UNSUPPORTED)]),
];
