// SPDX-License-Identifier: Apache-2.0
//! The processes of a run, found by a mark in their environment.

use std::fs;
use std::os::fd::OwnedFd;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};

use crate::TIME_OUT;

/// The variable that marks the processes of a run.
pub(crate) const MARK: &str = "LF_FEDERATIONS_RUN";

/// A process of a run that another process started.
pub struct Participant {
    pid: Pid,
    /// A descriptor that is readable when it has ended; it names this process even when its id is used again.
    end: OwnedFd,
    /// Its command line, with blanks between the arguments.
    pub command: String,
}

impl Participant {
    /// Kills it, as a crash or a careless user would.
    ///
    /// # Panics
    /// When it has ended already.
    pub fn kill(&self) {
        self.signal(Signal::KILL);
    }

    /// Sends it a signal.
    ///
    /// # Panics
    /// When it has ended already.
    pub fn signal(&self, signal: Signal) {
        kill_process(self.pid, signal).expect("it still runs");
    }
}

/// Returns the running processes with a mark, except for the first one.
pub(crate) fn marked(mark: &str, except: u32) -> Vec<Participant> {
    let entry = format!("{MARK}={mark}");
    let ids = fs::read_dir("/proc").into_iter().flatten().flatten().filter_map(|entry| {
        entry.file_name().to_str().and_then(|name| name.parse::<u32>().ok()).filter(|id| *id != except)
    });
    ids.filter_map(|id| {
        // A process may end while it is inspected.
        let environment = fs::read(format!("/proc/{id}/environ")).ok()?;
        environment.split(|byte| *byte == 0).find(|variable| *variable == entry.as_bytes())?;
        let command = fs::read(format!("/proc/{id}/cmdline")).ok()?;
        let command = String::from_utf8_lossy(&command).replace('\0', " ").trim_end().to_owned();
        let pid = Pid::from_raw(i32::try_from(id).ok()?)?;
        Some(Participant { pid, end: pidfd_open(pid, PidfdFlags::empty()).ok()?, command })
    })
    .collect()
}

/// Waits until all of these processes have ended.
///
/// # Panics
/// When one does not end.
pub fn wait_for_ends(participants: &[Participant]) {
    let time_out = Timespec::try_from(TIME_OUT).expect("it is a few minutes");
    for participant in participants {
        let mut ends = [PollFd::new(&participant.end, PollFlags::IN)];
        let ended = poll(&mut ends, Some(&time_out)).expect("a pidfd can be waited for");
        assert_eq!(ended, 1, "{} still runs", participant.command);
    }
}
