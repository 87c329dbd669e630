// SPDX-License-Identifier: Apache-2.0
//! One run of a scenario: the RTI and all federates, each with its real event loop, in one thread and in virtual time.

mod alone;
mod federate;
mod reports;
mod rti;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use lf_compiler::plan::{Federate, InputIndex, Plan};
use lf_coordination::rti::{Outcome, RtiEvent};
use lf_model::time::{Instant, Interval, Tag};
use lf_model::{Payload as _, Program as _, Tables, TriggerInfo, TriggerKind};
use lf_runtime::trace::{Event, Record};
use lf_runtime::{RunError, Turn};
use lf_testkit::random::combine;
use lf_testkit::trace::{Records, with_values};
use lf_testkit::world::{Shared, Side};

pub(crate) use alone::{Decided, Joined, run_alone, work_alone};
pub(crate) use reports::Reports;

use crate::check::{Counts, Introduction, Seen, Sent, Unpassed, Violation};
use crate::program::{BuildError, Handled, Played, Record as Ran, Value};
use crate::scenario::{Fault, FaultKind, Scenario};
use crate::world::{SimulatedMedium, World, strike, world};
use federate::{FederateMemory, Member};
use rti::{Centre, RtiBuffers, RtiMemory};

/// A federation that takes this many turns without a reaction, or without a turn of the RTI, makes no progress. Turns
/// of clock synchronization do not count, since they continue in any federation.
const IDLE_TURNS_MAX: u64 = 200_000;
/// A federation that runs no reaction for this much virtual time makes no progress either.
const IDLE_TIME_MAX_NS: u64 = 200_000_000_000;
/// After this many reactions, or turns, the run is cut short: it has shown enough.
const REACTIONS_MAX: u64 = 200_000;
const TURNS_MAX: u64 = 1_000_000;
/// Rounds of clock synchronization make that many more turns, while a federate that gets no room waits for a minute.
const ROUNDS: u64 = 10;

/// The end of a federate.
#[derive(Clone, Debug)]
pub(crate) enum FederateEnd {
    Ended(Result<(), RunError>),
    /// The federate vanished, or the run ended before it did.
    Gone,
}

/// The log events of the RTI.
#[derive(Clone, Debug, Default)]
pub(crate) struct RtiLog {
    started: Option<Instant>,
    pub(crate) overflow: bool,
    pub(crate) late: bool,
    pub(crate) dropped: bool,
}

/// The results of a run.
#[derive(Debug)]
pub(crate) struct Report {
    /// The RTI's outcome, if it ended.
    pub(crate) rti: Option<Outcome>,
    pub(crate) ends: Vec<FederateEnd>,
    pub(crate) traces: Vec<Vec<Ran>>,
    /// The stops that reactions requested.
    pub(crate) stops: Vec<Tag>,
    /// By instance: the times of physical actions.
    pub(crate) played: Vec<Played>,
    /// The recordings of the RTI, and then of each federate, as far as they recorded.
    pub(crate) records: Vec<Option<Records>>,
    pub(crate) rti_log: RtiLog,
    /// The faults that occurred, with their participants, as planned.
    pub(crate) struck: Vec<(usize, FaultKind)>,
    /// By federate: the granted stop, and the tag before which the RTI has received all its messages.
    pub(crate) granted: Vec<Option<Tag>>,
    pub(crate) announced: Vec<Tag>,
    /// By federate: whether it has proposed a stop tag or agreed to one.
    has_named: Vec<bool>,
    /// By federate and input: the capacity of its queue, and the largest number of messages for one tag.
    pub(crate) capacities: Vec<Vec<usize>>,
    /// By federate and input: the sender.
    pub(crate) senders: Vec<Vec<usize>>,
    /// By federate: the virtual time of its end.
    pub(crate) ended: Vec<Option<u64>>,
    pub(crate) bursts: Vec<Vec<usize>>,
    pub(crate) counts: Counts,
    /// With decentralized coordination: all messages between federates, and their outcomes.
    pub(crate) sent: Vec<Sent>,
    /// By federate: the time at which the RTI read that it had left.
    pub(crate) left: Vec<Option<u64>>,
    /// By instance: its effective start, if it is one of a transient federate, and the time from which on it is over.
    pub(crate) first: Vec<Option<Tag>>,
    pub(crate) over: Vec<Option<u64>>,
    /// By instance: what other ones have handed over to it.
    pub(crate) handovers: Vec<HandedState>,
    /// By instance: whether its program or the RTI has ended it, and the last tag that it has reported complete.
    pub(crate) may_leave: Vec<bool>,
    pub(crate) completed: Vec<Tag>,
    /// The messages that the RTI has read and not forwarded.
    pub(crate) unpassed: Vec<Unpassed>,
    pub(crate) lateness: Vec<Lateness>,
    /// The clocks of all participants.
    pub(crate) sides: Vec<&'static Side>,
    pub(crate) refused_writes: u64,
    pub(crate) fullest_percent: usize,
    /// Whether the run was cut short because it had shown enough.
    pub(crate) cut_short: bool,
    /// A hash of the whole run.
    pub(crate) digest: u64,
    pub(crate) violation: Option<Violation>,
}

impl Report {
    pub(crate) fn started(&self) -> Option<Instant> {
        self.rti_log.started
    }

    /// Returns the work of each federate's reactions, by time after the start, of each tag at that time.
    pub(crate) fn work(&self, scenario: &Scenario) -> Option<Vec<BTreeMap<i64, Vec<i64>>>> {
        alone::work(scenario, self.started()?, self.traces.iter().flatten())
    }

    /// Returns the times of physical actions of all federates that are there once.
    pub(crate) fn all_played(&self) -> Played {
        self.played.iter().flatten().map(|(name, events)| (name.clone(), events.clone())).collect()
    }

    /// Returns whether an instance has ended in order.
    pub(crate) fn has_ended(&self, instance: usize) -> bool {
        matches!(self.ends[instance], FederateEnd::Ended(Ok(())))
    }

    /// Returns whether a fault affected a federate.
    pub(crate) fn is_struck(&self, federate: usize) -> bool {
        self.struck.iter().any(|(participant, _)| *participant == federate + 1)
    }

    /// Returns a participant that is no instance of a transient federate and that a fault affected.
    pub(crate) fn struck_persistent(&self, scenario: &Scenario) -> Option<usize> {
        let stays = |participant: &usize| *participant == 0 || !scenario.is_transient(participant - 1);
        self.struck.iter().map(|(participant, _)| *participant).find(stays)
    }

    /// Returns the last tag of all federates, if one follows from the program and the granted stop.
    pub(crate) fn stop_tag(&self, scenario: &Scenario) -> Option<Tag> {
        let timeout = scenario.target.timeout.and_then(|ns| Some(self.started()? + Interval::from_nanos(ns)));
        [timeout.map(Tag::at), self.granted_stop()].into_iter().flatten().min()
    }

    /// Returns whether a federate had ended by itself before the others agreed to stop.
    pub(crate) fn left_before_stop(&self, federate: usize) -> bool {
        self.granted_stop().is_some() && (self.granted[federate].is_none() || !self.has_named[federate])
    }

    /// Returns the granted stop, if there is one.
    pub(crate) fn granted_stop(&self) -> Option<Tag> {
        self.granted.iter().flatten().copied().min()
    }
}

/// The state of an instance that is handed over in a swap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HandedState {
    /// Whether it has waited for its place while another one has handed over its state.
    pub(crate) is_next: bool,
    /// The state that it has taken over.
    pub(crate) taken: Option<u64>,
    /// Its last state, if it hands that over.
    pub(crate) last: Option<u64>,
}

impl HandedState {
    fn of(introduction: Introduction) -> Self {
        Self { is_next: introduction == Introduction::Next, taken: None, last: None }
    }
}

/// A federate's treatment of late messages.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lateness {
    /// The numbers of late messages that it has counted, and reported.
    pub(crate) counted: u64,
    /// The number of its own messages that did not reach their receivers, as it reports.
    pub(crate) lost: u64,
    pub(crate) reports: Reports,
    /// By network input: the handled messages.
    pub(crate) handled: Vec<Vec<Handled>>,
    /// The tags at which handlers ran.
    pub(crate) handlers: Vec<Tag>,
    pub(crate) mishandled: Option<Tag>,
}

/// A participant, before, while and after it takes part.
enum Participant<'a> {
    NotYet(ParticipantMemory<'a>),
    Rti(Box<Centre<'a>>),
    Federate(Box<Member<'a>>),
    Gone,
}

/// The memory that a participant will use.
enum ParticipantMemory<'a> {
    Rti(&'a mut RtiMemory<'a>),
    Federate(&'a mut FederateMemory),
}

/// The result of a participant's turn.
enum Step {
    Wait(lf_coordination::Deadline),
    Outcome(Outcome),
    End(Result<(), RunError>),
}

impl Participant<'_> {
    fn turn(&mut self) -> Step {
        if let Self::NotYet(_) = self {
            let Self::NotYet(seat) = std::mem::replace(self, Self::Gone) else { return Step::End(Ok(())) };
            let made = match seat {
                ParticipantMemory::Rti(memory) => memory.begin().map(|made| Participant::Rti(Box::new(made))),
                ParticipantMemory::Federate(memory) => memory.begin().map(|made| Participant::Federate(Box::new(made))),
            };
            match made {
                Ok(made) => *self = made,
                Err(error) => return Step::End(Err(error)),
            }
        }
        match self {
            Self::Rti(rti) => {
                rti.wait(lf_coordination::Deadline::Now);
                match rti.turn() {
                    Turn::Wait(until) => Step::Wait(until),
                    Turn::Ended(outcome) => Step::Outcome(outcome),
                }
            }
            Self::Federate(federate) => {
                federate.wait(lf_coordination::Deadline::Now);
                match federate.turn() {
                    Turn::Wait(until) => Step::Wait(until),
                    Turn::Ended(result) => Step::End(result),
                }
            }
            Self::NotYet(_) | Self::Gone => Step::End(Ok(())),
        }
    }
}

/// The outputs of a run besides its report.
#[derive(Clone, Copy, Default)]
pub(crate) struct OutputOptions {
    /// Whether to print all messages.
    pub(crate) prints: bool,
    /// Whether all participants record their events.
    pub(crate) records: bool,
}

/// Returns the recorders of all participants that record, which are `all` or those with physical actions.
fn recorders(scenario: &Scenario, all: bool) -> Vec<Option<Records>> {
    // The recordings show the times of physical actions.
    let of_federates = all || scenario.has_physical_actions();
    let is_kept = |participant: usize| if participant == 0 { all } else { of_federates };
    (0..=scenario.instances.len()).map(|participant| is_kept(participant).then(Records::default)).collect()
}

/// Runs a scenario whose federation has this plan.
pub(crate) fn run(scenario: &Scenario, plan: &Plan, options: OutputOptions) -> Result<Report, BuildError> {
    let OutputOptions { prints, records } = options;
    reports::listen();
    reports::take();
    let world = world(scenario, combine(scenario.seed, 11));
    world.lock().network.medium_mut().watch.prints = prints;
    let rti_log = Rc::new(RefCell::new(RtiLog::default()));
    let mut buffers = RtiBuffers::new(scenario, plan.federates.len());
    let (instances, records) = (scenario.instances.len(), recorders(scenario, records));
    let log_events = note_into(Rc::clone(&rti_log), prints);
    let mut rti = RtiMemory::new(scenario, plan, world.platform(0), log_events, &mut buffers, records[0].clone());
    let mut federates = Vec::new();
    for instance in 0..instances {
        let (platform, records) = (world.platform(instance + 1), records[instance + 1].clone());
        federates.push(FederateMemory::new(scenario, plan, instance, platform, records)?);
    }
    let mut stage = Stage::new(scenario, &mut rti, &mut federates);
    let violation = stage.play(&world, &rti_log);
    let Stage { ends, ended, counted, outcome, struck, turns, participants, cut_short, .. } = stage;
    drop(participants);
    let world = world.lock();
    let SimulatedMedium { watch, refused_writes, .. } = world.network.medium();
    let planned = || scenario.instances.iter().map(|federate| &plan.federates[*federate]);
    let mut report = Report {
        rti: outcome,
        ends,
        traces: Vec::new(),
        stops: Vec::new(),
        played: Vec::new(),
        records: records.clone(),
        rti_log: rti_log.borrow().clone(),
        struck,
        granted: watch.seen.iter().map(|seen| seen.stop).collect(),
        capacities: planned().map(capacities).collect(),
        senders: planned().map(senders).collect(),
        ended,
        bursts: planned().zip(&watch.seen).map(|(federate, seen)| bursts(federate, seen)).collect(),
        has_named: watch.seen.iter().map(|seen| seen.has_named).collect(),
        announced: watch.seen.iter().map(|seen| seen.announced).collect(),
        counts: watch.counts,
        sent: watch.direct.sent.iter().filter_map(|sent| to_input(scenario, plan, sent)).collect(),
        first: watch.seen.iter().map(|seen| seen.first).collect(),
        over: watch.seen.iter().map(Seen::over).collect(),
        handovers: watch.seen.iter().map(|seen| HandedState::of(seen.introduction)).collect(),
        may_leave: watch.seen.iter().map(|seen| seen.is_told_to_stop || seen.is_expelled).collect(),
        completed: watch.seen.iter().map(|seen| seen.completed).collect(),
        unpassed: watch.unpassed.clone(),
        left: watch.seen.iter().map(|seen| seen.left).collect(),
        lateness: Vec::new(),
        sides: (0..=instances).map(|participant| world.side(participant)).collect(),
        refused_writes: *refused_writes,
        fullest_percent: 0,
        digest: combine(watch.digest, turns),
        cut_short,
        violation: watch.violation.clone().or(violation),
    };
    for (instance, memory) in federates.into_iter().enumerate() {
        report.take(instance, memory, counted[instance]);
    }
    Ok(report)
}

impl Report {
    /// Takes the records of a federate's program.
    fn take(&mut self, instance: usize, memory: FederateMemory, counted: Counted) {
        let program = memory.program;
        let handled = program.handled().map(<[_]>::to_vec).collect();
        let (handlers, mishandled) = (program.handled_tardy.clone(), program.mishandled);
        let Counted { late: counted, lost, reports } = counted;
        self.lateness.push(Lateness { counted, lost, reports, handled, handlers, mishandled });
        for (most, capacity) in program.high_water() {
            self.fullest_percent = self.fullest_percent.max(100 * most / capacity.max(1));
            if most > capacity {
                self.violation.get_or_insert(Violation::Capacity { federate: instance, most, capacity });
            }
        }
        let mut played = Played::new();
        if let Some(records) = &self.records[instance + 1] {
            add_physical_events(&mut played, program.tables(), &records.to_vec());
        }
        self.played.push(played);
        for record in &program.trace {
            self.digest = combine(self.digest, record.digest);
        }
        self.stops.extend(&program.stops);
        self.may_leave[instance] |= program.has_left;
        let handover = &mut self.handovers[instance];
        (handover.taken, handover.last) = (program.taken_over, program.handed_over());
        self.traces.push(program.trace);
    }
}

/// Adds the times and values of a federate's physical actions, as it has recorded them.
fn add_physical_events(played: &mut Played, tables: &Tables, records: &[Record]) {
    let mut tag = Tag::NEVER;
    for (record, value) in with_values(records.iter().copied()) {
        match record.event {
            Event::TagBegins(begun) => tag = begun,
            Event::Physical(trigger) => {
                let TriggerInfo { name, kind, .. } = tables.triggers[usize::from(trigger.0)];
                if let TriggerKind::Physical(_) = kind {
                    let value = value.map(|bytes| Value::decode(&bytes).expect("it is one that was encoded"));
                    played.entry(name.to_owned()).or_default().push((tag, value));
                }
            }
            _ => {}
        }
    }
}

fn capacities(federate: &Federate) -> Vec<usize> {
    federate.inputs.iter().map(|input| federate.triggers[input.trigger.0].capacity).collect()
}

/// Returns a message with the number of its input instead of that of the port, if it has one.
fn to_input(scenario: &Scenario, plan: &Plan, sent: &Sent) -> Option<Sent> {
    let mut sent = *sent;
    sent.port = plan.federates[scenario.instances[sent.to]].input_of(u16::try_from(sent.port).ok()?)?.0;
    Some(sent)
}

/// Returns the bursts by input; on the wire, ports that are connected within the federate have numbers, too.
fn bursts(federate: &Federate, seen: &Seen) -> Vec<usize> {
    let inputs = (0..federate.inputs.len()).map(InputIndex);
    inputs.map(|input| seen.burst(federate.port_of(input))).collect()
}

fn senders(federate: &Federate) -> Vec<usize> {
    federate.inputs.iter().map(|input| usize::from(input.federate)).collect()
}

fn note_into(rti_log: Rc<RefCell<RtiLog>>, prints: bool) -> Box<dyn FnMut(RtiEvent<'_>)> {
    Box::new(move |event| {
        if prints {
            println!("RTI: {event}");
        }
        let mut rti_log = rti_log.borrow_mut();
        match event {
            RtiEvent::Started(start) => rti_log.started = Some(start),
            RtiEvent::InTransitFull(_) => rti_log.overflow = true,
            RtiEvent::Late { .. } => rti_log.late = true,
            RtiEvent::Dropped { .. } => rti_log.dropped = true,
            _ => {}
        }
    })
}

/// All participants, and their results.
struct Stage<'a> {
    participants: Vec<Participant<'a>>,
    ends: Vec<FederateEnd>,
    ended: Vec<Option<u64>>,
    /// The counts by federate.
    counted: Vec<Counted>,
    outcome: Option<Outcome>,
    /// The faults that are still to happen.
    faults: Vec<Fault>,
    /// The time at which the RTI has chosen the start.
    started: Option<u64>,
    struck: Vec<(usize, FaultKind)>,
    turns: u64,
    /// The factor of the maximum numbers of turns.
    scale: u64,
    progress: Progress,
    cut_short: bool,
}

/// The messages that a federate has counted and reported: late ones, and those that did not reach their receivers.
#[derive(Clone, Copy, Debug, Default)]
struct Counted {
    late: u64,
    lost: u64,
    reports: Reports,
}

/// The last turns in which reactions ran and in which the RTI ran.
#[derive(Clone, Copy, Debug, Default)]
struct Progress {
    reactions: u64,
    turn: u64,
    time: u64,
    turn_of_rti: u64,
}

impl Progress {
    /// Notes the number of reactions before this turn.
    fn note(&mut self, reactions: u64, of_rti: bool, turn: u64, time: u64) {
        if reactions > self.reactions {
            *self = Self { reactions, turn, time, ..*self };
        }
        if of_rti {
            self.turn_of_rti = turn;
        }
    }

    fn has_ceased(&self, turn: u64, time: u64, scale: u64) -> bool {
        turn > self.turn.min(self.turn_of_rti) + IDLE_TURNS_MAX * scale || time > self.time + IDLE_TIME_MAX_NS
    }
}

impl<'a> Stage<'a> {
    /// Returns the participants before their first turns.
    fn new(scenario: &Scenario, rti: &'a mut RtiMemory<'a>, federates: &'a mut [FederateMemory]) -> Self {
        let instances = federates.len();
        Self {
            participants: std::iter::once(Participant::NotYet(ParticipantMemory::Rti(rti)))
                .chain(federates.iter_mut().map(|memory| Participant::NotYet(ParticipantMemory::Federate(memory))))
                .collect(),
            ends: vec![FederateEnd::Gone; instances],
            ended: vec![None; instances],
            counted: vec![Counted::default(); instances],
            outcome: None,
            faults: scenario.faults.clone(),
            started: None,
            struck: Vec::new(),
            turns: 0,
            scale: if scenario.target.rounds.is_some() { ROUNDS } else { 1 },
            progress: Progress::default(),
            cut_short: false,
        }
    }

    /// Runs turn by turn, until all participants have ended or none can go on.
    fn play(&mut self, world: &Shared<SimulatedMedium>, rti_log: &RefCell<RtiLog>) -> Option<Violation> {
        loop {
            let mut locked = world.lock();
            if self.started.is_none() && rti_log.borrow().started.is_some() {
                self.started = Some(locked.now());
            }
            let fault_at = self.next_fault(&locked).map(|(at, _)| at);
            let Some(participant) = locked.next_turn(fault_at) else {
                if self.strike_next(&mut locked) {
                    continue;
                }
                let waiting = self.left(&locked);
                let now_ns = locked.now();
                return (!waiting.is_empty()).then_some(Violation::Deadlock { waiting, now_ns });
            };
            self.turns += 1;
            let (now_ns, reactions, side) = (locked.now(), locked.reactions(), locked.side(participant));
            let counted = self.turns.saturating_sub(locked.network.medium().datagram_turns);
            self.progress.note(reactions, participant == 0, counted, now_ns);
            self.cut_short = self.turns > TURNS_MAX * self.scale || reactions > REACTIONS_MAX;
            if self.cut_short {
                return None;
            }
            if self.progress.has_ceased(counted, now_ns, self.scale) {
                return Some(Violation::NoEnd { running: self.left(&locked), now_ns, turns: self.turns });
            }
            drop(locked);
            let step = self.participants[participant].turn();
            self.listen(participant);
            match step {
                Step::Wait(until) => world.lock().after_turn(participant, side.virtual_time(until)),
                Step::Outcome(outcome) => {
                    self.outcome = Some(outcome);
                    self.leave(&mut world.lock(), participant);
                }
                Step::End(result) => {
                    if participant > 0 {
                        self.ends[participant - 1] = FederateEnd::Ended(result);
                        self.ended[participant - 1] = Some(side.now());
                    }
                    self.leave(&mut world.lock(), participant);
                }
            }
        }
    }

    /// Takes the reports of a turn.
    fn listen(&mut self, participant: usize) {
        let reports = reports::take();
        if let Participant::Federate(federate) = &self.participants[participant] {
            let counted = &mut self.counted[participant - 1];
            (counted.late, counted.lost) = (federate.late_messages(), federate.lost_messages());
            counted.reports.all += reports.all;
            counted.reports.warnings += reports.warnings;
        }
    }

    fn leave(&mut self, world: &mut World, participant: usize) {
        self.participants[participant] = Participant::Gone;
        let now = world.now();
        world.network.medium_mut().watch.lose(participant, now);
        world.end(participant);
    }

    fn left(&self, world: &World) -> Vec<usize> {
        (0..self.participants.len()).filter(|participant| !world.has_ended(*participant)).collect()
    }

    /// Returns the virtual time of the next fault, and its position.
    fn next_fault(&self, world: &World) -> Option<(u64, usize)> {
        let faults = self.faults.iter().enumerate().filter(|(_, fault)| !world.has_ended(fault.participant));
        let times = faults.filter_map(|(index, Fault { at, early, .. })| {
            let base = if *early { 0 } else { self.started? };
            Some((base.saturating_add(at.max(&0).unsigned_abs()), index))
        });
        times.min()
    }

    /// Executes the next fault. Returns `false` if there is none.
    fn strike_next(&mut self, world: &mut World) -> bool {
        let Some((at, index)) = self.next_fault(world) else { return false };
        let fault = self.faults.remove(index);
        if fault.kind == FaultKind::Begin && world.has_ended(0) {
            // Nobody is there to whom it could come.
            self.leave(world, fault.participant);
            return true;
        }
        if fault.kind != FaultKind::Begin {
            self.struck.push((fault.participant, fault.kind));
        }
        if fault.kind == FaultKind::Vanish {
            self.participants[fault.participant] = Participant::Gone;
        }
        strike(world, &fault, at);
        true
    }
}
