// SPDX-License-Identifier: Apache-2.0
//! The commands of an RTI: lines of its standard input, which a thread reads, because files need not be pollable.

use std::io::{self, BufRead};
use std::sync::mpsc::{self, Receiver};
use std::thread;

use lf_coordination::FederateId;

use crate::wake::WakeUp;

/// A command to the RTI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RtiCommand {
    /// `stop FEDERATE`: tell the transient federate with this id to leave.
    Stop(FederateId),
}

impl RtiCommand {
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        match (words.next(), words.next(), words.next()) {
            (Some("stop"), Some(id), None) => Some(Self::Stop(FederateId(id.parse().ok()?))),
            _ => None,
        }
    }
}

/// The commands that come from standard input. Its end is no error: no more of them come then.
#[derive(Debug)]
pub(crate) struct RtiCommands(Receiver<RtiCommand>);

impl RtiCommands {
    /// Reads standard input from now on.
    ///
    /// # Errors
    /// When the system has no thread left.
    pub(crate) fn of_standard_input() -> io::Result<Self> {
        let (sender, receiver) = mpsc::channel();
        thread::Builder::new().name("commands".to_owned()).spawn(move || {
            for line in io::stdin().lock().lines() {
                let Ok(line) = line else { return };
                let Some(command) = RtiCommand::parse(&line) else {
                    log::warn!("\"{line}\" is no command; there is `stop FEDERATE`, with the id of a federate");
                    continue;
                };
                if sender.send(command).is_err() {
                    return;
                }
                WakeUp::wake_program();
            }
        })?;
        Ok(Self(receiver))
    }

    /// Returns the commands that have come since the last call.
    pub(crate) fn pending(&self) -> impl Iterator<Item = RtiCommand> + '_ {
        self.0.try_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_commands_count() {
        assert_eq!(RtiCommand::parse("stop 3"), Some(RtiCommand::Stop(FederateId(3))));
        for line in ["", "stop", "stop 3 4", "stop filter", "stop 65536", "start 3"] {
            assert_eq!(RtiCommand::parse(line), None, "{line}");
        }
    }
}
