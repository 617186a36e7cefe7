//! The pictures in `docs/` are what `examples/travel.rs` prints. `PROFIDRIVE_REWRITE=1` writes them anew.

use std::path::Path;
use std::{env, fs};

#[path = "../../examples/travel.rs"]
mod travel;

#[test]
fn the_pictures_are_those_of_the_example() {
    for name in ["direct", "loop", "load"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/travel-{name}.svg"));
        let picture = travel::picture(name).unwrap();
        if env::var_os("PROFIDRIVE_REWRITE").is_some() {
            fs::write(&path, &picture).unwrap();
        }
        let kept = fs::read_to_string(&path).unwrap_or_default();
        assert!(kept == picture, "{} differs; run with PROFIDRIVE_REWRITE=1 and look", path.display());
    }
    assert_eq!(travel::picture("nothing"), None);
}
