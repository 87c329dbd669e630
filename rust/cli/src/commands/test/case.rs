// SPDX-License-Identifier: Apache-2.0
//! Tests of a reactor that a file describes: a program for each, which sets the inputs at their times, schedules the
//! physical actions, and compares the outputs.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use lf_compiler::parse;
use lf_compiler::syntax::ast::{ActionKind, Direction, Reactor, TypeSyntax};
use serde::Deserialize;

use crate::compile::read_text;
use crate::failure::Failure;
use crate::time;

/// A file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    /// The reactor.
    reactor: String,
    /// The file that has it, from the folder of this file.
    file: String,
    cases: Vec<Case>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    name: String,
    #[serde(default)]
    parameters: BTreeMap<String, Scalar>,
    #[serde(default)]
    inputs: Vec<BTreeMap<String, Entry>>,
    #[serde(default)]
    outputs: Vec<BTreeMap<String, Entry>>,
    /// The time of the end; without it, the last time that the case names.
    until: Option<String>,
}

/// A value of a port or a physical action, or a tag.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Entry {
    One(Scalar),
    Tag(String, u32),
    /// The event of a physical action without values.
    Pure(()),
}

/// A value as the target language writes it; a text is code.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Scalar {
    Bool(bool),
    Int(i64),
    Float(f64),
    Code(String),
}

impl Scalar {
    fn code(&self) -> String {
        match self {
            Self::Bool(value) => value.to_string(),
            Self::Int(value) => value.to_string(),
            Self::Float(value) => format!("{value:?}"),
            Self::Code(code) => code.clone(),
        }
    }
}

/// The tag at which a port has a value: nanoseconds after the start, and microsteps.
type At = (u64, u32);

/// The values of each port or action, in order; an empty one is an event without a value.
type Events = BTreeMap<String, Vec<(At, String)>>;

/// Returns the programs of a file's cases, with the names of these. As images they do not wait for physical time;
/// programs of this computer are to run in virtual time.
pub(super) fn programs(
    name: &str,
    text: &str,
    folder: &Path,
    is_image: bool,
) -> Result<Vec<(String, String)>, Failure> {
    let description: Description = serde_saphyr::from_str(text).map_err(|error| {
        let place = error.location().map_or_else(String::new, |at| format!(":{}:{}", at.line(), at.column()));
        let message = error.without_snippet().to_string();
        Failure::message(format!("{name}{place}: {}", message.split(" at line ").next().unwrap_or(&message)))
    })?;
    let file = folder.join(&description.file);
    let shown = file.display();
    let code =
        read_text(&file).map_err(|error| Failure::message(format!("{name}: {shown} cannot be read: {error}")))?;
    let unit = parse(&description.file, &code).unit;
    let target = unit.target.map_or_else(|| "Rust".to_owned(), |target| target.name.text);
    let is_it = |reactor: &&Reactor| reactor.name.as_ref().is_some_and(|name| name.text == description.reactor);
    let tested = unit.reactors.iter().find(is_it).map(|reactor| Tested::of(reactor, &code)).ok_or_else(|| {
        let others = unit.reactors.iter().filter_map(|reactor| reactor.name.as_ref());
        let others = listed(others.map(|other| other.text.as_str()));
        Failure::message(format!("{name}: {shown} has no reactor `{}`; it has {others}", description.reactor))
    })?;
    let import = std::path::absolute(&file)?;
    let head = format!(
        "target {target} {{ {}timeout: UNTIL }}\nimport {} from \"{}\"\n",
        if is_image { "fast: true, " } else { "" },
        description.reactor,
        import.display()
    );
    let language = if target.eq_ignore_ascii_case("Rust") { BodyLanguage::Rust } else { BodyLanguage::C };
    let program = |case: &Case| {
        let wrong = |error: String| Failure::message(format!("{name}: {}: {error}", case.name));
        let (mut inputs, outputs) = (events(&case.inputs).map_err(wrong)?, events(&case.outputs).map_err(wrong)?);
        let last = inputs.values().chain(outputs.values()).flatten().map(|((time, _), _)| *time).max().unwrap_or(0);
        let until = case.until.as_ref().map_or(Ok(last), |until| time_of(until));
        let until = until.map_err(|error| wrong(format!("until: {error}")))?;
        let actions = tested.take_actions(&mut inputs);
        tested.check(&inputs, &outputs, &actions).map_err(wrong)?;
        let body = language.body(&tested, case, [&inputs, &actions, &outputs]);
        // The last time counts with all its microsteps.
        Ok((case.name.clone(), head.replace("UNTIL", &format!("{} ns", until.saturating_add(1))) + &body))
    };
    description.cases.iter().map(program).collect()
}

/// The reactor of a file, as far as its tests have to know it.
struct Tested {
    name: String,
    inputs: Vec<String>,
    outputs: Vec<String>,
    /// Its physical actions with their types as the file writes them, if they have values.
    actions: BTreeMap<String, Option<String>>,
    /// Whether it inherits ports and actions of others, which this file need not have.
    inherits: bool,
}

impl Tested {
    fn of(reactor: &Reactor, code: &str) -> Self {
        let ports = |direction| {
            let ports = reactor.body.ports.iter().filter(move |port| port.direction == direction);
            ports.map(|port| port.name.text.clone()).collect()
        };
        let physical = reactor.body.actions.iter().filter(|action| action.kind == ActionKind::Physical);
        let text = |ty: &TypeSyntax| code.get(ty.span.start..ty.span.end).unwrap_or_default().to_owned();
        Self {
            name: reactor.name.as_ref().map_or_else(String::new, |name| name.text.clone()),
            inputs: ports(Direction::Input),
            outputs: ports(Direction::Output),
            actions: physical.map(|action| (action.name.text.clone(), action.ty.as_ref().map(text))).collect(),
            inherits: !reactor.extends.is_empty(),
        }
    }

    /// Takes the events of physical actions out of those of inputs.
    fn take_actions(&self, inputs: &mut Events) -> Events {
        let names = self.actions.keys();
        names.filter_map(|name| inputs.remove(name).map(|events| (name.clone(), events))).collect()
    }

    /// Refuses names that the reactor does not have, and values where there are none.
    fn check(&self, inputs: &Events, outputs: &Events, actions: &Events) -> Result<(), String> {
        let name = &self.name;
        for (events, known, kind) in [(inputs, &self.inputs, "input"), (outputs, &self.outputs, "output")] {
            for (port, values) in events {
                if !self.inherits && !known.contains(port) {
                    let more = self.actions.keys().filter(|_| kind == "input");
                    let names = listed(known.iter().chain(more).map(String::as_str));
                    return Err(format!("`{name}` has no {kind} `{port}`; it has {names}"));
                }
                if values.iter().any(|(_, value)| value.is_empty()) {
                    return Err(format!("`{port}` has no value"));
                }
            }
        }
        for (action, events) in actions {
            let has_type = self.actions.get(action).is_some_and(Option::is_some);
            if let Some((_, value)) = events.iter().find(|(_, value)| value.is_empty() == has_type) {
                return Err(if value.is_empty() {
                    format!("the physical action `{action}` needs a value")
                } else {
                    format!("the physical action `{action}` has no values: write `{action}:`, with nothing behind it")
                });
            }
        }
        Ok(())
    }
}

/// Returns names as a list for a sentence.
fn listed<'n>(names: impl Iterator<Item = &'n str>) -> String {
    let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Returns the values by port; `at` is their tag.
fn events(list: &[BTreeMap<String, Entry>]) -> Result<Events, String> {
    let mut events = Events::new();
    for entry in list {
        let at = match entry.get("at") {
            Some(Entry::One(Scalar::Code(text))) => (time_of(text)?, 0),
            Some(Entry::One(Scalar::Int(0))) => (0, 0),
            Some(Entry::Tag(text, microstep)) => (time_of(text)?, *microstep),
            _ => return Err("each entry has an `at`: `10 ms`, or `[10 ms, 1]` with a microstep".to_owned()),
        };
        for (port, value) in entry.iter().filter(|(port, _)| *port != "at") {
            let value = match value {
                Entry::One(value) => value.code(),
                Entry::Pure(()) => String::new(),
                Entry::Tag(..) => return Err(format!("`{port}` is no tag, but gets a value")),
            };
            events.entry(port.clone()).or_default().push((at, value));
        }
    }
    for values in events.values_mut() {
        values.sort_by_key(|(at, _)| *at);
    }
    Ok(events)
}

fn time_of(text: &str) -> Result<u64, String> {
    let time = time::parse(text)?;
    u64::try_from(time.as_nanos()).map_err(|_| format!("`{text}` is too long"))
}

/// The language of the program.
#[derive(Clone, Copy)]
enum BodyLanguage {
    Rust,
    C,
}

impl BodyLanguage {
    /// Returns the main reactor, and one that is derived from the tested one where actions are scheduled.
    fn body(self, tested: &Tested, case: &Case, [inputs, actions, outputs]: [&Events; 3]) -> String {
        let given: Vec<_> =
            case.parameters.iter().map(|(name, value)| format!("{name} = {{= {} =}}", value.code())).collect();
        let mut text = String::new();
        // Writing to a String cannot fail.
        let mut class = tested.name.as_str();
        if !actions.is_empty() {
            class = "Scheduled";
            let _ = writeln!(text, "reactor Scheduled extends {} {{", tested.name);
            for (number, (action, (at, value))) in each(actions).enumerate() {
                let code = self.schedule(action, tested.actions.get(action).and_then(Option::as_deref), value);
                let timer = format!("scheduled_at_{number}");
                let _ = writeln!(text, "  timer {timer}({} ns)\n  reaction({timer}) -> {action} {{= {code} =}}", at.0);
            }
            text.push_str("}\n");
        }
        let _ = writeln!(text, "main reactor {{\n  tested = new {class}({})", given.join(", "));
        for (number, (port, (at, value))) in each(inputs).enumerate() {
            let set = match self {
                Self::Rust => format!("ctx.set(tested__{port}, {value});"),
                Self::C => format!("lf_set(tested.{port}, {value});"),
            };
            let _ = writeln!(
                text,
                "  timer at_{number}({} ns)\n  reaction(at_{number}) -> tested.{port} {{= {set} =}}",
                at.0
            );
        }
        for (port, values) in outputs {
            let _ = match self {
                Self::Rust => rust_output(&mut text, port, values),
                Self::C => c_output(&mut text, port, values),
            };
        }
        text + "}\n"
    }

    /// Returns code that schedules a physical action now.
    fn schedule(self, action: &str, ty: Option<&str>, value: &str) -> String {
        match (self, ty) {
            (Self::Rust, None) => format!("ctx.schedule_physical(&{action}, Asap).expect(\"there is room\");"),
            (Self::Rust, Some(_)) => {
                format!("ctx.schedule_physical_with_v(&{action}, Some({value}), Asap).expect(\"there is room\");")
            }
            (Self::C, None) => format!("lf_schedule({action}, 0);"),
            (Self::C, Some(ty)) => format!("{ty} value = {value}; lf_schedule_copy({action}, 0, &value, 1);"),
        }
    }
}

/// Returns all events of all ports or actions.
fn each(events: &Events) -> impl Iterator<Item = (&String, &(At, String))> {
    events.iter().flat_map(|(name, values)| values.iter().map(move |value| (name, value)))
}

fn rust_output(text: &mut String, port: &str, values: &[(At, String)]) -> std::fmt::Result {
    writeln!(text, "  state {port}_seen: usize = 0\n  reaction(tested.{port}) {{=")?;
    writeln!(text, "    let tag = ctx.get_tag();")?;
    writeln!(text, "    let at = (tag.offset_from_t0.as_nanos(), tag.microstep);")?;
    writeln!(text, "    let value = ctx.get_ref(tested__{port}).expect(\"it has triggered this\");")?;
    writeln!(text, "    self.{port}_seen += 1;\n    match self.{port}_seen {{")?;
    for (number, ((time, microstep), value)) in values.iter().enumerate() {
        let expected = number + 1;
        writeln!(
            text,
            "      {expected} => assert!(at == ({time}, {microstep}) && *value == ({value}), \
             \"{port} is {{value:?}} at {{at:?}}, instead of {{:?}} at ({time}, {microstep})\", {value}),"
        )?;
    }
    writeln!(
        text,
        "      _ => panic!(\"{port} is {{value:?}} at {{at:?}}, where it should be absent\"),\n    }}\n  =}}"
    )?;
    writeln!(text, "  reaction(shutdown) {{=")?;
    writeln!(text, "    assert_eq!(self.{port}_seen, {}, \"the number of values of {port}\");\n  =}}", values.len())
}

fn c_output(text: &mut String, port: &str, values: &[(At, String)]) -> std::fmt::Result {
    writeln!(text, "  state {port}_seen: int = 0\n  reaction(tested.{port}) {{=")?;
    writeln!(text, "    long long time = lf_time_logical_elapsed();\n    unsigned microstep = lf_tag().microstep;")?;
    writeln!(text, "    switch (++self->{port}_seen) {{")?;
    for (number, ((time, microstep), value)) in values.iter().enumerate() {
        let expected = number + 1;
        writeln!(
            text,
            "    case {expected}:\n      LF_TEST(time == {time} && microstep == {microstep} && \
             tested.{port}->value == ({value}), \
             \"{port} at (%lld, %u) should be %s at ({time}, {microstep})\", time, microstep, {value:?});\n      break;"
        )?;
    }
    writeln!(text, "    default:")?;
    writeln!(
        text,
        "      lf_print_error_and_exit(\"{port} is present at (%lld, %u), where it should be absent\", time, \
         microstep);"
    )?;
    writeln!(text, "    }}\n  =}}\n  reaction(shutdown) {{=")?;
    let count = values.len();
    writeln!(
        text,
        "    LF_TEST(self->{port}_seen == {count}, \"{port} had %d values instead of {count}\",\n            \
         self->{port}_seen);\n  =}}"
    )
}
