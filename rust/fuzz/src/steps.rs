// SPDX-License-Identifier: Apache-2.0
//! Steps of peers that follow the handshake, and the encoding of steps that `rti_raw` reads.

use arbitrary::{Arbitrary, Result, Unstructured};
use lf_coordination::rti::FEDERATION_ID_DEFAULT;
use lf_testkit::messages::{introduction, transient_introduction};
use lf_testkit::parts::{self, delay};
use lf_wire::{Message, MessageType};

use crate::rti::{CONNECTIONS, FEDERATES_MAX, World, config, with_world};

/// The most frequent messages of a joined federate.
const USUAL: &[MessageType] = &[
    MessageType::NextEventTag,
    MessageType::NextEventTag,
    MessageType::NextEventTag,
    MessageType::LatestTagComplete,
    MessageType::LatestTagComplete,
    MessageType::TaggedMessage,
    MessageType::TaggedMessage,
    MessageType::PortAbsent,
    MessageType::StopRequest,
    MessageType::StopReply,
    MessageType::AddressQuery,
    MessageType::Resign,
];

/// Lets federates of a graph that the input chooses join and start; then runs the steps in the input.
///
/// # Panics
/// If something does not hold that has to.
pub fn rti_structured(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok((choice, federates)) = <(u8, u8)>::arbitrary(&mut input) else { return };
    let federates = usize::from(federates) % FEDERATES_MAX + 1;
    // With authentication or clock synchronization no federate could join blindly.
    let config = config(choice & !0b101, federates);
    let has_transients = config.transients > 0;
    with_world(federates, config, |world| {
        // The end of the input ends the steps; reading it cannot fail otherwise.
        let joined = join(world, federates, has_transients, &mut input);
        let _ = joined.and_then(|()| run(world, federates, &mut input));
        world.settle();
    });
}

fn join(world: &mut World<'_>, federates: usize, has_transients: bool, input: &mut Unstructured<'_>) -> Result<()> {
    for (connection, id) in (0..federates).zip(0u16..) {
        let is_transient = has_transients && u8::arbitrary(input)? % 3 == 0;
        come(world, (connection, id), federates, is_transient, input)?;
    }
    Ok(())
}

/// Lets a federate come on a free connection, with any federates upstream of it.
fn come(
    world: &mut World<'_>,
    (connection, id): (usize, u16),
    federates: usize,
    is_transient: bool,
    input: &mut Unstructured<'_>,
) -> Result<()> {
    let mut upstream = Vec::new();
    for (from, _) in (0u16..).zip(0..federates) {
        if u8::arbitrary(input)? % 3 == 0 {
            upstream.push((from, delay(input)?));
        }
    }
    world.connect(connection);
    let introduce = if is_transient { transient_introduction } else { introduction };
    for message in introduce(id, FEDERATION_ID_DEFAULT, &upstream, &[]) {
        world.say_message(connection, &message);
    }
    world.say_message(connection, &Message::Timestamp(world.now()));
    Ok(())
}

fn run(world: &mut World<'_>, federates: usize, input: &mut Unstructured<'_>) -> Result<()> {
    while !input.is_empty() {
        let connection = usize::from(u8::arbitrary(input)?) % CONNECTIONS;
        match u8::arbitrary(input)? {
            0..180 => {
                let message_type = *input.choose(USUAL)?;
                let parts = parts::of_type(input, message_type, world.start())?;
                world.say_message(connection, &parts.message());
            }
            180..190 => {
                let parts = parts::any(input, world.start())?;
                world.say_message(connection, &parts.message());
            }
            190..240 => world.read(connection, usize::from(u8::arbitrary(input)?)),
            240..244 => world.connect(connection),
            244..248 => world.close(connection),
            248..251 => {
                let id = u16::from(u8::arbitrary(input)?) % u16::try_from(federates).unwrap_or(1);
                come(world, (connection, id), federates, true, input)?;
            }
            251..253 => world.pass(i64::from(u16::arbitrary(input)?) * 1_000_000),
            _ => {
                let count = usize::from(u8::arbitrary(input)?).min(input.len());
                let bytes = input.bytes(count)?.to_vec();
                world.say(connection, &bytes);
            }
        }
    }
    Ok(())
}

/// One step of the input of [`rti_raw`](crate::rti_raw).
#[derive(Clone, Debug)]
pub enum RawStep {
    /// A peer connects.
    Connect(u8),
    /// A peer closes its connection.
    Close(u8),
    /// A peer reads all bytes that are available to it.
    Read(u8),
    /// A peer sends bytes.
    Say(u8, Vec<u8>),
}

impl RawStep {
    /// Writes the step as `rti_raw` reads it. Connections are below 8.
    pub fn write(&self, target: &mut Vec<u8>) {
        match self {
            Self::Connect(connection) => target.push(connection % 8),
            Self::Close(connection) => target.push(8 + connection % 8),
            Self::Read(connection) => target.push(16 + connection % 8),
            Self::Say(connection, bytes) => {
                for piece in bytes.chunks(255) {
                    target.extend([32 + connection % 8, u8::try_from(piece.len()).unwrap_or(u8::MAX)]);
                    target.extend(piece);
                }
            }
        }
    }
}
