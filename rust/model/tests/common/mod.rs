// SPDX-License-Identifier: Apache-2.0
//! A stand-in for the event loop's host: a clock that the test sets, an out-buffer, and threads.
#![allow(dead_code, reason = "each test program uses its part")]
pub mod bench;

use std::cell::RefCell;
use std::sync::atomic::{AtomicI64, AtomicUsize, Ordering};
use std::thread::JoinHandle;

use lf_model::{
    Env, Instant, Mailbox, NetworkOutput, Outgoing, Outside, PhysicalLink, ReactionContext, SendError, Tag,
};

/// Physical time, set by hand.
pub struct Clock {
    now: AtomicI64,
    wakes: AtomicUsize,
    mailbox: Mailbox,
}

impl Clock {
    pub fn new_static(now: i64) -> &'static Self {
        Box::leak(Box::new(Self { now: AtomicI64::new(now), wakes: AtomicUsize::new(0), mailbox: Mailbox::new() }))
    }

    pub fn set(&self, now: Instant) {
        self.now.store(now.as_nanos(), Ordering::SeqCst);
    }

    pub fn wakes(&self) -> usize {
        self.wakes.load(Ordering::SeqCst)
    }
}

impl Outside for Clock {
    fn physical_time(&self) -> Instant {
        Instant::from_nanos(self.now.load(Ordering::SeqCst))
    }
    fn wake(&self) {
        self.wakes.fetch_add(1, Ordering::SeqCst);
    }
    fn mailbox(&self) -> &Mailbox {
        &self.mailbox
    }
}

/// A sent value: federate, port, tag, payload.
pub type Sent = (u16, u16, Tag, Vec<u8>);
/// A sent absence: federate, port, tag.
pub type Absent = (u16, u16, Tag);

/// The engine's environment.
pub struct Host {
    pub clock: &'static Clock,
    pub sent: Vec<Sent>,
    pub absent: Vec<Absent>,
    /// Messages that fit until the test makes room again.
    pub room: usize,
}

impl Host {
    pub fn new(clock: &'static Clock) -> Self {
        Self { clock, sent: Vec::new(), absent: Vec::new(), room: usize::MAX }
    }

    pub fn make_room(&mut self) {
        self.room += 1;
    }

    /// Waits for the threads that bodies have started, so that the test does not depend on their pace.
    pub fn join_threads() {
        for thread in THREADS.take() {
            thread.join().unwrap();
        }
    }
}

impl Env for Host {
    fn outside(&self) -> &'static dyn Outside {
        self.clock
    }

    fn send(&mut self, message: &Outgoing<'_>) -> Result<(), SendError> {
        self.room = self.room.checked_sub(1).ok_or(SendError::NoRoom)?;
        let mut bytes = vec![0; message.output.max_len];
        let len = message.encode(&mut bytes).map_err(SendError::Payload)?;
        bytes.truncate(len);
        self.sent.push((message.output.federate, message.output.port, message.tag, bytes));
        Ok(())
    }

    fn send_absent(&mut self, output: &'static NetworkOutput, tag: Tag) -> Result<(), SendError> {
        self.room = self.room.checked_sub(1).ok_or(SendError::NoRoom)?;
        self.absent.push((output.federate, output.port, tag));
        Ok(())
    }
}

thread_local! {
    /// Reactions run on the test's own thread, so tests do not see each other's.
    static THREADS: RefCell<Vec<JoinHandle<()>>> = const { RefCell::new(Vec::new()) };
}

/// A platform's `spawn_physical_thread` for bodies: an extension trait in its prelude, generic over the closure, so
/// that neither the model nor a static needs to know its type.
pub trait SpawnPhysicalThread {
    fn spawn_physical_thread<F: FnOnce(&mut PhysicalLink) + Send + 'static>(&mut self, body: F);
}

impl SpawnPhysicalThread for ReactionContext<'_> {
    fn spawn_physical_thread<F: FnOnce(&mut PhysicalLink) + Send + 'static>(&mut self, body: F) {
        let mut link = self.physical_link();
        THREADS.with_borrow_mut(|threads| threads.push(std::thread::spawn(move || body(&mut link))));
    }
}
