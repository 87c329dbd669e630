// SPDX-License-Identifier: Apache-2.0
//! The options of all commands: how much they say, and in which colours.

use std::process::Command;

use crate::support::{folder, lfz, said, text};

const PROGRAM: &str = "target Rust { timeout: 0 }
main reactor {
  reaction(startup) {= println!(\"hello\"); =}
}
";

#[test]
fn quiet_commands_say_only_what_is_wrong_and_verbose_ones_what_they_run() {
    let folder = folder(&[("P.lf", PROGRAM), ("Wrong.lf", "target Rust\nmain reactor {\n")]);
    let check = |arguments: &[&str]| {
        said(Command::new(env!("CARGO_BIN_EXE_lfz")).current_dir(folder.path()).arg("check").args(arguments))
    };
    assert_eq!(text(&check(&["P.lf"]).stdout), "P.lf: no errors\n");
    let quiet = check(&["-q", "P.lf"]);
    assert_eq!(
        (quiet.status.code(), text(&quiet.stdout), text(&quiet.stderr)),
        (Some(0), String::new(), String::new())
    );
    assert!(text(&check(&["--quiet", "Wrong.lf"]).stderr).contains("Wrong.lf:2:"));
    let run = |option: &str| said(&mut lfz(folder.path(), &["run", option]));
    let quiet = run("-q");
    assert_eq!((text(&quiet.stdout), text(&quiet.stderr)), ("hello\n".to_owned(), String::new()));
    let told = text(&run("-v").stderr);
    assert!(told.contains("Compiled P in ") && told.contains(" build --keep-going --manifest-path "), "{told}");
    let both = check(&["-q", "-v", "P.lf"]);
    assert_eq!(both.status.code(), Some(2), "{}", text(&both.stderr));
}

#[test]
fn colours_are_those_that_are_asked_for() {
    let folder = folder(&[("Wrong.lf", "target Rust\nmain reactor {\n")]);
    let has_colours = |arguments: &[&str], no_color: Option<&str>| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
        command.current_dir(folder.path()).args(arguments).arg("Wrong.lf").env_remove("NO_COLOR");
        command.envs(no_color.map(|value| ("NO_COLOR", value)));
        text(&said(&mut command).stderr).contains('\u{1b}')
    };
    assert!(has_colours(&["check", "--color", "always"], None));
    assert!(has_colours(&["--color=always", "check"], Some("1")), "an option is stronger than the environment");
    assert!(!has_colours(&["check", "--color", "never"], None));
    assert!(!has_colours(&["check"], None), "no terminal is there");
}
