// SPDX-License-Identifier: Apache-2.0
//! A program that a test puts together from closures, and an engine that the test drives tag by tag.
//!
//! Times are milliseconds. Every bench has the same cells: two timers, two logical actions, a physical action, a
//! watchdog, three ports, a connection with `after` from port 0, an input, and an output from port 1.
use lf_model::{
    ActionTiming, DeliverError, Delivery, Engine, EngineStorage, Full, InputId, Instant, Interval, LogicalActionQueue,
    ModeCell, ModeCells, ModeEvents, ModeId, ModeInfo, ModeTrigger, ModelError, Modes, NetworkInput, NetworkOutput,
    OutputId, PayloadError, PhysicalActionQueue, PhysicalInbox, Placed, Policy, Port, PortId, PortInfo, Program,
    Progress, QueuedPort, ReactionContext, ReactionId, ReactionInfo, ReactionKind, Settings, Storage, Tables, Tag,
    TardyInput, Timer, TriggerCell, TriggerId, TriggerInfo, TriggerKind, Undelivered, Watchdog,
};

use lf_testkit::host::{Clock, Host};

pub(crate) const MS: i64 = 1_000_000;
pub(crate) const START: Instant = Instant::from_nanos(5_000 * MS);

/// Returns the tag this many milliseconds and microsteps after the start.
pub(crate) fn at(ms: i64, microstep: u32) -> Tag {
    Tag::new(START + Interval::from_millis(ms), lf_model::Microstep(microstep))
}

/// The trigger of a reaction.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum By {
    Startup,
    Shutdown,
    Reset,
    Timer(usize),
    Action(usize),
    Physical,
    Watchdog,
    Port(usize),
    Delayed,
    Input,
}

/// The ports and actions of a bench for its reactions.
pub(crate) struct Cells {
    pub timers: [Timer; 2],
    pub actions: [LogicalActionQueue<u32, 4>; 2],
    pub physical: PhysicalActionQueue<u32, 3>,
    pub watchdog: Watchdog,
    pub ports: [Port<u32>; 3],
    pub delayed: QueuedPort<u32, 2>,
    pub input: TardyInput<u32, 2>,
    /// The modes whose state has been reset.
    pub resets: Vec<u16>,
    /// The log of reactions for the test: a word, and when.
    pub log: Vec<(String, Tag)>,
}

impl Cells {
    #[allow(clippy::needless_pass_by_value, reason = "a word is often a number or made on the spot")]
    pub(crate) fn log(&mut self, ctx: &ReactionContext<'_>, word: impl std::fmt::Display) {
        let tag = Tag::new(ctx.get_logical_time(), lf_model::Microstep(ctx.get_tag().microstep));
        self.log.push((format!("{word}"), tag));
    }
}

type Body = Box<dyn FnMut(&mut Cells, &mut ReactionContext<'_>)>;

struct Reaction {
    level: u16,
    triggers: Vec<By>,
    deadline: Option<Interval>,
    kind: ReactionKind,
    body: Body,
    handler: Option<Body>,
    tardy: Option<Body>,
    reads_input: bool,
    mode: Option<ModeId>,
}

pub(crate) struct BenchProgram {
    tables: &'static Tables,
    reactions: Vec<Reaction>,
    pub cells: Cells,
}

/// Puts a bench together.
pub(crate) struct Builder {
    settings: Settings,
    /// The first tag of a program that joins its federation later.
    first: Option<Tag>,
    timers: [(i64, i64); 2],
    actions: [ActionTiming; 2],
    physical: ActionTiming,
    watchdog: ActionTiming,
    delay: Interval,
    output_delay: Option<Interval>,
    tells_absence: bool,
    physical_connections: bool,
    tardy: bool,
    modes: &'static [ModeInfo],
    /// Of timers, actions, the physical action, the delayed connection, and the watchdog.
    trigger_modes: [Option<ModeId>; 10],
    reactions: Vec<Reaction>,
}

pub(crate) fn bench() -> Builder {
    Builder {
        settings: Settings::DEFAULT,
        first: None,
        timers: [(i64::MAX, 0); 2],
        actions: [ActionTiming::NONE; 2],
        physical: ActionTiming::NONE,
        watchdog: ActionTiming::NONE,
        delay: Interval::ZERO,
        output_delay: None,
        tells_absence: false,
        physical_connections: false,
        tardy: false,
        modes: &[],
        trigger_modes: [None; 10],
        reactions: Vec::new(),
    }
}

/// Returns an action's timing in milliseconds.
pub(crate) fn timing(min_delay: i64, min_spacing: Option<i64>, policy: Policy) -> ActionTiming {
    let min_spacing = min_spacing.map(Interval::from_millis);
    ActionTiming { min_delay: Interval::from_millis(min_delay), min_spacing, policy }
}

impl Builder {
    pub(crate) fn joins(mut self, first: Tag) -> Self {
        self.first = Some(first);
        self
    }

    pub(crate) fn settings(mut self, settings: Settings) -> Self {
        self.settings = settings;
        self
    }
    pub(crate) fn timer(mut self, index: usize, offset: i64, period: i64) -> Self {
        self.timers[index] = (offset * MS, period * MS);
        self
    }
    pub(crate) fn action(mut self, index: usize, timing: ActionTiming) -> Self {
        self.actions[index] = timing;
        self
    }
    pub(crate) fn physical(mut self, timing: ActionTiming) -> Self {
        self.physical = timing;
        self
    }
    pub(crate) fn watchdog(mut self, timeout_ms: i64) -> Self {
        self.watchdog = timing(timeout_ms, None, Policy::Defer);
        self
    }
    pub(crate) fn delay(mut self, ms: i64) -> Self {
        self.delay = Interval::from_millis(ms);
        self
    }
    pub(crate) fn output_delay(mut self, ms: i64) -> Self {
        self.output_delay = Some(Interval::from_millis(ms));
        self
    }
    /// Makes the output send absences.
    pub(crate) fn tells_absence(mut self) -> Self {
        self.tells_absence = true;
        self
    }
    /// Makes the connections into the delayed port and into the input physical.
    pub(crate) fn physical_connections(mut self) -> Self {
        self.physical_connections = true;
        self
    }

    /// Messages can come after their tag.
    pub(crate) fn tardy(mut self) -> Self {
        self.tardy = true;
        self
    }

    /// Adds modes to the program: the number of their instance, the mode that contains it, and whether they are
    /// initial.
    pub(crate) fn modes(mut self, modes: &[(u16, Option<u16>, bool)]) -> Self {
        self.modes = leak(modes.iter().map(|&(instance, parent, initial)| ModeInfo {
            name: "mode",
            instance,
            parent: parent.map(ModeId),
            initial,
        }));
        self
    }

    /// Puts a timer (2, 3), an action (4, 5), the physical action (6), the delayed connection (7) or the watchdog (9)
    /// into a mode.
    pub(crate) fn trigger_in(mut self, trigger: usize, mode: u16) -> Self {
        self.trigger_modes[trigger] = Some(ModeId(mode));
        self
    }

    /// Puts the reaction that was added last into a mode.
    pub(crate) fn in_mode(mut self, mode: u16) -> Self {
        self.reactions.last_mut().unwrap().mode = Some(ModeId(mode));
        self
    }

    /// Adds a handler for a tardy input to the reaction that was added last.
    pub(crate) fn handles_tardy(mut self, handler: impl FnMut(&mut Cells, &mut ReactionContext<'_>) + 'static) -> Self {
        self.reactions.last_mut().unwrap().tardy = Some(Box::new(handler));
        self
    }

    /// Lets the reaction that was added last read the input, which does not trigger it.
    pub(crate) fn reads_input(mut self) -> Self {
        self.reactions.last_mut().unwrap().reads_input = true;
        self
    }

    /// Adds a reaction; those of one level run in the order in which they are added.
    pub(crate) fn reaction(
        mut self,
        level: u16,
        triggers: &[By],
        body: impl FnMut(&mut Cells, &mut ReactionContext<'_>) + 'static,
    ) -> Self {
        self.reactions.push(Reaction {
            level,
            triggers: triggers.to_vec(),
            deadline: None,
            kind: ReactionKind::Body,
            body: Box::new(body),
            handler: None,
            tardy: None,
            reads_input: false,
            mode: None,
        });
        self
    }

    /// Adds a deadline to the reaction that was added last.
    pub(crate) fn deadline(
        mut self,
        ms: i64,
        handler: impl FnMut(&mut Cells, &mut ReactionContext<'_>) + 'static,
    ) -> Self {
        let reaction = self.reactions.last_mut().unwrap();
        reaction.deadline = Some(Interval::from_millis(ms));
        reaction.handler = Some(Box::new(handler));
        self
    }

    /// Adds the reaction that sends port 1 to another federate.
    pub(crate) fn sends(mut self, level: u16) -> Self {
        self = self.reaction(level, &[By::Port(1)], |_, _| unreachable!("it has no body"));
        self.reactions.last_mut().unwrap().kind = ReactionKind::Send(OutputId(0));
        self
    }

    pub(crate) fn build(mut self) -> Bench {
        let mut reactions = std::mem::take(&mut self.reactions);
        reactions.sort_by_key(|reaction| reaction.level);
        let sees_input = |reaction: &&Reaction| reaction.triggers.contains(&By::Input) || reaction.reads_input;
        let input_level = reactions.iter().filter(sees_input).map(|reaction| reaction.level).min().unwrap_or(u16::MAX);
        let sends = |reaction: &Reaction| reaction.kind == ReactionKind::Send(OutputId(0));
        let sending = (0..).map(ReactionId).zip(&reactions).filter(|(_, reaction)| sends(reaction)).map(|(id, _)| id);
        let fills = PortId(3);
        let delay = self.delay;
        let delayed = if self.physical_connections {
            TriggerKind::PhysicalDelay { fills, delay }
        } else {
            TriggerKind::Delay { fills, delay }
        };
        let reads = (0..).map(ReactionId).zip(&reactions).filter(|(_, reaction)| reaction.reads_input);
        let readers = leak(reads.map(|(id, _)| id));
        let absence = if self.tells_absence { leak(sending) } else { &[] };
        let tables: &'static Tables = Box::leak(Box::new(Tables {
            reactions: leak(reactions.iter().map(|reaction| ReactionInfo {
                name: "reaction",
                level: reaction.level,
                deadline: reaction.deadline,
                tardy: reaction.tardy.is_some(),
                kind: reaction.kind,
            })),
            triggers: triggers(&self, &reactions, delayed),
            ports: ports(&reactions),
            outputs: leak([NetworkOutput {
                name: "bench.out -> other.in",
                source: PortId(1),
                federate: 9,
                port: 3,
                delay: self.output_delay,
                max_len: 4,
                tells_absence: self.tells_absence,
                physical: false,
            }]),
            inputs: leak([NetworkInput {
                name: "other.out -> bench.in",
                trigger: TriggerId(8),
                federate: 9,
                delay: self.physical_connections.then_some(self.delay),
                max_len: 4,
                level: input_level,
                awaited: !self.physical_connections,
                physical: self.physical_connections,
                tardy: self.tardy,
                readers,
                ..NetworkInput::DEFAULT
            }]),
            absence,
            modes: (!self.modes.is_empty()).then(|| self.leak_modes(&reactions)),
            ..Tables::DEFAULT
        }));
        tables.check();
        let inbox: &'static PhysicalInbox<u32, 4> = Box::leak(Box::new(PhysicalInbox::new()));
        let cells = Cells {
            timers: Default::default(),
            actions: [4, 5].map(|id| LogicalActionQueue::new(TriggerId(id))),
            physical: PhysicalActionQueue::new(TriggerId(6), inbox),
            watchdog: Watchdog::new(TriggerId(9)),
            ports: [0, 1, 2].map(|id| Port::new(PortId(id))),
            delayed: QueuedPort::new(PortId(3)),
            input: TardyInput::new(PortId(4)),
            resets: Vec::new(),
            log: Vec::new(),
        };
        let mut engine = engine(tables, self.settings, self.tardy, !self.modes.is_empty());
        engine.join(START, self.first.unwrap_or(Tag::at(START)));
        let clock = Clock::new_static(START.as_nanos());
        Bench { program: BenchProgram { tables, reactions, cells }, engine, host: Host::new(clock), clock }
    }
}

impl Builder {
    fn leak_modes(&self, reactions: &[Reaction]) -> &'static Modes {
        let of_reactions = leak(reactions.iter().map(|reaction| reaction.mode));
        let offset =
            |trigger: usize| (2..4).contains(&trigger).then(|| Interval::from_nanos(self.timers[trigger - 2].0));
        let id = |trigger: usize| TriggerId(u16::try_from(trigger).unwrap());
        let triggers = self.trigger_modes.iter().enumerate().filter_map(|(trigger, mode)| {
            Some(ModeTrigger { trigger: id(trigger), mode: (*mode)?, offset: offset(trigger) })
        });
        let by = |by| triggered_by(reactions, by);
        let events = ModeEvents {
            entry: TriggerId(10),
            startup: by(By::Startup),
            reset: by(By::Reset),
            shutdown: by(By::Shutdown),
        };
        Box::leak(Box::new(Modes::new(self.modes, of_reactions, leak(triggers), events)))
    }
}

/// Returns an engine in memory of the right size; no bench has more than four modes.
fn engine(tables: &'static Tables, settings: Settings, tardy: bool, modal: bool) -> Engine<'static> {
    if modal {
        let storage: &'static mut Storage<11, 1, 1, 1, 0, 0, 4, 10> = Box::leak(Box::new(EngineStorage::new()));
        Engine::new(tables, storage, settings)
    } else if tardy {
        let storage: &'static mut Storage<10, 1, 1, 1, 1, 1> = Box::leak(Box::new(EngineStorage::new()));
        Engine::new(tables, storage, settings)
    } else {
        let storage: &'static mut Storage<10, 1, 1, 1> = Box::leak(Box::new(EngineStorage::new()));
        Engine::new(tables, storage, settings)
    }
}

fn leak<T>(items: impl IntoIterator<Item = T>) -> &'static [T] {
    Box::leak(items.into_iter().collect())
}

fn triggered_by(reactions: &[Reaction], by: By) -> &'static [ReactionId] {
    leak((0..).map(ReactionId).zip(reactions).filter(|(_, reaction)| reaction.triggers.contains(&by)).map(|(id, _)| id))
}

fn triggers(bench: &Builder, reactions: &[Reaction], delayed: TriggerKind) -> &'static [TriggerInfo] {
    let Builder { timers, actions, physical, watchdog, .. } = bench;
    let timer = |index: usize| TriggerKind::Timer {
        offset: Interval::from_nanos(timers[index].0),
        period: Interval::from_nanos(timers[index].1),
    };
    let info = |name, kind, by: Option<By>| TriggerInfo {
        name,
        kind,
        reactions: by.map_or(&[], |by| triggered_by(reactions, by)),
    };
    let reset = (!bench.modes.is_empty()).then(|| info("reset", TriggerKind::Reset, Some(By::Reset)));
    let triggers = [
        info("startup", TriggerKind::Startup, Some(By::Startup)),
        info("shutdown", TriggerKind::Shutdown, Some(By::Shutdown)),
        info("bench.t0", timer(0), Some(By::Timer(0))),
        info("bench.t1", timer(1), Some(By::Timer(1))),
        info("bench.a0", TriggerKind::Logical(actions[0]), Some(By::Action(0))),
        info("bench.a1", TriggerKind::Logical(actions[1]), Some(By::Action(1))),
        info("bench.p", TriggerKind::Physical(*physical), Some(By::Physical)),
        info("bench.p3", delayed, None),
        info("bench.in", TriggerKind::NetworkInput { fills: PortId(4) }, None),
        info("bench.w", TriggerKind::Logical(*watchdog), Some(By::Watchdog)),
    ];
    leak(triggers.into_iter().chain(reset))
}

fn ports(reactions: &[Reaction]) -> &'static [PortInfo] {
    let by = [By::Port(0), By::Port(1), By::Port(2), By::Delayed, By::Input];
    let names = ["bench.p0", "bench.p1", "bench.p2", "bench.p3", "bench.in"];
    leak(by.into_iter().zip(names).map(|(by, name)| PortInfo {
        name,
        reactions: triggered_by(reactions, by),
        delays: if by == By::Port(0) { &[TriggerId(7)] } else { &[] },
    }))
}

impl ModeCells for BenchProgram {
    fn in_mode(&mut self, trigger: TriggerId) -> Option<&mut dyn ModeCell> {
        match usize::from(trigger.0) {
            index @ 4..6 => Some(&mut self.cells.actions[index - 4]),
            6 => Some(&mut self.cells.physical),
            7 => Some(&mut self.cells.delayed),
            9 => Some(&mut self.cells.watchdog),
            _ => None,
        }
    }

    fn reset_mode(&mut self, mode: ModeId) {
        self.cells.resets.push(mode.0);
    }
}

impl Program for BenchProgram {
    fn tables(&self) -> &'static Tables {
        self.tables
    }

    fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        (self.reactions[usize::from(reaction.0)].body)(&mut self.cells, ctx);
    }

    fn miss_deadline(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        (self.reactions[usize::from(reaction.0)].handler.as_mut().unwrap())(&mut self.cells, ctx);
    }

    fn handle_tardy(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        (self.reactions[usize::from(reaction.0)].tardy.as_mut().unwrap())(&mut self.cells, ctx);
    }

    fn clear_port(&mut self, port: PortId) {
        match port.0 {
            3 => self.cells.delayed.port.clear(),
            4 => self.cells.input.port.clear(),
            index => self.cells.ports[usize::from(index)].clear(),
        }
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        let index = usize::from(trigger.0);
        match index {
            2..4 => Some(&mut self.cells.timers[index - 2]),
            4..6 => Some(&mut self.cells.actions[index - 4]),
            6 => Some(&mut self.cells.physical),
            7 => Some(&mut self.cells.delayed),
            8 => Some(&mut self.cells.input),
            9 => Some(&mut self.cells.watchdog),
            _ => None,
        }
    }

    fn modes(&mut self) -> Option<&mut dyn ModeCells> {
        Some(self)
    }

    fn capture(&mut self, _trigger: TriggerId, tag: Tag) -> Result<(), Full> {
        self.cells.delayed.capture(tag, &self.cells.ports[0])
    }

    fn encode(&self, _output: OutputId, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        // One value stands for all that cannot be written.
        if lf_model::Readable::value(&self.cells.ports[1]) == Some(&u32::MAX) {
            return Err(PayloadError::Nul);
        }
        self.cells.ports[1].encode(bytes)
    }

    fn deliver(&mut self, _input: InputId, tag: Tag, bytes: &[u8]) -> Result<(), Undelivered> {
        self.cells.input.deliver(tag, bytes)
    }

    fn deliver_tardy(&mut self, _input: InputId, tag: Tag, intended: Tag, bytes: &[u8]) -> Result<Placed, Undelivered> {
        self.cells.input.deliver_tardy(tag, intended, bytes)
    }
}

/// A program in the middle of its run.
pub(crate) struct Bench {
    pub program: BenchProgram,
    pub engine: Engine<'static>,
    pub host: Host,
    pub clock: &'static Clock,
}

impl Bench {
    /// Opens the next tag, with physical time at its time, and runs it; returns the tag and its outcome.
    pub(crate) fn step(&mut self) -> Option<(Tag, Progress)> {
        self.engine.drain_physical(&mut self.program, &self.host);
        let tag = self.engine.next_tag()?;
        self.clock.set(tag.time);
        self.engine.begin(&mut self.program, tag).unwrap();
        Some((tag, self.advance()))
    }

    pub(crate) fn advance(&mut self) -> Progress {
        self.advance_below(None)
    }

    /// Runs reactions below a level, if one is given.
    pub(crate) fn advance_below(&mut self, limit: Option<u16>) -> Progress {
        self.engine.advance(&mut self.program, &mut self.host, limit)
    }

    /// Opens a tag, whether or not it has events, with physical time at its time.
    pub(crate) fn begin(&mut self, tag: Tag) {
        self.clock.set(tag.time);
        self.engine.begin(&mut self.program, tag).unwrap();
    }

    /// Runs complete tags, at most `count`; returns the tags.
    pub(crate) fn steps(&mut self, count: usize) -> Vec<Tag> {
        let mut tags = Vec::new();
        for _ in 0..count {
            match self.step() {
                Some((tag, Progress::Complete)) => tags.push(tag),
                Some((tag, other)) => panic!("{other:?} at {tag}"),
                None => break,
            }
        }
        tags
    }

    /// Runs until the program fails, and returns the error.
    pub(crate) fn failure(&mut self) -> ModelError {
        loop {
            match self.step() {
                Some((_, Progress::Failed(error))) => return error,
                Some((_, Progress::Complete)) => {}
                other => panic!("{other:?}"),
            }
        }
    }

    pub(crate) fn deliver(&mut self, tag: Tag, value: u32) -> Result<(), DeliverError> {
        self.engine.deliver(&mut self.program, InputId(0), tag, &value.to_le_bytes())
    }

    pub(crate) fn deliver_tardy(&mut self, tag: Tag, value: u32) -> Delivery {
        self.engine.deliver_tardy(&mut self.program, InputId(0), tag, &value.to_le_bytes()).unwrap()
    }

    /// Returns the log since the last call: the word, the milliseconds after the start, the microstep.
    pub(crate) fn log(&mut self) -> Vec<(String, i64, u32)> {
        let log = std::mem::take(&mut self.program.cells.log);
        log.into_iter().map(|(word, tag)| (word, tag.time.since(START).as_nanos() / MS, tag.microstep.0)).collect()
    }
}

/// Converts entries for comparison with [`Bench::log`].
pub(crate) fn entries(expected: &[(&str, i64, u32)]) -> Vec<(String, i64, u32)> {
    expected.iter().map(|&(word, ms, microstep)| (word.to_string(), ms, microstep)).collect()
}
