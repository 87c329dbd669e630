// SPDX-License-Identifier: Apache-2.0
//! `lfz run --watch`: a thread waits for changes and builds; when a build succeeds, the run of the last one is stopped
//! and the new one starts. So a mistake does not end a run, and its error is the last thing on the screen.

use std::convert::Infallible;
use std::io::Write as _;
use std::os::unix::net::UnixStream;
use std::process::ExitCode;
use std::sync::mpsc::{self, Sender};
use std::thread;

use super::once::{request, run_once};
use crate::args::RunArgs;
use crate::compile::{Built, Request};
use crate::failure::Failure;
use crate::supervisor::{Ending, Interrupts, NEW_VERSION};
use crate::terminal;
use crate::watch::Watch;

/// Runs the program, and again whenever it has changed, until this program is told to stop.
pub(super) fn run(arguments: &RunArgs) -> Result<ExitCode, Failure> {
    let others: Vec<_> = arguments.devices.iter().cloned().collect();
    let watch = Watch::of(&arguments.file, &others)?;
    let first = request(arguments).build();
    let (sender, receiver) = mpsc::channel();
    let (woken, waker) = UnixStream::pair()?;
    let interrupts = Interrupts::of_this_process()?.with_versions(woken)?;
    let copy = arguments.clone();
    thread::Builder::new().name("builder".to_owned()).spawn(move || {
        let Err(failure) = build_at_changes(&copy, watch, &sender, &waker);
        report(&failure);
        terminal::report("changes are not seen any more; stop this run with ^C, and start it again");
    })?;
    let mut next = first.inspect_err(report).ok();
    loop {
        let name = arguments.file.display();
        if let Some(built) = next.take() {
            match run_once(&built, arguments, || interrupts.again()) {
                Ok(ending @ (Ending::Interrupted(_) | Ending::OutputClosed)) if !is_new_version(ending) => {
                    return Ok(ExitCode::from(ending.exit_code()));
                }
                Ok(ending) if !is_new_version(ending) => {
                    let code = ending.exit_code();
                    terminal::inform(format_args!("{name} has ended with status {code}; waiting for a change"));
                }
                Ok(_) => {}
                Err(failure) => report(&failure),
            }
        } else {
            terminal::inform(format_args!("{name} does not run; waiting for a change"));
        }
        // A version that came while the run ended by itself has been announced to that run.
        next = receiver.try_iter().last();
        if next.is_none() {
            let signal = interrupts.wait()?;
            next = receiver.try_iter().last();
            if signal != NEW_VERSION {
                return Ok(ExitCode::from(Ending::Interrupted(signal).exit_code()));
            }
        }
    }
}

fn is_new_version(ending: Ending) -> bool {
    ending == Ending::Interrupted(NEW_VERSION)
}

/// Builds the program after each change, and sends what can be run.
fn build_at_changes(
    arguments: &RunArgs,
    mut watch: Watch,
    versions: &Sender<Built>,
    mut waker: &UnixStream,
) -> Result<Infallible, Failure> {
    loop {
        let changed = watch.wait()?;
        terminal::inform(format_args!("{} has changed", changed.display()));
        match (Request { is_beside_run: true, ..request(arguments) }).build() {
            Ok(built) => {
                // The other end ends with this process.
                let _ = versions.send(built);
                waker.write_all(&[0])?;
            }
            Err(failure) => {
                report(&failure);
                terminal::inform("nothing is started before the next change");
            }
        }
    }
}

/// Prints the reason of a failure, unless the user knows it.
fn report(failure: &Failure) {
    if let Failure::Message(text) = failure {
        terminal::report(format_args!("error: {text}"));
    }
}
