// SPDX-License-Identifier: Apache-2.0
//! The wake-up of the event loop, and the signals that ask the program to end.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// The offset that a shell adds to the number of a signal.
const SIGNALED: u8 = 128;
/// ^C.
const SIGINT: u8 = 2;

/// One wake-up per program: statics of the generated code reach it from any thread.
static WAKE_UP: OnceLock<Arc<WakeUp>> = OnceLock::new();

/// A pair of sockets that ends the event loop's wait, and the last signal.
///
/// The signal handlers write to it too, so a signal just before a wait ends that wait.
#[derive(Debug)]
pub(crate) struct WakeUp {
    reader: UnixStream,
    writer: UnixStream,
    /// The number of the last signal that has come; 0 for none.
    signal: Arc<AtomicUsize>,
}

impl WakeUp {
    /// Returns the program's wake-up; the first call makes it and takes over SIGINT and SIGTERM.
    ///
    /// # Errors
    /// When the system has no descriptor left, or refuses a signal handler.
    pub(crate) fn of_program() -> std::io::Result<Arc<Self>> {
        if let Some(wake_up) = WAKE_UP.get() {
            return Ok(Arc::clone(wake_up));
        }
        let (reader, writer) = UnixStream::pair()?;
        reader.set_nonblocking(true)?;
        writer.set_nonblocking(true)?;
        let last = Arc::new(AtomicUsize::new(0));
        for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
            let number = usize::try_from(signal).expect("the numbers of signals are positive");
            signal_hook::flag::register_usize(signal, Arc::clone(&last), number)?;
            signal_hook::low_level::pipe::register(signal, writer.try_clone()?)?;
        }
        Ok(Arc::clone(WAKE_UP.get_or_init(|| Arc::new(Self { reader, writer, signal: last }))))
    }

    /// Ends the wait of the event loop, now or at its next start; does nothing before the program has an event loop.
    pub(crate) fn wake_program() {
        if let Some(wake_up) = WAKE_UP.get() {
            // It fails only when the socket is full, and then the loop is being woken anyway.
            let _ = (&wake_up.writer).write(&[1]);
        }
    }

    /// Returns the descriptor that becomes readable.
    pub(crate) fn descriptor(&self) -> &UnixStream {
        &self.reader
    }

    /// Clears the wake-ups, so that the next wait waits. Returns whether there was one.
    pub(crate) fn clear(&self) -> bool {
        let read = || matches!((&self.reader).read(&mut [0_u8; 64]), Ok(count) if count > 0);
        let was_woken = read();
        while read() {}
        was_woken
    }

    /// Returns whether SIGINT or SIGTERM has come.
    pub(crate) fn interrupted(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }
}

/// Returns the exit status of a program that a signal asked to end, as a shell reports it: 130 after SIGINT, 143 after
/// SIGTERM. Without a signal, that of ^C.
pub fn interruption_status() -> u8 {
    let signal = WAKE_UP.get().map_or(0, |wake_up| wake_up.signal.load(Ordering::Relaxed));
    let signal = u8::try_from(signal).ok().filter(|signal| *signal != 0).unwrap_or(SIGINT);
    SIGNALED + signal
}
