// SPDX-License-Identifier: Apache-2.0
//! A plan made by hand, of a program that has a bit of everything. Places are looked up in its text.

use crate::plan::{
    ActionDeclaration, Argument, Child, ClassIndex, Code, Federate, FileIndex, InputIndex, Instance, InstanceIndex,
    Location, Logging, NetworkInput, NetworkOutput, OutputIndex, Parameter, Plan, Port, PortDeclaration, PortDirection,
    PortIndex, Reaction, ReactionIndex, ReactionKind, ReactionParameter, ReactorClass, Rti, ScheduledReaction,
    SourceFile, SpacingPolicy, StateVariable, Target, TimerDeclaration, Trigger, TriggerIndex, TriggerKind, Type,
    Upstream, Value, VariableKind,
};

pub(super) const TEXT: &str = include_str!("everything.lf");
const MS: i64 = 1_000_000;

/// The place of the character that follows `before`, which must occur in the text.
pub(super) fn at(before: &str) -> Location {
    let end = TEXT.find(before).unwrap_or_else(|| panic!("{before:?} is not in the text")) + before.len();
    let line = TEXT[..end].matches('\n').count() + 1;
    let column = TEXT[..end].rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    Location { file: FileIndex(0), line, column }
}

/// The code between the first `{=` at the end of `before` and `=}`.
fn code(before: &str) -> Code {
    assert!(before.ends_with("{="), "{before:?}");
    let start = TEXT.find(before).unwrap_or_else(|| panic!("{before:?} is not in the text")) + before.len();
    let len = TEXT[start..].find("=}").expect("the text is well-formed");
    Code { text: TEXT[start..start + len].to_owned(), at: at(before) }
}

/// A word that follows `before`.
fn word(before: &str, word: &str) -> Value {
    let at = at(before);
    assert!(TEXT.contains(&format!("{before}{word}")));
    Value::Rust(Code { text: word.to_owned(), at })
}

fn ty(before: &str, text: &str) -> Type {
    Type { text: text.to_owned(), at: at(before) }
}

fn parameter(before: &str, name: &str, text: &str, default: Value) -> Parameter {
    Parameter { name: name.to_owned(), ty: ty(before, text), default: Some(default), at: at(before) }
}

fn state(name: &str, text: &str, init: Option<Value>) -> StateVariable {
    let before = format!("state {name}: ");
    let (ty, at) = (ty(&before, text), at("state "));
    StateVariable { name: name.to_owned(), at: Location { column: at.column, ..ty.at }, ty, init }
}

fn port(direction: PortDirection, name: &str, text: &str) -> PortDeclaration {
    let keyword = if direction == PortDirection::Input { "input" } else { "output" };
    let before = format!("{keyword} {name}: ");
    PortDeclaration { name: name.to_owned(), direction, ty: ty(&before, text), at: at(&before) }
}

/// A variable of a reaction: name, kind, and whether it is an effect.
fn variable(name: &str, kind: VariableKind, effect: bool) -> ReactionParameter {
    let at = Location { file: FileIndex(0), line: 1, column: 1 };
    ReactionParameter { name: name.to_owned(), kind, triggers: !effect, uses: false, effect, at }
}

fn reaction(number: usize, signature: &str, body: &str, parameters: Vec<ReactionParameter>) -> Reaction {
    Reaction {
        number,
        name: None,
        signature: signature.to_owned(),
        parameters,
        body: code(body),
        deadline: None,
        at: at(&body[..body.len() - " {=".len()]),
    }
}

fn class(name: &str) -> ReactorClass {
    ReactorClass {
        name: name.to_owned(),
        at: at(&format!("reactor {name}")),
        docs: None,
        preambles: Vec::new(),
        parameters: Vec::new(),
        state: Vec::new(),
        ports: Vec::new(),
        actions: Vec::new(),
        timers: Vec::new(),
        children: Vec::new(),
        reactions: Vec::new(),
    }
}

fn u32_port() -> VariableKind {
    VariableKind::Port { ty: ty("input raw: ", "u32") }
}

fn filter() -> ReactorClass {
    let body = "reaction scale(raw) -> smooth {=";
    let variables = vec![variable("raw", u32_port(), false), variable("smooth", u32_port(), true)];
    let mut scale = reaction(1, "reaction scale(raw) -> smooth", body, variables);
    scale.name = Some("scale".to_owned());
    scale.deadline = Some(code("=} deadline(5 msec) {="));
    ReactorClass {
        docs: Some("Multiplies.".to_owned()),
        parameters: vec![parameter("Filter(gain: ", "gain", "u32", word("Filter(gain: u32 = ", "2"))],
        state: vec![state("last", "u32", Some(word("state last: u32 = ", "gain")))],
        ports: vec![port(PortDirection::Input, "raw", "u32"), port(PortDirection::Output, "smooth", "u32")],
        reactions: vec![scale],
        ..class("Filter")
    }
}

fn unit() -> ReactorClass {
    let again = || VariableKind::LogicalAction { ty: ty("again(1 msec): ", "u32") };
    let button = || VariableKind::PhysicalAction { ty: ty("\"drop\"): ", "u32") };
    let command = VariableKind::Port { ty: ty("input command: ", "Command") };
    let child = |before: &str, name: &str, arguments| Child {
        name: name.to_owned(),
        class: ClassIndex(0),
        arguments,
        at: at(before),
    };
    let action = |before: &str, name: &str, physical| ActionDeclaration {
        name: name.to_owned(),
        physical,
        ty: ty(before, "u32"),
        at: at(before),
    };
    ReactorClass {
        preambles: vec![code("  preamble {=")],
        parameters: vec![
            parameter("Unit(limit: ", "limit", "u32", word("Unit(limit: u32 = ", "100")),
            parameter("type: {= ", "type", "&'static str", word("&'static str =} = ", "\"π // unit\"")),
        ],
        state: vec![
            state("seen", "u32", None),
            state("wait", "core::time::Duration", Some(Value::Time { ns: 2 * MS })),
            state("half", "u32", Some(Value::Rust(code("state half: u32 = {=")))),
        ],
        ports: vec![port(PortDirection::Input, "command", "Command"), port(PortDirection::Output, "report", "Report")],
        actions: vec![action("again(1 msec): ", "again", false), action("\"drop\"): ", "button", true)],
        timers: vec![TimerDeclaration { name: "t".to_owned(), at: at("timer ") }],
        children: vec![
            child("  first = ", "first", vec![Some(word("first = new Filter(gain = ", "limit"))]),
            child("  second = ", "second", vec![None]),
        ],
        reactions: vec![
            reaction(
                1,
                "reaction(startup) -> button",
                "reaction(startup) -> button {=",
                vec![variable("button", button(), true)],
            ),
            reaction(
                2,
                "reaction(t) -> first.raw, again",
                "reaction(t) -> first.raw, again {=",
                vec![
                    variable("t", VariableKind::Timer, false),
                    variable("first__raw", u32_port(), true),
                    variable("again", again(), true),
                ],
            ),
            reaction(
                3,
                "reaction(again, button)",
                "reaction(again, button) {=",
                vec![variable("again", again(), false), variable("button", button(), false)],
            ),
            reaction(
                4,
                "reaction(command) second.smooth",
                "reaction(command) second.smooth {=",
                vec![variable("command", command, false), variable("second__smooth", u32_port(), false)],
            ),
            reaction(5, "reaction(shutdown)", "reaction(shutdown) {=", vec![]),
        ],
        ..class("Unit")
    }
}

fn other() -> ReactorClass {
    let body = "reaction(report) -> command {=";
    let report = VariableKind::Port { ty: ty("input report: ", "Report") };
    let command = VariableKind::Port { ty: ty("output command: ", "Command") };
    let variables = vec![variable("report", report, false), variable("command", command, true)];
    ReactorClass {
        ports: vec![port(PortDirection::Input, "report", "Report"), port(PortDirection::Output, "command", "Command")],
        reactions: vec![reaction(1, "reaction(report) -> command", body, variables)],
        ..class("Other")
    }
}

fn everything() -> ReactorClass {
    ReactorClass {
        parameters: vec![parameter("Everything(limit: ", "limit", "u32", word("Everything(limit: u32 = ", "50"))],
        children: vec![
            Child {
                name: "unit".to_owned(),
                class: ClassIndex(1),
                arguments: vec![Some(word("new Unit(limit = ", "limit")), None],
                at: at("  unit = "),
            },
            Child { name: "other".to_owned(), class: ClassIndex(2), arguments: vec![], at: at("  other = ") },
        ],
        ..class("Everything")
    }
}

fn ports(ports: &[(&str, &str, &[usize], &[usize])]) -> Vec<Port> {
    let make = |(path, text, reactions, delays): &(&str, &str, &[usize], &[usize])| Port {
        path: (*path).to_owned(),
        ty: ty("input raw: ", text),
        reactions: reactions.iter().copied().map(ReactionIndex).collect(),
        delays: delays.iter().copied().map(TriggerIndex).collect(),
        at: at("input raw: "),
    };
    ports.iter().map(make).collect()
}

fn trigger(path: &str, kind: TriggerKind, capacity: usize, reactions: &[usize]) -> Trigger {
    let at = (!matches!(kind, TriggerKind::Startup | TriggerKind::Shutdown)).then(|| at("timer "));
    let reactions = reactions.iter().copied().map(ReactionIndex).collect();
    Trigger { path: path.to_owned(), kind, capacity, reactions, at }
}

fn body(name: &str, level: u16, instance: usize, reaction: usize, arguments: Vec<Argument>) -> ScheduledReaction {
    let kind = ReactionKind::Body { instance: InstanceIndex(instance), reaction, arguments };
    ScheduledReaction { name: name.to_owned(), level, deadline_ns: None, kind }
}

fn send(name: &str, level: u16) -> ScheduledReaction {
    let kind = ReactionKind::Send(OutputIndex(0));
    ScheduledReaction { name: name.to_owned(), level, deadline_ns: None, kind }
}

fn instance(path: &str, class: usize, parent: Option<usize>, child: usize) -> Instance {
    let parent = parent.map(InstanceIndex);
    Instance { path: path.to_owned(), class: ClassIndex(class), parent, child: Some(child), at: at("  first = ") }
}

fn unit_reactions() -> Vec<ScheduledReaction> {
    let (port, trigger) = (|index| Argument::Port(PortIndex(index)), |index| Argument::Trigger(TriggerIndex(index)));
    let late = |reaction| ScheduledReaction { deadline_ns: Some(5 * MS), ..reaction };
    vec![
        body("unit.reaction_1", 0, 0, 1, vec![trigger(4)]),
        body("unit.reaction_2", 1, 0, 2, vec![trigger(2), port(0), trigger(3)]),
        late(body("unit.first.reaction_1", 2, 1, 1, vec![port(0), port(1)])),
        body("unit.reaction_3", 2, 0, 3, vec![trigger(3), trigger(4)]),
        late(body("unit.second.reaction_1", 2, 2, 1, vec![port(2), port(3)])),
        send("unit.report -> other.report", 3),
        body("unit.reaction_4", 3, 0, 4, vec![port(4), port(3)]),
        body("unit.reaction_5", 4, 0, 5, vec![]),
    ]
}

fn unit_triggers() -> Vec<Trigger> {
    let action = |physical, min_delay_ns, min_spacing_ns, policy| TriggerKind::Action {
        instance: InstanceIndex(0),
        physical,
        ty: ty("again(1 msec): ", "u32"),
        min_delay_ns,
        min_spacing_ns,
        policy,
    };
    let timer = TriggerKind::Timer { instance: InstanceIndex(0), offset_ns: 0, period_ns: Some(10 * MS) };
    let delay = TriggerKind::Delay { source: PortIndex(1), fills: PortIndex(2), delay_ns: 5 * MS };
    let input = TriggerKind::NetworkInput { input: InputIndex(0), fills: PortIndex(4) };
    vec![
        trigger("startup", TriggerKind::Startup, 1, &[0]),
        trigger("shutdown", TriggerKind::Shutdown, 1, &[7]),
        trigger("unit.t", timer, 1, &[1]),
        trigger("unit.again", action(false, MS, None, SpacingPolicy::Defer), 4, &[3]),
        trigger("unit.button", action(true, 0, Some(MS), SpacingPolicy::Drop), 4, &[3]),
        trigger("unit.second.raw", delay, 2, &[]),
        trigger("unit.command", input, 3, &[]),
    ]
}

fn unit_federate() -> Federate {
    Federate {
        id: 0,
        name: "unit".to_owned(),
        at: at("  unit = "),
        host: None,
        instances: vec![
            instance("unit", 1, None, 0),
            instance("unit.first", 0, Some(0), 0),
            instance("unit.second", 0, Some(0), 1),
        ],
        ports: ports(&[
            ("unit.first.raw", "u32", &[2], &[]),
            ("unit.first.smooth", "u32", &[], &[5]),
            ("unit.second.raw", "u32", &[4], &[]),
            ("unit.second.smooth", "u32", &[5], &[]),
            ("unit.command", "Command", &[6], &[]),
        ]),
        triggers: unit_triggers(),
        reactions: unit_reactions(),
        outputs: vec![NetworkOutput {
            name: "unit.report -> other.report".to_owned(),
            source: PortIndex(3),
            federate: 1,
            port: 0,
            delay_ns: Some(20 * MS),
            ty: ty("input report: ", "u32"),
            at: at("unit.report "),
        }],
        inputs: vec![NetworkInput {
            name: "other.command -> unit.command".to_owned(),
            trigger: TriggerIndex(6),
            federate: 1,
            delay_ns: None,
            ty: ty("input command: ", "Command"),
            at: at("other.command "),
        }],
        upstream: vec![Upstream { federate: 1, delay_ns: None }],
        downstream: vec![1],
        physical_delay_ns: None,
    }
}

fn other_federate() -> Federate {
    let input = TriggerKind::NetworkInput { input: InputIndex(0), fills: PortIndex(0) };
    let arguments = vec![Argument::Port(PortIndex(0)), Argument::Port(PortIndex(1))];
    Federate {
        id: 1,
        name: "other".to_owned(),
        at: at("  other = "),
        host: Some("somewhere".to_owned()),
        instances: vec![instance("other", 2, None, 1)],
        ports: ports(&[("other.report", "u32", &[0], &[]), ("other.command", "Command", &[1], &[])]),
        triggers: vec![trigger("other.report", input, 8, &[])],
        reactions: vec![body("other.reaction_1", 0, 0, 1, arguments), send("other.command -> unit.command", 1)],
        outputs: vec![NetworkOutput {
            name: "other.command -> unit.command".to_owned(),
            source: PortIndex(1),
            federate: 0,
            port: 0,
            delay_ns: None,
            ty: ty("input command: ", "Command"),
            at: at("other.command "),
        }],
        inputs: vec![NetworkInput {
            name: "unit.report -> other.report".to_owned(),
            trigger: TriggerIndex(0),
            federate: 0,
            delay_ns: Some(20 * MS),
            ty: ty("input report: ", "u32"),
            at: at("unit.report "),
        }],
        upstream: vec![Upstream { federate: 0, delay_ns: Some(20 * MS) }],
        downstream: vec![0],
        physical_delay_ns: None,
    }
}

/// The plan of `everything.lf`.
pub(super) fn plan() -> Plan {
    Plan {
        name: "Everything".to_owned(),
        files: vec![SourceFile { path: "src/everything.lf".to_owned(), preambles: vec![code("preamble {=")] }],
        target: Target { timeout_ns: Some(1_000 * MS), logging: Logging::Debug, ..Target::default() },
        rti: Some(Rti { host: "10.0.0.1".to_owned(), port: 15055, federation_id: "Everything".to_owned() }),
        classes: vec![filter(), unit(), other(), everything()],
        main: ClassIndex(3),
        federates: vec![unit_federate(), other_federate()],
    }
}
