// SPDX-License-Identifier: Apache-2.0
//! Descendants of participants do not outlive a run, and stop and go on with it.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::thread;

use rustix::process::{Pid, Signal, WaitOptions, kill_process, waitpid};

/// A run of one participant that holds a pipe open, as do all processes that it starts.
struct Running {
    lfz: Child,
    pipe: BufReader<File>,
    _folder: tempfile::TempDir,
}

/// Starts a run of a shell.
fn start(script: &str) -> Running {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let made = Command::new("mkfifo").current_dir(folder.path()).arg("pipe").status();
    assert!(made.expect("mkfifo can be started").success());
    let description = format!(
        r#"{{ "version": 1, "id": {{ "exactly": "f" }},
            "federates": [{{ "name": "a", "words": ["sh", "-c", "exec 3>pipe; {script}"] }}] }}"#
    );
    fs::write(folder.path().join("run.json"), description).expect("there is room");
    // Shells and `nohup` let their processes ignore some of the signals.
    let mut command = Command::new("env");
    command.current_dir(folder.path()).args(["--default-signal", env!("CARGO_BIN_EXE_lfz"), "supervise", "run.json"]);
    let lfz = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let pipe = BufReader::new(File::open(folder.path().join("pipe")).expect("it is there"));
    Running { lfz: lfz.expect("lfz can be started"), pipe, _folder: folder }
}

impl Running {
    fn line(&mut self) -> String {
        let mut line = String::new();
        self.pipe.read_line(&mut line).expect("it is text");
        line.trim().to_owned()
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.lfz), signal).expect("it still runs");
    }

    /// Returns the status of `lfz`, once the last process that holds the pipe open has ended.
    fn end(mut self) -> i32 {
        self.pipe.read_to_end(&mut Vec::new()).expect("it can be read");
        let status = self.lfz.wait().expect("it is a child of this process");
        status.code().or_else(|| status.signal().map(|signal| 128 + signal)).expect("it has ended")
    }
}

/// A process in the participant's process group, and one that has left its session and its parents.
const DESCENDANTS: &str = "(setsid sleep 1000 &); sleep 1000 & echo started >&3";

#[test]
fn processes_of_participants_end_with_the_run_however_it_ends() {
    for (script, signal, status) in [
        ("exit 0", None, 0),
        ("exit 3", None, 3),
        ("wait", Some(Signal::INT), 130),
        ("wait", Some(Signal::TERM), 143),
        ("wait", Some(Signal::QUIT), 131),
        ("wait", Some(Signal::HUP), 129),
        ("wait", Some(Signal::KILL), 137),
    ] {
        let mut run = start(&format!("{DESCENDANTS}; {script}"));
        assert_eq!(run.line(), "started");
        if let Some(signal) = signal {
            run.signal(signal);
        }
        assert_eq!(run.end(), status, "{script} {signal:?}");
    }
}

/// Returns the state of a process: `T` for a stopped one.
fn state(process: &str) -> Option<char> {
    let text = fs::read_to_string(format!("/proc/{process}/stat")).expect("it is there");
    text.rsplit(") ").next()?.chars().next()
}

/// Participants are in process groups that the terminal does not know.
#[test]
fn participants_stop_and_go_on_with_lfz() {
    let mut run = start("echo $$ >&3; exec sleep 1000");
    let participant = run.line();
    run.signal(Signal::TSTP);
    let (_, status) = waitpid(Some(Pid::from_child(&run.lfz)), WaitOptions::UNTRACED)
        .expect("it is a child of this process")
        .expect("that waits");
    assert!(status.stopped());
    while state(&participant) != Some('T') {
        thread::yield_now();
    }
    run.signal(Signal::CONT);
    while state(&participant) == Some('T') {
        thread::yield_now();
    }
    run.signal(Signal::INT);
    assert_eq!(run.end(), 130);
}
