// SPDX-License-Identifier: Apache-2.0
//! A scenario's program as LF source text.

use std::fmt::Write as _;

use super::ports::{Ports, port_of};
use super::{Action, Connection, Link, LinkEnd, Nanos, Reaction, Reactor, Scenario, Script, Ty, Variable, Watchdog};

/// The form of a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Form {
    /// A federation.
    Federated,
    /// One main reactor with all federates.
    Alone,
    /// One main reactor with the persistent federates. *Players* replay what the transient ones have sent to them.
    Persistent,
    /// One main reactor with this federate, and players for what all others have sent to it.
    Only(usize),
}

impl Form {
    /// Returns whether a federate is in the program with all its contents.
    fn has(self, scenario: &Scenario, federate: usize) -> bool {
        match self {
            Self::Federated | Self::Alone => true,
            Self::Persistent => !scenario.federates[federate].transient,
            Self::Only(one) => federate == one,
        }
    }
}

/// The capacity of a connection with `after` without the network, which has to hold all messages in transit.
const IN_TRANSIT: usize = 256;

/// Returns the name of the instance that replays the messages of a connection.
pub(crate) fn player(connection: usize) -> String {
    format!("player{connection}")
}

/// Returns the program in this form.
pub(crate) fn source(scenario: &Scenario, form: Form) -> String {
    let mut text = String::new();
    let target = &scenario.target;
    let federated = form == Form::Federated;
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
    let ports = scenario.ports();
    let statements = statements(scenario, form, &ports);
    classes(&mut text, scenario, form, &ports, waits);
    for relay in statements.iter().flat_map(|statement| &statement.relays) {
        relay.class(&mut text);
    }
    let _ = writeln!(text, "\n{} reactor {{", if federated { "federated" } else { "main" });
    for (index, reactor) in scenario.federates.iter().enumerate() {
        wait(&mut text, "maxwait", reactor.max_wait.filter(|_| waits));
        if federated && reactor.transient {
            text.push_str("  @transient\n");
        }
        let _ = writeln!(text, "  f{index} = new F{index}()");
    }
    for (index, connection) in scenario.connections.iter().enumerate() {
        if !form.has(scenario, connection.from.0) {
            let _ = writeln!(text, "  {0} = new Player{index}()", player(index));
        }
    }
    for Statement { members, sources, destinations, relays } in statements {
        for relay in &relays {
            relay.instance(&mut text);
        }
        let connection = &scenario.connections[members[0]];
        wait(&mut text, "maxwait", connection.max_wait.filter(|_| waits));
        wait(&mut text, "absent_after", connection.absent_after.filter(|_| waits));
        // Players and relays send at the tags at which messages happen.
        let after = connection.after.filter(|_| form.has(scenario, connection.from.0) && relays.is_empty());
        let capacity = if federated { connection.capacity } else { after.map(|_| IN_TRANSIT) };
        link(&mut text, capacity, &format!("{sources} -> {destinations}"), after);
    }
    text.push_str("}\n");
    text
}

/// Writes the reactors of all federates, and the players.
fn classes(text: &mut String, scenario: &Scenario, form: Form, ports: &[Ports], waits: bool) {
    for (index, (reactor, ports)) in scenario.federates.iter().zip(ports).enumerate() {
        if form.has(scenario, index) {
            class(text, &format!("F{index}"), reactor, ports, waits);
        } else {
            let deaf = Reactor { inputs: reactor.inputs.clone(), ..Reactor::default() };
            let ports = Ports { inputs: ports.inputs.clone(), outputs: Vec::new() };
            class(text, &format!("F{index}"), &deaf, &ports, waits);
        }
    }
    for (index, connection) in scenario.connections.iter().enumerate() {
        if !form.has(scenario, connection.from.0) {
            player_class(text, index, scenario.federates[connection.from.0].outputs[connection.from.1]);
        }
    }
}

/// A statement that connects federates.
struct Statement {
    /// The connections.
    members: Vec<usize>,
    sources: String,
    destinations: String,
    relays: Vec<Relay>,
}

/// A reactor that delays what a federate sends, in a statement whose other messages are replayed without a delay.
struct Relay {
    /// The first of its connections.
    index: usize,
    source: String,
    width: usize,
    ty: Ty,
    after: Nanos,
}

impl Relay {
    fn class(&self, text: &mut String) {
        let Self { index, width, after, .. } = self;
        let (ty, width) = (type_name(self.ty), if *width > 1 { format!("[{width}]") } else { String::new() });
        let _ = writeln!(text, "\nreactor Relay{index} {{\n  input{width} in: {ty}\n  output{width} out: {ty}");
        link(text, Some(IN_TRANSIT), "in -> out", Some(*after));
        text.push_str("}\n");
    }

    fn instance(&self, text: &mut String) {
        let Self { index, source, .. } = self;
        let _ = writeln!(text, "  relay{index} = new Relay{index}()\n  {source} -> relay{index}.in");
    }
}

/// Returns the statements that concern a federate of the program.
fn statements(scenario: &Scenario, form: Form, ports: &[Ports]) -> Vec<Statement> {
    let mut statements: Vec<Statement> = Vec::new();
    let concerns = |one: &usize| {
        let Connection { from, to, .. } = &scenario.connections[*one];
        form.has(scenario, from.0) || form.has(scenario, to.0)
    };
    let mut done = vec![false; scenario.connections.len()];
    for index in 0..scenario.connections.len() {
        if done[index] {
            continue;
        }
        let statement = statement(scenario, form, ports, index);
        for member in &statement.members {
            done[*member] = true;
        }
        if statement.members.iter().any(concerns) {
            statements.push(statement);
        }
    }
    statements
}

/// Returns the statement with this connection.
fn statement(scenario: &Scenario, form: Form, ports: &[Ports], index: usize) -> Statement {
    let connection = &scenario.connections[index];
    let port = |ports: &[(usize, usize)], channel: usize| port_of(ports, channel);
    let ((from, output), (to, input)) = (connection.from, connection.to);
    let (source, destination) = (port(&ports[from].outputs, output), port(&ports[to].inputs, input));
    let channels = |(first, width): (usize, usize)| first..first + width;
    let all = || scenario.connections.iter().enumerate();
    let mut members: Vec<(usize, &Connection)> = if destination.1 > 1 {
        all().filter(|(_, one)| one.to.0 == to && channels(destination).contains(&one.to.1)).collect()
    } else if !form.has(scenario, from) {
        vec![(index, connection)]
    } else if source.1 > 1 {
        all().filter(|(_, one)| one.from.0 == from && channels(source).contains(&one.from.1)).collect()
    } else {
        all().filter(|(_, one)| one.to == connection.to).collect()
    };
    members.sort_by_key(|(_, one)| if destination.1 > 1 { one.to.1 } else { one.from.1 });
    let is_replayed = |(_, one): &(usize, &Connection)| !form.has(scenario, one.from.0);
    let is_mixed = members.iter().any(is_replayed) && !members.iter().all(is_replayed);
    let (mut relays, mut sources) = (Vec::<Relay>::new(), Vec::new());
    for member in &members {
        let (index, Connection { from: (federate, channel), after, .. }) = *member;
        if is_replayed(member) {
            sources.push(format!("{}.out", player(index)));
            continue;
        }
        let (first, width) = port(&ports[*federate].outputs, *channel);
        let source = format!("f{federate}.out{first}");
        match after.filter(|_| is_mixed) {
            // The channels of one port stand together.
            _ if *channel > first => {}
            None => sources.push(source),
            Some(after) => {
                let ty = scenario.federates[*federate].outputs[first];
                sources.push(format!("relay{index}.out"));
                relays.push(Relay { index, source, width, ty, after });
            }
        }
    }
    let destinations = members.iter().filter_map(|(_, Connection { to: (federate, channel), .. })| {
        let (first, _) = port(&ports[*federate].inputs, *channel);
        (*channel == first).then(|| format!("f{federate}.in{first}"))
    });
    let destinations = destinations.collect::<Vec<_>>().join(", ");
    let sources = sources.join(", ");
    Statement { members: members.iter().map(|(index, _)| *index).collect(), sources, destinations, relays }
}

/// Writes an attribute with a time, before its subject.
fn wait(text: &mut String, name: &str, time: Option<Nanos>) {
    if let Some(ns) = time {
        let _ = writeln!(text, "  @{name}({ns} nsec)");
    }
}

fn class(text: &mut String, name: &str, reactor: &Reactor, ports: &Ports, waits: bool) {
    let children: Vec<_> = (0..reactor.children.len()).map(|child| reactor.child_ports(child)).collect();
    for (index, (child, ports)) in reactor.children.iter().zip(&children).enumerate() {
        class(text, &format!("{name}C{index}"), child, ports, waits);
    }
    let _ = writeln!(text, "\nreactor {name} {{");
    for (direction, of, types) in [("in", &ports.inputs, &reactor.inputs), ("out", &ports.outputs, &reactor.outputs)] {
        for (first, width) in of {
            let width = if *width > 1 { format!("[{width}]") } else { String::new() };
            let _ = writeln!(text, "  {direction}put{width} {direction}{first}: {}", type_name(types[*first]));
        }
    }
    if reactor.hands_over {
        text.push_str("  @handed_over\n  state memory: u64 = 0\n");
    }
    let names = Names { reactor, name, ports, children: &children, waits };
    names.members(text, None);
    // The reactions to outputs of contained reactors come last: it is no loop if others set the inputs of these
    // reactors.
    names.reactions(text, None, false);
    for mode in 0..reactor.modes {
        let _ = writeln!(text, "  {}mode M{mode} {{", if mode == 0 { "initial " } else { "" });
        names.members(text, Some(mode));
        names.reactions(text, Some(mode), false);
        names.reactions(text, Some(mode), true);
        text.push_str("  }\n");
    }
    names.reactions(text, None, true);
    text.push_str("}\n");
}

/// Writes a reactor that sends the values of a physical action, whose events are known in advance.
fn player_class(text: &mut String, connection: usize, ty: Ty) {
    let (ty, body) = (type_name(ty), words(&Script { plays: true, ..Script::default() }));
    let _ = writeln!(
        text,
        "\nreactor Player{connection} {{\n  output out: {ty}\n  physical action a: {ty}\n  \
         reaction(a) -> out {{= \"{body}\" =}}\n}}"
    );
}

/// A reactor with the names of its contents.
struct Names<'a> {
    reactor: &'a Reactor,
    name: &'a str,
    ports: &'a Ports,
    children: &'a [Ports],
    waits: bool,
}

impl Names<'_> {
    /// Writes the reactions in a mode, or in none, that read outputs of contained reactors, or those that do not.
    fn reactions(&self, text: &mut String, mode: Option<usize>, read_children: bool) {
        let reads = |one: &Variable| matches!(one, Variable::ChildOutput(..));
        for declared in self.reactor.reactions.iter().filter(|it| it.mode == mode) {
            if declared.triggers.iter().any(reads) == read_children {
                self.reaction(text, declared);
            }
        }
    }

    /// Writes the contents of a mode, or of none, except for reactions.
    fn members(&self, text: &mut String, mode: Option<usize>) {
        let reactor = self.reactor;
        for (index, timer) in reactor.timers.iter().enumerate().filter(|(_, it)| it.mode == mode) {
            let period = timer.period.map_or(String::new(), |ns| format!(", {ns} nsec"));
            let _ = writeln!(text, "  timer t{index}({} nsec{period})", timer.offset);
        }
        for (index, declared) in reactor.actions.iter().enumerate().filter(|(_, it)| it.mode == mode) {
            action(text, index, declared);
        }
        for (index, Watchdog { timeout, handler }) in
            reactor.watchdogs.iter().enumerate().filter(|(_, it)| it.handler.mode == mode)
        {
            let (effects, body) = (self.effects(handler), words(&handler.script));
            let _ = writeln!(text, "  watchdog w{index}({timeout} nsec){effects} {{= \"{body}\" =}}");
        }
        for (index, child) in reactor.children.iter().enumerate().filter(|(_, it)| it.mode == mode) {
            let bank = child.bank.map_or(String::new(), |width| format!("[{width}]"));
            let _ = writeln!(text, "  c{index} = new{bank} {}C{index}()", self.name);
        }
        for connection in reactor.links.iter().filter(|it| it.mode == mode) {
            self.link(text, connection);
        }
    }

    /// Writes a connection, with those to the other channels of its destination.
    fn link(&self, text: &mut String, connection: &Link) {
        let from = |end: LinkEnd| match end {
            LinkEnd::Own(port) => format!("in{port}"),
            LinkEnd::Child(child, port) => format!("c{child}.out{port}"),
        };
        let capacity = connection.after.map(|_| connection.capacity);
        let ends = match connection.to {
            LinkEnd::Own(port) => format!("{} -> out{port}", from(connection.from)),
            LinkEnd::Child(child, port) => {
                let (first, width) = port_of(&self.children[child].inputs, port);
                if port > first {
                    return;
                }
                let into = |input: usize| self.reactor.links.iter().find(|it| it.to == LinkEnd::Child(child, input));
                let sources: Vec<_> = (first..first + width).filter_map(into).map(|link| from(link.from)).collect();
                let sources = sources.join(", ");
                let is_bank = self.reactor.children[child].bank.is_some();
                let sources = if is_bank { format!("({sources})+") } else { sources };
                format!("{sources} -> c{child}.in{first}")
            }
        };
        link(text, capacity, &ends, connection.after);
    }

    fn reaction(&self, text: &mut String, reaction: &Reaction) {
        let uses = if reaction.uses.is_empty() { String::new() } else { format!(" {}", self.list(&reaction.uses)) };
        let tardy = if reaction.tardy && self.waits { " tardy {= =}" } else { "" };
        let (triggers, effects, body) =
            (self.list(&reaction.triggers), self.effects(reaction), words(&reaction.script));
        let _ = writeln!(text, "  reaction({triggers}){uses}{effects} {{= \"{body}\" =}}{tardy}");
    }

    fn effects(&self, reaction: &Reaction) -> String {
        if reaction.effects.is_empty() { String::new() } else { format!(" -> {}", self.list(&reaction.effects)) }
    }

    /// Returns a list of names. It names the channels of one port once, and a mode as well.
    fn list(&self, variables: &[Variable]) -> String {
        let mut names: Vec<String> = Vec::new();
        for name in variables.iter().map(|one| self.variable(*one)) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names.join(", ")
    }

    fn variable(&self, variable: Variable) -> String {
        let child = |child: usize| &self.children[child];
        match variable {
            Variable::Startup => "startup".to_owned(),
            Variable::Shutdown => "shutdown".to_owned(),
            Variable::Reset => "reset".to_owned(),
            Variable::Mode { mode, history: true } => format!("history(M{mode})"),
            Variable::Mode { mode, history: false } => format!("reset(M{mode})"),
            Variable::Watchdog(index) => format!("w{index}"),
            Variable::Timer(index) => format!("t{index}"),
            Variable::Action(index) => format!("a{index}"),
            Variable::Input(index) => format!("in{}", port_of(&self.ports.inputs, index).0),
            Variable::Output(index) => format!("out{}", port_of(&self.ports.outputs, index).0),
            Variable::ChildInput(one, index) => format!("c{one}.in{}", port_of(&child(one).inputs, index).0),
            Variable::ChildOutput(one, index) => format!("c{one}.out{}", port_of(&child(one).outputs, index).0),
        }
    }
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

pub(super) fn type_name(ty: Ty) -> &'static str {
    match ty {
        Ty::Small => "u64",
        Ty::Large => "{= [u64; 32] =}",
        Ty::Varying => "{= heapless::Vec<u64, 40> =}",
    }
}

/// Returns the script, as [`Script::parse`] reads it.
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
    add("leave", script.leave_at.and_then(|count| i64::try_from(count).ok()).unwrap_or(0));
    add("play", script.plays.into());
    text
}

impl Script {
    /// Reads the body of a reaction: pairs of a word and a number.
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
                "leave" => script.leave_at = Some(number),
                "play" => script.plays = true,
                _ => {}
            }
        }
        script
    }
}
