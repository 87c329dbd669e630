// SPDX-License-Identifier: Apache-2.0
//! Signals to this program, as descriptors that the supervisor's loop can wait for.

use std::io::{self, Read};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP};

/// The number that stands for a new version of the program instead of a signal: no signal has it.
pub(crate) const NEW_VERSION: u8 = 0;

/// The signals that concern all participants, too.
pub(crate) struct Interrupts {
    sources: Vec<(u8, UnixStream)>,
}

impl Interrupts {
    /// Takes over SIGINT (^C), SIGTERM, SIGQUIT (^\\), SIGHUP and SIGTSTP (^Z) from now on; of the last three those
    /// that are not ignored, as SIGHUP is under `nohup`.
    ///
    /// # Errors
    /// When the system has no descriptors left.
    pub(crate) fn of_this_process() -> io::Result<Self> {
        let mut sources = Vec::new();
        let ignored = ignored();
        let may_be_ignored = |signal| [SIGQUIT, SIGHUP, SIGTSTP].contains(&signal);
        for signal in [SIGINT, SIGTERM, SIGQUIT, SIGHUP, SIGTSTP] {
            if may_be_ignored(signal) && ignored >> (signal - 1) & 1 == 1 {
                continue;
            }
            let (read, write) = UnixStream::pair()?;
            read.set_nonblocking(true)?;
            signal_hook::low_level::pipe::register(signal, write)?;
            // All of them are below 32 on every system.
            sources.push((u8::try_from(signal).unwrap_or(u8::MAX), read));
        }
        Ok(Self { sources })
    }

    /// Adds a stream, each byte of which says that there is a new version of the program.
    ///
    /// # Errors
    /// When the stream cannot be set up.
    pub(crate) fn with_versions(mut self, stream: UnixStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        self.sources.push((NEW_VERSION, stream));
        Ok(self)
    }

    /// Returns the same signals for another run. Each signal reaches one of them.
    ///
    /// # Errors
    /// When the system has no descriptors left.
    pub(crate) fn again(&self) -> io::Result<Self> {
        let sources = self.sources.iter().map(|(signal, stream)| Ok((*signal, stream.try_clone()?)));
        Ok(Self { sources: sources.collect::<io::Result<_>>()? })
    }

    /// Waits for a signal that does not ask to stop for a while only.
    ///
    /// # Errors
    /// When the system's call fails.
    pub(crate) fn wait(&self) -> io::Result<u8> {
        let mut again = self.again()?;
        loop {
            let signals = again.take();
            if let Some(signal) = signals.iter().find(|signal| !Self::is_suspension(**signal)) {
                return Ok(*signal);
            }
            if !signals.is_empty() {
                Self::suspend();
            }
            let mut descriptors: Vec<_> =
                again.descriptors().map(|descriptor| PollFd::from_borrowed_fd(descriptor, PollFlags::IN)).collect();
            match poll(&mut descriptors, None) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Returns whether a signal asks to stop for a while.
    pub(super) fn is_suspension(signal: u8) -> bool {
        i32::from(signal) == SIGTSTP
    }

    /// Stops this process, and returns when it is continued, as by the shell's `fg`.
    pub(super) fn suspend() {
        // An error means that it goes on at once.
        let _ = signal_hook::low_level::emulate_default_handler(SIGTSTP);
    }

    /// Returns only signals that a test makes: each byte written to the other end is one.
    #[cfg(test)]
    pub(super) fn of_stream(signal: u8, stream: UnixStream) -> Self {
        stream.set_nonblocking(true).expect("a fresh socket can be set up");
        Self { sources: vec![(signal, stream)] }
    }

    /// Returns the descriptors to wait for.
    pub(super) fn descriptors(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        self.sources.iter().map(|(_, stream)| stream.as_fd())
    }

    /// Returns the signals since the last call, each once.
    pub(super) fn take(&mut self) -> Vec<u8> {
        let mut taken = Vec::new();
        for (signal, stream) in &mut self.sources {
            let mut bytes = [0; 64];
            if matches!(stream.read(&mut bytes), Ok(length) if length > 0) {
                taken.push(*signal);
            }
        }
        taken
    }
}

/// Returns the signals that this program was started to ignore, as the kernel reports them: one bit per signal, the
/// lowest is 1.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or_default()
}
