// SPDX-License-Identifier: Apache-2.0
//! The programs that `lfz new` makes: they run, pass their tests, and are formatted.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::{folder, said, text};

fn lfz(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder).args(arguments).env("CARGO_NET_OFFLINE", "true");
    said(command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0"))
}

#[test]
fn new_programs_run_and_pass_their_tests() {
    let parent = folder(&[]);
    for (name, options, program) in [
        ("my-first program", &[][..], "MyFirstProgram"),
        ("plant", &["--target", "c", "--federated", "--board", "qemu_cortex_m3"], "Plant"),
    ] {
        let made = lfz(parent.path(), &[&["new", name][..], options].concat());
        let folder = parent.path().join(name);
        assert!(text(&made.stdout).starts_with(&format!("{name} is there.")), "{}", text(&made.stderr));
        let file = format!("src/{program}.lf");
        let formatted = lfz(&folder, &["fmt", "--check", &file, "src/lib/Mean.lf"]);
        assert!(formatted.status.success(), "{}", text(&formatted.stdout));
        let run = lfz(&folder, &["run", &file]);
        let all = text(&run.stdout);
        for line in ["0 ms: 5", "250 ms: 15", "1000 ms: 45"] {
            assert!(all.lines().any(|printed| printed.ends_with(line)), "{line}: {all}{}", text(&run.stderr));
        }
        // The steps of the workflow, with this lfz.
        let workflow = fs::read_to_string(folder.join(".github/workflows/test.yml")).expect("it is made");
        let steps: Vec<_> = workflow.lines().filter_map(|line| line.trim().strip_prefix("- run: lfz ")).collect();
        assert_eq!(steps.len(), 3, "{workflow}");
        for step in steps {
            let mut shell = Command::new("sh");
            shell.current_dir(&folder).args(["-ec", &format!("\"$LFZ\" {step}")]).env("LFZ", env!("CARGO_BIN_EXE_lfz"));
            let done = said(shell.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0"));
            assert!(done.status.success(), "{step}: {}{}", text(&done.stdout), text(&done.stderr));
        }
    }

    for (name, expected) in [
        ("plant", "error: plant exists already\n"),
        ("7", "error: a program cannot be named after 7: choose a name of letters and digits\n"),
        ("a/b/c", "error: a/b/c cannot be made: No such file or directory (os error 2)\n"),
    ] {
        assert_eq!(text(&lfz(parent.path(), &["new", name]).stderr), expected);
    }
    let refused = lfz(parent.path(), &["new", "other", "--board", "my board"]);
    let expected = "error: \"my board\" is no name of a board, such as native_sim/native/64\n";
    assert_eq!(text(&refused.stderr), expected);
    assert!(!parent.path().join("other").exists());
}
