//! Where the manuals contradict themselves about parameters.

/// Alternatives to the proposals of `ag03.md` 15; each is off by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// On an AG03/1 the I gain (PNU 1001) begins at 1, not at 0 (C-01).
    pub i_gain_from_1: bool,
    /// On an AG03 the accelerations (PNU 1003, 1005, 1007) begin at 1, not at 0 (C-02).
    pub acceleration_from_1: bool,
    /// Writing the calibration value (PNU 1018) calibrates, not only PNU 970 = 5 (C-19).
    pub calibrate_by_value: bool,
    /// D-Pos (PNU 1039) can only be written without travel job (C-38).
    pub d_pos_without_job: bool,
    /// A shaft that turns without travel job, so one that runs out, can be calibrated (C-39).
    pub calibrate_while_moving: bool,
}

impl Quirks {
    /// None of them.
    pub(crate) const NONE: Self = Self {
        i_gain_from_1: false,
        acceleration_from_1: false,
        calibrate_by_value: false,
        d_pos_without_job: false,
        calibrate_while_moving: false,
    };
}
