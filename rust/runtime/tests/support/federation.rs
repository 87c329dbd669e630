// SPDX-License-Identifier: Apache-2.0
//! Whole federations of [`Node`]s with an RTI, as participants of a [`Threads`].

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;
use std::sync::Mutex;

use lf_coordination::Deadline;
use lf_coordination::heap::{Growing, Memory, Sizes};
use lf_coordination::rti::{AfterLoss, ClockSync as RtiClockSync, Config, Outcome, RtiEvent, START_REPORT, SetupError};
use lf_model::time::{Interval, Tag};
use lf_model::{Engine, EngineStorage as _, Settings};
use lf_runtime::platform::{Endpoint, Interest, IpAddress, Platform as _, SocketId, Transfer};
use lf_runtime::trace::{Record, Recorder, Recording};
use lf_runtime::{
    AwaitedInput, Buffers, ClockSync, Coordination, DELAY_NONE, Federation, Inbound, Inlet, Join, Outbound, Outgoing,
    RtiLoop, RtiSetup, RunError, buffer_bytes, peer_buffer_bytes,
};
use lf_testkit::network::address_of;
use lf_wire::Storage;

use super::keys::{Host, with_host};
use super::lines;
use super::node::{Behavior, Late, Log, Node, NodeStorage, TardyStorage};
use super::profiles::{Parts, run_loop};
use lf_testkit::world::{Blocking, Conditions, Fault, LivenessViolation, Threads, Virtual};

/// The port of the first listener of a federate.
const FIRST_EPHEMERAL_PORT: u16 = 49_152;
/// The time that intruders stay.
pub(crate) const INTRUSION: Interval = Interval::from_secs(200);
/// The RTI's port.
pub(crate) const PORT: u16 = 15045;
/// The RTI's number among the participants; the federates follow, in order of id.
pub(crate) const RTI: usize = 0;
const ID: &[u8] = b"virtual";

/// A connection from a federate to another; `None` for no `after`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub from: u16,
    pub to: u16,
    pub delay: Option<Interval>,
    /// Whether the connection is physical.
    pub physical: bool,
    /// With decentralized coordination, the time that the receiver waits for messages, before a tag and within it.
    pub waits: (Interval, Interval),
}

/// Returns a connection without a delay and without waits.
pub(crate) fn edge(from: u16, to: u16) -> Edge {
    Edge { from, to, delay: None, physical: false, waits: (Interval::ZERO, Interval::ZERO) }
}

/// A federation, with its faults.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub nodes: Vec<Behavior>,
    pub edges: Vec<Edge>,
    /// Port numbers that all federates leave out, as if they had connections to themselves.
    pub own_ports: &'static [u16],
    /// The federates that come and go; they hand over how often their timer has fired.
    pub transients: &'static [u16],
    /// Capacity of each input's queue: 1, 2 or 16.
    pub capacity: usize,
    /// Whether events are recorded, and if so, whether with values.
    pub records: Option<bool>,
    pub timeout: Option<Interval>,
    /// The time-outs of federates that have another one.
    pub timeouts: BTreeMap<u16, Option<Interval>>,
    pub coordination: Coordination,
    pub fast: bool,
    pub keepalive: bool,
    /// Bytes of the receive buffers beyond the allowed minimum.
    pub spare_bytes: usize,
    pub trials: u16,
    pub federation_id: &'static [u8],
    /// Whether the RTI requires authentication.
    pub authentication: bool,
    /// Federates that authenticate if the RTI does not, and the reverse.
    pub otherwise: BTreeSet<u16>,
    pub log_waits: Option<Interval>,
    pub after_loss: AfterLoss,
    /// The times at which federates begin, if not at once.
    pub begins: BTreeMap<u16, Interval>,
    /// The RTI begins at this time; `None`: never.
    pub rti_begins: Option<Interval>,
    /// The address at which the federates look for the RTI.
    pub rti: IpAddress,
    /// Further addresses at which they look for it.
    pub others: Vec<IpAddress>,
    /// Federates that claim the id of another one.
    pub same_id: BTreeMap<u16, u16>,
    /// Federates that want to join another federation.
    pub strangers: BTreeSet<u16>,
    /// The intruders: each connects to a federate as soon as that listens, a number of times, and sends the same bytes
    /// on each connection.
    pub intruders: Vec<Intruder>,
    /// The participants with keys, by their number, and those whose key each of them has.
    pub keys: BTreeMap<usize, usize>,
    /// The faults: time, participant and kind.
    pub faults: Vec<(Interval, usize, Fault)>,
    /// The memory in bytes that the RTI's computer has for the input of one connection, and for its output.
    pub rti_memory: (usize, usize),
}

/// A program that is no federate, and connects to one.
#[derive(Clone, Debug)]
pub(crate) struct Intruder {
    /// The federate; `None` for the RTI.
    pub to: Option<u16>,
    pub connections: usize,
    pub says: Vec<u8>,
}

impl Intruder {
    /// Connects, and keeps its connections until it is interrupted.
    fn intrude(&self, platform: &mut Virtual) {
        let address = match self.to {
            Some(federate) => Endpoint::new(address_of(1 + usize::from(federate)), FIRST_EPHEMERAL_PORT),
            None => Endpoint::new(address_of(RTI), PORT),
        };
        for _ in 0..self.connections {
            while !self.connect(platform, address) {
                let later = platform.now() + Interval::from_millis(1);
                platform.wait(Deadline::At(later), &mut |_, _| {});
            }
        }
        while !platform.interrupted() {
            let later = platform.now() + Interval::from_secs(1);
            platform.wait(Deadline::At(later), &mut |_, _| {});
        }
    }

    fn connect(&self, platform: &mut Virtual, address: Endpoint) -> bool {
        let Ok(socket) = platform.connect(address) else { return false };
        platform.set_interest(socket, Interest::WRITE);
        let mut ready = false;
        while !ready && !platform.interrupted() {
            platform.wait(Deadline::Never, &mut |found, _| ready |= found == socket);
        }
        platform.set_interest(socket, Interest::NONE);
        let connected = platform.connected(socket).is_ok();
        if !connected {
            platform.close(socket);
            return false;
        }
        let mut rest = &self.says[..];
        while let [_, ..] = rest {
            match platform.write(socket, rest) {
                Ok(Transfer::Bytes(count)) => rest = &rest[count..],
                Ok(Transfer::WouldBlock) => {}
                other => panic!("so little finds room: {other:?}"),
            }
        }
        true
    }
}

impl Plan {
    pub(crate) fn new(nodes: Vec<Behavior>, edges: Vec<Edge>) -> Self {
        Self {
            nodes,
            edges,
            own_ports: &[],
            transients: &[],
            capacity: 2,
            records: Some(true),
            timeout: None,
            timeouts: BTreeMap::new(),
            coordination: Coordination::Centralized,
            fast: false,
            keepalive: false,
            spare_bytes: 0,
            trials: 3,
            federation_id: ID,
            authentication: false,
            otherwise: BTreeSet::new(),
            log_waits: None,
            after_loss: AfterLoss::GoOn,
            begins: BTreeMap::new(),
            rti_begins: Some(Interval::ZERO),
            rti: address_of(RTI),
            others: Vec::new(),
            same_id: BTreeMap::new(),
            strangers: BTreeSet::new(),
            intruders: Vec::new(),
            keys: BTreeMap::new(),
            faults: Vec::new(),
            rti_memory: (usize::MAX, usize::MAX),
        }
    }
}

impl Plan {
    /// Returns whether federates are in a cycle without delay.
    pub(crate) fn has_cycle(&self) -> bool {
        self.edges.iter().any(|edge| self.is_awaited(*edge))
    }

    /// Returns whether the receiver waits within a tag for messages over a connection: it reaches the sender without
    /// delay.
    fn is_awaited(&self, edge: Edge) -> bool {
        let mut reached = BTreeSet::from([edge.to]);
        let mut open = vec![edge.to];
        while let Some(at) = open.pop() {
            let next = self
                .edges
                .iter()
                .filter(|edge| edge.from == at && edge.delay.is_none() && !edge.physical)
                .map(|edge| edge.to);
            open.extend(next.filter(|next| reached.insert(*next)));
        }
        edge.delay.is_none() && !edge.physical && reached.contains(&edge.from)
    }
}

/// The results of a federation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Report {
    pub outcome: Option<Result<Outcome, SetupError>>,
    pub results: Vec<Result<(), RunError>>,
    /// The inputs that each federate has noted.
    pub logs: Vec<Log>,
    /// The tardy ones among them.
    pub late: Vec<Late>,
    /// The number of messages that each federate has counted as late.
    pub late_messages: Vec<u64>,
    /// The number of messages that each federate knows not to have arrived.
    pub lost_messages: Vec<u64>,
    /// The virtual time at which each federate ended.
    pub ended: Vec<Interval>,
    /// Whether each has run its shutdown reaction.
    pub shut_down: Vec<bool>,
    /// The log lines of each, at the level of information and above.
    pub lines: Vec<Vec<String>>,
    /// The log events of the RTI.
    pub log_events: Vec<String>,
    pub violation: Option<LivenessViolation>,
    /// The records of the RTI, and then of each federate.
    pub records: Vec<Vec<Record>>,
}

#[derive(Default)]
struct Results {
    outcome: Option<Result<Outcome, SetupError>>,
    log_events: Vec<String>,
    federates: BTreeMap<u16, (Ran, Interval)>,
}

/// The results of a federate.
#[derive(Debug, PartialEq)]
pub(crate) struct Ran {
    pub result: Result<(), RunError>,
    pub log: Log,
    pub late: Late,
    pub late_messages: u64,
    pub lost_messages: u64,
    pub shut_down: bool,
    pub lines: Vec<String>,
}

/// Runs a federation to its end, on computers, and with some seeds in images too, which makes no difference.
pub(crate) fn run(plan: &Plan, conditions: Conditions) -> Report {
    let report = run_once(plan, false, conditions);
    if conditions.seed % 4 == 1 {
        assert_eq!(run_once(plan, true, conditions), report, "in images");
    }
    report
}

fn run_once(plan: &Plan, in_image: bool, conditions: Conditions) -> Report {
    lines::keep();
    let world = Threads::new(conditions);
    let results = Mutex::new(Results::default());
    let rti = world.join(plan.rti_begins.unwrap_or(Interval::ZERO), Interval::ZERO);
    let federates: Vec<_> = (0..u16::try_from(plan.nodes.len()).unwrap())
        .map(|id| {
            // Each clock differs from the others by seconds.
            let offset = Interval::from_millis(i64::from(id) * 1700 - 900);
            (id, world.join(plan.begins.get(&id).copied().unwrap_or_default(), offset))
        })
        .collect();
    let intruders: Vec<_> =
        plan.intruders.iter().map(|intruder| (intruder, world.join(Interval::ZERO, Interval::ZERO))).collect();
    for (_, platform) in &intruders {
        world.plan(INTRUSION, platform.number(), Fault::Kill);
    }
    for (at, participant, fault) in &plan.faults {
        world.plan(*at, *participant, *fault);
    }
    std::thread::scope(|scope| {
        let results = &results;
        scope.spawn(move || {
            let mut platform = rti;
            platform.begin();
            if plan.rti_begins.is_some() {
                let mut log_events = Vec::new();
                let outcome = with_host(plan, platform, |host| run_the_rti(plan, host, &mut log_events));
                let mut results = results.lock().unwrap();
                (results.outcome, results.log_events) = (Some(outcome), log_events);
            }
        });
        for (id, mut platform) in federates {
            let world = world.clone();
            scope.spawn(move || {
                platform.begin();
                with_host(plan, platform, |host| {
                    let ran = match plan.capacity {
                        1 => run_node::<1>(plan, in_image, id, host),
                        2 => run_node::<2>(plan, in_image, id, host),
                        _ => run_node::<16>(plan, in_image, id, host),
                    };
                    results.lock().unwrap().federates.insert(id, (ran, world.now()));
                });
            });
        }
        for (intruder, mut platform) in intruders {
            scope.spawn(move || {
                platform.begin();
                intruder.intrude(&mut platform);
            });
        }
        world.start();
    });
    Report { records: world.records(), ..report(results.into_inner().unwrap(), world.violation()) }
}

/// Runs one federate, on a computer and then in an image, which makes no difference, while `act` plays its RTI, which
/// has accepted its connection, and all others; returns the results.
pub(crate) fn run_with<const N: usize, T: Debug + PartialEq + Send>(
    plan: &Plan,
    id: u16,
    clock_offset: Interval,
    act: impl Fn(&mut Blocking, SocketId) -> T + Sync,
) -> (Ran, T) {
    let [results, in_image] =
        [false, true].map(|in_image| run_once_with::<N, T>(plan, in_image, id, clock_offset, &act));
    assert_eq!(in_image, results, "in an image");
    results
}

fn run_once_with<const N: usize, T: Send>(
    plan: &Plan,
    in_image: bool,
    id: u16,
    clock_offset: Interval,
    act: impl FnOnce(&mut Blocking, SocketId) -> T + Send,
) -> (Ran, T) {
    lines::keep();
    let world = Threads::new(Conditions::seeded(1));
    let tester = world.join(Interval::ZERO, Interval::ZERO);
    let mut federate = world.join(Interval::from_millis(1), clock_offset);
    std::thread::scope(|scope| {
        let acted = scope.spawn(move || {
            let mut tester = Blocking::new(tester);
            let listener = tester.platform.listen(PORT).unwrap();
            let rti = tester.accept(listener);
            act(&mut tester, rti)
        });
        let ran = scope.spawn(move || {
            federate.begin();
            with_host(plan, federate, |host| run_node::<N>(plan, in_image, id, host))
        });
        world.start();
        (ran.join().unwrap(), acted.join().unwrap())
    })
}

fn report(results: Results, violation: Option<LivenessViolation>) -> Report {
    let Results { outcome, log_events, federates } = results;
    let mut report = Report {
        outcome,
        results: Vec::new(),
        logs: Vec::new(),
        late: Vec::new(),
        late_messages: Vec::new(),
        lost_messages: Vec::new(),
        ended: Vec::new(),
        shut_down: Vec::new(),
        lines: Vec::new(),
        log_events,
        violation,
        records: Vec::new(),
    };
    for (ran, ended) in federates.into_values() {
        report.results.push(ran.result);
        report.logs.push(ran.log);
        report.late.push(ran.late);
        report.late_messages.push(ran.late_messages);
        report.lost_messages.push(ran.lost_messages);
        report.ended.push(ended);
        report.shut_down.push(ran.shut_down);
        report.lines.push(ran.lines);
    }
    report
}

/// Memory that ends before its announced size.
struct Scarce {
    growing: Growing,
    memory: usize,
}

impl AsRef<[u8]> for Scarce {
    fn as_ref(&self) -> &[u8] {
        self.growing.as_ref()
    }
}

impl AsMut<[u8]> for Scarce {
    fn as_mut(&mut self) -> &mut [u8] {
        self.growing.as_mut()
    }
}

impl Storage for Scarce {
    fn bytes_usual(&self) -> usize {
        self.growing.bytes_usual()
    }

    fn bytes_max(&self) -> usize {
        self.growing.bytes_max()
    }

    fn grow(&mut self, bytes: usize) -> bool {
        bytes <= self.memory && self.growing.grow(bytes)
    }

    fn shrink(&mut self) {
        self.growing.shrink();
    }
}

fn run_the_rti(plan: &Plan, platform: &mut Host<'_>, log_events: &mut Vec<String>) -> Result<Outcome, SetupError> {
    let listener = platform.listen(PORT).unwrap();
    let count = plan.nodes.len();
    let connections = count + 2;
    let bytes = buffer_bytes(4, count);
    // The buffers are so short that most messages make them grow, and they shrink again afterwards.
    let buffer = |memory| Scarce { growing: Growing::new(1, 16, bytes), memory };
    let (input, output) = plan.rti_memory;
    let (mut inlets, mut outgoings): (Vec<_>, Vec<_>) =
        (0..connections).map(|_| (Inlet::new(buffer(input)), Outgoing::new(buffer(output)))).unzip();
    let mut memory = Memory::new(Sizes { federates: count, connections, upstream: count, in_transit: 64 });
    let setup = RtiSetup {
        config: Config {
            authentication: plan.authentication.then_some(lf_runtime::AUTHENTICATOR),
            after_loss: plan.after_loss,
            start_report: Some(START_REPORT),
            log_waits: plan.log_waits,
            clock_sync: RtiClockSync::Init { trials: plan.trials.into() },
            ..Config::new(plan.federation_id, 4)
        },
        storage: memory.storage(),
        inlets: &mut inlets,
        outgoings: &mut outgoings,
        datagrams: None,
    };
    let (mut recorder, mut log) =
        (platform.inner().recorder(), |event: RtiEvent<'_>| log_events.push(event.to_string()));
    let mut rti = RtiLoop::new(platform, setup, listener, &mut log)?;
    if let Some(values) = plan.records {
        rti.record(Recording::new(&mut recorder, values));
    }
    Ok(rti.run())
}

/// Returns the configuration of the federate in the federation.
pub(crate) fn federation_of(plan: &Plan, id: u16) -> Federation {
    let mut upstream: BTreeMap<u16, i64> = BTreeMap::new();
    for edge in plan.edges.iter().filter(|edge| edge.to == id && !edge.physical) {
        let delay = edge.delay.map_or(DELAY_NONE, Interval::as_nanos);
        upstream.entry(edge.from).and_modify(|least| *least = delay.min(*least)).or_insert(delay);
    }
    let from = |physical: bool| plan.edges.iter().filter(move |edge| edge.from == id && edge.physical == physical);
    let downstream: BTreeSet<u16> = from(false).map(|edge| edge.to).collect();
    let all_direct = plan.coordination == Coordination::Decentralized;
    let is_direct = |edge: &&Edge| edge.physical || all_direct;
    let peers_out: BTreeSet<u16> =
        plan.edges.iter().filter(|edge| edge.from == id).filter(is_direct).map(|edge| edge.to).collect();
    let peers_in: BTreeSet<u16> =
        plan.edges.iter().filter(|edge| edge.to == id).filter(is_direct).map(|edge| edge.from).collect();
    let direct = plan.edges.iter().filter(|edge| edge.to == id && edge.physical);
    let physical_delay = direct.map(|edge| edge.delay.unwrap_or_default()).min();
    let bytes = buffer_bytes(4, plan.nodes.len());
    Federation {
        id,
        federation_id: "virtual",
        coordination: plan.coordination,
        authentication: (plan.authentication != plan.otherwise.contains(&id)).then_some(lf_runtime::answer_rti),
        federates: u16::try_from(plan.nodes.len()).unwrap(),
        rti_host: "10.0.0.1",
        rti_port: PORT,
        upstream: upstream.into_iter().collect::<Vec<_>>().leak(),
        downstream: downstream.into_iter().collect::<Vec<_>>().leak(),
        awaited: &[],
        cycles: true,
        clock_sync: ClockSync::Init { trials: plan.trials },
        local_clock_sync: true,
        test_offset: Interval::ZERO,
        physical_delay: plan.nodes[usize::from(id)].physical.then_some(Interval::ZERO).or(physical_delay),
        advance_interval: Interval::from_millis(10),
        log_waits: plan.log_waits,
        // Images, whose runs are the same, offer none.
        window: 0,
        input_bytes: bytes + plan.spare_bytes,
        output_bytes: bytes,
        peers_in: peers_in.into_iter().collect::<Vec<_>>().leak(),
        peers_out: peers_out.into_iter().collect::<Vec<_>>().leak(),
        transients: plan.transients,
        untagged: plan.edges.iter().any(|edge| edge.physical),
        peer_input_bytes: peer_buffer_bytes(4),
        peer_output_bytes: peer_buffer_bytes(4),
    }
}

/// Runs one federate of a federation on this platform, perhaps as in an image.
pub(crate) fn run_node<const N: usize>(plan: &Plan, in_image: bool, id: u16, platform: &mut Host<'_>) -> Ran {
    // A connection's port is its position among the connections to its destination, those to itself included.
    let port_of = |index: usize| {
        let to = plan.edges[index].to;
        let others = plan.edges[..index].iter().filter(|edge| edge.to == to).count();
        (0..).filter(|port| !plan.own_ports.contains(port)).nth(others).unwrap()
    };
    let is_decentralized = plan.coordination == Coordination::Decentralized;
    let waits = |edge: Edge| (is_decentralized && !edge.physical).then_some(edge.waits);
    let edges = || plan.edges.iter().copied().enumerate();
    let inputs: Vec<_> = edges()
        .filter(|(_, edge)| edge.to == id)
        .map(|(index, edge)| (edge.from, port_of(index), edge.delay, plan.is_awaited(edge), edge.physical, waits(edge)))
        .collect();
    let outputs: Vec<_> = edges()
        .filter(|(_, edge)| edge.from == id)
        .map(|(index, edge)| (edge.to, port_of(index), edge.delay, plan.is_awaited(edge), edge.physical, None))
        .collect();
    let behavior = plan.nodes[usize::from(id)];
    let mut node = Node::<N>::new(behavior, platform.inner().side(), &inputs, &outputs).with_own_ports(plan.own_ports);
    #[cfg(feature = "transients")]
    if plan.transients.contains(&id) {
        node = node.with_state();
    }
    let (mut storage, mut tardy_storage) = (NodeStorage::new(), TardyStorage::new());
    let Plan { fast, keepalive, .. } = *plan;
    let timeout = plan.timeouts.get(&id).copied().unwrap_or(plan.timeout);
    let settings = Settings { federated: true, timeout, fast, keepalive };
    let tables = lf_model::Program::tables(&node);
    let engine = if is_decentralized {
        Engine::new(tables, &mut tardy_storage, settings)
    } else {
        Engine::new(tables, &mut storage, settings)
    };
    let awaited =
        (0..).zip(tables.inputs).filter(|(_, input)| if is_decentralized { !input.physical } else { input.awaited });
    let awaited: Vec<_> = awaited.map(|(port, input)| AwaitedInput { port, level: input.level }).collect();
    let federation = Federation {
        id: plan.same_id.get(&id).copied().unwrap_or(id),
        awaited: awaited.leak(),
        ..federation_of(plan, id)
    };
    let (mut input, mut output) = (vec![0; federation.input_bytes], vec![0; federation.output_bytes]);
    let federation_id: &[u8] = if plan.strangers.contains(&id) { b"another" } else { plan.federation_id };
    let others: Vec<_> = plan.others.iter().map(|ip| Endpoint::new(*ip, PORT)).collect();
    let join = Join { federation_id, rti: Endpoint::new(plan.rti, PORT), others: &others };
    let mut peer_inputs = vec![vec![0; federation.peer_input_bytes]; federation.peers_in.len()];
    let mut peer_outputs = vec![vec![0; federation.peer_output_bytes]; federation.peers_out.len()];
    let mut inbound: Vec<_> = peer_inputs.iter_mut().map(|bytes| Inbound::new(bytes)).collect();
    let mut outbound: Vec<_> = peer_outputs.iter_mut().map(|bytes| Outbound::new(bytes)).collect();
    let buffers = Buffers::new(&mut input, &mut output).with_peers(&mut outbound, &mut inbound);
    let mut known = vec![Tag::NEVER; federation.awaited.len()];
    let mut recorder = platform.inner().recorder();
    let parts = Parts {
        program: &mut node,
        engine,
        federation: &federation,
        join: &join,
        buffers,
        known: &mut known,
        recorder: plan.records.map(|values| (&mut recorder as &mut dyn Recorder, values)),
    };
    let (result, late_messages, lost_messages) = run_loop(plan, in_image, platform, parts);
    Ran {
        result,
        log: node.log,
        late: node.late,
        late_messages,
        lost_messages,
        shut_down: node.ended,
        lines: lines::take(),
    }
}
