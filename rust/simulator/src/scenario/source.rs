// SPDX-License-Identifier: Apache-2.0
//! A scenario's program as LF source text.

use std::fmt::Write as _;

use super::{Action, End, Nanos, Reaction, Reactor, Scenario, Script, Ty, Variable};

/// The program as a federation, or, with `federated` false, as one main reactor.
pub(crate) fn source(scenario: &Scenario, federated: bool) -> String {
    let mut text = String::new();
    let target = &scenario.target;
    let waits = federated && scenario.decentralized.is_some();
    let clock_sync = match target.clock_sync {
        Some(trials) if let Some(ns) = target.rounds => {
            format!("clock-sync: on,\n  clock-sync-options: {{trials: {trials}, period: {ns} nsec}}")
        }
        Some(trials) => format!("clock-sync: init,\n  clock-sync-options: {{trials: {trials}}}"),
        None => "clock-sync: off".to_owned(),
    };
    let timeout = target.timeout.map_or(String::new(), |ns| format!("timeout: {ns} nsec,\n  "));
    let advance = target
        .advance
        .map_or(String::new(), |ns| format!("coordination-options: {{advance-message-interval: {ns} nsec}},\n  "));
    let coordination = if scenario.decentralized.is_some() { "decentralized" } else { "centralized" };
    let _ = writeln!(
        text,
        "target Rust {{\n  coordination: {coordination},\n  {timeout}{advance}fast: {},\n  keepalive: {},\n  \
         auth: {},\n  {clock_sync}\n}}",
        target.fast, target.keepalive, target.auth
    );
    for (index, reactor) in scenario.federates.iter().enumerate() {
        class(&mut text, &format!("F{index}"), reactor, waits);
    }
    let _ = writeln!(text, "\n{} reactor {{", if federated { "federated" } else { "main" });
    for (index, reactor) in scenario.federates.iter().enumerate() {
        wait(&mut text, "maxwait", reactor.max_wait.filter(|_| waits));
        let _ = writeln!(text, "  f{index} = new F{index}()");
    }
    for connection in &scenario.connections {
        let ((from, output), (to, input)) = (connection.from, connection.to);
        wait(&mut text, "maxwait", connection.max_wait.filter(|_| waits));
        wait(&mut text, "absent_after", connection.absent_after.filter(|_| waits));
        // Without the network, the queue of a connection with `after` has to hold all that is on its way, and a
        // connection without has none.
        let capacity = match (federated, connection.capacity) {
            (true, capacity) => capacity,
            (false, _) => connection.after.map(|_| 256),
        };
        link(&mut text, capacity, &format!("f{from}.out{output} -> f{to}.in{input}"), connection.after);
    }
    text.push_str("}\n");
    text
}

/// An attribute with a time, before what it is about.
fn wait(text: &mut String, name: &str, time: Option<Nanos>) {
    if let Some(ns) = time {
        let _ = writeln!(text, "  @{name}({ns} nsec)");
    }
}

fn class(text: &mut String, name: &str, reactor: &Reactor, waits: bool) {
    for (index, child) in reactor.children.iter().enumerate() {
        class(text, &format!("{name}C{index}"), child, waits);
    }
    let _ = writeln!(text, "\nreactor {name} {{");
    for (index, ty) in reactor.inputs.iter().enumerate() {
        let _ = writeln!(text, "  input in{index}: {}", type_name(*ty));
    }
    for (index, ty) in reactor.outputs.iter().enumerate() {
        let _ = writeln!(text, "  output out{index}: {}", type_name(*ty));
    }
    for (index, timer) in reactor.timers.iter().enumerate() {
        let period = timer.period.map_or(String::new(), |ns| format!(", {ns} nsec"));
        let _ = writeln!(text, "  timer t{index}({} nsec{period})", timer.offset);
    }
    for (index, declared) in reactor.actions.iter().enumerate() {
        action(text, index, declared);
    }
    for index in 0..reactor.children.len() {
        let _ = writeln!(text, "  c{index} = new {name}C{index}()");
    }
    for connection in &reactor.links {
        let from = match connection.from {
            End::Own(port) => format!("in{port}"),
            End::Child(child, port) => format!("c{child}.out{port}"),
        };
        let to = match connection.to {
            End::Own(port) => format!("out{port}"),
            End::Child(child, port) => format!("c{child}.in{port}"),
        };
        let capacity = connection.after.map(|_| connection.capacity);
        link(text, capacity, &format!("{from} -> {to}"), connection.after);
    }
    for declared in &reactor.reactions {
        reaction(text, declared, waits);
    }
    text.push_str("}\n");
}

fn action(text: &mut String, index: usize, action: &Action) {
    let kind = if action.physical { "physical" } else { "logical" };
    let spacing = match action.min_spacing {
        Some((ns, policy)) => format!(", {ns} nsec, \"{policy}\""),
        None => String::new(),
    };
    let _ = writeln!(text, "  @capacity({})", action.capacity);
    let outside =
        if action.outside.is_empty() { String::new() } else { format!("  // from outside {:?}", action.outside) };
    let _ = writeln!(text, "  {kind} action a{index}({} nsec{spacing}): u64{outside}", action.min_delay);
}

fn link(text: &mut String, capacity: Option<usize>, ends: &str, after: Option<i64>) {
    if let Some(capacity) = capacity {
        let _ = writeln!(text, "  @capacity({capacity})");
    }
    let after = after.map_or(String::new(), |ns| format!(" after {ns} nsec"));
    let _ = writeln!(text, "  {ends}{after}");
}

fn reaction(text: &mut String, reaction: &Reaction, waits: bool) {
    let list = |variables: &[Variable]| variables.iter().map(|one| variable(*one)).collect::<Vec<_>>().join(", ");
    let uses = if reaction.uses.is_empty() { String::new() } else { format!(" {}", list(&reaction.uses)) };
    let effects = if reaction.effects.is_empty() { String::new() } else { format!(" -> {}", list(&reaction.effects)) };
    let tardy = if reaction.tardy && waits { " tardy {= =}" } else { "" };
    let (triggers, body) = (list(&reaction.triggers), words(&reaction.script));
    let _ = writeln!(text, "  reaction({triggers}){uses}{effects} {{= \"{body}\" =}}{tardy}");
}

fn variable(variable: Variable) -> String {
    match variable {
        Variable::Startup => "startup".to_owned(),
        Variable::Shutdown => "shutdown".to_owned(),
        Variable::Timer(index) => format!("t{index}"),
        Variable::Action(index) => format!("a{index}"),
        Variable::Input(index) => format!("in{index}"),
        Variable::Output(index) => format!("out{index}"),
        Variable::ChildInput(child, index) => format!("c{child}.in{index}"),
        Variable::ChildOutput(child, index) => format!("c{child}.out{index}"),
    }
}

pub(super) fn type_name(ty: Ty) -> &'static str {
    match ty {
        Ty::Small => "u64",
        Ty::Large => "{= [u64; 32] =}",
        Ty::Varying => "{= heapless::Vec<u64, 40> =}",
    }
}

/// The script, as [`Script::parse`] reads it.
fn words(script: &Script) -> String {
    let mut text = format!("percent {} energy {}", script.percent, script.energy);
    let mut add = |name: &str, value: i64| {
        if value > 0 {
            let _ = write!(text, " {name} {value}");
        }
    };
    add("work", script.work_ns);
    add("offset", script.offset_ns);
    add("stop", script.stop_at.and_then(|count| i64::try_from(count).ok()).unwrap_or(0));
    add("stop-offset", script.stop_offset_ns);
    text
}

impl Script {
    /// Reads the body of a reaction: a text of pairs of a word and a number.
    pub(crate) fn parse(body: &str) -> Self {
        let mut script = Self::default();
        let mut words = body.trim().trim_matches('"').split_whitespace();
        while let (Some(word), Some(number)) = (words.next(), words.next().and_then(|text| text.parse::<u64>().ok())) {
            let time = i64::try_from(number).unwrap_or(i64::MAX);
            match word {
                "percent" => script.percent = number,
                "energy" => script.energy = number,
                "work" => script.work_ns = time,
                "offset" => script.offset_ns = time,
                "stop" => script.stop_at = Some(number),
                "stop-offset" => script.stop_offset_ns = time,
                _ => {}
            }
        }
        script
    }
}
