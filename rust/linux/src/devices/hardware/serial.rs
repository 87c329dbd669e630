// SPDX-License-Identifier: Apache-2.0
//! Serial lines, as terminals in raw mode.

use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;

use lf_devices::{Device, EventPoster, Problem, SerialLine};
use lf_model::PhysicalLink;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::io::{Errno, read, write};
use rustix::termios::{ControlModes, OptionalActions, ioctl_tiocexcl, tcgetattr, tcsetattr};

use super::super::binding::{Bound, Kind};
use super::super::watch::Watch;
use super::listener::Listener;
use super::{Advice, DeviceRef, failed};

const ADVICE: Advice = Advice {
    missing: "which is not there: is it plugged in? `ls /dev/serial/by-id` lists adapters",
    denied: "which this user may not open: as a rule members of the group dialout may",
    busy: "which another program uses: `fuser` says which",
    other: "but the program uses it as a serial line: write serial, its file and its speed",
};
const NO_LINE: &str = "which is no serial line, or has no such speed";

/// The time in nanoseconds after which a thread that waits for a byte checks whether it still has to wait.
const PAUSE_NS: i64 = 100_000_000;

/// A serial line.
#[derive(Debug)]
pub struct Serial {
    place: DeviceRef,
    line: Arc<OwnedFd>,
}

impl Serial {
    /// Opens the line of a line of the script.
    pub(in super::super) fn open(name: &'static str, bound: &'static Bound) -> Result<Self, Problem> {
        let place = DeviceRef::of(name, bound, &ADVICE);
        let Kind::Serial { baud } = bound.binding.kind else { return Err(place.is_other()) };
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let line = open(place.path, flags, Mode::empty()).map_err(|error| place.refuses(&error.into()))?;
        raw(&line, baud).map_err(|error| place.problem(NO_LINE, error.raw_os_error()))?;
        Ok(Self { place, line: Arc::new(line) })
    }
}

/// Sets eight bits, no parity, one stop bit, no flow control, and no conversion of bytes.
fn raw(line: &OwnedFd, baud: u32) -> rustix::io::Result<()> {
    let mut modes = tcgetattr(line)?;
    modes.make_raw();
    modes.control_modes -= ControlModes::CSTOPB | ControlModes::CRTSCTS;
    modes.control_modes |= ControlModes::CLOCAL | ControlModes::CREAD;
    modes.set_speed(baud)?;
    tcsetattr(line, OptionalActions::Now, &modes)?;
    // Two programs would take each other's bytes.
    ioctl_tiocexcl(line)
}

/// Waits until the line is in this state, or for this long.
fn wait(line: &OwnedFd, until: PollFlags, at_most: Option<&Timespec>) -> Result<(), Problem> {
    match poll(&mut [PollFd::new(line, until)], at_most) {
        Ok(_) | Err(Errno::INTR) => Ok(()),
        Err(error) => Err(failed(&error.into())),
    }
}

/// Returns the bytes that have come, if there are any.
fn take(line: &OwnedFd, buffer: &mut [u8]) -> io::Result<usize> {
    match read(line, buffer) {
        // A terminal that has gone reads as an end.
        Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
        Ok(count) => Ok(count),
        Err(Errno::AGAIN | Errno::INTR) => Ok(0),
        Err(error) => Err(error.into()),
    }
}

impl Device for Serial {
    fn name(&self) -> &'static str {
        self.place.name
    }
}

impl SerialLine for Serial {
    type Watch = Watch;

    fn is_ready(&self) -> Result<(), Problem> {
        Ok(())
    }

    fn send(&self, mut bytes: &[u8]) -> Result<(), Problem> {
        while !bytes.is_empty() {
            match write(&self.line, bytes) {
                Ok(count) => bytes = &bytes[count..],
                Err(Errno::AGAIN) => wait(&self.line, PollFlags::OUT, None)?,
                Err(Errno::INTR) => {}
                Err(error) => return Err(failed(&error.into())),
            }
        }
        Ok(())
    }

    fn receive(&self) -> Result<Option<u8>, Problem> {
        let mut byte = [0];
        let count = take(&self.line, &mut byte).map_err(|error| failed(&error))?;
        Ok((count > 0).then_some(byte[0]))
    }

    fn pause(&self) {
        // Reading reports the line's errors.
        let _ = wait(&self.line, PollFlags::IN, Some(&Timespec { tv_sec: 0, tv_nsec: PAUSE_NS }));
    }

    fn watch(&self, link: PhysicalLink, poster: EventPoster) -> Result<Watch, Problem> {
        let mut buffer = [0; 256];
        let listener = Listener::spawn(self.place.name, Arc::clone(&self.line), link, move |line, lost| {
            let count = take(line, &mut buffer)?;
            for byte in &buffer[..count] {
                lost.count(poster.post(*byte));
            }
            Ok(())
        });
        listener.map(Watch::until_dropped).map_err(|error| failed(&error))
    }
}
