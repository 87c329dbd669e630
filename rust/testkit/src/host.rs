// SPDX-License-Identifier: Apache-2.0
//! A stand-in for an engine's host: a clock that the test sets, and an out-buffer.

use std::sync::atomic::{AtomicI64, AtomicUsize, Ordering};

use lf_model::{Engine, Env, Instant, Mailbox, NetworkOutput, Outgoing, Outside, Program, Progress, SendError, Tag};

/// Physical time that the test sets.
#[derive(Debug)]
pub struct Clock {
    now: AtomicI64,
    wakes: AtomicUsize,
    mailbox: Mailbox,
}

impl Clock {
    /// Returns a clock that shows this number of nanoseconds.
    pub fn new_static(now: i64) -> &'static Self {
        Box::leak(Box::new(Self { now: AtomicI64::new(now), wakes: AtomicUsize::new(0), mailbox: Mailbox::new() }))
    }

    /// Sets the time that the clock shows.
    pub fn set(&self, now: Instant) {
        self.now.store(now.as_nanos(), Ordering::SeqCst);
    }

    /// Returns how often the event loop was woken.
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
#[derive(Debug)]
pub struct Host {
    /// Physical time.
    pub clock: &'static Clock,
    /// The sent values.
    pub sent: Vec<Sent>,
    /// The sent absences.
    pub absent: Vec<Absent>,
    /// The number of messages that fit until the test makes room again.
    pub room: usize,
}

impl Host {
    /// Returns a host with room for all messages.
    pub fn new(clock: &'static Clock) -> Self {
        Self { clock, sent: Vec::new(), absent: Vec::new(), room: usize::MAX }
    }

    /// Makes room for one more message.
    pub fn make_room(&mut self) {
        self.room += 1;
    }

    /// Runs a started program until it has nothing left to do: physical time is that of each tag, and `after` is called
    /// when a tag is complete.
    ///
    /// # Panics
    /// If a reaction fails.
    pub fn run<P: Program>(
        &mut self,
        engine: &mut Engine<'_>,
        program: &mut P,
        mut after: impl FnMut(&mut Engine<'_>, &mut P, Tag),
    ) {
        while !engine.is_done() {
            engine.drain_physical(program, self);
            // A federate asks the RTI at this point: NET(next_tag), and waits for a TAG.
            let Some(tag) = engine.next_tag() else { break };
            self.clock.set(tag.time);
            engine.begin(program, tag).expect("it is the next tag");
            while engine.is_in_tag() {
                match engine.advance(program, self, None) {
                    Progress::Complete => {}
                    Progress::OutputFull { .. } => self.make_room(),
                    other => panic!("{other:?}"),
                }
            }
            // A federate informs the RTI at this point: LTC, or a request to stop, which the RTI grants.
            if let Some(tag) = engine.take_stop_request() {
                engine.set_stop_tag(tag);
            }
            after(engine, program, tag);
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
