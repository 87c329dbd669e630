// SPDX-License-Identifier: Apache-2.0
//! Ends the descendants of a run's processes, however the run ends.
//!
//! Beside a run there is another process, which waits for the end of this one, and then ends all processes whose
//! environment contains the mark of the run.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Read};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};

use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};

use crate::guard::THIS_PROGRAM;

/// The variable that marks the processes of a run.
const MARK: &str = "LFZ_RUN";

/// Ends the processes that a run leaves behind, when it is dropped, and however this program ends.
#[derive(Debug)]
pub(crate) struct Descendants {
    mark: String,
    /// Waits for the end of its standard input, which only this program keeps open.
    watcher: Child,
}

impl Descendants {
    /// Starts to watch over the processes of the run with this mark.
    ///
    /// # Errors
    /// When the system has no processes or descriptors left.
    pub(crate) fn of_run(mark: String) -> io::Result<Self> {
        let mut command = Command::new(THIS_PROGRAM);
        // Neither signals of the terminal nor those to all marked processes are for the watcher.
        command.arg0("lfz").args(["end-descendants", &mark]).env_clear().process_group(0);
        let watcher = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
        Ok(Self { mark, watcher })
    }

    /// Returns the variable that marks a process, and with it all that it will start.
    pub(crate) fn mark(&self) -> (&'static str, &str) {
        (MARK, &self.mark)
    }
}

impl Drop for Descendants {
    fn drop(&mut self) {
        drop(self.watcher.stdin.take());
        // An error means that it is gone already.
        let _ = self.watcher.wait();
    }
}

/// Waits until the process that holds the other end of the standard input has ended, and ends all processes with the
/// mark.
///
/// # Errors
/// When there is no `/proc` to find processes in.
pub(crate) fn end(mark: &str) -> io::Result<()> {
    // The result does not matter: an error is an end, too.
    let _ = io::stdin().read_to_end(&mut Vec::new());
    let variable = format!("{MARK}={mark}");
    let mut ended = BTreeSet::new();
    // Processes that start others meanwhile are ended, so that each round finds fewer that can.
    loop {
        let found = marked(&variable)?.into_iter().filter(|pid| ended.insert(*pid)).count();
        if found == 0 {
            return Ok(());
        }
    }
}

/// Kills the processes that have this variable, and returns their ids.
fn marked(variable: &str) -> io::Result<Vec<i32>> {
    let mut all = Vec::new();
    for entry in fs::read_dir("/proc")? {
        let Some(id) = entry?.file_name().to_str().and_then(|name| name.parse::<i32>().ok()) else { continue };
        // The descriptor stays with the process even if another one gets its id.
        let Some(process) = Pid::from_raw(id).and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok()) else {
            continue;
        };
        let environment = fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
        if environment.split(|byte| *byte == 0).any(|found| found == variable.as_bytes())
            && pidfd_send_signal(process, Signal::KILL).is_ok()
        {
            all.push(id);
        }
    }
    Ok(all)
}
