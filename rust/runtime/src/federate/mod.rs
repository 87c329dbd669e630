// SPDX-License-Identifier: Apache-2.0
//! The event loop of a federate with centralized coordination.

mod input;
mod link;
mod output;
mod tags;

use core::net::SocketAddrV4;

use lf_coordination::Deadline;
use lf_coordination::federate::{Config, Event, Federate, Phase};
use lf_model::time::Interval;
use lf_model::{Engine, InputId, Program, Tables};
use lf_wire::Limits;
use lf_wire::june_2026::{Message, NeighborStructure};

use crate::connection::Buffers;
use crate::description::{CONTROL_BYTES, Federation, TAGGED_MESSAGE_HEADER_BYTES};
use crate::error::RunError;
use crate::platform::Platform;
use input::Held;
use link::{Arrival, Link};
use tags::Advance;

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
    check_buffers(&buffers, engine.tables(), federation, join)?;
    let limits = Limits {
        // What the buffer holds is the limit; an input's own length is checked when its value is decoded.
        payload_bytes_max: buffers.input.capacity(),
        federation_id_bytes_max: 0,
        neighbors_max: 0,
    };
    let link = Link::new(platform.now(), join.rti, buffers);
    let has_upstream = !federation.upstream.is_empty();
    let mut state =
        Loop { platform, program, engine, machine, link, limits, held: Held::NONE, has_upstream, silent: false };
    log::debug!("connecting to the RTI at {}", join.rti);
    let result = state.run();
    if result.is_err() {
        state.machine.fail();
    }
    state.take_leave();
    state.link.close(state.platform);
    result
}

/// Whether the buffers can hold what this federate sends and receives; otherwise it would wait for room for ever.
fn check_buffers(
    buffers: &Buffers<'_>,
    tables: &Tables,
    federation: &Federation,
    join: &Join<'_>,
) -> Result<(), RunError> {
    let message = |payload: usize| payload.saturating_add(TAGGED_MESSAGE_HEADER_BYTES);
    let longest_input = tables.inputs.iter().map(|input| message(input.max_len)).max().unwrap_or(0);
    let longest_output = tables.outputs.iter().map(|output| message(output.max_len)).max().unwrap_or(0);
    let ids = Message::FedIds { federate: federation.id, federation_id: join.federation_id };
    let neighbors = NeighborStructure::new(federation.upstream, federation.downstream);
    let handshake = ids.encoded_len().max(Message::NeighborStructure(neighbors).encoded_len());
    let needs = [
        ("receive", longest_input.max(CONTROL_BYTES), buffers.input.capacity()),
        ("send", longest_output.saturating_add(CONTROL_BYTES).max(handshake), buffers.output.capacity()),
    ];
    match needs.into_iter().find(|(_, needed, found)| found < needed) {
        Some((buffer, needed, found)) => Err(RunError::BufferTooSmall { buffer, needed, found }),
        None => Ok(()),
    }
}

struct Loop<'a, 's, P> {
    platform: &'a mut P,
    program: &'a mut dyn Program,
    engine: Engine<'s>,
    machine: Federate<'a>,
    link: Link<'s>,
    limits: Limits,
    /// The messages in the input buffer that wait for room in their inputs' queues.
    held: Held,
    has_upstream: bool,
    /// The RTI has been told that nothing more is sent from here, though a last tag is still to be run.
    silent: bool,
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
            self.handle_timeout()?;
            let advance = self.advance()?;
            self.transmit();
            if advance == Advance::NotGranted
                && let Some(InputId(input)) = self.choked()
            {
                let name = self.engine.tables().inputs.get(usize::from(input)).map_or("", |input| input.name);
                return Err(RunError::InputFull { input: name });
            }
            if self.machine.phase() == Phase::Ended && self.link.buffers.output.is_empty() {
                return Ok(());
            }
            self.wait(advance);
        }
    }

    fn handle_timeout(&mut self) -> Result<(), RunError> {
        let now = self.platform.now();
        if self.machine.poll_timeout().is_due(now)
            && let Event::ClockCorrected(estimate) = self.machine.handle_timeout(now)?
        {
            log::debug!("initial clock synchronization, with fewer exchanges than expected: {estimate}");
            self.platform.set_correction(self.machine.clock());
        }
        Ok(())
    }

    /// Sends what the handshake has to say at once: answers to clock synchronization are as good as they are prompt.
    fn say_early(&mut self) {
        if self.machine.phase() < Phase::Running {
            self.transmit();
        }
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
            _ if self.held.is_stale() => Deadline::Now,
            Advance::Until(deadline) => deadline,
            Advance::NotGranted | Advance::OutputFull | Advance::Done => Deadline::Never,
        };
        let until = event.min(self.machine.poll_timeout()).min(self.link.poll_timeout());
        self.link.set_interest(self.platform);
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
            self.link.set_interest(self.platform);
            let link = &mut self.link;
            self.platform.wait(Deadline::At(until), &mut |socket, interest| link.handle_ready(socket, interest));
        }
    }
}
