// SPDX-License-Identifier: Apache-2.0
//! The latency of a message from one federate to another.

use std::io::{Read, Write};
use std::time::Instant;

use lf_wire::{Decoded, Limits, Message, Tag, decode};

use crate::forwarder::Waiting;
use crate::graph::{Graph, Shape};
use crate::link::connect;
use crate::peer::{Load, Peer};
use crate::process::{Program, start_self};
use crate::{Access, Result, Samples};

/// The period in nanoseconds of logical time.
const PERIOD_NS: i64 = 1_000_000;
/// The number of exchanges before those that count.
const WARM_UP: u32 = 200;

/// The latencies, each from before the sender writes until the receiver has read.
#[derive(Clone, Debug, Default)]
pub struct Latency {
    /// From the NET of the upstream federate to the TAG of the downstream one.
    pub grant: Samples,
    /// From the sender of a message with 8 bytes to its receiver.
    pub message: Samples,
}

/// Measures an RTI that has been started for two federates.
///
/// # Errors
/// When the RTI does not answer as it should.
pub fn rti_latency(rti: Access, exchanges: u32) -> Result<Latency> {
    let graph = Graph::new(Shape::Chain, 2, PERIOD_NS);
    let load = Load { period_ns: PERIOD_NS, messages: 1, rounds_ahead: 0 };
    let (mut up, mut down) = (Peer::join(rti, 0, &graph, load)?, Peer::join(rti, 1, &graph, load)?);
    up.send_clock()?;
    down.send_clock()?;
    up.await_start()?;
    down.await_start()?;
    let mut latency = Latency::default();
    let first = Message::NextEventTag(down.tag_of(0));
    send(down.link(), &first)?;
    for round in 1..=u64::from(WARM_UP + exchanges) {
        let (tag, next) = (up.tag_of(round), up.tag_of(round + 1));
        let message = Message::TaggedMessage { port: 0, federate: 1, tag, payload: &[0; 8] };
        let begin = Instant::now();
        send(up.link(), &message)?;
        expect(down.link(), &message)?;
        let on_its_way = begin.elapsed();

        let announcement = Message::NextEventTag(next);
        let begin = Instant::now();
        send(up.link(), &announcement)?;
        expect(down.link(), &Message::TagGrant(Tag::new(next.time - 1, u32::MAX)))?;
        if round > u64::from(WARM_UP) {
            latency.grant.push(begin.elapsed());
            latency.message.push(on_its_way);
        }
        send(down.link(), &Message::LatestTagComplete(tag))?;
    }
    for peer in [&mut up, &mut down] {
        send(peer.link(), &Message::NextEventTag(Tag::FOREVER))?;
        send(peer.link(), &Message::Resign)?;
    }
    Ok(latency)
}

/// Starts an RTI and measures it.
///
/// # Errors
/// When it cannot be started, or does not answer as it should.
pub fn program_latency(program: &Program, exchanges: u32) -> Result<Latency> {
    let rti = program.start(2)?;
    rti_latency(rti.access(), exchanges)
}

/// Measures the raw forwarder, with messages as long as those of the RTI.
///
/// # Errors
/// When the forwarder cannot be started.
pub fn forwarder_latency(waiting: Waiting, exchanges: u32) -> Result<Latency> {
    let role = match waiting {
        Waiting::Asleep => "forward-asleep",
        Waiting::Awake => "forward-awake",
    };
    let (_child, port, _) = start_self(role)?;
    let mut from = connect(port)?;
    from.set_nodelay(true)?;
    let mut to = connect(port)?;
    let mut latency = Latency::default();
    let tag = Tag::new(0, 0);
    let message = Message::TaggedMessage { port: 0, federate: 1, tag, payload: &[0; 8] };
    let grant = Message::TagGrant(tag);
    for round in 0..WARM_UP + exchanges {
        let begin = Instant::now();
        send(&mut from, &message)?;
        expect(&mut to, &message)?;
        let on_its_way = begin.elapsed();
        let begin = Instant::now();
        send(&mut from, &grant)?;
        expect(&mut to, &grant)?;
        if round >= WARM_UP {
            latency.grant.push(begin.elapsed());
            latency.message.push(on_its_way);
        }
    }
    Ok(latency)
}

fn send(stream: &mut impl Write, message: &Message<'_>) -> Result<()> {
    let mut bytes = [0; 64];
    let len = message.encode(&mut bytes)?;
    stream.write_all(&bytes[..len])?;
    Ok(())
}

fn expect(stream: &mut impl Read, expected: &Message<'_>) -> Result<()> {
    let mut bytes = [0; 64];
    let bytes = &mut bytes[..expected.encoded_len()];
    stream.read_exact(bytes)?;
    match decode(bytes, &Limits::NONE)? {
        Decoded::Complete { message, .. } if message == *expected => Ok(()),
        other => Err(format!("{expected:?} was expected, but {other:?} came").into()),
    }
}
