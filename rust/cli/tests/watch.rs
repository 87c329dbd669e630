// SPDX-License-Identifier: Apache-2.0
//! `lfz run --watch` while the program is edited.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

use crate::support::{folder, lfz};

fn program(properties: &str, text: &str) -> String {
    let body = format!("println!(\"{text}\");");
    format!("target Rust {{ {properties} }}\nmain reactor {{\n  timer t(0, 20 ms)\n  reaction(t) {{= {body} =}}\n}}\n")
}

/// Returns the lines of a stream as they come.
fn lines(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let lines = BufReader::new(stream).lines().map_while(Result::ok);
        lines.for_each(|line| {
            let _ = sender.send(line);
        });
    });
    receiver
}

/// Waits for a line that contains a text.
fn wait_for(lines: &Receiver<String>, text: &str) {
    let mut seen = Vec::new();
    loop {
        let line = lines.recv_timeout(Duration::from_secs(300));
        let line = line.unwrap_or_else(|error| panic!("no line has `{text}` ({error}): {seen:#?}"));
        if line.contains(text) {
            return;
        }
        seen.push(line);
    }
}

#[test]
fn a_program_is_started_again_when_it_has_changed_and_goes_on_beside_errors() {
    let folder = folder(&[("P.lf", &program("", "one"))]);
    let path = folder.path().join("P.lf");
    let mut command = lfz(folder.path(), &["run", "--watch"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("lfz can be started");
    let output = lines(child.stdout.take().expect("it is a pipe"));
    let errors = lines(child.stderr.take().expect("it is a pipe"));
    wait_for(&output, "one");
    fs::write(&path, program("", "wrong").replace("reaction(t)", "reaction(u)")).expect("it can be written");
    wait_for(&errors, "P.lf has changed");
    wait_for(&errors, "error");
    wait_for(&errors, "nothing is started before the next change");
    // Those lines that came before the error are no evidence.
    let _ = output.try_iter().count();
    wait_for(&output, "one");
    fs::write(&path, program("timeout: 20 ms", "two")).expect("it can be written");
    wait_for(&output, "two");
    wait_for(&errors, "P.lf has ended with status 0; waiting for a change");
    // Editors replace the file by a new one.
    fs::write(folder.path().join("new"), program("", "three")).expect("it can be written");
    fs::rename(folder.path().join("new"), &path).expect("it is in the same folder");
    wait_for(&output, "three");
    let id = Pid::from_raw(i32::try_from(child.id()).expect("process ids are small")).expect("it is not 0");
    kill_process(id, Signal::INT).expect("it runs");
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
}
