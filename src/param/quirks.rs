//! Where the manuals contradict themselves about parameters.

/// Alternatives to the proposals of `ag03.md` 15; each is off by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// C-01: on an AG03/1 the I gain (PNU 1001) begins at 1, not at 0.
    pub i_gain_from_1: bool,
    /// C-02: on an AG03 the accelerations (PNU 1003, 1005, 1007) begin at 1, not at 0.
    pub acceleration_from_1: bool,
    /// C-19: writing the calibration value (PNU 1018) calibrates, not only PNU 970 = 5.
    pub calibrate_by_value: bool,
    /// C-38: d-Pos (PNU 1039) can only be written without travel job.
    pub d_pos_without_job: bool,
    /// C-39: a shaft that turns without travel job, so one that runs out, can be calibrated.
    pub calibrate_while_moving: bool,
}
