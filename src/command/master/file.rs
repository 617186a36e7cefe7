//! Where `save` writes: a plain file is replaced whole or not at all, anything else is written as it is.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

#[cfg(unix)]
#[path = "file/unix.rs"]
mod special;
#[cfg(not(unix))]
#[path = "file/windows.rs"]
mod special;

use special::{keep, write_to_device};

/// Writes `text` to `file`, which may be there or not. Symbolic links are followed. A plain file keeps its owner and its
/// permissions, and a read-only one is refused, also if this user could replace it.
pub(super) fn put(file: &Path, text: &str) -> io::Result<()> {
    match fs::metadata(file) {
        Ok(found) if found.is_file() => {
            if found.permissions().readonly() {
                return Err(io::Error::new(ErrorKind::PermissionDenied, "the file is read-only"));
            }
            // Whether this user may write it; nothing is changed yet.
            OpenOptions::new().write(true).open(file)?;
            replace(&fs::canonicalize(file)?, text, Some(&found))
        }
        Ok(found) if found.is_dir() => Err(ErrorKind::IsADirectory.into()),
        Ok(found) => write_to_device(file, text, &found),
        Err(error) if error.kind() == ErrorKind::NotFound => replace(&end_of_links(file), text, None),
        Err(error) => Err(error),
    }
}

/// Where a link leads whose target is not there.
fn end_of_links(file: &Path) -> PathBuf {
    match fs::read_link(file) {
        // A circle of links is another error than that something is not there: this comes to an end.
        Ok(to) => end_of_links(&file.parent().unwrap_or(Path::new("")).join(to)),
        Err(_) => file.into(),
    }
}

/// Puts a new file in the place of what is there.
fn replace(file: &Path, text: &str, before: Option<&Metadata>) -> io::Result<()> {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = file.with_file_name(name);
    let outcome = File::create_new(&part)
        .and_then(|mut part| {
            if let Some(before) = before {
                keep(&part, before)?;
            }
            part.write_all(text.as_bytes()).and_then(|()| part.sync_all())
        })
        .and_then(|()| fs::rename(&part, file));
    if outcome.is_err() {
        // Perhaps it was never there.
        let _ = fs::remove_file(&part);
    }
    outcome
}

#[cfg(all(test, unix))]
mod tests {
    use std::io::Read;
    use std::os::unix::fs::{FileTypeExt, OpenOptionsExt, PermissionsExt, symlink};

    use rustix::fs::OFlags;

    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_a_folder_is_left_alone() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("axis.json");
        put(&file, "one").unwrap();
        put(&file, "two").unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "two");
        assert_eq!(put(dir.path(), "three").unwrap_err().kind(), ErrorKind::IsADirectory);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "nothing is left behind");
    }

    #[test]
    fn a_file_keeps_its_permissions_and_a_read_only_one_its_content() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("axis.json");
        let mode = || fs::metadata(&file).unwrap().permissions().mode() & 0o777;
        fs::write(&file, "one").unwrap();
        fs::set_permissions(&file, PermissionsExt::from_mode(0o640)).unwrap();
        put(&file, "two").unwrap();
        assert_eq!((fs::read_to_string(&file).unwrap().as_str(), mode()), ("two", 0o640));
        fs::set_permissions(&file, PermissionsExt::from_mode(0o444)).unwrap();
        assert_eq!(put(&file, "three").unwrap_err().kind(), ErrorKind::PermissionDenied);
        assert_eq!((fs::read_to_string(&file).unwrap().as_str(), mode()), ("two", 0o444));
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "nothing is left behind");
    }

    #[test]
    fn a_link_stays_a_link_and_its_target_is_written() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("sets");
        fs::create_dir(&folder).unwrap();
        for target in ["sets/there.json", "sets/new.json"] {
            let link = dir.path().join(target.replace('/', "-"));
            symlink(target, &link).unwrap();
            if target.contains("there") {
                fs::write(dir.path().join(target), "one").unwrap();
            }
            put(&link, "two").unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink(), "{target}");
            assert_eq!(fs::read_to_string(dir.path().join(target)).unwrap(), "two");
        }
        let circle = dir.path().join("circle");
        symlink(&circle, &circle).unwrap();
        assert!(put(&circle, "two").is_err());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "nothing is left behind");
    }

    #[test]
    fn a_device_and_a_fifo_are_written_and_stay_what_they_are() {
        let full = put(Path::new("/dev/full"), "text").unwrap_err();
        assert_eq!(full.kind(), ErrorKind::StorageFull);
        assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
        let dir = tempfile::tempdir().unwrap();
        let fifo = dir.path().join("fifo");
        let made = std::process::Command::new("mkfifo").arg(&fifo).status().unwrap();
        assert!(made.success());
        assert_eq!(put(&fifo, "text").unwrap_err().to_string(), "nobody reads this FIFO");
        let flags = OFlags::NONBLOCK.bits().cast_signed();
        let mut reader = OpenOptions::new().read(true).custom_flags(flags).open(&fifo).unwrap();
        put(&fifo, "text").unwrap();
        let mut text = String::new();
        reader.read_to_string(&mut text).unwrap();
        assert_eq!(text, "text");
        assert!(fs::metadata(&fifo).unwrap().file_type().is_fifo());
    }
}
