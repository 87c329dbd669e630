// SPDX-License-Identifier: Apache-2.0
//! The tags of a running federate: which may begin and when, how far one runs, and when it is complete.
//!
//! This part owns the engine with its program, the coordination machine, and the state of awaited inputs. Its caller
//! passes the time, the held messages and whether others can still send; it reads and writes no connection. A tag whose
//! output does not fit stays open, and continues where it has stopped.

use core::fmt;

use lf_coordination::federate::{Awaited, Coordination, Federate, Needs, Phase};
use lf_coordination::{Deadline, to_wire};
#[cfg(feature = "traces")]
use lf_model::ReactionStep;
use lf_model::time::{Instant, Interval, Tag};
use lf_model::{Engine, Env, InputId, NetworkInput, NetworkOutput, Outgoing, Outside, Program, Progress, SendError};
use lf_wire::Message;

use super::held::Held;
use crate::error::RunError;
#[cfg(feature = "traces")]
use crate::trace::Event;
#[cfg(feature = "traces")]
use crate::trace::step_event;
use crate::unfederated::IdleEnv;

/// The progress of the tags in one turn.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Advance {
    /// Everything that is possible now is done; at this time more may be.
    Until(Deadline),
    /// The next tag, or the rest of the open one, needs a message of the RTI or of other federates.
    NotGranted,
    /// The output buffer is full in the middle of a tag.
    OutputFull,
    /// The last tag is complete.
    Done,
}

/// This federate cannot go on: [`Execution::fail`] has the reason. An error is large, and is not passed from function
/// to function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Failed;

/// The destination of messages. It returns [`SendError::NoRoom`] when one does not fit now.
pub(super) trait Outlet {
    /// See [`Env::outside`].
    fn outside(&self) -> &'static dyn Outside;

    /// Sends a message through the RTI.
    fn send(&mut self, message: &Outgoing<'_>, tag: lf_wire::Tag) -> Result<(), SendError>;

    /// Sends a control message through the RTI.
    fn send_control(&mut self, message: &Message<'_>) -> Result<(), SendError>;

    /// Sends a message to its receiver directly; over a logical connection with this tag.
    fn send_directly(&mut self, message: &Outgoing<'_>, tag: Option<lf_wire::Tag>) -> Result<(), SendError>;

    /// Sends another federate a control message directly.
    fn send_control_directly(&mut self, federate: u16, message: &Message<'_>) -> Result<(), SendError>;

    /// Records an event: now, or at this physical time of the federation.
    #[cfg(feature = "traces")]
    fn note(&mut self, at: Option<Instant>, event: Event);
}

/// Engine and machine of a federate.
pub(super) struct Execution<'a, 's, N: Needs> {
    pub(super) engine: Engine<'s>,
    pub(super) program: &'a mut dyn Program,
    pub(super) machine: Federate<'a, N>,
    /// The awaited inputs.
    pub(super) awaited: Awaited<'s>,
    /// Whether other federates send to this one through the RTI.
    has_upstream: bool,
    /// Whether the RTI knows that nothing more is sent from here, though a last tag is still to be run.
    pub(super) silent: bool,
    /// The physical time at which the common stop tag became known.
    stop_decided: Instant,
    /// Whether this federate, which is transient, has joined, and its owner has not noted it.
    #[cfg(feature = "transients")]
    pub(super) has_joined: bool,
    /// A tag before the first one of this federate, which is transient, at which others may wait for it, and the number
    /// of outputs for which they have been told that nothing comes.
    #[cfg(feature = "transients")]
    pub(super) passed: Option<(Tag, usize)>,
    /// The number of states that this federate, which is transient, has handed over, once it has nothing else to do.
    #[cfg(feature = "transients")]
    pub(super) handed_over: Option<u16>,
    /// The reason why this federate cannot go on, if there is one.
    pub(super) failure: Option<RunError>,
}

impl<N: Needs> fmt::Debug for Execution<'_, '_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Execution")
            .field("machine", &self.machine)
            .field("silent", &self.silent)
            .finish_non_exhaustive()
    }
}

impl<'a, 's, N: Needs> Execution<'a, 's, N> {
    pub(super) fn new(
        engine: Engine<'s>,
        program: &'a mut dyn Program,
        machine: Federate<'a, N>,
        awaited: Awaited<'s>,
        has_upstream: bool,
    ) -> Self {
        Self {
            engine,
            program,
            machine,
            awaited,
            has_upstream,
            silent: false,
            stop_decided: Instant::NEVER,
            #[cfg(feature = "transients")]
            has_joined: false,
            #[cfg(feature = "transients")]
            passed: None,
            #[cfg(feature = "transients")]
            handed_over: None,
            failure: None,
        }
    }

    /// Returns whether messages go directly to their receivers.
    pub(super) fn is_decentralized(&self) -> bool {
        self.machine.coordination() == Coordination::Decentralized
    }

    /// Stores the reason why this federate cannot go on.
    pub(super) fn fail(&mut self, error: RunError) -> Failed {
        self.failure = Some(error);
        Failed
    }

    /// Returns the federate's phase.
    pub(super) fn phase(&self) -> Phase {
        self.machine.phase()
    }

    /// Returns the federation's physical time at this time of the platform.
    pub(super) fn physical(&self, now: Instant) -> Instant {
        self.machine.clock().physical(now)
    }

    /// Starts the federation at this physical time.
    pub(super) fn start(&mut self, start: Instant) {
        log::debug!("the federation starts");
        self.engine.start(start);
        self.limit_stop();
        if N::AWAITED && self.is_decentralized() {
            let inputs = self.engine.tables().inputs;
            self.awaited.start(Tag::at(start), |port| inputs.get(usize::from(port)).and_then(|input| input.delay));
        }
    }

    /// Passes the program's own last tag to the machine.
    pub(super) fn limit_stop(&mut self) {
        if self.engine.stop_tag() < Tag::FOREVER {
            self.machine.limit_stop(self.engine.stop_tag());
        }
    }

    /// Sets the tag at which all stop.
    pub(super) fn stop(&mut self, now: Instant, tag: Tag) {
        log::debug!("the federation stops at {tag}");
        self.stop_decided = self.physical(now);
        self.engine.set_stop_tag(tag);
    }

    /// Returns whether a message of this tag, or without one, has to wait for room in the queue of its input. What
    /// comes after the last tag needs no room.
    pub(super) fn lacks_room(&mut self, input: InputId, tag: Option<Tag>) -> bool {
        tag.is_none_or(|tag| tag <= self.engine.stop_tag()) && !self.engine.has_room(self.program, input)
    }

    /// Schedules the events of other threads. `can_receive`: other federates can send something directly.
    pub(super) fn collect(&mut self, outside: &'static dyn Outside, can_receive: bool) {
        // Asked first: a thread that has left by now has left all its events behind. A program that stays without
        // events has sources that it has not registered.
        let stays = self.engine.settings().keepalive;
        self.machine.set_physical_sources(stays || outside.mailbox().links() > 0 || can_receive);
        self.engine.drain_physical(self.program, &IdleEnv(outside));
        self.take_stop_request();
    }

    fn take_stop_request(&mut self) {
        if let Some(tag) = self.engine.take_stop_request() {
            self.machine.request_stop(tag);
        }
    }

    /// With centralized coordination, announces the next tag to the RTI and returns it; `None` when there is none. The
    /// earliest message that is `held` counts like those in the queues.
    pub(super) fn announce(&mut self, now: Instant, held: Tag) -> Option<Tag> {
        let event = self.engine.next_tag();
        // In a cycle without delay others may wait for this federate at a tag at which it has no event.
        let demanded = self.machine.demanded_tag().filter(|demanded| event.is_none_or(|event| *demanded < event));
        let tag = demanded.or(event)?;
        // An announcement accounts for everything that was sent to this federate before the grant that it has followed,
        // which includes held messages.
        self.machine.next_event(now, event.unwrap_or(Tag::FOREVER).min(held));
        Some(tag)
    }

    /// Returns what a tag that was announced waits for, if it waits.
    pub(super) fn grant(&self, now: Instant, tag: Tag, held: Tag) -> Option<Advance> {
        // A message of the last tag can come though that was granted long ago.
        if !self.machine.may_advance(tag) || N::INPUTS && tag >= held {
            return Some(Advance::NotGranted);
        }
        let waits = !self.engine.settings().fast && self.physical(now) < tag.time;
        waits.then(|| Advance::Until(Deadline::At(self.machine.clock().local(tag.time))))
    }

    /// Begins a tag that is due and granted.
    pub(super) fn begin(&mut self, tag: Tag) -> Result<(), Failed> {
        self.machine.begin(tag).map_err(|error| self.fail(error.into()))?;
        self.engine.begin(self.program, tag).map_err(|error| self.fail(error.into()))
    }

    /// Handles that there is no event. When none can come any more, the next microstep is the last tag.
    pub(super) fn idle(&mut self, now: Instant, held: Tag, outside: &dyn Outside, can_receive: bool) -> Advance {
        // Without an event, neither the program nor one of its threads nor another federate can make a new one.
        let has_source = self.engine.settings().keepalive || outside.mailbox().links() > 0 || can_receive;
        if self.is_decentralized() {
            if has_source {
                return Advance::Until(Deadline::Never);
            }
        } else if N::INPUTS && self.has_upstream || has_source {
            // FOREVER is granted when all upstream federates have left. Others may be granted any tag once they know
            // that nothing comes from here before FOREVER; so what the last tag sends would come too late, and is not
            // sent. A held message has just got room, and is about to be an event.
            self.silent = self.machine.next_event(now, held) && !has_source && held == Tag::FOREVER;
            if !self.silent {
                return Advance::Until(Deadline::Never);
            }
        }
        self.engine.set_stop_tag(Tag::NEVER);
        Advance::Until(Deadline::Now)
    }

    /// With centralized coordination, returns the level from which on reactions of the open tag wait for inputs, if any
    /// do.
    pub(super) fn max_level(&self) -> Option<u16> {
        if N::AWAITED && N::CYCLES { self.awaited.max_level(&self.machine) } else { None }
    }

    /// Runs the open tag up to this level. Returns `None` when it is complete and others may follow; otherwise why it
    /// stops, which is `limit` at the level.
    pub(super) fn run(
        &mut self,
        outlet: &mut impl Outlet,
        max_level: Option<u16>,
        limit: Advance,
    ) -> Result<Option<Advance>, Failed> {
        let mut env = TagEnv { machine: &mut self.machine, silent: self.silent, outlet };
        match self.engine.advance(self.program, &mut env, max_level) {
            Progress::Complete => {}
            Progress::OutputFull { .. } => return Ok(Some(Advance::OutputFull)),
            Progress::LevelLimit { .. } => return Ok(Some(limit)),
            Progress::Failed(error) => return Err(self.fail(error.into())),
        }
        #[cfg(feature = "traces")]
        env.outlet.note(None, Event::TagEnds(self.engine.current_tag()));
        self.machine.complete(self.engine.had_network_input());
        self.take_stop_request();
        if !self.engine.is_done() {
            return Ok(None);
        }
        self.finish();
        Ok(Some(Advance::Done))
    }

    /// Leaves; one that hands over states does so when they are sent.
    pub(super) fn finish(&mut self) {
        #[cfg(feature = "transients")]
        if !self.engine.tables().handed_over.is_empty() {
            self.handed_over.get_or_insert(0);
            return;
        }
        self.machine.finish();
    }

    /// Returns the open tag, or else the next one.
    pub(super) fn tag_in_question(&self) -> Option<Tag> {
        if self.engine.is_in_tag() { Some(self.engine.current_tag()) } else { self.engine.next_tag() }
    }

    /// Returns the input that has to become known first, before this tag begins or within it.
    pub(super) fn unknown_input(&self, tag: Tag) -> Option<InputId> {
        let waits = N::AWAITED && (self.is_decentralized() || N::CYCLES && self.engine.is_in_tag());
        if !waits {
            return None;
        }
        // A tag begins when everything before it is known.
        let needed = if self.engine.is_in_tag() { tag } else { tag.before() };
        self.awaited.first_unknown(needed).map(InputId)
    }

    /// Returns the input whose queue cannot hold all messages of one tag, if there is one. They have to be in the queue
    /// before the tag begins, and nothing that is earlier can make room any more.
    pub(super) fn input_over_capacity(&self, held: &Held) -> Option<InputId> {
        if !N::INPUTS {
            return None;
        }
        let earliest = held.earliest;
        let granted = held.granted || self.machine.granted() >= earliest;
        let due = !held.stale && granted && !self.machine.awaits_stop_tag() && !self.engine.is_in_tag();
        let nothing_before = self.engine.next_tag().is_none_or(|next| next >= earliest);
        held.input.filter(|_| due && nothing_before)
    }

    /// Returns the name of the connection that ends at an input.
    pub(super) fn name_of(&self, input: InputId) -> &'static str {
        self.engine.tables().inputs.get(usize::from(input.0)).map_or("", |input| input.name)
    }

    /// Returns the local time of this tag, if the program waits for physical time.
    pub(super) fn local(&self, tag: Tag) -> Option<Instant> {
        (!self.engine.settings().fast).then(|| self.machine.clock().local(tag.time))
    }
}

/// Decentralized coordination: when tags begin, and where their reactions wait.
impl<N: Needs> Execution<'_, '_, N> {
    /// Returns the time from which on the next tag may begin, and whether everything before it is known. The last part
    /// is `None` when the tag may begin, or what it waits for.
    pub(super) fn begin_time(&self, now: Instant, tag: Tag) -> (Instant, bool, Option<Advance>) {
        let max_wait = |port| self.engine.max_wait(InputId(port));
        let since = self.waits_since(tag);
        let (is_known, begins) = if N::AWAITED {
            (self.awaited.knows_before(tag), self.awaited.begin_time(tag, since, max_wait))
        } else {
            (true, since)
        };
        let is_free = is_known && self.engine.settings().fast;
        let waits = !is_free && self.physical(now) < begins;
        (begins, is_known, waits.then(|| self.wait_for(begins)))
    }

    /// Returns the level from which on reactions of the open tag have to wait, if any have to, and what they wait for:
    /// `None` once the time for that is over.
    pub(super) fn pause(&self, now: Instant) -> Option<(u16, Option<Advance>)> {
        if !N::AWAITED {
            return None;
        }
        let current = self.engine.current_tag();
        let pause = self.awaited.pause(current, self.waits_since(current), |port| self.wait_limit(port))?;
        let waits = self.physical(now) < pause.until;
        Some((pause.level, waits.then(|| self.wait_for(pause.until))))
    }

    /// Takes inputs as absent whose wait is over at `now`. Everything that had come by then has been read.
    pub(super) fn assume_absent(&mut self, now: Instant) {
        let (now, engine) = (self.physical(now), &self.engine);
        let (current, since) = (engine.current_tag(), self.waits_since(engine.current_tag()));
        self.awaited.assume_absent(current, since, now, |port| wait_limit(engine, port));
    }

    /// Returns the time from which on waits for inputs of this tag count: the tag's time, or else the time at which
    /// this federate has learnt that all stop there. It could not begin the tag before.
    fn waits_since(&self, tag: Tag) -> Instant {
        if self.machine.stop_tag() == Some(tag) { tag.time.max(self.stop_decided) } else { tag.time }
    }

    /// Waits until this physical time of the federation, or for a message of others.
    fn wait_for(&self, time: Instant) -> Advance {
        if time == Instant::FOREVER {
            return Advance::NotGranted;
        }
        Advance::Until(Deadline::At(self.machine.clock().local(time)))
    }

    fn wait_limit(&self, port: u16) -> Interval {
        wait_limit(&self.engine, port)
    }

    /// Returns the inputs to which a federate sends directly, and whether that is over a physical connection.
    pub(super) fn direct_inputs(&self, from: u16) -> impl Iterator<Item = (u16, bool)> + use<N> {
        let (inputs, is_decentralized) = (self.engine.tables().inputs, self.is_decentralized());
        let is_direct = move |input: &NetworkInput| input.federate == from && (input.physical || is_decentralized);
        (0..).zip(inputs).filter(move |(_, input)| is_direct(input)).map(|(port, input)| (port, input.physical))
    }

    /// Returns whether a federate has ended every input to which it sends directly, or will have when held messages are
    /// delivered. `physical`: it has ended its physical connections.
    pub(super) fn is_over(&self, from: u16, physical: bool, is_held: impl Fn(u16) -> bool) -> bool {
        self.direct_inputs(from).all(|(port, is_physical)| {
            is_held(port) || if is_physical { physical } else { self.awaited.is_known(port, Tag::FOREVER) }
        })
    }

    /// Handles that a federate sends nothing directly any more, apart from held messages for some of its inputs.
    pub(super) fn end_inputs(&mut self, from: u16, is_held: impl Fn(u16) -> bool) {
        for (port, _) in self.direct_inputs(from).filter(|(port, is_physical)| !is_physical && !is_held(*port)) {
            self.awaited.learn(port, Tag::FOREVER);
        }
    }

    /// Returns whether a tag has begun after which nothing is sent.
    pub(super) fn has_sent_all(&self) -> bool {
        self.engine.has_sent_all()
    }

    /// Returns whether this federate and a sender deadlock: the receive buffer is full of messages without room, and
    /// only behind them can come a message or an absence for another input, for which this federate waits without end.
    pub(super) fn deadlocks_with(&self, from: u16) -> bool {
        let Some(tag) = self.tag_in_question() else { return false };
        let tag = if self.engine.is_in_tag() { tag } else { tag.before() };
        let inputs = (0..).zip(self.engine.tables().inputs);
        let mut inputs = inputs.filter(|(_, input)| !input.physical && input.federate == from);
        inputs.any(|(port, _)| self.wait_limit(port) == Interval::FOREVER && !self.awaited.is_known(port, tag))
    }
}

/// Returns how long after a tag's time to wait for an input within the tag.
fn wait_limit(engine: &Engine<'_>, port: u16) -> Interval {
    let input = engine.tables().inputs.get(usize::from(port));
    input.map_or(Interval::ZERO, |input| engine.max_wait(InputId(port)).saturating_add(input.absent_after))
}

/// The engine's environment while a tag runs: what may be sent, and which way.
struct TagEnv<'x, 'a, O, N: Needs> {
    machine: &'x mut Federate<'a, N>,
    /// Whether nothing is sent any more.
    silent: bool,
    outlet: &'x mut O,
}

impl<O: Outlet, N: Needs> Env for TagEnv<'_, '_, O, N> {
    fn outside(&self) -> &'static dyn Outside {
        self.outlet.outside()
    }

    #[cfg(feature = "traces")]
    fn step(&mut self, step: ReactionStep, worker: Option<(u16, Instant)>) {
        let at = worker.map(|(_, at)| self.machine.clock().local(at));
        self.outlet.note(at, step_event(step, worker.map_or(0, |(worker, _)| worker)));
    }

    fn send(&mut self, message: &Outgoing<'_>) -> Result<(), SendError> {
        if N::PEERS_OUT && N::UNTAGGED && message.output.physical {
            return self.outlet.send_directly(message, None);
        }
        if self.silent || !self.machine.may_send(message.tag) {
            // No federate reaches this tag.
            return Ok(());
        }
        let tag = to_wire(message.tag);
        if N::PEERS_OUT && self.machine.coordination() == Coordination::Decentralized {
            return self.outlet.send_directly(message, Some(tag));
        }
        self.outlet.send(message, tag)?;
        self.machine.sent();
        Ok(())
    }

    fn send_absent(&mut self, output: &'static NetworkOutput, tag: Tag) -> Result<(), SendError> {
        // Others that are at this tag provisionally wait for the word that nothing comes.
        let is_silent = self.silent && self.machine.granted_provisionally() != Some(tag);
        if is_silent || !self.machine.may_send(tag) {
            return Ok(());
        }
        let message = Message::PortAbsent { port: output.port, federate: output.federate, tag: to_wire(tag) };
        if N::PEERS_OUT && self.machine.coordination() == Coordination::Decentralized {
            self.outlet.send_control_directly(output.federate, &message)
        } else {
            self.outlet.send_control(&message)
        }
    }
}

#[cfg(test)]
mod tests {
    use lf_coordination::federate::{All, AwaitedInput, Config};
    use lf_model::{EngineStorage as _, PortId, PortInfo, Settings, Storage, Tables, TriggerInfo, TriggerKind};

    use super::*;

    const fn input(federate: u16, max_wait: Interval) -> NetworkInput {
        NetworkInput {
            name: "a.x -> b.y",
            federate,
            max_len: 4,
            level: 0,
            awaited: true,
            max_wait,
            ..NetworkInput::DEFAULT
        }
    }

    const TABLES: Tables = Tables {
        triggers: &[TriggerInfo { name: "b.y", kind: TriggerKind::NetworkInput { fills: PortId(0) }, reactions: &[] }],
        ports: &[PortInfo { name: "b.y", reactions: &[], delays: &[] }],
        inputs: &[input(1, Interval::FOREVER), input(1, Interval::from_millis(5)), input(2, Interval::ZERO)],
        ..Tables::DEFAULT
    };

    /// A program whose queues never have room.
    struct FullProgram;

    impl Program for FullProgram {
        fn tables(&self) -> &'static Tables {
            &TABLES
        }
    }

    fn with_execution(test: impl FnOnce(&mut Execution<'_, '_, All>)) {
        let (mut storage, mut known, mut program) = (Storage::<1, 1, 1, 1>::new(), [Tag::NEVER; 3], FullProgram);
        let engine = Engine::new(&TABLES, &mut storage, Settings::DEFAULT);
        let config = Config { coordination: Coordination::Decentralized, ..Config::new(0.into(), b"federation") };
        let machine = Federate::new(config).expect("the configuration is in order");
        let inputs = [0, 1, 2].map(|port| AwaitedInput { port, level: 0 });
        let awaited = Awaited::new(&inputs, &mut known).expect("there is memory");
        test(&mut Execution::new(engine, &mut program, machine, awaited, true));
    }

    #[test]
    fn messages_after_the_last_tag_need_no_room() {
        with_execution(|execution| {
            execution.start(Instant::from_nanos(100));
            let tag = |time| Some(Tag::at(Instant::from_nanos(time)));
            assert!(execution.lacks_room(InputId(0), tag(200)) && execution.lacks_room(InputId(0), None));
            execution.engine.set_stop_tag(Tag::at(Instant::from_nanos(150)));
            assert!(execution.lacks_room(InputId(0), tag(150)) && !execution.lacks_room(InputId(0), tag(200)));
        });
    }

    /// The federate waits without end for one of two inputs from the same sender, and not at all for that of another
    /// one.
    #[test]
    fn a_federate_deadlocks_with_an_input_until_its_sender_has_ended_and_nothing_is_held_for_it() {
        with_execution(|execution| {
            execution.start(Instant::from_nanos(100));
            execution.engine.set_stop_tag(Tag::at(Instant::from_nanos(150)));
            assert_eq!([1, 2].map(|from| execution.deadlocks_with(from)), [true, false]);
            let tag = execution.tag_in_question().expect("the last tag is to come");
            assert_eq!(
                execution.begin_time(Instant::from_nanos(150), tag),
                (Instant::FOREVER, false, Some(Advance::NotGranted))
            );
            execution.end_inputs(1, |port| port == 0);
            assert!(execution.deadlocks_with(1));
            execution.end_inputs(1, |_| false);
            assert!(!execution.deadlocks_with(1));
            assert_eq!(execution.begin_time(Instant::from_nanos(150), tag).0, tag.time);
        });
    }
}
