// SPDX-License-Identifier: Apache-2.0
//! A process whose output is read while it runs.

use std::fmt;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;

use rustix::process::{Pid, Signal, kill_process};

use crate::TIME_OUT;
use crate::processes::{self, Participant};

static RUNS: AtomicU32 = AtomicU32::new(0);

/// A started process, killed on drop.
pub struct Run {
    child: Child,
    lines: Receiver<String>,
    seen: Vec<String>,
    /// The mark of this process and all its descendants in their environment.
    mark: String,
}

/// The results of a process.
pub struct Finished {
    /// The exit status.
    pub status: ExitStatus,
    /// All lines of both outputs, in the order of arrival.
    pub lines: Vec<String>,
}

impl Run {
    /// Starts a command, without input.
    ///
    /// # Panics
    /// When it cannot be started.
    pub fn start(mut command: Command) -> Self {
        let mark = format!("{}-{}", std::process::id(), RUNS.fetch_add(1, Ordering::Relaxed));
        command.env(processes::MARK, &mark).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let (sender, lines) = channel();
        read(child.stdout.take(), sender.clone());
        read(child.stderr.take(), sender);
        Self { child, lines, seen: Vec::new(), mark }
    }

    /// Waits for a line that contains this text, and returns it; an earlier line counts, too.
    ///
    /// # Panics
    /// When the process ends its output first.
    pub fn wait_for(&mut self, text: &str) -> String {
        let is_it = |line: &str| line.contains(text) && !is_of_build(line);
        if let Some(line) = self.seen.iter().find(|line| is_it(line)) {
            return line.clone();
        }
        loop {
            match self.next() {
                Some(line) if is_it(&line) => return line,
                Some(_) => {}
                None => panic!("the output has ended without `{text}`:\n{}", self.seen.join("\n")),
            }
        }
    }

    /// Waits for the end of the process and of its output.
    ///
    /// # Panics
    /// When it does not end.
    pub fn finish(mut self) -> Finished {
        while self.next().is_some() {}
        let status = self.child.wait().expect("it is a child of this process");
        Finished { status, lines: std::mem::take(&mut self.seen) }
    }

    /// Waits for its end, which has to be successful.
    ///
    /// # Panics
    /// When it does not end, or with an error.
    #[track_caller]
    pub fn succeed(self) -> Finished {
        let finished = self.finish();
        assert_eq!(finished.code(), 0, "{finished}");
        finished
    }

    /// Returns the number of the process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends it a signal.
    ///
    /// # Panics
    /// When it has ended.
    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).expect("it still runs");
    }

    /// Returns the running processes that this one has started, directly or not.
    pub fn participants(&self) -> Vec<Participant> {
        processes::marked(&self.mark, self.child.id())
    }

    /// Returns the maximum number of bytes of memory that it has reserved, whether it has touched them or not.
    ///
    /// # Panics
    /// When it has ended.
    pub fn memory_bytes_max(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).expect("it still runs");
        let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:")).expect("it has memory");
        let kilobytes = line.split_whitespace().next().and_then(|number| number.parse::<u64>().ok());
        1024 * kilobytes.expect("the line has a number")
    }

    fn next(&mut self) -> Option<String> {
        match self.lines.recv_timeout(TIME_OUT) {
            Ok(line) => {
                self.seen.push(line.clone());
                Some(line)
            }
            Err(RecvTimeoutError::Disconnected) => None,
            Err(RecvTimeoutError::Timeout) => {
                panic!("nothing has come for a long time after\n{}", self.seen.join("\n"))
            }
        }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        // An error means that it has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Finished {
    /// Returns the exit status, 128 + n for signal n.
    pub fn code(&self) -> i32 {
        self.status.code().or_else(|| self.status.signal().map(|signal| 128 + signal)).unwrap_or(-1)
    }

    /// Returns the line that contains all of these texts.
    ///
    /// # Panics
    /// When there is none.
    pub fn line(&self, texts: &[&str]) -> &str {
        let line = self.lines.iter().find(|line| texts.iter().all(|text| line.contains(text)));
        line.unwrap_or_else(|| panic!("no line with {texts:?} in\n{self}"))
    }

    /// Returns the lines of one participant, without its name.
    pub fn of<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a str> {
        let lines = self.lines.iter().filter_map(|line| line.split_once(" | "));
        lines.filter(move |(prefix, _)| prefix.trim_end() == name).map(|(_, text)| text)
    }

    /// Returns the output of each federate, one federate after the other. Messages of a federate about the federation
    /// are no result of the program, except for warnings.
    pub fn trace(&self) -> String {
        let lines = self.lines.iter().filter_map(|line| line.split_once(" | "));
        let mut lines: Vec<(&str, &str)> = lines
            .map(|(name, text)| (name.trim_end(), text))
            .filter(|(name, text)| is_name(name) && *name != "RTI" && !text.starts_with("info: "))
            .collect();
        lines.sort_by_key(|(name, _)| *name);
        let lines: Vec<String> = lines.iter().map(|(name, text)| format!("{name}: {text}")).collect();
        if lines.is_empty() { "nothing".to_owned() } else { lines.join("\n") }
    }
}

impl fmt::Display for Finished {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.status)?;
        f.write_str(&self.lines.join("\n"))
    }
}

fn read(stream: Option<impl Read + Send + 'static>, lines: Sender<String>) {
    let Some(stream) = stream else { return };
    thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            // The test may be over.
            if lines.send(line).is_err() {
                return;
            }
        }
    });
}

/// Returns whether a participant can have this name; the compiler's excerpts of a program have numbers in its place.
fn is_name(name: &str) -> bool {
    name.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// Returns whether a line comes from a build by `lfz` and cargo. Such lines depend on earlier and concurrent builds, so
/// no test expects them.
pub fn is_of_build(line: &str) -> bool {
    ["Compil", "Waiting until", "Blocking waiting"].iter().any(|begin| line.trim_start().starts_with(begin))
}
