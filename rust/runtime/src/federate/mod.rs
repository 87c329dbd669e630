// SPDX-License-Identifier: Apache-2.0
//! The event loop of a federate with centralized coordination.

mod link;
mod output;

use core::net::SocketAddrV4;

use lf_coordination::Deadline;
use lf_coordination::federate::{Config, Disconnected, Event, Federate, Phase};
use lf_model::time::{Instant, Interval, Tag};
use lf_model::{Engine, InputId, Program, Progress};
use lf_wire::Limits;
use lf_wire::june_2026::Message;

use crate::connection::Buffers;
use crate::description::Federation;
use crate::error::RunError;
use crate::platform::Platform;
use link::{Arrival, Link};
use output::Output;

/// How many tags are run before the socket is looked at again, when physical time is ahead of logical time.
const TAGS_PER_TURN: u32 = 16;
/// How long a federate that has failed tries to tell the RTI.
const LAST_WORDS: Interval = Interval::from_secs(1);

/// What a federate is told when it is started, and not when it is built.
#[derive(Clone, Copy, Debug)]
pub struct Join<'a> {
    /// The federation to join.
    pub federation_id: &'a [u8],
    /// Where its RTI listens.
    pub rti: SocketAddrV4,
}

/// Runs a federate from its first connection to its end.
///
/// # Errors
/// Why it ended early. The RTI has been told, where that was possible.
pub fn run_federate<P: Platform>(
    platform: &mut P,
    program: &mut dyn Program,
    engine: Engine<'_>,
    federation: &Federation,
    join: &Join<'_>,
    buffers: Buffers<'_>,
) -> Result<(), RunError> {
    let config = Config {
        upstream: federation.upstream,
        downstream: federation.downstream,
        clock_sync: federation.clock_sync,
        physical_delay: federation.physical_delay,
        ..Config::new(federation.id.into(), join.federation_id)
    };
    let machine = Federate::new(config)?;
    let limits = Limits {
        // What the buffer holds is the limit; an input's own length is checked when its value is decoded.
        payload_bytes_max: buffers.input.capacity(),
        federation_id_bytes_max: 0,
        neighbors_max: 0,
    };
    let link = Link::new(platform.now(), join.rti, buffers);
    let mut state = Loop { platform, program, engine, machine, link, limits, ended: false, input_full: false };
    log::debug!("connecting to the RTI at {}", join.rti);
    let result = state.run();
    if result.is_err() {
        state.machine.fail();
    }
    state.take_leave();
    state.link.close(state.platform);
    result
}

struct Loop<'a, 's, P> {
    platform: &'a mut P,
    program: &'a mut dyn Program,
    engine: Engine<'s>,
    machine: Federate<'a>,
    link: Link<'s>,
    limits: Limits,
    /// The RTI has closed the connection; what it said before may still be in the buffer.
    ended: bool,
    /// The message at the front of the input buffer waits for room in its input's queue.
    input_full: bool,
}

/// How far the tags of one turn came.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Advance {
    /// All that is possible now is done; at this time more may be.
    Until(Deadline),
    /// The output buffer is full in the middle of a tag.
    OutputFull,
    /// The last tag is complete.
    Done,
}

impl<P: Platform> Loop<'_, '_, P> {
    fn run(&mut self) -> Result<(), RunError> {
        loop {
            if self.platform.interrupted() {
                return Err(RunError::Interrupted);
            }
            if self.link.establish(self.platform)? {
                let now = self.platform.now();
                self.machine.handle_connected(now);
            }
            self.receive()?;
            let now = self.platform.now();
            if self.machine.poll_timeout().is_due(now) {
                self.machine.handle_timeout(now)?;
            }
            let advance = self.advance()?;
            self.transmit();
            if self.machine.phase() == Phase::Ended && self.link.buffers.output.is_empty() {
                return Ok(());
            }
            self.wait(advance);
        }
    }

    /// Reads what has come and handles it, as long as there is room for it.
    fn receive(&mut self) -> Result<(), RunError> {
        if self.link.fill(self.platform) == Arrival::End {
            self.ended = true;
        }
        self.handle_messages()?;
        if self.ended && !self.input_full {
            self.ended = false;
            match self.machine.handle_disconnected()? {
                Disconnected::ConnectAgain => self.link.begin_anew(self.platform),
                Disconnected::Ended => self.link.close(self.platform),
            }
        }
        Ok(())
    }

    /// Handles the messages in the input buffer; bounded by its size.
    fn handle_messages(&mut self) -> Result<(), RunError> {
        self.input_full = false;
        let now = self.platform.now();
        loop {
            let Some((message, length)) = self.link.buffers.input.next(&self.limits)? else { return Ok(()) };
            if let Message::TaggedMessage { port, .. } = message
                && usize::from(port) < self.engine.tables().inputs.len()
                && !self.engine.has_room(self.program, InputId(port))
            {
                self.input_full = true;
                return Ok(());
            }
            match self.machine.handle_message(now, message)? {
                Event::Message { port, tag, payload } => {
                    self.engine.deliver(self.program, InputId(port), tag, payload)?;
                }
                Event::ClockCorrected(estimate) => {
                    log::debug!("initial clock synchronization: {estimate}");
                    self.platform.set_correction(self.machine.clock());
                }
                Event::Started(start) => self.start(start),
                Event::StopGranted(tag) => {
                    log::debug!("the federation stops at {tag}");
                    self.engine.set_stop_tag(tag);
                }
                Event::Accepted => log::debug!("the RTI has accepted this federate"),
                Event::None
                | Event::Granted(_)
                | Event::GrantedProvisionally(_)
                | Event::MessageAfterStop { .. }
                | Event::PortAbsent { .. }
                | Event::StopRequested(_) => {}
            }
            self.link.buffers.input.consume(length);
            // Answers to clock synchronization are as good as they are prompt.
            if self.machine.phase() < Phase::Running {
                self.transmit();
            }
        }
    }

    fn start(&mut self, start: Instant) {
        log::debug!("the federation starts");
        self.engine.start(start);
        if self.engine.stop_tag() < Tag::FOREVER {
            self.machine.limit_stop(self.engine.stop_tag());
        }
    }

    /// Runs the tags that are due and granted.
    fn advance(&mut self) -> Result<Advance, RunError> {
        if self.machine.phase() != Phase::Running {
            return Ok(Advance::Until(Deadline::Never));
        }
        for _ in 0..TAGS_PER_TURN {
            if !self.engine.is_in_tag()
                && let Some(deadline) = self.begin_next()?
            {
                return Ok(Advance::Until(deadline));
            }
            let mut output = Output::new(self.platform, &mut self.link, &mut self.machine);
            match self.engine.advance(self.program, &mut output, None) {
                Progress::Complete => {}
                Progress::OutputFull { .. } | Progress::LevelLimit { .. } => return Ok(Advance::OutputFull),
                Progress::Failed(error) => return Err(error.into()),
            }
            self.machine.complete(self.engine.had_network_input());
            if let Some(tag) = self.engine.take_stop_request() {
                self.machine.request_stop(tag);
            }
            if self.engine.is_done() {
                self.machine.finish();
                return Ok(Advance::Done);
            }
        }
        Ok(Advance::Until(Deadline::Now))
    }

    /// Begins the next tag, if it is due and granted; else says when to try again.
    fn begin_next(&mut self) -> Result<Option<Deadline>, RunError> {
        let env = Output::new(self.platform, &mut self.link, &mut self.machine);
        self.engine.drain_physical(self.program, &env);
        if let Some(tag) = self.engine.take_stop_request() {
            self.machine.request_stop(tag);
        }
        let now = self.platform.now();
        let Some(tag) = self.engine.next_tag() else { return Ok(Some(self.idle(now))) };
        let granted = self.machine.next_event(now, tag);
        // One NET per tag, even when many tags go into one write: each lets the RTI grant the tag before to others, and a
        // receiver whose queue is full of messages that are not granted yet would read no further.
        self.collect();
        if !granted {
            return Ok(Some(Deadline::Never));
        }
        if !self.engine.settings().fast && self.machine.clock().physical(now) < tag.time {
            return Ok(Some(Deadline::At(self.machine.clock().local(tag.time))));
        }
        self.machine.begin(tag)?;
        self.engine.begin(self.program, tag)?;
        Ok(None)
    }

    /// There is no event. When none can come any more, the next microstep is the last tag.
    fn idle(&mut self, now: Instant) -> Deadline {
        let nothing_comes = self.machine.next_event(now, Tag::FOREVER) && self.has_no_source_of_its_own();
        if nothing_comes {
            self.engine.set_stop_tag(Tag::NEVER);
        }
        if nothing_comes { Deadline::Now } else { Deadline::Never }
    }

    /// Whether neither the program nor one of its threads can make an event out of nothing.
    fn has_no_source_of_its_own(&self) -> bool {
        !self.engine.settings().keepalive && self.platform.outside().mailbox().links() == 0
    }

    /// Moves what the machine has to say into the output buffer, and writes it.
    fn transmit(&mut self) {
        if !self.link.is_open() {
            return;
        }
        loop {
            self.collect();
            if !self.link.flush(self.platform) {
                return;
            }
            let now = self.platform.now();
            self.machine.handle_written(now);
            if !self.machine.has_transmit() {
                return;
            }
        }
    }

    /// Moves what the machine has to say into the output buffer, behind the messages of the tags it speaks of.
    fn collect(&mut self) {
        while let Some(message) = self.machine.poll_transmit(self.link.buffers.output.room()) {
            // There is room: the machine was told how much, and gave a message that fits.
            let _ = self.link.buffers.output.push(&message);
        }
    }

    fn wait(&mut self, advance: Advance) {
        let event = match advance {
            Advance::Until(deadline) => deadline,
            Advance::OutputFull | Advance::Done => Deadline::Never,
        };
        let until = event.min(self.machine.poll_timeout()).min(self.link.poll_timeout());
        self.link.set_interest(self.platform, !self.input_full && !self.ended);
        let link = &mut self.link;
        self.platform.wait(until, &mut |socket, interest| link.handle_ready(socket, interest));
    }

    /// Sends what is still to be said (RESIGN or FAILED), closes our direction, and awaits the RTI's end.
    ///
    /// A socket that is closed while something is unread resets the connection, and what was sent last may be lost. So
    /// the RTI's last words are read, but not for longer than [`LAST_WORDS`].
    fn take_leave(&mut self) {
        let until = self.platform.now() + LAST_WORDS;
        while self.link.is_open() && self.platform.now() < until {
            self.transmit();
            if self.link.buffers.output.is_empty() && !self.machine.has_transmit() {
                self.link.shut_down_writing(self.platform);
            }
            self.link.buffers.input.clear();
            if self.link.fill(self.platform) == Arrival::End {
                return;
            }
            self.link.set_interest(self.platform, true);
            let link = &mut self.link;
            self.platform.wait(Deadline::At(until), &mut |socket, interest| link.handle_ready(socket, interest));
        }
    }
}
