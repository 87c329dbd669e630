// SPDX-License-Identifier: Apache-2.0
//! Runs the participants of a federation as child processes, shows their output, and ends all of them together.
//!
//! One loop waits for everything: the ends of processes (through their pidfds), their output, signals to this
//! program, and the time limits. Only this loop starts, signals and reaps processes, so a process id that it signals
//! is always one of its own children.

mod child;
mod ending;
mod interrupts;
mod launch;
mod output;

use std::io;
use std::process::Command;
use std::time::Instant;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::Signal;

pub(crate) use ending::{Ending, Limits};
pub(crate) use interrupts::{Interrupts, NEW_VERSION};
pub(crate) use launch::Launch;
pub(crate) use output::Output;

use child::{Child, End};
pub(crate) use child::{Role, Streams};
use ending::{Action, Plan};
use output::Stream;

use crate::control::Control;

/// The participants of one run.
pub(crate) struct Supervisor {
    children: Vec<Child>,
    /// The participants that can be started again.
    launches: Vec<Launch>,
    /// Those that are to be started again at these times.
    restarts: Vec<(Instant, String)>,
    /// The socket for those who control this run.
    control: Option<Control>,
    plan: Plan,
    interrupts: Interrupts,
    output: Output,
}

/// The source of what a wait reports.
#[derive(Clone, Copy)]
enum Source {
    Signal,
    Control,
    /// The end of a child.
    End(usize),
    /// Output of a child.
    Output(usize, Stream),
}

/// The descriptors that are ready after a wait.
#[derive(Default)]
struct Ready {
    signals: bool,
    /// The user wants to control this run.
    control: bool,
    /// Children that have ended.
    ended: Vec<usize>,
    /// Output to read.
    streams: Vec<(usize, Stream)>,
}

impl Supervisor {
    /// Returns a supervisor without processes; the time limit counts from now.
    pub(crate) fn new(limits: Limits, interrupts: Interrupts, output: Output) -> Self {
        Self {
            children: Vec::new(),
            launches: Vec::new(),
            restarts: Vec::new(),
            control: None,
            plan: Plan::new(limits, Instant::now()),
            interrupts,
            output,
        }
    }

    /// Starts a participant in a process group of its own, unless it may read from a terminal. A simulator continues
    /// after the program in it has ended; the line of its standard output that begins with `status_line` contains the
    /// program's status.
    ///
    /// # Errors
    /// When the program cannot be started; processes that were started earlier keep running.
    pub(crate) fn start(
        &mut self,
        name: &str,
        role: Role,
        status_line: Option<&str>,
        streams: Streams,
        command: &mut Command,
    ) -> io::Result<()> {
        self.children.push(Child::start(name, role, status_line, streams, command)?);
        Ok(())
    }

    /// Lets the user control this run.
    pub(crate) fn obey(&mut self, control: Control) {
        self.control = Some(control);
    }

    /// Prints a message in this program's own name.
    pub(crate) fn note(&mut self, text: &str) {
        self.output.note(text);
    }

    /// Runs until a line of the last started participant's standard output answers `wanted`, and does not show that
    /// line. Returns `None` if the run has to end before that line comes; continue with [`Self::finish`].
    ///
    /// # Errors
    /// When the system's calls fail.
    pub(crate) fn wait_for_line<T>(&mut self, wanted: impl Fn(&str) -> Option<T>) -> io::Result<Option<T>> {
        let Some(last) = self.children.len().checked_sub(1) else { return Ok(None) };
        let mut found = None;
        while found.is_none() && !self.plan.is_ending() && self.children[last].is_running() {
            self.turn(&mut |index, line| {
                if index == last && found.is_none() {
                    found = wanted(line);
                    return found.is_some();
                }
                false
            })?;
        }
        Ok(found.filter(|_| !self.plan.is_ending()))
    }

    /// Runs until all participants have ended, and returns the outcome.
    ///
    /// # Errors
    /// When the system's calls fail; all participants are killed then.
    pub(crate) fn finish(mut self) -> io::Result<Ending> {
        while self.children.iter().any(Child::is_running) {
            self.turn(&mut |_, _| false)?;
        }
        self.output.flush();
        Ok(self.plan.ending())
    }

    /// Waits once, and handles all events.
    fn turn(&mut self, swallow: &mut dyn FnMut(usize, &str) -> bool) -> io::Result<()> {
        let ready = self.wait()?;
        for (index, stream) in ready.streams {
            self.copy(index, stream, swallow)?;
        }
        for index in ready.ended {
            self.ended(index, swallow)?;
        }
        if ready.control {
            self.serve_control();
        }
        if ready.signals {
            for signal in self.interrupts.take() {
                if Interrupts::is_suspension(signal) {
                    self.suspend();
                    continue;
                }
                if !self.plan.is_stopping() {
                    let cause = if signal == NEW_VERSION { "there is a new version" } else { "interrupted" };
                    self.output.note(&format!("{cause}; stopping all participants"));
                }
                let action = self.plan.interrupted(signal, Instant::now());
                self.act(action);
            }
        }
        if let Some(error) = self.output.take_error()
            && !self.plan.is_stopping()
        {
            if error.kind() != io::ErrorKind::BrokenPipe {
                self.output.note(&format!("the output cannot be written: {error}; stopping all participants"));
            }
            let action = self.plan.output_lost(&error, Instant::now());
            self.act(action);
        }
        self.restart(Instant::now())?;
        let stays = |child: &Child| child.role == Role::Transient && child.is_running();
        // The RTI serves transient federates as long as they stay.
        if self.children.iter().any(stays) && self.plan.dismisses(Instant::now()) {
            for index in 0..self.children.len() {
                if stays(&self.children[index]) {
                    let name = &self.children[index].name;
                    self.output.note(&format!("{name} is still there after the others; stopping it"));
                    if !self.ask(index) {
                        self.children[index].signal(Signal::TERM);
                    }
                }
            }
        }
        let running = self.children.iter().filter(|child| child.is_running());
        let names = || running.clone().map(|child| child.name.as_str()).collect::<Vec<_>>().join(", ");
        if running.clone().next().is_some()
            && let Some((action, why)) = self.plan.due(Instant::now(), names)
        {
            self.output.note(&why);
            self.act(action);
        }
        Ok(())
    }

    fn wait(&self) -> io::Result<Ready> {
        let mut sources = Vec::new();
        let mut descriptors = Vec::new();
        for descriptor in self.interrupts.descriptors() {
            sources.push(Source::Signal);
            descriptors.push(PollFd::from_borrowed_fd(descriptor, PollFlags::IN));
        }
        if let Some(control) = &self.control {
            sources.push(Source::Control);
            descriptors.push(PollFd::from_borrowed_fd(control.descriptor(), PollFlags::IN));
        }
        for (index, child) in self.children.iter().enumerate() {
            for (stream, descriptor) in child.descriptors() {
                sources.push(stream.map_or(Source::End(index), |stream| Source::Output(index, stream)));
                descriptors.push(PollFd::from_borrowed_fd(descriptor, PollFlags::IN));
            }
        }
        let restart = self.restarts.iter().map(|(at, _)| *at).min();
        let timeout = self
            .plan
            .next()
            .into_iter()
            .chain(restart)
            .min()
            .map(|until| until.saturating_duration_since(Instant::now()));
        let timeout = timeout.and_then(|duration| Timespec::try_from(duration).ok());
        match poll(&mut descriptors, timeout.as_ref()) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let mut ready = Ready::default();
        for (source, descriptor) in sources.into_iter().zip(&descriptors) {
            if descriptor.revents().is_empty() {
                continue;
            }
            match source {
                Source::Signal => ready.signals = true,
                Source::Control => ready.control = true,
                Source::End(index) => ready.ended.push(index),
                Source::Output(index, stream) => ready.streams.push((index, stream)),
            }
        }
        Ok(ready)
    }

    /// Shows the available whole lines of one stream, and returns whether there were any.
    fn copy(&mut self, index: usize, stream: Stream, swallow: &mut dyn FnMut(usize, &str) -> bool) -> io::Result<bool> {
        if self.children[index].is_shown_as_it_comes() {
            let bytes = self.children[index].read_bytes(stream)?;
            self.output.bytes(stream, &bytes);
            return Ok(!bytes.is_empty());
        }
        let lines = self.children[index].read(stream)?;
        let any = !lines.is_empty();
        for line in lines {
            let is_standard = stream == Stream::Standard;
            if is_standard && swallow(index, &String::from_utf8_lossy(&line)) {
                continue;
            }
            self.output.line(index, &self.children[index].name, stream, &line);
            if is_standard && let Some(end) = self.children[index].told(&line) {
                self.judge(index, &end);
            }
        }
        Ok(any)
    }

    /// Handles the end of a process: reaps it, and shows the rest of its output.
    fn ended(&mut self, index: usize, swallow: &mut dyn FnMut(usize, &str) -> bool) -> io::Result<()> {
        let end = self.children[index].reap()?;
        for stream in [Stream::Standard, Stream::Error] {
            while self.copy(index, stream, swallow)? {}
            if let Some(rest) = self.children[index].close(stream) {
                self.output.line(index, &self.children[index].name, stream, &rest);
            }
        }
        if !self.children[index].has_told() {
            self.judge(index, &end);
        }
        Ok(())
    }

    /// Decides the consequences of a participant's end for the others.
    fn judge(&mut self, index: usize, end: &End) {
        let ended = &self.children[index];
        let mut others = self.children.iter().filter(|child| child.is_running()).peekable();
        let is_last = others.peek().is_none();
        if ended.role == Role::Transient {
            if !end.success && !self.plan.is_ending() {
                self.output.note(&format!("{} {}; the others continue without it", ended.name, end.how));
                let name = ended.name.clone();
                self.plan_restart(&name, Instant::now());
            }
        } else if !end.success {
            // A process that was told to stop may end with any status; the status of one that ends by itself counts.
            if !self.plan.is_stopping() {
                let rest = if is_last { "" } else { "; waiting for the others to end" };
                self.output.note(&format!("{} {}{rest}", ended.name, end.how));
            }
            self.plan.failed(end.exit_code, Instant::now());
        } else if !is_last && (ended.role == Role::Rti || others.all(|child| child.role != Role::Federate)) {
            // The RTI and the last federates end at the same time, in any order; a process that stays much longer
            // hangs. A federation ends with its persistent federates.
            self.plan.federation_over(Instant::now());
        }
    }

    /// Stops all processes until this one may continue: those in groups of their own do not get the terminal's signals.
    fn suspend(&self) {
        let there = || self.children.iter().filter(|child| child.is_there());
        there().for_each(|child| child.signal(Signal::STOP));
        Interrupts::suspend();
        there().for_each(|child| child.signal(Signal::CONT));
    }

    /// Signals the process groups of all participants that still run.
    fn act(&mut self, action: Action) {
        let signal = match action {
            Action::Terminate => Signal::TERM,
            Action::Kill => Signal::KILL,
        };
        for child in self.children.iter().filter(|child| child.is_running()) {
            child.signal(signal);
        }
    }
}

impl Drop for Supervisor {
    /// Ends all participants, whatever happens to this program.
    fn drop(&mut self) {
        for child in self.children.iter_mut().filter(|child| child.is_there()) {
            // An error means that it is gone already.
            let _ = child.reap();
        }
    }
}

#[cfg(test)]
mod tests;
