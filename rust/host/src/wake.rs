// SPDX-License-Identifier: Apache-2.0
//! The wake-up of the event loop, and the signals that ask the program to end.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// One wake-up per program: statics of the generated code reach it from any thread.
static WAKE_UP: OnceLock<Arc<WakeUp>> = OnceLock::new();

/// A pair of sockets that ends the event loop's wait, and what the signal handlers have seen.
///
/// The signal handlers write to it too, so a signal that comes just before a wait ends that wait.
#[derive(Debug)]
pub(crate) struct WakeUp {
    reader: UnixStream,
    writer: UnixStream,
    interrupted: Arc<AtomicBool>,
}

impl WakeUp {
    /// The program's wake-up; the first call makes it and takes over SIGINT and SIGTERM.
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
        let interrupted = Arc::new(AtomicBool::new(false));
        for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
            signal_hook::flag::register(signal, Arc::clone(&interrupted))?;
            signal_hook::low_level::pipe::register(signal, writer.try_clone()?)?;
        }
        Ok(Arc::clone(WAKE_UP.get_or_init(|| Arc::new(Self { reader, writer, interrupted }))))
    }

    /// Ends the wait of the event loop, now or at its next start; a no-op before the program has an event loop.
    pub(crate) fn wake_program() {
        if let Some(wake_up) = WAKE_UP.get() {
            // It fails only when the socket is full, and then the loop is being woken anyway.
            let _ = (&wake_up.writer).write(&[1]);
        }
    }

    /// What becomes readable.
    pub(crate) fn descriptor(&self) -> &UnixStream {
        &self.reader
    }

    /// Takes the wake-ups back, so that the next wait waits.
    pub(crate) fn clear(&self) {
        while matches!((&self.reader).read(&mut [0_u8; 64]), Ok(count) if count > 0) {}
    }

    /// Whether SIGINT or SIGTERM has come.
    pub(crate) fn interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}
