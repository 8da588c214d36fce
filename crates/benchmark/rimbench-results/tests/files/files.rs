//! Files written whole or not at all, and what is read of files of users.

use rimbench_core::error::Result;
use rimbench_results::atomic_file::{check_writable_file, write_atomically};
use rimbench_results::input::{read_bytes, read_text};
use rimbench_results::text_place::said_at;
use std::io::Write;
use std::path::Path;

#[test]
fn only_regular_files_of_a_size_that_makes_sense_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a");
    std::fs::write(&file, "text").unwrap();
    assert_eq!(read_text(&file).unwrap(), "text");
    let said = |found: Result<Vec<u8>>| found.unwrap_err().to_string();
    assert!(said(read_bytes(&file, 3)).ends_with("a: is larger than 3 bytes"));
    assert!(said(read_bytes(folder.path(), 3)).ends_with("is no regular file"));
    assert!(said(read_bytes(&folder.path().join("b"), 3)).contains("cannot be read"));
    std::fs::write(&file, b"a\nb\xff").unwrap();
    let message = read_text(&file).unwrap_err().to_string();
    assert!(message.contains("is no text in UTF-8: line 2 has the byte 0xff"), "{message}");
    #[cfg(unix)]
    assert!(said(read_bytes("/dev/zero".as_ref(), 3)).contains("no regular file"));
}

#[test]
fn a_place_in_a_text_is_told_by_line_and_column_and_what_stands_there() {
    let text = "a = 1\nsteps = 5e-3\n";
    assert_eq!(said_at(text, Some(14..18), "no list"), "line 2, column 9: `steps = 5e-3`: no list");
    assert_eq!(said_at(text, None, "no list\n"), "no list");
    // What the reader of TOML itself says of a path of Windows.
    assert_eq!(said_at(text, Some(0..5), "missing field `b`"), "missing field `b`");
    // Types are those of TOML.
    for (message, wanted) in [
        ("invalid type: map, expected usize", "invalid type: table, expected a whole number from 0"),
        (
            "invalid type: integer `3`, expected struct Draw, or so",
            "invalid type: integer `3`, expected a table, or so",
        ),
    ] {
        assert_eq!(said_at(text, None, message), wanted);
    }
    let text = "file = \"C:\\models\\arm.fmu\"\n";
    let error = toml::from_str::<toml::Table>(text).unwrap_err();
    let said = said_at(text, error.span(), error.message());
    assert!(said.contains("write a path with `/`, or in single quotes"), "{said}");
    let long = format!("a = 1\nb = \"{}\"\n", "x".repeat(400_000));
    let said = said_at(&long, Some(10..14), &"y".repeat(400_000));
    assert!(said.starts_with("line 2, column 5: `\"xxxx") && said.len() < 1000, "{said}");
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_failed_write_leaves_what_stood_there_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    write_atomically(&path, |file| file.write_all(b"before")).unwrap();
    let full = |file: &mut dyn Write| file.write_all(b"half").and(Err(std::io::Error::other("disk full")));
    let message = write_atomically(&path, full).unwrap_err().to_string();
    assert!(message.contains("a.csv: cannot be written: disk full"), "{message}");
    assert_eq!(
        (std::fs::read_to_string(&path).unwrap(), names_in(folder.path())),
        ("before".into(), vec!["a.csv".into()])
    );
}

#[test]
fn what_a_killed_process_has_left_goes_with_the_next_file_written_there() {
    let folder = tempfile::tempdir().unwrap();
    // No process has this number, which is above what Linux gives; the others are not ours to remove.
    let living = format!(".rimbench-{}-x", std::process::id());
    for name in [".rimbench-4194999-abc", &living, ".rimbench-notes-1"] {
        std::fs::write(folder.path().join(name), "half").unwrap();
    }
    write_atomically(&folder.path().join("a.csv"), |file| file.write_all(b"whole")).unwrap();
    assert_eq!(names_in(folder.path()), [living.as_str(), ".rimbench-notes-1", "a.csv"]);
}

#[test]
fn a_folder_is_refused_and_so_is_a_name_without_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    for (path, wanted) in
        [(folder.path().to_owned(), "is a folder"), (folder.path().join("missing").join("a.csv"), "there is no folder")]
    {
        let message = check_writable_file(&path).unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
        assert!(write_atomically(&path, |file| file.write_all(b"x")).is_err());
    }
    check_writable_file(&folder.path().join("a.csv")).unwrap();
    assert_eq!(names_in(folder.path()), [""; 0]);
}

#[cfg(unix)]
mod on_unix {
    use super::*;
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};

    #[test]
    fn a_link_stays_a_link_and_what_it_leads_to_is_written() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("data")).unwrap();
        // Relative, over two links; and one that leads to nothing yet.
        symlink("data/a.csv", folder.path().join("inner")).unwrap();
        symlink("inner", folder.path().join("outer")).unwrap();
        for text in ["new", "replaced"] {
            check_writable_file(&folder.path().join("outer")).unwrap();
            write_atomically(&folder.path().join("outer"), |file| file.write_all(text.as_bytes())).unwrap();
            assert_eq!(std::fs::read_to_string(folder.path().join("data/a.csv")).unwrap(), text);
        }
        for link in ["inner", "outer"] {
            assert!(std::fs::symlink_metadata(folder.path().join(link)).unwrap().is_symlink(), "{link}");
        }
        assert_eq!(names_in(folder.path()), ["data", "inner", "outer"]);
        symlink("circle", folder.path().join("circle")).unwrap();
        let message = check_writable_file(&folder.path().join("circle")).unwrap_err().to_string();
        assert!(message.contains("in a circle"), "{message}");
    }

    #[test]
    fn a_pipe_is_written_through_and_stays_a_pipe() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        // Before a reader is there: the check must not wait for one.
        check_writable_file(&pipe).unwrap();
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read_to_string(pipe).unwrap()
        });
        write_atomically(&pipe, |file| file.write_all(b"through")).unwrap();
        assert!(std::fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo(), "the pipe was replaced");
        assert_eq!(reader.join().unwrap(), "through");
        assert_eq!(names_in(folder.path()), ["pipe"]);
        // Through a link as well; a reader that leaves early is no error.
        symlink("pipe", folder.path().join("link")).unwrap();
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || drop(std::fs::File::open(pipe).unwrap())
        });
        let much = |file: &mut dyn Write| (0..100_000).try_for_each(|_| file.write_all(&[0; 64]));
        write_atomically(&folder.path().join("link"), much).unwrap();
        reader.join().unwrap();
        assert!(std::fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        assert!(std::fs::symlink_metadata(folder.path().join("link")).unwrap().is_symlink());
    }

    #[test]
    fn a_replaced_file_keeps_its_permissions() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mode = || std::fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        write_atomically(&path, |file| file.write_all(b"1")).unwrap();
        assert_eq!(mode(), 0o644);
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600)).unwrap();
        write_atomically(&path, |file| file.write_all(b"2")).unwrap();
        assert_eq!(mode(), 0o600);
    }
}
