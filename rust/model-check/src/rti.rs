// SPDX-License-Identifier: Apache-2.0
//! The RTI as part of a state: between two messages it lies suspended in its memory.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use ahash::RandomState;
use lf_coordination::heap::{Memory, Sizes};
use lf_coordination::rti::{ClockSync, Config, ConnectionId, Outlet, Rti, RtiEvent, Suspended, Verdict};
use lf_coordination::{from_wire, to_wire};
use lf_model::time::Instant;
use lf_testkit::messages::{encoded, introduction, transient_introduction};
use lf_wire::Message;

use crate::bounds::{Bounds, Fault};
use crate::graph::Delay;
use crate::messages::{ToFederate, ToRti, Violation};
use crate::small_tag::START;
use crate::world::World;

const FEDERATION_ID: &[u8] = b"model";
/// Messages carry no payload, because the RTI does not look at it.
const PAYLOAD_BYTES_MAX: usize = 0;
const NOW: Instant = Instant::from_nanos(0);
/// The time after the start where a federate comes and goes: what the RTI grants then does not wait for its clock.
const LATER: Instant = Instant::from_nanos(START.as_nanos() + 1000);
/// The fixed seeds of hashes, which make runs reproducible.
const HASHES: RandomState = RandomState::with_seeds(1, 2, 3, 4);

/// A suspended RTI. All states share it between which it reads nothing.
#[derive(Clone)]
pub(crate) struct Suspension {
    contents: Arc<Contents>,
    /// The hash of the contents, computed once rather than for every state.
    hash: u64,
}

#[derive(Clone, PartialEq, Eq, Hash)]
struct Contents {
    memory: Memory,
    rest: Option<Suspended>,
}

impl Contents {
    fn new(world: &World) -> Self {
        let federates = world.graph.federates();
        let in_transit = world.bounds.in_transit.into();
        let sizes = Sizes { federates, connections: world.instances(), upstream: federates, in_transit };
        Self { memory: Memory::new(sizes), rest: None }
    }

    /// Resumes the RTI, calls `act` with it, and suspends it again.
    fn with<R>(&mut self, bounds: &Bounds, act: impl FnOnce(&mut Rti<'_>) -> R) -> R {
        let Bounds { dnet, window, .. } = *bounds;
        let transients = u16::from(bounds.transient.is_some());
        let config = Config {
            clock_sync: ClockSync::Off,
            dnet,
            window,
            transients,
            ..Config::new(FEDERATION_ID, PAYLOAD_BYTES_MAX)
        };
        let storage = self.memory.storage();
        let rti = match self.rest {
            Some(rest) => Rti::resume(config, storage, rest),
            None => Rti::new(config, storage),
        };
        let mut rti = rti.expect("the storage is made for this number of federates");
        let result = act(&mut rti);
        self.rest = Some(rti.suspend());
        result
    }

    fn suspend(self) -> Suspension {
        Suspension { hash: HASHES.hash_one(&self), contents: Arc::new(self) }
    }
}

impl Suspension {
    /// Returns an RTI that has just started the federation, without the federate that is `absent`.
    ///
    /// # Panics
    /// If the RTI does not start the federation, which would be a defect in it or here.
    pub(crate) fn started(world: &World, absent: Option<usize>) -> Self {
        let mut contents = Contents::new(world);
        let mut outlet = Collected::new(world);
        let transient = world.bounds.transient.map(usize::from);
        contents.with(&world.bounds, |rti| {
            // The start does not wait for a transient federate, so that one comes first.
            let others = (0..world.graph.federates()).filter(|id| Some(*id) != transient);
            for id in transient.into_iter().chain(others).filter(|id| Some(*id) != absent) {
                introduce(rti, world, id, NOW, &mut outlet);
                let verdict = rti.handle_input(NOW, ConnectionId(id), &clock(), &mut outlet);
                assert!(matches!(verdict, Verdict::Consumed(_)), "the clock of {id}: {verdict:?}");
            }
            assert_eq!(rti.start_time(), Some(START), "all have come");
        });
        contents.suspend()
    }

    /// Lets the RTI meet an instance of the transient federate that comes while the federation runs: the handshake up
    /// to its clock. Returns the RTI's new state and the messages that it sent.
    pub(crate) fn meet(&self, world: &World, instance: usize) -> (Self, Collected) {
        let mut contents = Contents::clone(&self.contents);
        let mut outlet = Collected::new(world);
        contents.with(&world.bounds, |rti| introduce(rti, world, instance, LATER, &mut outlet));
        (contents.suspend(), outlet)
    }

    /// Lets the RTI read the next message of an instance. Returns `None` if the message has to wait, else the RTI's new
    /// state and the messages that it sent.
    pub(crate) fn hear(&self, world: &World, from: usize, message: ToRti) -> Option<(Self, Collected)> {
        let bounds = &world.bounds;
        let mut contents = Contents::clone(&self.contents);
        let mut outlet = Collected::new(world);
        let now = if bounds.transient.is_some() { LATER } else { NOW };
        let port = number(world.federate(from));
        let bytes = match message {
            ToRti::Clock => clock(),
            ToRti::Next(tag) => encoded(&Message::NextEventTag(to_wire(tag))),
            ToRti::Complete(at) => encoded(&Message::LatestTagComplete(to_wire(at.tag()))),
            ToRti::Message { to, at } => {
                encoded(&Message::TaggedMessage { port, federate: to.into(), tag: to_wire(at.tag()), payload: &[] })
            }
            ToRti::Absent { to, at } => {
                encoded(&Message::PortAbsent { port, federate: to.into(), tag: to_wire(at.tag()) })
            }
            ToRti::Resign => encoded(&Message::Resign),
            ToRti::End => {
                contents.with(bounds, |rti| rti.handle_disconnect(now, ConnectionId(from), &mut outlet));
                return Some((contents.suspend(), outlet));
            }
        };
        let verdict = contents.with(bounds, |rti| {
            let verdict = rti.handle_input(now, ConnectionId(from), &bytes, &mut outlet);
            if message == ToRti::Resign {
                rti.handle_disconnect(now, ConnectionId(from), &mut outlet);
            }
            verdict
        });
        match verdict {
            Verdict::Consumed(len) if len == bytes.len() => Some((contents.suspend(), outlet)),
            // Nothing has changed, so this is no step.
            Verdict::Held(_) | Verdict::HeldReadOn(_) => None,
            Verdict::Consumed(_) | Verdict::Incomplete(_) | Verdict::Blocked(_) | Verdict::Closed => {
                outlet.violation = Some(Violation::Refused { from: from.try_into().unwrap_or(u8::MAX) });
                Some((contents.suspend(), outlet))
            }
        }
    }
}

impl PartialEq for Suspension {
    fn eq(&self, other: &Self) -> bool {
        self.hash == other.hash && self.contents == other.contents
    }
}

impl Eq for Suspension {}

impl Hash for Suspension {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.hash.hash(state);
    }
}

impl std::fmt::Debug for Suspension {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Suspension").field("hash", &self.hash).finish_non_exhaustive()
    }
}

/// The messages of the RTI to each instance.
pub(crate) struct Collected {
    pub(crate) said: Vec<Vec<ToFederate>>,
    pub(crate) violation: Option<Violation>,
}

impl Collected {
    fn new(world: &World) -> Self {
        Self { said: vec![Vec::new(); world.instances()], violation: None }
    }
}

impl Outlet for Collected {
    fn room(&self, _: ConnectionId) -> usize {
        usize::MAX
    }

    fn send(&mut self, ConnectionId(to): ConnectionId, message: &Message<'_>) {
        let sender = |port: u16| u8::try_from(port).unwrap_or(u8::MAX);
        let said = match *message {
            Message::TagGrant(tag) => ToFederate::Grant(from_wire(tag)),
            Message::ProvisionalTagGrant(tag) => ToFederate::Provisional(from_wire(tag)),
            Message::DownstreamNextEventTag(tag) => ToFederate::DownstreamNext(from_wire(tag)),
            Message::TaggedMessage { port, tag, .. } => ToFederate::Message { from: sender(port), tag: from_wire(tag) },
            Message::PortAbsent { port, tag, .. } => ToFederate::Absent { from: sender(port), tag: from_wire(tag) },
            Message::EffectiveStart { tag, .. } => ToFederate::Begins(from_wire(tag)),
            Message::UpstreamConnected { federate } => ToFederate::Came(sender(federate)),
            Message::UpstreamDisconnected { federate } => ToFederate::Left(sender(federate)),
            Message::Stop => ToFederate::Stop,
            // The handshake is the same for all.
            _ => return,
        };
        self.said[to].push(said);
    }

    fn half_close(&mut self, _: ConnectionId) {}

    fn close(&mut self, ConnectionId(of): ConnectionId) {
        self.violation = Some(Violation::Expelled { federate: of.try_into().unwrap_or(u8::MAX) });
    }

    fn log(&mut self, event: RtiEvent<'_>) {
        match event {
            RtiEvent::InTransitFull(federate) => {
                self.violation = Some(Violation::InTransitFull { federate: federate.0.try_into().unwrap_or(u8::MAX) });
            }
            RtiEvent::Late { to, .. } => {
                self.violation = Some(Violation::CalledLate { federate: to.0.try_into().unwrap_or(u8::MAX) });
            }
            _ => {}
        }
    }
}

/// Lets an instance make its handshake up to its clock.
fn introduce(rti: &mut Rti<'_>, world: &World, instance: usize, now: Instant, outlet: &mut Collected) {
    let World { graph, bounds, .. } = world;
    let id = world.federate(instance);
    let told = |delay: Delay| match (bounds.fault, delay) {
        (Some(Fault::DelaysTooLong), Delay::Zero | Delay::Microstep) => 1,
        (Some(Fault::DelaysTooLong), Delay::Tick) => 2,
        _ => delay.wire(),
    };
    let upstream: Vec<_> = graph.upstream(id).map(|(from, delay)| (number(from), told(delay))).collect();
    let downstream: Vec<_> = graph.downstream(id).map(|(to, _)| number(to)).collect();
    let localhost = lf_coordination::IpAddress::V4([127, 0, 0, 1].into());
    rti.handle_connect(now, ConnectionId(instance), localhost, [0; 8], outlet);
    let introduce = if world.is_transient(id) { transient_introduction } else { introduction };
    for message in introduce(number(id), FEDERATION_ID, &upstream, &downstream) {
        let verdict = rti.handle_input(now, ConnectionId(instance), &encoded(&message), outlet);
        if !matches!(verdict, Verdict::Consumed(_)) {
            outlet.violation = Some(Violation::Refused { from: instance.try_into().unwrap_or(u8::MAX) });
        }
    }
}

/// Returns the bytes with which a federate says its clock.
fn clock() -> Vec<u8> {
    encoded(&Message::Timestamp(0))
}

fn number(federate: usize) -> u16 {
    federate.try_into().unwrap_or(u16::MAX)
}
