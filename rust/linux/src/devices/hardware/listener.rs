// SPDX-License-Identifier: Apache-2.0
//! A thread that waits for the events of a device.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use lf_model::PhysicalLink;
use rustix::event::{EventfdFlags, PollFd, PollFlags, eventfd, poll};
use rustix::io::Errno;

use super::super::watch::Lost;

/// A thread that reads a device whenever there is something to read, until this is dropped.
#[derive(Debug)]
pub(super) struct Listener {
    end: Arc<OwnedFd>,
    thread: Option<JoinHandle<()>>,
}

impl Listener {
    /// Starts the thread. `take` reads once, and counts events without room.
    ///
    /// # Errors
    /// When the system has no descriptor or no thread left.
    pub(super) fn spawn<S: AsFd + Send + Sync + 'static>(
        name: &'static str,
        source: Arc<S>,
        link: PhysicalLink,
        mut take: impl FnMut(&S, &mut Lost) -> io::Result<()> + Send + 'static,
    ) -> io::Result<Self> {
        let end = Arc::new(eventfd(0, EventfdFlags::CLOEXEC)?);
        let ended = Arc::clone(&end);
        let run = move || {
            // While this lives, the program does not end for want of events.
            let _link = link;
            let mut lost = Lost::of(name);
            loop {
                match wait(&*source, &ended) {
                    Ok(true) => {}
                    Ok(false) => return,
                    Err(error) => return log::error!("{name} cannot be waited for: {error}"),
                }
                if let Err(error) = take(&source, &mut lost) {
                    return log::error!("{name} schedules nothing any more: {error}");
                }
            }
        };
        let thread = thread::Builder::new().name(name.to_owned()).spawn(run)?;
        Ok(Self { end, thread: Some(thread) })
    }
}

/// Waits for the device. Returns `false` when the listener has been dropped.
fn wait(source: &impl AsFd, end: &OwnedFd) -> io::Result<bool> {
    loop {
        let mut both = [PollFd::new(source, PollFlags::IN), PollFd::new(end, PollFlags::IN)];
        match poll(&mut both, None) {
            Ok(_) if !both[1].revents().is_empty() => return Ok(false),
            Ok(_) if !both[0].revents().is_empty() => return Ok(true),
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // A counter of one always has room.
        let _ = rustix::io::write(&self.end, &1_u64.to_ne_bytes());
        // The thread has ended, so nothing is scheduled any more. Its panic has been reported.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}
