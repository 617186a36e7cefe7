//! Axes of a drive with several motors: the objects of axis n + 1 are n times 800h behind those of the first.

/// The most axes of a node.
pub(crate) const MAX_AXES: u8 = 8;

/// The first object of the first axis.
const FIRST: u16 = 0x6000;
/// Objects of an axis.
const OBJECTS: u16 = 0x800;

/// The axis of an object, 0 the first, and the index that the first axis has for it. What is of no axis is of the first.
pub(crate) const fn of_first(index: u16) -> (u8, u16) {
    match index.checked_sub(FIRST) {
        Some(behind) if behind < OBJECTS * MAX_AXES as u16 => {
            let [axis, _] = (behind / OBJECTS).to_le_bytes();
            (axis, FIRST + behind % OBJECTS)
        }
        Some(_) | None => (0, index),
    }
}

/// Where an axis has an object of the first.
pub(crate) const fn index(axis: u8, first: u16) -> u16 {
    first + axis as u16 * OBJECTS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_axis_has_the_objects_of_the_first_behind_it() {
        for (at, axis, first) in [
            (0x1018, 0, 0x1018),
            (0x6040, 0, 0x6040),
            (0x67FF, 0, 0x67FF),
            (0x6840, 1, 0x6040),
            (0x70FF, 2, 0x60FF),
            (0x9FFF, 7, 0x67FF),
            (0xA040, 0, 0xA040),
        ] {
            assert_eq!(of_first(at), (axis, first), "{at:04X}h");
            if (0x6000..0xA000).contains(&at) {
                assert_eq!(index(axis, first), at);
            }
        }
    }
}
