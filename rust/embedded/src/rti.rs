// SPDX-License-Identifier: Apache-2.0
//! The RTI of an image: its static memory, and how to run it.
//!
//! It runs in two steps, because a federate in the same image must find it listening: [`ImageRti::listen`], then
//! [`ImageRti::run`], perhaps from another thread.

use core::mem;

pub use lf_coordination::rti::ClockSync;
use lf_coordination::rti::{
    AfterLoss, Config, Connection, Node, Outcome, PathWords, RtiEvent, RtiStorage, START_REPORT, Slot,
};
use lf_model::time::{Interval, Tag};
use lf_runtime::platform::{Platform, SocketId};
use lf_runtime::trace::Recording;
pub use lf_runtime::{AUTHENTICATOR, Authenticator};
use lf_runtime::{Inlet, Outgoing, RtiError, RtiLoop, RtiPorts, RtiSetup, log_rti_event};
use log::LevelFilter;

use crate::cell::{Handover, Once, StaticSlot};
use crate::federate::larger;

/// An RTI's description of its federation.
#[derive(Clone, Copy, Debug)]
pub struct Description {
    /// The federation id, unless the image's settings have another.
    pub federation_id: &'static str,
    /// The functions by which federates prove that they know the federation id, if they have to.
    pub authentication: Option<Authenticator>,
    /// Clock synchronization.
    pub clock_sync: ClockSync,
    /// Whether to send DNETs.
    pub dnet: bool,
    /// The time after which a running federate's wait is logged, if at all.
    pub log_waits: Option<Interval>,
    /// The level of the log.
    pub logging: LevelFilter,
    /// Bytes of the longest forwarded payload.
    pub payload_bytes_max: usize,
}

impl Description {
    /// Returns the size of the buffer of each connection in each direction: that of the longest message of a federation
    /// of this many federates, and at least what the system asks for.
    pub const fn buffer_bytes(&self, federates: usize, minimum: usize) -> usize {
        larger(self.config(&[]).message_bytes_max(federates), minimum)
    }

    const fn config<'a>(&self, federation_id: &'a [u8]) -> Config<'a> {
        let mut config = Config::new(federation_id, self.payload_bytes_max);
        config.authentication = self.authentication;
        config.clock_sync = self.clock_sync;
        config.dnet = self.dnet;
        config.start_report = Some(START_REPORT);
        config.log_waits = self.log_waits;
        config.after_loss = AfterLoss::StopAll;
        config
    }
}

/// Returns the longest of some lengths; 0 of none.
pub const fn longest(lengths: &[usize]) -> usize {
    let (mut longest, mut index) = (0, 0);
    while index < lengths.len() {
        longest = larger(longest, lengths[index]);
        index += 1;
    }
    longest
}

/// The RTI of an image on a platform `P`, without the sizes in its type.
pub trait ImageRti<P>: Sync {
    /// Accepts federates on this TCP port, where 0 stands for any, and returns the port. The federation id is that of
    /// the description if this one is empty.
    ///
    /// # Errors
    /// The reason why it cannot.
    fn listen(
        &'static self,
        description: &Description,
        platform: P,
        port: u16,
        federation_id: &'static [u8],
    ) -> Result<u16, RtiError>;

    /// Runs the federation to its end.
    ///
    /// # Errors
    /// The reason why it ended early.
    fn run(&'static self, description: &Description, recording: Recording<'_>) -> Result<(), RtiError>;
}

/// The static memory of an RTI on a platform `P`, with storage `S`. It is all zero at first, so it takes no flash.
pub struct Memory<P, S> {
    listening: Handover<Listening<P>>,
    storage: Once<(S, StaticSlot<RtiLoop<'static, 'static, (), ()>>)>,
}

/// The RTI before it runs.
struct Listening<P> {
    platform: P,
    ports: RtiPorts,
    federation_id: &'static [u8],
}

impl<P: Platform + Send + 'static, S: Storage> Memory<P, S> {
    /// Returns the memory of an RTI that does not listen yet.
    #[expect(clippy::new_without_default, reason = "it is for statics, which cannot use Default")]
    pub const fn new() -> Self {
        Self { listening: Handover::new(), storage: Once::new((S::EMPTY, StaticSlot::EMPTY)) }
    }

    /// Constructs the event loop in place. Its stack frame is released before the loop runs.
    #[inline(never)]
    fn begin<'a, 'r: 'a, N: FnMut(RtiEvent<'_>)>(
        &'static self,
        description: &Description,
        recording: Recording<'r>,
        log: &'a mut N,
    ) -> Result<&'a mut RtiLoop<'a, 'static, P, N>, RtiError> {
        let Listening { platform, ports, federation_id } = self.listening.take().ok_or(RtiError::Order)?;
        let (storage, place) = self.storage.take().ok_or(RtiError::Order)?;
        let setup = storage.setup(description.config(federation_id), ports.datagrams);
        // It stays where it is written, and is not dropped.
        const { assert!(!mem::needs_drop::<RtiLoop<'_, '_, P, N>>(), "plain data and borrowed memory") };
        let rti = RtiLoop::new(platform, setup, ports.listener, log).map_err(RtiError::Setup)?;
        let rti = place.room().write(rti);
        rti.record(recording);
        Ok(rti)
    }
}

impl<P: Platform + Send + 'static, S: Storage> ImageRti<P> for Memory<P, S> {
    fn listen(
        &'static self,
        description: &Description,
        mut platform: P,
        port: u16,
        federation_id: &'static [u8],
    ) -> Result<u16, RtiError> {
        let mut actual = port;
        let listening = self.listening.put(|| {
            let ports = RtiPorts::open(&mut platform, port, description.clock_sync)?;
            actual = ports.tcp;
            let id = if federation_id.is_empty() { description.federation_id.as_bytes() } else { federation_id };
            Ok(Listening { platform, ports, federation_id: id })
        });
        listening.unwrap_or(Err(RtiError::Order)).map(|()| actual)
    }

    fn run(&'static self, description: &Description, recording: Recording<'_>) -> Result<(), RtiError> {
        let mut log = log_rti_event;
        match self.begin(description, recording, &mut log)?.run() {
            Outcome::Complete => Ok(()),
            outcome => Err(RtiError::Ended(outcome)),
        }
    }
}

/// The memory of an RTI and of its connections, without the sizes in its type.
pub trait Storage: Send + 'static {
    /// Fresh storage, all zero.
    const EMPTY: Self;

    /// Returns the parts of an RTI in this storage.
    fn setup(&'static mut self, config: Config<'static>, datagrams: Option<SocketId>) -> RtiSetup<'static>;
}

/// The memory of an RTI for these numbers of federates, transient ones among them, connections that can be open at
/// once, upstream federates of one, and different tags in transit to one (see [`RtiStorage`]); and of buffers of this
/// size.
pub struct Parts<
    const FEDERATES: usize,
    const TRANSIENTS: usize,
    const CONNECTIONS: usize,
    const UPSTREAM: usize,
    const IN_TRANSIT: usize,
    const BYTES: usize,
> {
    inputs: [[u8; BYTES]; CONNECTIONS],
    outputs: [[u8; BYTES]; CONNECTIONS],
    inlets: [StaticSlot<Inlet<&'static mut [u8]>>; CONNECTIONS],
    outgoings: [StaticSlot<Outgoing<&'static mut [u8]>>; CONNECTIONS],
    connections: [StaticSlot<Connection>; CONNECTIONS],
    slots: [StaticSlot<Slot>; FEDERATES],
    nodes: [StaticSlot<Node>; FEDERATES],
    paths: [[[PathWords; FEDERATES]; FEDERATES]; 2],
    upstream: [[PathWords; UPSTREAM]; FEDERATES],
    in_transit: [[StaticSlot<Tag>; IN_TRANSIT]; FEDERATES],
    #[cfg(feature = "transients")]
    registrations: [[bool; FEDERATES]; FEDERATES],
}

impl<
    const FEDERATES: usize,
    const TRANSIENTS: usize,
    const CONNECTIONS: usize,
    const UPSTREAM: usize,
    const IN_TRANSIT: usize,
    const BYTES: usize,
> Storage for Parts<FEDERATES, TRANSIENTS, CONNECTIONS, UPSTREAM, IN_TRANSIT, BYTES>
{
    const EMPTY: Self = {
        assert!(CONNECTIONS >= FEDERATES, "each federate of the RTI needs one connection");
        assert!(TRANSIENTS == 0 || cfg!(feature = "transients"), "transient federates need the feature `transients`");
        Self {
            inputs: [[0; BYTES]; CONNECTIONS],
            outputs: [[0; BYTES]; CONNECTIONS],
            inlets: [StaticSlot::EMPTY; CONNECTIONS],
            outgoings: [StaticSlot::EMPTY; CONNECTIONS],
            connections: [StaticSlot::EMPTY; CONNECTIONS],
            slots: [StaticSlot::EMPTY; FEDERATES],
            nodes: [StaticSlot::EMPTY; FEDERATES],
            paths: [[[[0; 2]; FEDERATES]; FEDERATES]; 2],
            upstream: [[[0; 2]; UPSTREAM]; FEDERATES],
            in_transit: [const { [StaticSlot::EMPTY; IN_TRANSIT] }; FEDERATES],
            #[cfg(feature = "transients")]
            registrations: [[false; FEDERATES]; FEDERATES],
        }
    };

    fn setup(&'static mut self, config: Config<'static>, datagrams: Option<SocketId>) -> RtiSetup<'static> {
        #[cfg(feature = "transients")]
        let config = Config { transients: u16::try_from(TRANSIENTS).unwrap_or(u16::MAX), ..config };
        RtiSetup {
            config,
            storage: RtiStorage {
                slots: fill(&mut self.slots, Slot::EMPTY),
                nodes: fill(&mut self.nodes, Node::EMPTY),
                connections: fill(&mut self.connections, Connection::EMPTY),
                paths: self.paths.as_flattened_mut().as_flattened_mut(),
                upstream: self.upstream.as_flattened_mut(),
                in_transit: fill(self.in_transit.as_flattened_mut(), Tag::NEVER),
                #[cfg(feature = "transients")]
                registrations: self.registrations.as_flattened_mut(),
            },
            inlets: StaticSlot::fill_all(&mut self.inlets, slices(&mut self.inputs).map(Inlet::new)),
            outgoings: StaticSlot::fill_all(&mut self.outgoings, slices(&mut self.outputs).map(Outgoing::new)),
            datagrams,
        }
    }
}

fn fill<T: Clone>(slots: &'static mut [StaticSlot<T>], value: T) -> &'static mut [T] {
    StaticSlot::fill_all(slots, core::iter::repeat(value))
}

/// Iterates over buffers without their length in the type.
fn slices<const BYTES: usize>(buffers: &mut [[u8; BYTES]]) -> impl Iterator<Item = &mut [u8]> {
    buffers.iter_mut().map(|bytes| &mut bytes[..])
}
