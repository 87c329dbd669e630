// SPDX-License-Identifier: Apache-2.0
//! Tests of a reactor that a file describes: a program for each, which sets the inputs at their times and compares the
//! outputs.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use lf_compiler::parse;
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

/// A value of a port, or a tag.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Entry {
    One(Scalar),
    Tag(String, u32),
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

/// The values of each port, in order.
type Events = BTreeMap<String, Vec<(At, String)>>;

/// Returns the programs of a file's cases, with the names of these.
pub(super) fn programs(name: &str, text: &str, folder: &Path) -> Result<Vec<(String, String)>, Failure> {
    let description: Description = serde_saphyr::from_str(text).map_err(|error| {
        let place = error.location().map_or_else(String::new, |at| format!(":{}:{}", at.line(), at.column()));
        let message = error.without_snippet().to_string();
        Failure::message(format!("{name}{place}: {}", message.split(" at line ").next().unwrap_or(&message)))
    })?;
    let file = folder.join(&description.file);
    let shown = file.display();
    let code =
        read_text(&file).map_err(|error| Failure::message(format!("{name}: {shown} cannot be read: {error}")))?;
    let target =
        parse(&description.file, &code).unit.target.map_or_else(|| "Rust".to_owned(), |target| target.name.text);
    let import = std::path::absolute(&file)?;
    let head = format!(
        "target {target} {{ fast: true, timeout: UNTIL }}\nimport {} from \"{}\"\n",
        description.reactor,
        import.display()
    );
    let is_rust = target.eq_ignore_ascii_case("Rust");
    let program = |case: &Case| {
        let events = |list| events(list).map_err(|error| Failure::message(format!("{name}: {}: {error}", case.name)));
        let (inputs, outputs) = (events(&case.inputs)?, events(&case.outputs)?);
        let last = inputs.values().chain(outputs.values()).flatten().map(|((time, _), _)| *time).max().unwrap_or(0);
        let until = case.until.as_ref().map_or(Ok(last), |until| time_of(until));
        let until = until.map_err(|error| Failure::message(format!("{name}: {}: until: {error}", case.name)))?;
        let body = if is_rust { BodyLanguage::Rust } else { BodyLanguage::C }.body(
            &description.reactor,
            case,
            &inputs,
            &outputs,
        );
        // The last time counts with all its microsteps.
        Ok((case.name.clone(), head.replace("UNTIL", &format!("{} ns", until.saturating_add(1))) + &body))
    };
    description.cases.iter().map(program).collect()
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
            let Entry::One(value) = value else { return Err(format!("`{port}` has no value")) };
            events.entry(port.clone()).or_default().push((at, value.code()));
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
    /// Returns the main reactor.
    fn body(self, reactor: &str, case: &Case, inputs: &Events, outputs: &Events) -> String {
        let given: Vec<_> =
            case.parameters.iter().map(|(name, value)| format!("{name} = {{= {} =}}", value.code())).collect();
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "main reactor {{\n  tested = new {reactor}({})", given.join(", "));
        for (number, (port, (at, value))) in
            inputs.iter().flat_map(|(port, values)| values.iter().map(move |value| (port, value))).enumerate()
        {
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
