// SPDX-License-Identifier: Apache-2.0
//! `lfz run` on a terminal, which sends its signals to the process group that reads from it.

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use lf_federations::{Lfz, Participant, Run, programs, wait_for_ends};
use rustix::process::Signal;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// A run whose standard input is a terminal, from which it can be interrupted.
struct OnTerminal {
    run: Run,
    keyboard: File,
    /// All processes of the run except for the one that waits for `lfz`.
    processes: Vec<Participant>,
}

/// Starts a program that prints `words` when all of it runs.
fn start(test: &str, program: &str, arguments: &[&str], words: &[&str]) -> OnTerminal {
    let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("there is a terminal");
    grantpt(&controller).and_then(|()| unlockpt(&controller)).expect("it can be used");
    let name = ptsname(&controller, Vec::new()).expect("it has a name").into_string().expect("that is text");
    let file: PathBuf = programs().join(program);
    let run = Lfz::run_command(test, &file, arguments);
    let mut command = Command::new("sh");
    // `setsid` makes the terminal that of a new session, and becomes `lfz`.
    command.args([
        "-c",
        "terminal=$1; shift; exec env --default-signal setsid --ctty \"$@\" < \"$terminal\"",
        "sh",
        &name,
    ]);
    command.arg(run.get_program()).args(run.get_args()).current_dir(run.get_current_dir().expect("it is given"));
    for (name, value) in run.get_envs() {
        command.env(name, value.expect("none is taken away"));
    }
    command.stdin(Stdio::null());
    let mut run = Run::start(command);
    for words in words {
        run.wait_for(words);
    }
    let processes = run.participants();
    OnTerminal { run, keyboard: File::from(controller), processes }
}

impl OnTerminal {
    fn types(&mut self, key: u8) {
        self.keyboard.write_all(&[key]).expect("the terminal takes it");
    }

    /// Returns the status, once no process is left.
    fn end(self) -> i32 {
        let finished = self.run.finish();
        println!("{finished}");
        wait_for_ends(&self.processes);
        finished.code()
    }
}

/// With one process, the program is in the process group of the terminal; federates are not. All processes that they
/// have started end with them.
#[test]
fn nothing_is_left_of_a_run_on_a_terminal_however_it_ends() {
    let kinds = [("Descendant.lf", &["both run"][..]), ("Endless.lf", &["the source runs", "the sink runs"])];
    for (program, words) in kinds {
        let start = |arguments: &[&str]| start(&format!("terminal_{program}"), program, arguments, words);
        for (key, status) in [(3, 130), (28, 131)] {
            let mut run = start(&[]);
            run.types(key);
            assert_eq!(run.end(), status, "{program}, {key}");
        }
        for (signal, status) in [(Signal::TERM, 143), (Signal::KILL, 137)] {
            let run = start(&[]);
            run.run.signal(signal);
            assert_eq!(run.end(), status, "{program}, {signal:?}");
        }
        assert_eq!(start(&["--timeout", "5 s"]).end(), 124, "{program}");
    }
}
