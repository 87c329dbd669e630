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
    /// The program and its arguments; for an image that has a spare board, also those with which it runs there.
    pub(crate) places: Vec<Vec<OsString>>,
    /// Whether only one instance can run at a place at a time, as on a board.
    pub(crate) is_exclusive: bool,
    /// The id by which the RTI tells it to leave, for an image, which understands no signal.
    pub(crate) image_id: Option<u16>,
    /// Variables beside those of this program.
    pub(crate) environment: Vec<(OsString, OsString)>,
    pub(crate) folder: Option<PathBuf>,
}

impl Launch {
    fn command(&self, place: usize) -> Command {
        let mut words = self.places.get(place).into_iter().flatten();
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

    /// Starts an instance at a free place. One that has ended there as a program, and is still there as a board, is
    /// switched off before.
    fn launch_again(&mut self, launch: &Launch) -> io::Result<()> {
        let Launch { name, role, status_line, streams, .. } = launch;
        let place = self.free_place(launch).ok_or_else(|| io::Error::other("another instance is in its place"))?;
        let is_here = |child: &Child| child.is_there() && child.name == *name && child.place == place;
        while launch.is_exclusive
            && let Some(index) = self.children.iter().position(is_here)
        {
            self.ended(index, &mut |_, _| false)?;
        }
        self.start(name, *role, status_line.as_deref(), *streams, &mut launch.command(place))?;
        if let Some(child) = self.children.last_mut() {
            (child.place, child.image_id) = (place, launch.image_id);
        }
        Ok(())
    }

    /// Returns the first place where another instance can run.
    fn free_place(&self, launch: &Launch) -> Option<usize> {
        let is_free = |place: &usize| !self.running(&launch.name).any(|child| child.place == *place);
        (0..launch.places.len()).find(|place| !launch.is_exclusive || is_free(place))
    }

    /// Asks a participant to leave: by a signal, or through the RTI if it is an image. Returns `false` if the RTI takes
    /// no commands.
    pub(super) fn ask(&mut self, index: usize) -> bool {
        let asked = if let Some(id) = self.children[index].image_id {
            let rti = self.children.iter_mut().find(|child| child.role == Role::Rti);
            rti.is_some_and(|rti| rti.command(&format!("stop {id}")))
        } else {
            self.children[index].signal(Signal::TERM);
            true
        };
        self.children[index].was_asked |= asked;
        asked
    }

    /// Has the instances of a transient federate leave; those that were asked before are killed, as they may hang.
    fn dismiss(&mut self, name: &str) -> Result<String, String> {
        let (mut asked, mut killed) = (false, false);
        for index in 0..self.children.len() {
            let child = &self.children[index];
            if !child.is_running() || child.name != name {
                continue;
            }
            if child.was_asked {
                child.signal(Signal::KILL);
                killed = true;
            } else if self.ask(index) {
                asked = true;
            } else {
                return Err(format!(
                    "{name} is an image, which only its RTI can tell to leave: an `lfz rti` that this run has started, \
                     and no RTI on a board"
                ));
            }
        }
        let verb = if killed && !asked { "killed, as it was asked to leave before" } else { "asked to leave" };
        Ok(format!("{name} is {verb}"))
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
            ControlRequest::Swap(_) if running == 1 && self.free_place(&launch).is_none() => Err(format!(
                "{name} is on a board, and another instance needs another one: say which in the deployment file, \
                 `spare: {{ ip: ADDRESS }}`"
            )),
            _ if running == 0 => Err(format!("{name} does not run; `lfz ctl start {name}` starts it")),
            ControlRequest::Swap(_) if running > 1 => Err(format!("another instance of {name} is about to begin")),
            ControlRequest::Swap(_) => {
                self.launch_again(&launch).map_err(starts)?;
                Ok(format!("another instance of {name} is started, and takes its place"))
            }
            _ => self.dismiss(name),
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
            let state = match (self.running(name).count(), self.running(name).next()) {
                (0, _) => "does not run",
                (1, Some(child)) if child.place > 0 => "runs on its spare board",
                (1, _) => "runs",
                _ => "is being swapped",
            };
            text = text + "\n  " + name + ": " + state + kind;
        }
        text
    }
}
