//! Tests of whole lines: of what they tell, and of what they keep.

mod kept_lines;
pub(crate) mod silence;
