// SPDX-License-Identifier: Apache-2.0
//! A program with bodies in C, as the compiler generates it; its C part is in the folder `c`. Roughly:
//!
//! ```text
//! reactor Source {
//!   output y: int  output[2] m: int  output list: int[]  output box: box_t*  output grid: int[3]
//!   timer t(0, 20 ms)
//!   logical action again: int  logical action items: int[]  physical action button: int
//!   watchdog poodle(4 ms) {= … =}
//! }
//! reactor Modal { input y: int  output copied: int  logical action tick
//!   initial mode One { reaction(y) -> reset(Two) }
//!   mode Two { reset state n: int = 40  y -> copied  reaction(reset) -> tick  reaction(tick) -> history(One) } }
//! federated reactor { …  source.list -> writer.late after 5 ms  other.text -> network.text … }
//! ```
use lf_c as c;
use lf_model as lf;

/// The sizes of C types that the tables need.
pub mod sizes {
    #![allow(missing_docs, reason = "the build script writes it")]
    include!(concat!(env!("OUT_DIR"), "/sizes.rs"));
}

static BUTTON: c::PhysicalInbox<4> = c::PhysicalInbox::new();

/// The owner of the program.
#[allow(missing_debug_implementations)]
pub struct Program {
    y: c::Port,
    m: [c::Port; 2],
    list: c::Port,
    a_box: c::Port,
    grid: c::Port,
    doubled: c::Port,
    late: c::QueuedPort<1>,
    text: c::QueuedPort<2>,
    numbers: c::QueuedPort<2>,
    point: c::TardyInput<2>,
    copied: c::Port,
    text_out: c::Port,
    point_out: c::Port,
    t: c::Timer,
    again: c::LogicalAction<2>,
    items: c::LogicalAction<4>,
    button: c::PhysicalAction<4>,
    poodle: c::Watchdog,
    tick: c::LogicalAction<1>,
}

impl Default for Program {
    fn default() -> Self {
        c::construct();
        let port = |id| c::Port::new(lf::PortId(id));
        Self {
            y: port(0),
            m: [port(1), port(2)],
            list: port(3),
            a_box: port(4),
            grid: port(5),
            doubled: port(6),
            late: c::QueuedPort::new(lf::PortId(7), lf::TriggerId(7)),
            text: c::QueuedPort::new(lf::PortId(8), lf::TriggerId(8)),
            numbers: c::QueuedPort::new(lf::PortId(9), lf::TriggerId(9)),
            point: c::TardyInput::new(lf::PortId(10), lf::TriggerId(10)),
            copied: port(11),
            text_out: port(12),
            point_out: port(13),
            t: c::Timer::new(lf::TriggerId(2)),
            again: c::LogicalAction::new(lf::TriggerId(3)),
            items: c::LogicalAction::new(lf::TriggerId(4)),
            button: c::PhysicalAction::new(lf::TriggerId(5), &BUTTON),
            poodle: c::Watchdog::new(lf::TriggerId(6)),
            tick: c::LogicalAction::new(lf::TriggerId(12)),
        }
    }
}

impl c::Bodies for Program {
    fn action(&mut self, action: lf::TriggerId) -> Option<&mut dyn lf::Schedulable<Value = c::Token>> {
        match action.0 {
            3 => Some(&mut self.again),
            4 => Some(&mut self.items),
            5 => Some(&mut self.button),
            12 => Some(&mut self.tick),
            _ => None,
        }
    }

    fn watchdog(&mut self, watchdog: lf::TriggerId) -> Option<&mut lf::Watchdog> {
        (watchdog.0 == 6).then_some(&mut self.poodle)
    }

    fn inbox(action: lf::TriggerId) -> Option<&'static dyn lf::Inbox<c::Token>> {
        match action.0 {
            5 => Some(&BUTTON),
            _ => None,
        }
    }
}

impl lf::Program for Program {
    fn tables(&self) -> &'static lf::Tables {
        &TABLES
    }

    fn react(&mut self, reaction: lf::ReactionId, ctx: &mut lf::ReactionContext<'_>) {
        match reaction.0 {
            7 => c::copy(ctx, &self.y, &mut self.copied),
            _ => c::react(self, reaction, ctx),
        }
    }

    fn miss_deadline(&mut self, reaction: lf::ReactionId, ctx: &mut lf::ReactionContext<'_>) {
        c::miss_deadline(self, reaction, ctx);
    }

    fn handle_tardy(&mut self, reaction: lf::ReactionId, ctx: &mut lf::ReactionContext<'_>) {
        c::handle_tardy(self, reaction, ctx);
    }

    fn port(&mut self, port: lf::PortId) -> Option<&mut dyn lf::PortCell> {
        match port.0 {
            0 => Some(&mut self.y),
            1 => Some(&mut self.m[0]),
            2 => Some(&mut self.m[1]),
            3 => Some(&mut self.list),
            4 => Some(&mut self.a_box),
            5 => Some(&mut self.grid),
            6 => Some(&mut self.doubled),
            7 => Some(&mut self.late.port),
            8 => Some(&mut self.text.port),
            9 => Some(&mut self.numbers.port),
            10 => Some(&mut self.point.port),
            11 => Some(&mut self.copied),
            12 => Some(&mut self.text_out),
            13 => Some(&mut self.point_out),
            _ => None,
        }
    }

    fn trigger(&mut self, trigger: lf::TriggerId) -> Option<&mut dyn lf::TriggerCell> {
        match trigger.0 {
            2 => Some(&mut self.t),
            3 => Some(&mut self.again),
            4 => Some(&mut self.items),
            5 => Some(&mut self.button),
            6 => Some(&mut self.poodle),
            7 => Some(&mut self.late),
            8 => Some(&mut self.text),
            9 => Some(&mut self.numbers),
            10 => Some(&mut self.point),
            12 => Some(&mut self.tick),
            _ => None,
        }
    }

    fn modes(&mut self) -> Option<&mut dyn lf::ModeCells> {
        Some(self)
    }

    fn capture(&mut self, trigger: lf::TriggerId, tag: lf::Tag) -> Result<(), lf::Full> {
        match trigger.0 {
            7 => self.late.capture(tag, &self.list),
            _ => Ok(()),
        }
    }

    fn encode(&self, output: lf::OutputId, bytes: &mut [u8]) -> Result<usize, lf::PayloadError> {
        match output.0 {
            0 => self.list.encode(bytes),
            1 => self.text_out.encode(bytes),
            2 => self.point_out.encode(bytes),
            _ => Err(lf::PayloadError::Absent),
        }
    }

    fn deliver(&mut self, input: lf::InputId, tag: lf::Tag, bytes: &[u8]) -> Result<(), lf::Undelivered> {
        match input.0 {
            0 => self.text.deliver(tag, bytes),
            1 => self.numbers.deliver(tag, bytes),
            2 => self.point.deliver(tag, bytes),
            _ => Err(lf::Undelivered::NoSuchPort),
        }
    }

    fn deliver_tardy(
        &mut self,
        input: lf::InputId,
        tag: lf::Tag,
        intended: lf::Tag,
        bytes: &[u8],
    ) -> Result<lf::Placed, lf::Undelivered> {
        match input.0 {
            2 => self.point.deliver_tardy(tag, intended, bytes),
            _ => Err(lf::Undelivered::NoSuchPort),
        }
    }
}

impl lf::ModeCells for Program {
    fn in_mode(&mut self, trigger: lf::TriggerId) -> Option<&mut dyn lf::ModeCell> {
        (trigger.0 == 12).then_some(&mut self.tick)
    }

    fn reset_mode(&mut self, mode: lf::ModeId) {
        c::reset_mode(mode);
    }
}

const fn ms(ms: i64) -> lf::Interval {
    lf::Interval::from_millis(ms)
}

const fn reaction(name: &'static str, level: u16) -> lf::ReactionInfo {
    lf::ReactionInfo { name, level, ..lf::ReactionInfo::DEFAULT }
}

const fn sends(level: u16, output: u16) -> lf::ReactionInfo {
    lf::ReactionInfo { kind: lf::ReactionKind::Send(lf::OutputId(output)), ..reaction("sends", level) }
}

const fn trigger(name: &'static str, kind: lf::TriggerKind, reactions: &'static [lf::ReactionId]) -> lf::TriggerInfo {
    lf::TriggerInfo { name, kind, reactions }
}

const fn action(name: &'static str, reactions: &'static [lf::ReactionId]) -> lf::TriggerInfo {
    trigger(name, lf::TriggerKind::Logical(lf::ActionTiming::NONE), reactions)
}

const fn input(fills: u16) -> lf::TriggerInfo {
    trigger("input", lf::TriggerKind::NetworkInput { fills: lf::PortId(fills) }, &[])
}

const fn port(name: &'static str, reactions: &'static [lf::ReactionId]) -> lf::PortInfo {
    lf::PortInfo { name, reactions, delays: &[] }
}

/// Lists of reactions.
macro_rules! ids {
    ($($id:literal)*) => { &[$(lf::ReactionId($id)),*] };
}

/// The tables.
pub const TABLES: lf::Tables = lf::Tables {
    reactions: &[
        reaction("source.1", 0),
        reaction("source.2", 1),
        reaction("source.3", 2),
        reaction("source.poodle", 2),
        reaction("reader.1", 3),
        reaction("writer.1", 3),
        reaction("modal.1", 3),
        reaction("modal.copy", 3),
        reaction("modal.2", 4),
        reaction("modal.3", 5),
        lf::ReactionInfo { deadline: Some(ms(1000)), ..reaction("writer.2", 5) },
        reaction("network.1", 5),
        lf::ReactionInfo { tardy: true, ..reaction("network.2", 5) },
        sends(6, 0),
        sends(6, 1),
        sends(6, 2),
        reaction("source.4", 7),
    ],
    triggers: &[
        trigger("startup", lf::TriggerKind::Startup, ids![0]),
        trigger("shutdown", lf::TriggerKind::Shutdown, ids![16]),
        trigger("t", lf::TriggerKind::Timer { offset: ms(0), period: ms(20) }, ids![1]),
        action("again", ids![2]),
        action("items", ids![2]),
        trigger("button", lf::TriggerKind::Physical(lf::ActionTiming::NONE), ids![2]),
        trigger(
            "poodle",
            lf::TriggerKind::Logical(lf::ActionTiming { min_delay: ms(4), ..lf::ActionTiming::NONE }),
            ids![3],
        ),
        trigger("late", lf::TriggerKind::Delay { fills: lf::PortId(7), delay: ms(5) }, &[]),
        input(8),
        input(9),
        input(10),
        trigger("reset", lf::TriggerKind::Reset, &[]),
        action("tick", ids![9]),
    ],
    ports: &[
        port("y", ids![4 6 7]),
        port("m[0]", ids![4]),
        port("m[1]", ids![4]),
        lf::PortInfo { delays: &[lf::TriggerId(7)], ..port("list", ids![4 5 13]) },
        port("box", ids![4]),
        port("grid", ids![4]),
        port("doubled", ids![10]),
        port("late", ids![10]),
        port("text", ids![11]),
        port("numbers", ids![11]),
        port("point", ids![12]),
        port("copied", ids![10]),
        port("text_out", ids![14]),
        port("point_out", ids![15]),
    ],
    outputs: &[
        lf::NetworkOutput { source: lf::PortId(3), max_len: 4 * sizes::LF_SIZE_1, ..lf::NetworkOutput::DEFAULT },
        lf::NetworkOutput { source: lf::PortId(12), port: 1, max_len: 8, ..lf::NetworkOutput::DEFAULT },
        lf::NetworkOutput { source: lf::PortId(13), port: 2, max_len: sizes::LF_SIZE_0, ..lf::NetworkOutput::DEFAULT },
    ],
    inputs: &[
        lf::NetworkInput { name: "text", trigger: lf::TriggerId(8), max_len: 8, level: 5, ..lf::NetworkInput::DEFAULT },
        lf::NetworkInput {
            name: "numbers",
            trigger: lf::TriggerId(9),
            max_len: 16,
            level: 5,
            ..lf::NetworkInput::DEFAULT
        },
        lf::NetworkInput {
            name: "point",
            trigger: lf::TriggerId(10),
            max_len: sizes::LF_SIZE_0,
            level: 5,
            tardy: true,
            ..lf::NetworkInput::DEFAULT
        },
    ],
    modes: Some(&MODES),
    ..lf::Tables::DEFAULT
};
const _: () = TABLES.check();

const ONE: Option<lf::ModeId> = Some(lf::ModeId(0));
const TWO: Option<lf::ModeId> = Some(lf::ModeId(1));
const MODES: lf::Modes = lf::Modes::new(
    &[
        lf::ModeInfo { name: "modal.One", instance: 0, parent: None, initial: true },
        lf::ModeInfo { name: "modal.Two", instance: 0, parent: None, initial: false },
    ],
    &[None, None, None, None, None, None, ONE, TWO, TWO, TWO, None, None, None, None, None, None, None],
    &[lf::ModeTrigger { trigger: lf::TriggerId(12), mode: lf::ModeId(1), offset: None }],
    lf::ModeEvents { entry: lf::TriggerId(11), startup: ids![0], reset: ids![8], shutdown: ids![16] },
);

/// The engine's memory.
pub type Storage = lf::storage_for!(TABLES);
