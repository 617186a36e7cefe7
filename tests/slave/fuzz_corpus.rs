//! Replays what the fuzzer has found worth keeping, on a stable compiler: every file under `fuzz/corpus`.

use std::fs;
use std::path::Path;

#[path = "../../fuzz/invariants/mod.rs"]
pub(crate) mod invariants;

type Check = fn(&[u8]);

#[test]
fn every_input_of_every_corpus_keeps_the_invariants() {
    let targets: &[(&str, Check)] = &[
        #[cfg(feature = "std")]
        ("decode_cli", invariants::decode_cli::check),
        #[cfg(feature = "eds")]
        ("eds", invariants::eds::check),
        #[cfg(feature = "eds")]
        ("eds_node", invariants::eds_node::check),
        #[cfg(feature = "std")]
        ("gsd", invariants::gsd::check),
        #[cfg(feature = "parameters")]
        ("ppo_drive", invariants::ppo_drive::check),
        ("dpv1", invariants::dpv1::check),
        #[cfg(all(feature = "capture", feature = "judge"))]
        ("capture", invariants::capture::check),
        #[cfg(feature = "judge")]
        ("observer", invariants::observer::check),
        #[cfg(feature = "std")]
        ("products", invariants::products::check),
        ("clients", invariants::clients::check),
        ("telegram", invariants::telegram::check),
        ("framer", invariants::framer::check),
        ("slave_ops", invariants::slave_ops::check),
        ("pkw_ops", invariants::pkw_ops::check),
        ("canopen_node", invariants::canopen_node::check),
        ("sdo_server", invariants::sdo_server::check),
        ("eeprom_image", invariants::eeprom_image::check),
        ("slcan", invariants::slcan::check),
    ];
    for (target, check) in targets {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
        let mut replayed = 0;
        for entry in fs::read_dir(&folder).expect("the corpus is committed") {
            let path = entry.expect("the corpus can be listed").path();
            println!("{}", path.display());
            check(&fs::read(&path).expect("an input can be read"));
            replayed += 1;
        }
        assert!(replayed >= 10, "{target}: only {replayed} inputs in {}", folder.display());
    }
}
