// SPDX-License-Identifier: Apache-2.0
//! Programs are built in parallel, and share the compiled runtime.

use std::fs::{self, File};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::support::{folder, lfz, said, text};
use rustix::fs::{FlockOperation, flock};

const PROGRAM: &str = "target Rust\nmain reactor {\n  reaction(startup) {= println!(\"it runs\"); =}\n}\n";

/// Returns the folder in a store that belongs to the program with these generated crates.
fn of_program(store: &Path, out: &Path) -> PathBuf {
    let out = fs::canonicalize(out).expect("it was generated").to_string_lossy().into_owned();
    let entries = fs::read_dir(store.join("programs")).expect("programs were built").flatten();
    let is_owner = |folder: &PathBuf| fs::read_to_string(folder.join("owner")).is_ok_and(|owner| owner == out);
    entries.map(|entry| entry.path()).find(is_owner).expect("it was built")
}

/// Returns the number of bytes below a folder that no other folder shares.
fn own_size(folder: &Path) -> u64 {
    let size = |entry: fs::DirEntry| match entry.metadata().expect("it can be read") {
        metadata if metadata.is_dir() => own_size(&entry.path()),
        metadata => {
            if metadata.nlink() == 1 {
                metadata.len()
            } else {
                0
            }
        }
    };
    fs::read_dir(folder).expect("it can be read").flatten().map(size).sum()
}

#[test]
fn a_build_neither_waits_for_that_of_another_program_nor_compiles_the_runtime_again() {
    let store = tempfile::tempdir().expect("a temporary folder");
    let (one, other) = (folder(&[("P.lf", PROGRAM)]), folder(&[("P.lf", PROGRAM)]));
    let run = |folder: &Path| said(lfz(folder, &["run"]).env("LFZ_TARGET_DIR", store.path()));
    let first = text(&run(one.path()).stderr);
    assert!(first.contains("Compiling the runtime crates, once for all programs"), "{first}");

    // Another process builds the first program.
    let its = of_program(store.path(), &one.path().join("out"));
    let lock = File::open(its.with_extension("lock")).expect("it is there");
    flock(&lock, FlockOperation::LockExclusive).expect("nobody builds it yet");
    let output = run(other.path());
    let errors = text(&output.stderr);
    assert_eq!(text(&output.stdout), "it runs\n", "{errors}");
    assert!(!errors.contains("runtime crates") && !errors.contains("Waiting"), "{errors}");
    let size = own_size(&of_program(store.path(), &other.path().join("out")));
    assert!(size < 5_000_000, "{size} bytes for a program of a few lines");

    // A folder in use is left, and listed.
    let clean = |words: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_lfz"));
        command.args(words).env("LFZ_TARGET_DIR", store.path()).env("CARGO_TARGET_DIR", store.path().join("cargo"));
        said(&mut command)
    };
    let output = clean(&["clean", "--all"]);
    let (freed, left) = (text(&output.stdout), text(&output.stderr));
    assert!(left.contains("is left: a build uses it") && its.is_dir(), "{left}");
    let megabytes: f64 = freed.split(' ').next().and_then(|number| number.parse().ok()).expect("a number");
    assert!(megabytes > 1.0, "{freed}");
    drop(lock);
    clean(&["clean", "--all"]);
    assert!(!its.exists());
}
