// SPDX-License-Identifier: Apache-2.0
//! Programs can be built and run by any names of their files and folders.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use crate::support::{folder, said, text};

const PROGRAM: &str = "target Rust { rust-include: \"../lib/units.rs\" }\nmain reactor {\n  reaction(startup) {=\n    \
                       let unused = 1;\n    println!(\"{}\", crate::units::KILO);\n  =}\n}\n";

/// Returns a command of `lfz` in a folder, with these words.
fn lfz(current: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(current).args(words);
    command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_NET_OFFLINE", "true");
    command
}

#[test]
fn a_program_is_built_and_its_warnings_are_shown_whatever_leads_to_it() {
    let folder = folder(&[
        ("real ü/my app/src/P.lf", PROGRAM),
        ("real ü/my app/lib/units.rs", "pub const KILO: u32 = { let spare = 1; 1000 };\n"),
    ]);
    let root = folder.path();
    symlink(root.join("real ü"), root.join("link")).expect("it can be made");
    symlink(root.join("link/my app/src"), root.join("sources")).expect("it can be made");
    let application = root.join("link/my app");
    for (current, words) in [
        (application.join("lib"), &["run", "../src/P.lf"][..]),
        (application.join("lib"), &["run", "../src/../lib/.././src/P.lf", "--out", "../o ö"]),
        (root.to_owned(), &["run", "link/my app/src/P.lf", "--out", "link/other/../o"]),
        (application.clone(), &["run", "../../sources/P.lf"]),
    ] {
        let output = said(&mut lfz(&current, words));
        let errors = text(&output.stderr);
        assert_eq!(text(&output.stdout), "1000\n", "{words:?}: {errors}");
        for warning in [
            "P.lf:4:9: warning[unused_variables]: unused variable: `unused`",
            "units.rs:1:29: warning[unused_variables]: unused",
        ] {
            assert!(errors.contains(warning), "{words:?}: {errors}");
        }
    }
    assert!(root.join("real ü/my app/build/lfz/P/host/Cargo.toml").is_file());
    assert!(root.join("real ü/my app/o ö/Cargo.toml").is_file());
    assert!(root.join("real ü/o/Cargo.toml").is_file());
    assert!(!root.join("real ü/other").exists(), "a folder that a path only passes is not made");

    let output = said(&mut lfz(&application.join("lib"), &["check", "--bodies", "../src/P.lf"]));
    let errors = text(&output.stderr);
    assert!(errors.contains("unused variable: `unused`") && output.status.success(), "{errors}");

    // The build folder goes, and the program stays.
    let freed = text(&said(&mut lfz(&application.join("lib"), &["clean", "../src/P.lf"])).stdout);
    assert!(freed.ends_with(" MB freed\n") && !freed.starts_with("0.0"), "{freed}");
    assert!(!root.join("real ü/my app/build").exists());
    assert_eq!(fs::read_to_string(root.join("sources/P.lf")).expect("it is there"), PROGRAM);
}

#[test]
fn a_folder_without_write_access_is_reported_with_the_option_for_another_one() {
    let folder = folder(&[("src/P.lf", PROGRAM), ("lib/units.rs", ""), ("build", "no folder")]);
    let output = said(&mut lfz(folder.path(), &["build", "src/P.lf"]));
    let errors = text(&output.stderr);
    assert!(!output.status.success() && errors.contains("--out") && errors.contains("build"), "{errors}");
    let output = said(&mut lfz(folder.path(), &["build", "src/P.lf", "--out", "a:b"]));
    let errors = text(&output.stderr);
    assert!(errors.contains("contains `:`") && errors.contains("--out"), "{errors}");
}

#[test]
fn clean_leaves_a_folder_alone_in_which_nothing_was_generated() {
    let folder = folder(&[("P.lf", PROGRAM), ("mine/Cargo.lock", "my own"), ("mine/target/x", "my own")]);
    let output = said(&mut lfz(folder.path(), &["clean", "P.lf", "--out", "mine"]));
    assert_eq!(text(&output.stdout), "0.0 MB freed\n", "{}", text(&output.stderr));
    assert!(folder.path().join("mine/Cargo.lock").is_file() && folder.path().join("mine/target/x").is_file());
}

/// Without a program, all that is compiled goes: for programs, of the runtime, and what editors have checked.
#[test]
fn clean_of_everything_leaves_what_is_not_its_own() {
    let kinds = ["programs/1", "runtime/2", "editor/check"];
    let folder = folder(&[("store/mine/x", "my own")]);
    let store = folder.path().join("store");
    for kind in kinds {
        fs::create_dir_all(store.join(kind)).expect("it can be made");
        fs::write(store.join(kind).join("x"), vec![7; 1_000_000]).expect("it can be written");
    }
    let output = said(&mut lfz(folder.path(), &["clean", "--all", "--target-dir", "store"]));
    assert_eq!(text(&output.stdout), "3.0 MB freed\n", "{}", text(&output.stderr));
    assert_eq!(kinds.map(|kind| store.join(kind).exists()), [false; 3]);
    assert!(store.join("mine/x").is_file());
}
