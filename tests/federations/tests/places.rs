// SPDX-License-Identifier: Apache-2.0
//! Files and folders as users have them: a command works with them, or says which one it cannot use and how to fix
//! that.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use lf_federations::{Lfz, Run};
use rustix::fs::{CWD, FileType, Mode, mknodat};

const TEXT: &str = "target Rust\nmain reactor { reaction(startup) {= println!(\"it runs\"); =} }\n";

/// Entries that can stand in the place of a file.
const NO_FILES: [&str; 5] = ["nothing", "folder", "pipe", "/dev/zero", "nowhere"];

/// Entries that can stand in the place of a folder to write.
const NO_FOLDERS: [&str; 4] = ["file", "pipe", "file/below", "/dev/zero"];

/// Creates the folder `folder`, the file `file`, the pipe `pipe`, and the dangling link `nowhere`.
fn things() -> tempfile::TempDir {
    let things = tempfile::tempdir().expect("a temporary folder");
    let path = |name| things.path().join(name);
    fs::create_dir(path("folder")).expect("it can be made");
    fs::write(path("file"), "").expect("it can be written");
    fs::write(path("P.lf"), TEXT).expect("it can be written");
    mknodat(CWD, path("pipe"), FileType::Fifo, Mode::RWXU, 0).expect("it can be made");
    symlink("gone", path("nowhere")).expect("it can be made");
    things
}

/// Returns the commands that read a program.
fn commands() -> [Command; 5] {
    let all: [&[&str]; 5] = [&["check"], &["check", "--bodies"], &["plan"], &["build"], &["run"]];
    all.map(|words| Lfz::command(words.iter().copied()))
}

/// Asserts that a command reports that it cannot use this, with one of these pieces of advice.
fn refuses(command: Command, shown: &str, advice: &[&str]) {
    let words = format!("{command:?}");
    let finished = Run::start(command).finish();
    assert_eq!(finished.code(), 1, "{words}: {finished}");
    let said = finished.lines.join("\n");
    assert!(said.contains(shown), "{words} says nothing of {shown}: {finished}");
    assert!(advice.iter().any(|advice| said.contains(advice)), "{words} has none of {advice:?}: {finished}");
    assert!(!said.contains("os error"), "{words}: {finished}");
}

#[test]
fn a_path_that_is_no_file_is_refused_in_each_place_of_a_file() {
    let things = things();
    for name in NO_FILES {
        for mut command in commands() {
            command.current_dir(things.path()).arg(name);
            refuses(command, name, &["name the file of LF"]);
        }
        fs::write(things.path().join("I.lf"), format!("target Rust\nimport A from \"{name}\"\nmain reactor {{}}\n"))
            .expect("it can be written");
        for mut command in commands() {
            command.current_dir(things.path()).arg("I.lf");
            refuses(command, name, &["relative to the folder of this file"]);
        }
        let mut command = Lfz::command(["build", "P.lf", "--deployment", name]);
        command.current_dir(things.path());
        refuses(command, name, &["it is", "it does not exist"]);
    }
}

#[test]
fn a_path_that_is_no_folder_is_refused_with_the_option_for_another_one() {
    let things = things();
    for name in NO_FOLDERS {
        for option in ["--out", "--target-dir"] {
            for command in ["build", "run"] {
                let mut command = Lfz::command([command, "P.lf", option, name]);
                command.current_dir(things.path());
                refuses(command, name, &[option]);
            }
        }
    }
}

#[test]
fn a_name_that_is_no_text_is_told_with_the_part_to_rename() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let strange = OsStr::from_bytes(b"b\xFFd");
    fs::create_dir(folder.path().join(strange)).expect("it can be made");
    let strange_file = folder.path().join(strange).join("P.lf");
    let other = folder.path().join(OsStr::from_bytes(b"\xE4.lf"));
    for file in [&strange_file, &other] {
        fs::write(file, TEXT).expect("it can be written");
        for mut command in commands() {
            command.arg(file);
            refuses(command, "UTF-8", &["rename \"b\\xFFd\"", "rename \"\\xE4.lf\""]);
        }
    }
    for words in [&["build", "P.lf"][..], &["run", "P.lf"], &["check", "--bodies", "P.lf"]] {
        let mut command = Lfz::command(words.iter().copied());
        command.current_dir(folder.path().join(strange));
        refuses(command, "UTF-8", &["rename \"b\\xFFd\""]);
    }
}

/// Returns a command that runs in a removed folder.
fn in_a_removed_folder(command: &Command) -> Command {
    let mut shell = Command::new("sh");
    shell.args(["-c", "d=$(mktemp -d) && cd \"$d\" && rmdir \"$d\" && exec \"$@\"", "sh"]);
    shell.arg(command.get_program()).args(command.get_args());
    let variables = command.get_envs().filter_map(|(name, value)| Some((name, value?)));
    shell.envs(variables);
    shell
}

#[test]
fn a_removed_current_folder_is_told_where_something_begins_in_it() {
    let things = things();
    for mut command in commands() {
        command.arg("P.lf");
        refuses(in_a_removed_folder(&command), "folder", &["change to another one"]);
    }
    for words in ["check", "plan", "run"] {
        let mut command = Lfz::command([words]);
        command.arg(things.path().join("P.lf"));
        Run::start(in_a_removed_folder(&command)).succeed();
    }
}

/// The program, its application, the generated crates, cargo's results, temporary files and the paths to all of them
/// may lie anywhere.
#[test]
fn a_program_runs_wherever_its_files_lie() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let real = fs::canonicalize(folder.path()).expect("it is there");
    let make = |name: &str| -> PathBuf {
        let path = real.join(name);
        fs::create_dir_all(&path).expect("it can be made");
        path
    };
    let (deep, temporary) = (make("an app/ü ß/src/deep"), make("t m p#ü"));
    symlink(&deep, real.join("first")).expect("it can be made");
    symlink("first", real.join("second")).expect("it can be made");
    let beside = "import Said from \"../beside/Said.lf\"\n";
    fs::create_dir(deep.join("../beside")).expect("it can be made");
    fs::write(deep.join("../beside/said.h"), "#define SAID \"it runs\"\n").expect("it can be written");
    fs::write(
        deep.join("../beside/Said.lf"),
        "target C { files: \"said.h\" }\npreamble {=\n  #include \"said.h\"\n=}\nreactor Said { reaction(startup) {= \
         printf(\"%s\\n\", SAID); =} }\n",
    )
    .expect("it can be written");
    fs::write(deep.join("P.lf"), format!("target C\n{beside}main reactor {{ a = new Said() }}\n"))
        .expect("it can be written");
    let ways: [(&Path, &str); 4] = [
        (&real, "an app/ü ß/src/deep/P.lf"),
        (&real, "second/P.lf"),
        (&real, "second/../deep/./P.lf"),
        (&deep, "P.lf"),
    ];
    for (current, file) in ways {
        let mut command = Lfz::command(["run", file, "--out"]);
        command.arg(real.join("second/../out é")).current_dir(current).env("TMPDIR", &temporary);
        let finished = Run::start(command).succeed();
        assert!(finished.lines.iter().any(|line| line == "it runs"), "{file}: {finished}");
    }
}
