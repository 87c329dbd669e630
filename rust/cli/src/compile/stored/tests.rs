// SPDX-License-Identifier: Apache-2.0
//! Cargo's messages about a crate for Zephyr, which is generated for each test.

use std::fs;
use std::path::{Path, PathBuf};

use super::super::{Console, Request};
use super::{FILE, explain};
use crate::args::{Places, Platform};

const TEXT: &str = "\
target Rust
main reactor {
  reaction(startup) {=
    let wrong: u8 = \"é\";
  =}
}
";

/// A program and the messages about it.
struct World {
    folder: tempfile::TempDir,
}

impl World {
    fn new() -> Self {
        let world = Self { folder: tempfile::tempdir().expect("a temporary folder") };
        let file = world.path("Wrong.lf");
        fs::write(&file, TEXT).expect("it can be written");
        let places = Places { out: Some(world.path("out")), ..Places::default() };
        let (platform, board) = (Some(Platform::Zephyr), Some("some_board"));
        let request = Request { platform, board, ..Request::new(&file, &places) };
        request.build().expect("crates for Zephyr are generated and not compiled");
        world
    }

    fn path(&self, path: &str) -> PathBuf {
        self.folder.path().join(path)
    }

    fn crate_folder(&self) -> PathBuf {
        self.path("out/Wrong")
    }

    /// Returns the place of the body's value in the crate.
    fn place(&self) -> (&'static str, usize, usize) {
        let file = "src/wrong/wrong.rs";
        let text = fs::read_to_string(self.crate_folder().join(file)).expect("it was generated");
        let (index, line) =
            text.lines().enumerate().find(|(_, line)| line.contains("let wrong")).expect("the body is in it");
        let column = line.chars().position(|character| character == '"').expect("the value is in it") + 1;
        (file, index + 1, column)
    }

    /// Returns a message about the value in the body, in the crate with this folder.
    fn message(&self, level: &str, folder: &Path) -> String {
        let (file, line, column) = self.place();
        let span = serde_json::json!({ "file_name": file, "line_start": line, "line_end": line,
            "column_start": column, "column_end": column + 3, "is_primary": true,
            "label": "expected `u8`, found `&str`", "suggested_replacement": null, "expansion": null });
        let message = serde_json::json!({ "message": "mismatched types", "code": { "code": "E0308" },
            "level": level, "spans": [span], "children": [], "rendered": "as rustc prints it\n" });
        let manifest = folder.join("Cargo.toml");
        serde_json::json!({ "reason": "compiler-message", "manifest_path": manifest, "message": message }).to_string()
    }

    /// Returns the diagnostics for files with these lines; the program's file has no folder.
    fn explained(&self, files: &[&[String]]) -> String {
        let write = |(index, lines): (usize, &&[String])| {
            let path = self.path(&format!("{index}.json"));
            fs::write(&path, lines.join("\n")).expect("it can be written");
            path
        };
        let paths: Vec<PathBuf> = files.iter().enumerate().map(write).collect();
        let text = explain(&paths).expect("the messages can be read");
        text.replace(&format!("{}/", self.folder.path().display()), "")
    }
}

const ERROR: &str = "\
Wrong.lf:4:21: error[E0308]: mismatched types
  |
4 |     let wrong: u8 = \"é\";
  |                     ^^^ expected `u8`, found `&str`

";

#[test]
fn an_error_is_shown_in_the_lf_file_once() {
    let world = World::new();
    let error = world.message("error", &world.crate_folder());
    let finished = r#"{"reason":"build-finished","success":false}"#.to_owned();
    let first = [error.clone(), finished, "a build script's own words".to_owned()];
    assert_eq!(world.explained(&[&first, &[error]]), ERROR);
}

#[test]
fn the_lf_file_is_shown_as_it_was_compiled() {
    let world = World::new();
    let error = world.message("error", &world.crate_folder());
    fs::write(world.path("Wrong.lf"), "").expect("it can be written");
    assert_eq!(world.explained(&[&[error]]), ERROR);
}

#[test]
fn warnings_are_the_programs_own_ones() {
    let world = World::new();
    let own = world.message("warning", &world.crate_folder());
    assert!(world.explained(&[&[own]]).starts_with("Wrong.lf:4:21: warning[E0308]: mismatched types\n"));
    let others = world.message("warning", &world.path("another"));
    assert_eq!(world.explained(&[&[others]]), "");
}

#[test]
fn errors_of_other_crates_are_shown_as_they_are() {
    let world = World::new();
    let error = world.message("error", &world.path("another"));
    assert_eq!(world.explained(&[&[error]]), "as rustc prints it\n\n");
}

#[test]
fn unreadable_files_are_named() {
    let world = World::new();
    let missing = world.path("missing.json");
    let text = |path: &Path| explain(&[path.to_owned()]).expect_err("it cannot be read").to_string();
    assert!(text(&missing).starts_with(&format!("cannot read {}", missing.display())));
    let map = world.crate_folder().join(FILE);
    let messages = world.path("messages.json");
    fs::write(&messages, world.message("error", &world.crate_folder())).expect("it can be written");
    fs::write(&map, "{}").expect("it can be written");
    assert!(text(&messages).starts_with(&format!("{} was not made by this version of lfz", map.display())));
}

#[test]
fn places_in_what_an_image_prints_become_places_in_the_program() {
    let world = World::new();
    let console = Console::known(&world.crate_folder()).expect("it was generated");
    let shown = |line: &str| {
        let shown = String::from_utf8(console.with_lf_places(line.as_bytes()).into_owned()).expect("it is text");
        shown.replace(&format!("{}/", world.folder.path().display()), "")
    };
    let (file, line, column) = world.place();
    assert_eq!(shown(&format!("lf: panicked at {file}:{line}:{column}:")), "lf: panicked at Wrong.lf:4:21:");
    let whole = world.crate_folder().join(file);
    let twice = format!("({}:{line}:{column}) {file}:{line}:{column}", whole.display());
    assert_eq!(shown(&twice), "(Wrong.lf:4:21) Wrong.lf:4:21");
    for line in ["", "at src/other.rs:1:2", "x.rs:", "x.rs:1", "x.rs:1:", "é.rs:99999999999999999999:1 .rs:1:1"] {
        assert_eq!(shown(line), line);
    }
    assert!(Console::known(world.folder.path()).is_err());
    assert!(Console::of(world.folder.path()).expect("nothing to read").is_none());
}

#[test]
fn a_crate_that_needs_std_is_named_once() {
    let world = World::new();
    let message = |text: &str, code: &str| {
        let message = serde_json::json!({ "message": text, "code": { "code": code }, "level": "error", "spans": [],
            "children": [], "rendered": format!("{text}\n") });
        let manifest = world.path("rand/Cargo.toml");
        let target = serde_json::json!({ "name": "rand" });
        serde_json::json!({ "reason": "compiler-message", "manifest_path": manifest, "target": target,
            "message": message })
        .to_string()
    };
    let lines = [message("can't find crate for `std`", "E0463"), message("cannot find macro `vec`", "E0425")];
    let text = world.explained(&[&lines, &lines]);
    assert!(text.starts_with("error: the crate `rand` needs `std`, which images do not have\n"), "{text}");
    assert_eq!(text.matches("error").count(), 1, "{text}");
}
