// SPDX-License-Identifier: Apache-2.0
//! Participants that can be started again: those that the user starts, stops and swaps while the others run.

use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use rustix::process::Signal;

use super::Supervisor;
use super::child::{Child, Role, Streams};
use crate::control::ControlRequest;
use crate::guard;

/// The pause before a participant that has failed is started again, so that one that fails at once does not take the
/// whole computer.
const RESTART_PAUSE: Duration = Duration::from_secs(1);

/// A participant that can be started.
#[derive(Clone, Debug)]
pub(crate) struct Launch {
    pub(crate) name: String,
    pub(crate) role: Role,
    /// Whether it is started again when it has failed.
    pub(crate) restarts: bool,
    /// The beginning of the line of a simulator's output that contains the program's exit status.
    pub(crate) status_line: Option<String>,
    pub(crate) streams: Streams,
    /// The program and its arguments.
    pub(crate) words: Vec<OsString>,
    /// Variables beside those of this program.
    pub(crate) environment: Vec<(OsString, OsString)>,
    pub(crate) folder: Option<PathBuf>,
}

impl Launch {
    fn command(&self) -> Command {
        let mut words = self.words.iter();
        let mut command = guard::command(words.next().cloned().unwrap_or_default());
        command.args(words).envs(self.environment.iter().map(|(name, value)| (name, value)));
        if let Some(folder) = &self.folder {
            command.current_dir(folder);
        }
        command
    }
}

impl Supervisor {
    /// Starts a participant, which can be started again when it has ended.
    ///
    /// # Errors
    /// When its program cannot be started; processes that were started earlier keep running.
    pub(crate) fn launch(&mut self, launch: Launch) -> io::Result<()> {
        self.launch_again(&launch)?;
        self.launches.push(launch);
        Ok(())
    }

    /// Records a participant that the user starts.
    pub(crate) fn leave_out(&mut self, launch: Launch) {
        self.launches.push(launch);
    }

    fn launch_again(&mut self, launch: &Launch) -> io::Result<()> {
        let Launch { name, role, status_line, streams, .. } = launch;
        self.start(name, *role, status_line.as_deref(), *streams, &mut launch.command())
    }

    /// Plans to start a participant again that has failed, if it is one for that.
    pub(super) fn plan_restart(&mut self, name: &str, now: Instant) {
        if self.launches.iter().any(|launch| launch.name == name && launch.restarts) {
            self.restarts.push((now + RESTART_PAUSE, name.to_owned()));
        }
    }

    /// Starts participants again whose time has come.
    pub(super) fn restart(&mut self, now: Instant) -> io::Result<()> {
        let (due, later) = std::mem::take(&mut self.restarts).into_iter().partition(|(at, _)| *at <= now);
        self.restarts = later;
        let due: Vec<(Instant, String)> = due;
        for (_, name) in due {
            let launch = self.launches.iter().find(|launch| launch.name == name).cloned();
            if let Some(launch) = launch.filter(|_| !self.plan.is_ending() && self.running(&name).next().is_none()) {
                self.launch_again(&launch)?;
                self.note(&format!("{name} is started again"));
            }
        }
        Ok(())
    }

    /// Serves those who control this run from another terminal.
    pub(super) fn serve_control(&mut self) {
        let Some(control) = self.control.take() else { return };
        control.serve(|request| self.controlled(&request));
        self.control = Some(control);
    }

    /// Does what a user asks for, and says what was done.
    fn controlled(&mut self, request: &ControlRequest) -> Result<String, String> {
        let (ControlRequest::Start(name) | ControlRequest::Stop(name) | ControlRequest::Swap(name)) = request else {
            return Ok(self.list());
        };
        let launch = self.launches.iter().find(|launch| launch.name == *name).cloned();
        let launch = launch.ok_or_else(|| format!("there is no federate `{name}`; this run has\n{}", self.list()))?;
        let is_transient = launch.role == Role::Transient;
        let running = self.running(name).count();
        let starts = |error: io::Error| format!("{name} cannot be started: {error}");
        match request {
            _ if self.plan.is_ending() => Err("the federation is ending".to_owned()),
            ControlRequest::Start(_) if running > 0 && is_transient => {
                Err(format!("{name} runs already; `lfz ctl swap {name}` puts another instance in its place"))
            }
            ControlRequest::Start(_) if running > 0 => Err(format!("{name} runs already")),
            ControlRequest::Start(_) => {
                self.launch_again(&launch).map_err(starts)?;
                Ok(format!("{name} is started"))
            }
            _ if !is_transient => Err(format!("{name} is not transient: only such federates leave and are swapped")),
            _ if running == 0 => Err(format!("{name} does not run; `lfz ctl start {name}` starts it")),
            ControlRequest::Swap(_) if running > 1 => Err(format!("another instance of {name} is about to begin")),
            ControlRequest::Swap(_) => {
                self.launch_again(&launch).map_err(starts)?;
                Ok(format!("another instance of {name} is started, and takes its place"))
            }
            _ => {
                for child in self.children.iter_mut().filter(|child| child.is_running() && child.name == *name) {
                    // One that has been asked before may hang.
                    child.signal(if child.was_asked { Signal::KILL } else { Signal::TERM });
                    child.was_asked = true;
                }
                Ok(format!("{name} is asked to leave"))
            }
        }
    }

    fn running(&self, name: &str) -> impl Iterator<Item = &Child> {
        self.children.iter().filter(move |child| child.is_running() && child.name == name)
    }

    /// Returns the participants of this run, and which of them run.
    fn list(&self) -> String {
        let mut text = format!("run {}", std::process::id());
        for Launch { name, role, .. } in self.launches.iter().filter(|launch| launch.role != Role::Rti) {
            let kind = if *role == Role::Transient { ", transient" } else { "" };
            let state = match self.running(name).count() {
                0 => "does not run",
                1 => "runs",
                _ => "is being swapped",
            };
            text = text + "\n  " + name + ": " + state + kind;
        }
        text
    }
}
