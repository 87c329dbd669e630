// SPDX-License-Identifier: Apache-2.0
//! One participant's process: its group, its output, its end.

use std::io::{self, ErrorKind, IsTerminal, Read, Write};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child as Process, ChildStderr, ChildStdout, Command, ExitStatus, Stdio};

use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, kill_process_group, pidfd_open};
use serde::Deserialize;

use super::output::Stream;

/// The size of the pieces of an endless line, in bytes, so that it does not accumulate in memory.
const LINE_LENGTH_MAX: usize = 64 * 1024;

/// The role of a participant, which decides whether the run waits for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// A part of the program.
    Federate,
    /// A part of the program that may come and go: its end does not end the run.
    Transient,
    /// An RTI serves the federates, and is expected to end soon after the last one has.
    Rti,
}

/// The input of a participant, and the form of its output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Streams {
    /// It reads nothing; its lines are shown as they become whole, so that those of several do not mix.
    #[default]
    Lines,
    /// It reads this program's input, and its output is shown at once, including a question that ends no line.
    Own,
    /// It is an RTI, which reads commands of this program; its lines are shown as they become whole.
    Commands,
}

/// A started process.
pub(super) struct Child {
    pub(super) name: String,
    pub(super) role: Role,
    process: Process,
    /// `None` once the process has been reaped, and its id may belong to another.
    running: Option<Running>,
    standard: Option<Lines<ChildStdout>>,
    error: Option<Lines<ChildStderr>>,
    /// For a simulator: the text before the status of the program in it.
    status_line: Option<String>,
    /// Whether that line has arrived. The process counts as ended then, but runs until all others have ended too, as a
    /// board would: it may still have to tell its peers that it closes its connections.
    has_told: bool,
    /// Whether the user has asked it to leave.
    pub(super) was_asked: bool,
    /// The index of its place, among those of its launch.
    pub(super) place: usize,
    /// The id by which the RTI tells it to leave, for an image, which understands no signal.
    pub(super) image_id: Option<u16>,
    streams: Streams,
}

struct Running {
    pid: Pid,
    /// Whether it is in a process group of its own.
    has_group: bool,
    /// A descriptor that is readable when the process has ended.
    end: OwnedFd,
}

/// The end of a process.
pub(super) struct End {
    pub(super) success: bool,
    /// 128 + n for signal n.
    pub(super) exit_code: u8,
    /// The description of the end, after its name: `ended with exit status 3`.
    pub(super) how: String,
}

impl Child {
    pub(super) fn start(
        name: &str,
        role: Role,
        status_line: Option<&str>,
        streams: Streams,
        command: &mut Command,
    ) -> io::Result<Self> {
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.stdin(match streams {
            Streams::Lines => Stdio::null(),
            Streams::Own => Stdio::inherit(),
            Streams::Commands => Stdio::piped(),
        });
        // A terminal lets only one group read, and sends that one ^C and ^Z; the shell has chosen this program's.
        let has_group = streams != Streams::Own || !io::stdin().is_terminal();
        if has_group {
            command.process_group(0);
        }
        let mut process = command.spawn()?;
        let pid = Pid::from_child(&process);
        let end = match pidfd_open(pid, PidfdFlags::empty()) {
            Ok(end) => end,
            Err(error) => {
                process.kill()?;
                process.wait()?;
                return Err(error.into());
            }
        };
        let standard = process.stdout.take().map(Lines::new).transpose()?;
        let error = process.stderr.take().map(Lines::new).transpose()?;
        let running = Some(Running { pid, has_group, end });
        let (name, status_line) = (name.to_owned(), status_line.map(str::to_owned));
        Ok(Self {
            name,
            role,
            process,
            running,
            standard,
            error,
            status_line,
            has_told: false,
            was_asked: false,
            place: 0,
            image_id: None,
            streams,
        })
    }

    /// Returns whether the run waits for it.
    pub(super) fn is_running(&self) -> bool {
        self.is_there() && !self.has_told
    }

    /// Returns whether a line of its output has announced its end.
    pub(super) fn has_told(&self) -> bool {
        self.has_told
    }

    /// Writes a command for this participant. Returns `false` if it takes none, or has ended.
    pub(super) fn command(&mut self, line: &str) -> bool {
        self.process.stdin.as_mut().is_some_and(|input| writeln!(input, "{line}").is_ok())
    }

    /// Returns whether there is a process.
    pub(super) fn is_there(&self) -> bool {
        self.running.is_some()
    }

    /// Returns the end of the program in a simulator, if this is the first line of its output that contains it.
    pub(super) fn told(&mut self, line: &[u8]) -> Option<End> {
        let before = self.status_line.as_ref().filter(|_| !self.has_told)?;
        let line = str::from_utf8(line).ok()?;
        let code = line.strip_prefix(before.as_str())?.parse().ok()?;
        self.has_told = true;
        Some(End::with_status(code))
    }

    /// Returns the descriptors to wait for: the end (`None`) and the output.
    pub(super) fn descriptors(&self) -> impl Iterator<Item = (Option<Stream>, BorrowedFd<'_>)> {
        let end = self.running.iter().map(|running| (None, running.end.as_fd()));
        let standard = self.standard.iter().map(|lines| (Some(Stream::Standard), lines.source.as_fd()));
        let error = self.error.iter().map(|lines| (Some(Stream::Error), lines.source.as_fd()));
        end.chain(standard).chain(error)
    }

    /// Returns whether its output is shown at once.
    pub(super) fn is_shown_as_it_comes(&self) -> bool {
        self.streams == Streams::Own
    }

    /// Returns the available bytes.
    pub(super) fn read_bytes(&mut self, stream: Stream) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut keep = |read: &[u8]| {
            bytes.extend_from_slice(read);
            bytes.len() >= LINE_LENGTH_MAX
        };
        let ended = match stream {
            Stream::Standard => read(self.standard.as_mut().map(|lines| &mut lines.source), &mut keep)?,
            Stream::Error => read(self.error.as_mut().map(|lines| &mut lines.source), &mut keep)?,
        };
        if ended {
            self.close(stream);
        }
        Ok(bytes)
    }

    /// Returns the available whole lines; at the end of the stream also the one that is not whole.
    pub(super) fn read(&mut self, stream: Stream) -> io::Result<Vec<Vec<u8>>> {
        let (lines, ended) = match stream {
            Stream::Standard => read_lines(&mut self.standard)?,
            Stream::Error => read_lines(&mut self.error)?,
        };
        if ended && let Some(rest) = self.close(stream) {
            return Ok(lines.into_iter().chain([rest]).collect());
        }
        Ok(lines)
    }

    /// Closes a stream and returns the line that was not whole. By then, everything that the process itself has written
    /// has been read; a descendant that keeps the stream open is not awaited.
    pub(super) fn close(&mut self, stream: Stream) -> Option<Vec<u8>> {
        let rest = match stream {
            Stream::Standard => self.standard.take()?.partial,
            Stream::Error => self.error.take()?.partial,
        };
        (!rest.is_empty()).then_some(rest)
    }

    /// Signals the process group, or the process if it has none. An error means that there is no process left.
    pub(super) fn signal(&self, signal: Signal) {
        if let Some(Running { pid, has_group, .. }) = self.running {
            let _ = if has_group { kill_process_group(pid, signal) } else { kill_process(pid, signal) };
        }
    }

    /// Ends the rest of the process group, and waits for the process, which ends with it if it has not before.
    pub(super) fn reap(&mut self) -> io::Result<End> {
        // Until it is reaped the process keeps its id, so that the group is its own.
        self.signal(Signal::KILL);
        let status = self.process.wait()?;
        self.running = None;
        if self.status_line.is_some() && status.success() {
            return Ok(End { success: false, exit_code: 1, how: "ended before the program in it".to_owned() });
        }
        Ok(End::new(status))
    }
}

impl End {
    fn new(status: ExitStatus) -> Self {
        let Some(signal) = status.signal().and_then(|number| u8::try_from(number).ok()) else {
            return Self::with_status(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1));
        };
        let name = signal_hook::low_level::signal_name(i32::from(signal)).unwrap_or("unnamed");
        let how = format!("was ended by signal {signal} ({name})");
        Self { success: false, exit_code: signal.saturating_add(128), how }
    }

    fn with_status(code: u8) -> Self {
        Self { success: code == 0, exit_code: code, how: format!("ended with exit status {code}") }
    }
}

/// A stream that is cut into lines.
struct Lines<S> {
    source: S,
    partial: Vec<u8>,
}

impl<S: Read + AsFd> Lines<S> {
    fn new(source: S) -> io::Result<Self> {
        let flags = fcntl_getfl(&source)?;
        fcntl_setfl(&source, flags | OFlags::NONBLOCK)?;
        Ok(Self { source, partial: Vec::new() })
    }
}

/// Reads until no more bytes are available, or `take` has enough; returns whether the stream has ended.
fn read(source: Option<&mut impl Read>, take: &mut dyn FnMut(&[u8]) -> bool) -> io::Result<bool> {
    let Some(source) = source else { return Ok(false) };
    let mut buffer = [0; 16 * 1024];
    loop {
        match source.read(&mut buffer) {
            Ok(0) => return Ok(true),
            Ok(length) if take(&buffer[..length]) => return Ok(false),
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(false),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// Returns the available whole lines, and whether the stream has ended.
fn read_lines<S: Read + AsFd>(lines: &mut Option<Lines<S>>) -> io::Result<(Vec<Vec<u8>>, bool)> {
    let mut found = Vec::new();
    let Some(Lines { source, partial }) = lines else { return Ok((found, false)) };
    let ended = read(Some(source), &mut |bytes| {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            partial.extend_from_slice(piece);
            if partial.pop_if(|byte| *byte == b'\n').is_some() {
                // The consoles of boards end lines with both.
                partial.pop_if(|byte| *byte == b'\r');
                found.push(std::mem::take(partial));
            } else if partial.len() >= LINE_LENGTH_MAX {
                found.push(std::mem::take(partial));
            }
        }
        // A participant that never stops writing must not block the output of the others.
        found.len() >= 1024
    })?;
    Ok((found, ended))
}
