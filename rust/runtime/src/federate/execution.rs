// SPDX-License-Identifier: Apache-2.0
//! The tags of a running federate: which may begin and when, how far one runs, and when it is complete.
//!
//! This part owns the engine with its program, the coordination machine, and what is known of awaited inputs. It asks
//! for the time, for what is held and for what others can still send; it reads and writes no connection. A tag whose
//! output does not fit stays open, and goes on where it has stopped.

use core::fmt;

use lf_coordination::federate::{Awaited, Coordination, Federate, Needs, Phase};
use lf_coordination::{Deadline, to_wire};
#[cfg(feature = "traces")]
use lf_model::ReactionStep;
use lf_model::time::{Instant, Interval, Tag};
use lf_model::{Engine, Env, InputId, NetworkInput, NetworkOutput, Outgoing, Outside, Program, Progress, SendError};
use lf_wire::Message;

use super::held::Held;
use crate::description::PEERS;
use crate::error::RunError;
#[cfg(feature = "traces")]
use crate::trace::Event;
#[cfg(feature = "traces")]
use crate::trace::step_event;
use crate::unfederated::World;

/// How far the tags of one turn came.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Advance {
    /// All that is possible now is done; at this time more may be.
    Until(Deadline),
    /// The next tag, or the rest of the open one, needs word from the RTI or from other federates.
    NotGranted,
    /// The output buffer is full in the middle of a tag.
    OutputFull,
    /// The last tag is complete.
    Done,
}

/// This federate cannot go on: [`Execution::fail`] was told why. An error is large, and is not handed from function to
/// function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Failed;

/// Where messages go. It says [`SendError::NoRoom`] when one does not fit now.
pub(super) trait Outlet {
    /// See [`Env::outside`].
    fn outside(&self) -> &'static dyn Outside;

    /// Sends a message through the RTI.
    fn send(&mut self, message: &Outgoing<'_>, tag: lf_wire::Tag) -> Result<(), SendError>;

    /// Sends word through the RTI.
    fn tell(&mut self, message: &Message<'_>) -> Result<(), SendError>;

    /// Sends a message past the RTI; over a logical connection with this tag.
    fn send_directly(&mut self, message: &Outgoing<'_>, tag: Option<lf_wire::Tag>) -> Result<(), SendError>;

    /// Sends another federate word past the RTI.
    fn tell_directly(&mut self, federate: u16, message: &Message<'_>) -> Result<(), SendError>;

    /// Records what happens: now, or at this physical time of the federation.
    #[cfg(feature = "traces")]
    fn note(&mut self, at: Option<Instant>, event: Event);
}

/// Engine and machine of a federate.
pub(super) struct Execution<'a, 's, N: Needs> {
    pub(super) engine: Engine<'s>,
    pub(super) program: &'a mut dyn Program,
    pub(super) machine: Federate<'a, N>,
    /// What is known of inputs for which reactions wait.
    pub(super) awaited: Awaited<'s>,
    /// Other federates send to this one through the RTI.
    has_upstream: bool,
    /// The RTI has been told that nothing more is sent from here, though a last tag is still to be run.
    silent: bool,
    /// The physical time at which the common stop tag was learnt.
    stop_decided: Instant,
    /// Why this federate cannot go on, if it cannot.
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
            failure: None,
        }
    }

    /// Whether messages go past the RTI; never where there are no connections past it.
    pub(super) fn is_decentralized(&self) -> bool {
        PEERS && self.machine.coordination() == Coordination::Decentralized
    }

    /// Keeps why this federate cannot go on.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub(super) fn fail(&mut self, error: RunError) -> Failed {
        self.failure = Some(error);
        Failed
    }

    /// How far the federate is.
    pub(super) fn phase(&self) -> Phase {
        self.machine.phase()
    }

    /// The federation's physical time at this time of the platform.
    pub(super) fn physical(&self, now: Instant) -> Instant {
        self.machine.clock().physical(now)
    }

    /// The federation starts at this physical time.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub(super) fn start(&mut self, start: Instant) {
        log::debug!("the federation starts");
        self.engine.start(start);
        if self.engine.stop_tag() < Tag::FOREVER {
            self.machine.limit_stop(self.engine.stop_tag());
        }
        if self.is_decentralized() {
            let inputs = self.engine.tables().inputs;
            self.awaited.start(Tag::at(start), |port| inputs.get(usize::from(port)).and_then(|input| input.delay));
        }
    }

    /// All stop at this tag, as is known from now on.
    pub(super) fn stop(&mut self, now: Instant, tag: Tag) {
        log::debug!("the federation stops at {tag}");
        self.stop_decided = self.physical(now);
        self.engine.set_stop_tag(tag);
    }

    /// Whether a message of this tag, or without one, has to wait for room in the queue of its input. What comes after
    /// the last tag needs no room.
    pub(super) fn lacks_room(&mut self, input: InputId, tag: Option<Tag>) -> bool {
        tag.is_none_or(|tag| tag <= self.engine.stop_tag()) && !self.engine.has_room(self.program, input)
    }

    /// Schedules what has come from other threads. `can_receive`: other federates can send something past the RTI.
    pub(super) fn collect(&mut self, outside: &'static dyn Outside, can_receive: bool) {
        // Asked first: who leaves now has left all its events behind. A program that stays without events has sources
        // that nobody has told of.
        let stays = self.engine.settings().keepalive;
        self.machine.set_physical_sources(stays || outside.mailbox().links() > 0 || can_receive);
        self.engine.drain_physical(self.program, &World(outside));
        self.take_stop_request();
    }

    fn take_stop_request(&mut self) {
        if let Some(tag) = self.engine.take_stop_request() {
            self.machine.request_stop(tag);
        }
    }

    /// With centralized coordination, the tag that is next, which the RTI is told; `None` when there is none. The
    /// earliest message that is `held` counts like those in the queues.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub(super) fn announce(&mut self, now: Instant, held: Tag) -> Option<Tag> {
        let event = self.engine.next_tag();
        // In a cycle without delay others may wait for this federate at a tag at which it has no event.
        let summons = self.machine.summons().filter(|summons| event.is_none_or(|event| *summons < event));
        let tag = summons.or(event)?;
        // What this federate announces after it has done something stands for all that it was sent before the grant for
        // that, which includes the messages that wait for room.
        self.machine.next_event(now, event.unwrap_or(Tag::FOREVER).min(held));
        Some(tag)
    }

    /// What a tag that was announced waits for, if it waits.
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

    /// There is no event. When none can come any more, the next microstep is the last tag.
    #[cfg_attr(target_pointer_width = "32", inline(never))]
    pub(super) fn idle(&mut self, now: Instant, held: Tag, outside: &dyn Outside, can_receive: bool) -> Advance {
        // Neither the program, nor one of its threads, nor another federate can make an event out of nothing.
        let has_source = self.engine.settings().keepalive || outside.mailbox().links() > 0 || can_receive;
        if self.is_decentralized() {
            if has_source {
                return Advance::Until(Deadline::Never);
            }
        } else if N::INPUTS && self.has_upstream || has_source {
            // FOREVER is granted when all upstream federates have left. Others may be granted any tag once they are
            // told that nothing comes from here before FOREVER; so what the last tag sends would come too late, and is
            // not sent.
            // What still waits for room has just got some, and is about to be an event.
            self.silent = self.machine.next_event(now, held) && !has_source && held == Tag::FOREVER;
            if !self.silent {
                return Advance::Until(Deadline::Never);
            }
        }
        self.engine.set_stop_tag(Tag::NEVER);
        Advance::Until(Deadline::Now)
    }

    /// With centralized coordination, the level from which on reactions of the open tag wait for word, if any do.
    pub(super) fn max_level(&self) -> Option<u16> {
        if N::CYCLES { self.awaited.max_level(&self.machine) } else { None }
    }

    /// Runs the open tag up to this level. `None` when it is complete and others may follow; else where it stops, which
    /// is `limit` at the level.
    pub(super) fn run(
        &mut self,
        outlet: &mut impl Outlet,
        max_level: Option<u16>,
        limit: Advance,
    ) -> Result<Option<Advance>, Failed> {
        let is_decentralized = self.is_decentralized();
        let mut gate = Gate { machine: &mut self.machine, silent: self.silent, is_decentralized, outlet };
        match self.engine.advance(self.program, &mut gate, max_level) {
            Progress::Complete => {}
            Progress::OutputFull { .. } => return Ok(Some(Advance::OutputFull)),
            Progress::LevelLimit { .. } => return Ok(Some(limit)),
            Progress::Failed(error) => return Err(self.fail(error.into())),
        }
        #[cfg(feature = "traces")]
        gate.outlet.note(None, Event::TagEnds(self.engine.current_tag()));
        self.machine.complete(self.engine.had_network_input());
        self.take_stop_request();
        if !self.engine.is_done() {
            return Ok(None);
        }
        self.machine.finish();
        Ok(Some(Advance::Done))
    }

    /// The tag that is open, or else the one that is next.
    pub(super) fn tag_in_question(&self) -> Option<Tag> {
        if self.engine.is_in_tag() { Some(self.engine.current_tag()) } else { self.engine.next_tag() }
    }

    /// The input of which it is to be known first what comes, before this tag begins or within it.
    pub(super) fn unknown_input(&self, tag: Tag) -> Option<InputId> {
        let waits = self.is_decentralized() || N::CYCLES && self.engine.is_in_tag();
        // A tag begins when all is known that comes before it.
        let needed = if self.engine.is_in_tag() { tag } else { tag.before() };
        self.awaited.first_unknown(needed).filter(|_| waits).map(InputId)
    }

    /// Whether more messages have come for one tag than a queue holds: then which input holds the others. They have to
    /// be in the queue before the tag is begun, and nothing that is earlier can make room any more.
    pub(super) fn overfull(&self, held: &Held) -> Option<InputId> {
        if !N::INPUTS {
            return None;
        }
        let earliest = held.earliest;
        let granted = held.granted || self.machine.granted() >= earliest;
        let due = !held.stale && granted && !self.machine.awaits_stop_tag() && !self.engine.is_in_tag();
        let nothing_before = self.engine.next_tag().is_none_or(|next| next >= earliest);
        held.input.filter(|_| due && nothing_before)
    }

    /// The name of the connection that ends at an input.
    pub(super) fn name_of(&self, input: InputId) -> &'static str {
        self.engine.tables().inputs.get(usize::from(input.0)).map_or("", |input| input.name)
    }

    /// The local time at which this tag's time has come, where the program waits for that.
    pub(super) fn local(&self, tag: Tag) -> Option<Instant> {
        (!self.engine.settings().fast).then(|| self.machine.clock().local(tag.time))
    }
}

/// With decentralized coordination: when tags begin, and where their reactions wait.
impl<N: Needs> Execution<'_, '_, N> {
    /// From when on the next tag may begin, and whether all is known that comes before it. `None` when it can, or what
    /// it waits for.
    pub(super) fn begin_time(&self, now: Instant, tag: Tag) -> (Instant, bool, Option<Advance>) {
        let max_wait = |port| self.engine.max_wait(InputId(port));
        let is_known = self.awaited.knows_before(tag);
        let begins = self.awaited.begin_time(tag, self.waits_since(tag), max_wait);
        let is_free = is_known && self.engine.settings().fast;
        let waits = !is_free && self.physical(now) < begins;
        (begins, is_known, waits.then(|| self.wait_for(begins)))
    }

    /// The level from which on reactions of the open tag have to wait, if any have to, and what they wait for: `None`
    /// once the time for that is over.
    pub(super) fn pause(&self, now: Instant) -> Option<(u16, Option<Advance>)> {
        let current = self.engine.current_tag();
        let pause = self.awaited.pause(current, self.waits_since(current), |port| self.patience(port))?;
        let waits = self.physical(now) < pause.until;
        Some((pause.level, waits.then(|| self.wait_for(pause.until))))
    }

    /// It is this time, and all has been read that had come: the inputs whose time is over are taken as absent.
    pub(super) fn assume_absent(&mut self, now: Instant) {
        let (now, engine) = (self.physical(now), &self.engine);
        let (current, since) = (engine.current_tag(), self.waits_since(engine.current_tag()));
        self.awaited.assume_absent(current, since, now, |port| patience(engine, port));
    }

    /// From when on inputs of this tag are waited for: from its time, or else from when this federate has learnt that
    /// all stop there. Nobody could begin the tag before.
    fn waits_since(&self, tag: Tag) -> Instant {
        if self.machine.stop_tag() == Some(tag) { tag.time.max(self.stop_decided) } else { tag.time }
    }

    /// Waits until this physical time of the federation, or for word from others.
    fn wait_for(&self, time: Instant) -> Advance {
        if time == Instant::FOREVER {
            return Advance::NotGranted;
        }
        Advance::Until(Deadline::At(self.machine.clock().local(time)))
    }

    fn patience(&self, port: u16) -> Interval {
        patience(&self.engine, port)
    }

    /// The inputs to which a federate sends past the RTI, and whether that is over a physical connection.
    fn direct_inputs(&self, from: u16) -> impl Iterator<Item = (u16, bool)> + use<N> {
        let (inputs, is_decentralized) = (self.engine.tables().inputs, self.is_decentralized());
        let is_direct = move |input: &NetworkInput| input.federate == from && (input.physical || is_decentralized);
        (0..).zip(inputs).filter(move |(_, input)| is_direct(input)).map(|(port, input)| (port, input.physical))
    }

    /// Whether a federate has said of each input to which it sends past the RTI that nothing more comes, or will have
    /// when what is held is taken. `physical`: it has said so of physical connections.
    pub(super) fn is_over(&self, from: u16, physical: bool, is_held: impl Fn(u16) -> bool) -> bool {
        self.direct_inputs(from).all(|(port, is_physical)| {
            is_held(port) || if is_physical { physical } else { self.awaited.is_known(port, Tag::FOREVER) }
        })
    }

    /// A federate sends nothing past the RTI any more, apart from what is held for some of its inputs.
    pub(super) fn end_inputs(&mut self, from: u16, is_held: impl Fn(u16) -> bool) {
        for (port, _) in self.direct_inputs(from).filter(|(port, is_physical)| !is_physical && !is_held(*port)) {
            self.awaited.learn(port, Tag::FOREVER);
        }
    }

    /// Whether the last tag has begun: nothing is sent for a later one.
    pub(super) fn has_begun_last_tag(&self) -> bool {
        self.engine.current_tag() >= self.engine.stop_tag()
    }

    /// Whether a federate, whose receive buffer is full of messages without room, would have to send word of another of
    /// its inputs, for which this one waits for ever.
    pub(super) fn starves_for(&self, from: u16) -> bool {
        let Some(tag) = self.tag_in_question() else { return false };
        let tag = if self.engine.is_in_tag() { tag } else { tag.before() };
        let inputs = (0..).zip(self.engine.tables().inputs);
        let mut inputs = inputs.filter(|(_, input)| !input.physical && input.federate == from);
        inputs.any(|(port, _)| self.patience(port) == Interval::FOREVER && !self.awaited.is_known(port, tag))
    }
}

/// How long after a tag's time an input is waited for within the tag.
fn patience(engine: &Engine<'_>, port: u16) -> Interval {
    let input = engine.tables().inputs.get(usize::from(port));
    input.map_or(Interval::ZERO, |input| engine.max_wait(InputId(port)).saturating_add(input.absent_after))
}

/// The engine's environment while a tag runs: what may be sent, and which way.
struct Gate<'x, 'a, O, N: Needs> {
    machine: &'x mut Federate<'a, N>,
    /// Nothing is sent any more.
    silent: bool,
    is_decentralized: bool,
    outlet: &'x mut O,
}

impl<O: Outlet, N: Needs> Env for Gate<'_, '_, O, N> {
    fn outside(&self) -> &'static dyn Outside {
        self.outlet.outside()
    }

    #[cfg(feature = "traces")]
    fn step(&mut self, step: ReactionStep, worker: Option<(u16, Instant)>) {
        let at = worker.map(|(_, at)| self.machine.clock().local(at));
        self.outlet.note(at, step_event(step, worker.map_or(0, |(worker, _)| worker)));
    }

    fn send(&mut self, message: &Outgoing<'_>) -> Result<(), SendError> {
        if PEERS && message.output.physical {
            return self.outlet.send_directly(message, None);
        }
        if self.silent || !self.machine.may_send(message.tag) {
            // Nobody gets as far as this tag.
            return Ok(());
        }
        let tag = to_wire(message.tag);
        if PEERS && self.is_decentralized {
            return self.outlet.send_directly(message, Some(tag));
        }
        self.outlet.send(message, tag)?;
        self.machine.sent();
        Ok(())
    }

    fn send_absent(&mut self, output: &'static NetworkOutput, tag: Tag) -> Result<(), SendError> {
        if self.silent || !self.machine.may_send(tag) {
            return Ok(());
        }
        let message = Message::PortAbsent { port: output.port, federate: output.federate, tag: to_wire(tag) };
        if PEERS && self.is_decentralized {
            self.outlet.tell_directly(output.federate, &message)
        } else {
            self.outlet.tell(&message)
        }
    }
}

#[cfg(test)]
mod tests {
    use lf_coordination::federate::{All, AwaitedInput, Config};
    use lf_model::{PortId, PortInfo, Settings, Storage, Tables, TriggerInfo, TriggerKind};

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
    struct Crowded;

    impl Program for Crowded {
        fn tables(&self) -> &'static Tables {
            &TABLES
        }
    }

    fn with_execution(test: impl FnOnce(&mut Execution<'_, '_, All>)) {
        let (mut storage, mut known, mut program) = (Storage::<1, 1, 1, 1>::new(), [Tag::NEVER; 3], Crowded);
        let engine = Engine::new(&TABLES, &mut storage, Settings::DEFAULT);
        let config = Config { coordination: Coordination::Decentralized, ..Config::new(0.into(), b"federation") };
        let machine = Federate::new(config).expect("the configuration is in order");
        let inputs = [0, 1, 2].map(|port| AwaitedInput { port, level: 0 });
        let awaited = Awaited::new(&inputs, &mut known).expect("there is memory");
        test(&mut Execution::new(engine, &mut program, machine, awaited, true));
    }

    #[test]
    fn what_comes_after_the_last_tag_needs_no_room() {
        with_execution(|execution| {
            execution.start(Instant::from_nanos(100));
            let tag = |time| Some(Tag::at(Instant::from_nanos(time)));
            assert!(execution.lacks_room(InputId(0), tag(200)) && execution.lacks_room(InputId(0), None));
            execution.engine.set_stop_tag(Tag::at(Instant::from_nanos(150)));
            assert!(execution.lacks_room(InputId(0), tag(150)) && !execution.lacks_room(InputId(0), tag(200)));
        });
    }

    /// The federate waits for ever for one of two inputs from the same sender, and not at all for that of another one.
    #[test]
    fn a_federate_starves_for_an_input_until_its_sender_has_ended_and_nothing_is_held_for_it() {
        with_execution(|execution| {
            execution.start(Instant::from_nanos(100));
            execution.engine.set_stop_tag(Tag::at(Instant::from_nanos(150)));
            assert_eq!([1, 2].map(|from| execution.starves_for(from)), [true, false]);
            let tag = execution.tag_in_question().expect("the last tag is to come");
            assert_eq!(
                execution.begin_time(Instant::from_nanos(150), tag),
                (Instant::FOREVER, false, Some(Advance::NotGranted))
            );
            execution.end_inputs(1, |port| port == 0);
            assert!(execution.starves_for(1));
            execution.end_inputs(1, |_| false);
            assert!(!execution.starves_for(1));
            assert_eq!(execution.begin_time(Instant::from_nanos(150), tag).0, tag.time);
        });
    }
}
