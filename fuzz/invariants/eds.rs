//! A device file of a stranger: reading never fails but with a place, is the same again, and every entry has the octets
//! of its type at every node.

use profidrive::can_bus::canopen::NodeId;
use profidrive::eds::{Eds, ReadError};

/// The file.
pub(crate) fn check(data: &[u8]) {
    let eds = match Eds::read(data) {
        Ok(eds) => eds,
        Err(error) => {
            assert!(error == ReadError::Empty || error.to_string().starts_with("line "), "{error}");
            return;
        }
    };
    // Once more for some inputs: it takes as long as everything else.
    if data.len().is_multiple_of(8) {
        let again = Eds::read(data).map(|eds| (eds.objects.len(), eds.hints));
        assert_eq!(again, Ok((eds.objects.len(), eds.hints.clone())), "reading is the same again");
    }
    assert!(eds.hints.iter().all(|hint| hint.place.line > 0 && hint.place.column > 0));
    assert!(eds.hints.is_sorted_by_key(|hint| hint.place.line));
    for (index, object) in &eds.objects {
        assert!(
            *index >= 0x1000 && !object.entries.is_empty() && object.entries.contains_key(&0),
            "{index:04X}"
        );
        for entry in object.entries.values() {
            for node in [1, 127] {
                let octets = entry.octets(NodeId::new(node).expect("1 to 127"));
                assert!(entry.data.octets().is_none_or(|expected| expected == octets.len()), "{index:04X}");
            }
        }
    }
}
