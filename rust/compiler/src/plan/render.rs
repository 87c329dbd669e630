// SPDX-License-Identifier: Apache-2.0
//! Renders a plan as text: `lfz plan`.

use core::fmt::{self, Display, Formatter};

use super::{
    ADVANCE_INTERVAL_NS_DEFAULT, Argument, BANK_INDEX, Coordination, Federate, InputIndex, Language, NetworkInput,
    NetworkOutput, Plan, Port, ReactionIndex, ReactionKind, ScheduledReaction, Security, Serializer, Tardy, Target,
    Trigger, TriggerKind, Value,
};

/// A duration in the largest unit that divides it: `25 ms`.
pub(crate) struct Time(pub(crate) i64);

impl Display for Time {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        const UNITS: [(i64, &str); 4] = [(1_000_000_000, "s"), (1_000_000, "ms"), (1_000, "us"), (1, "ns")];
        match self.0 {
            0 => return f.write_str("0"),
            i64::MAX => return f.write_str("forever"),
            _ => {}
        }
        let (size, unit) = UNITS.into_iter().find(|(size, _)| self.0 % size == 0).unwrap_or((1, "ns"));
        write!(f, "{} {unit}", self.0 / size)
    }
}

/// ` after 25 ms`, or nothing.
struct After(Option<i64>);

impl Display for After {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |ns| write!(f, " after {}", Time(ns)))
    }
}

/// ` by postcard of at most 200`, or nothing.
struct By<'a>(Option<&'a Serializer>);

impl Display for By<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Some(Serializer { name, max_length }) = self.0 else { return Ok(()) };
        name.as_ref().map_or(Ok(()), |name| write!(f, " by {name}"))?;
        max_length.map_or(Ok(()), |length| write!(f, " of at most {length}"))
    }
}

/// A value on one line.
struct OneLine<'a>(&'a Value);

impl Display for OneLine<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            Value::Time { ns } => Time(*ns).fmt(f),
            Value::Code(code) => {
                for (index, word) in code.text.split_whitespace().enumerate() {
                    write!(f, "{}{word}", if index == 0 { "" } else { " " })?;
                }
                Ok(())
            }
        }
    }
}

impl Display for Plan {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "program {}", self.name)?;
        for file in &self.files {
            match &file.language {
                None => writeln!(f, "  file {}", file.path)?,
                Some(language) => writeln!(f, "  file {}, in {language}", file.path)?,
            }
        }
        render_target(&self.target, self.target.language, f)?;
        if let Some(rti) = &self.rti {
            writeln!(f, "  rti at {}:{}, federation id \"{}\"", rti.host, rti.port, rti.federation_id)?;
        }
        for federate in &self.federates {
            writeln!(f)?;
            self.render_federate(federate, f)?;
        }
        Ok(())
    }
}

/// A summary of a federate.
struct Summary<'a>(&'a Plan, &'a Federate, Language);

impl Display for Summary<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self(plan, federate, language) = self;
        plan.render_head(federate, f)?;
        render_target(&plan.target, *language, f)?;
        plan.render_instances(federate, f)?;
        plan.render_neighbours(federate, f)?;
        let (reactions, triggers, ports) = (federate.reactions.len(), federate.triggers.len(), federate.ports.len());
        let (inputs, outputs) = (federate.inputs.len(), federate.outputs.len());
        writeln!(f, "  {reactions} reactions, {triggers} triggers, {ports} ports, {inputs} inputs, {outputs} outputs")
    }
}

fn render_target(target: &Target, language: Language, f: &mut Formatter<'_>) -> fmt::Result {
    let mut words = Vec::new();
    match target.timeout_ns {
        Some(ns) => words.push(format!("timeout {}", Time(ns))),
        None => words.push("no timeout".to_owned()),
    }
    if target.fast {
        words.push("fast".to_owned());
    }
    if target.keepalive {
        words.push("keepalive".to_owned());
    }
    if target.coordination == Coordination::Decentralized {
        words.push("decentralized".to_owned());
    }
    if target.authentication {
        words.push("authentication".to_owned());
    }
    match target.security {
        Security::None => {}
        Security::Noise => words.push("encrypted by noise".to_owned()),
        Security::Tls => words.push("encrypted by TLS".to_owned()),
        Security::UnverifiedTls => words.push("encrypted by TLS, unverified".to_owned()),
    }
    words.push(format!("logging {:?}", target.logging).to_lowercase());
    if target.advance_interval_ns != ADVANCE_INTERVAL_NS_DEFAULT {
        words.push(format!("advance message interval {}", Time(target.advance_interval_ns)));
    }
    if let Some(ns) = target.log_waits_ns {
        words.push(format!("log waits of {}", Time(ns)));
    }
    if !target.dnet {
        words.push("no DNET".to_owned());
    }
    writeln!(f, "  target {}: {}", language, words.join(", "))
}

impl Plan {
    /// Returns a summary of a federate, a part of the lines of the whole plan; its bodies are in this language.
    pub(crate) fn summary(&self, federate: &Federate, language: Language) -> String {
        Summary(self, federate, language).to_string()
    }

    fn render_head(&self, federate: &Federate, f: &mut Formatter<'_>) -> fmt::Result {
        match (&self.rti, &federate.host) {
            (None, _) => writeln!(f, "main reactor {}", federate.name),
            (Some(_), None) => writeln!(f, "federate {} {}", federate.id, federate.name),
            (Some(_), Some(host)) => writeln!(f, "federate {} {} at {host}", federate.id, federate.name),
        }
    }

    fn render_federate(&self, federate: &Federate, f: &mut Formatter<'_>) -> fmt::Result {
        self.render_head(federate, f)?;
        self.render_instances(federate, f)?;
        list(f, "ports", &federate.ports, render_port)?;
        list(f, "modes", &federate.modes, |mode, f| {
            write!(f, "{}", mode.path)?;
            mode.parent.map_or(Ok(()), |parent| write!(f, " in mode {parent}"))?;
            f.write_str(if mode.initial { ", initial" } else { "" })
        })?;
        list(f, "triggers", &federate.triggers, |trigger, f| {
            render_trigger(trigger, f)?;
            trigger.mode.map_or(Ok(()), |mode| write!(f, ", in mode {mode}"))
        })?;
        list(f, "reactions in execution order", &federate.reactions, |reaction, f| {
            self.render_reaction(federate, reaction, f)
        })?;
        list(f, "network outputs", &federate.outputs, |output, f| self.render_output(output, f))?;
        if !federate.inputs.is_empty() {
            writeln!(f, "  network inputs by wire port")?;
        }
        for (index, input) in federate.inputs.iter().enumerate() {
            write!(f, "    {} ", federate.port_of(InputIndex(index)))?;
            self.render_input(input, f)?;
            writeln!(f)?;
        }
        self.render_neighbours(federate, f)?;
        if let Some(ns) = federate.physical_delay_ns {
            writeln!(f, "  least delay from a physical action to another federate: {}", Time(ns))?;
        }
        Ok(())
    }

    fn render_instances(&self, federate: &Federate, f: &mut Formatter<'_>) -> fmt::Result {
        list(f, "instances", &federate.instances, |instance, f| {
            let class = self.class(instance);
            write!(f, "{}: {}", instance.path, class.name)?;
            let types: Vec<_> = class.types.iter().map(|(_, ty)| ty.text.as_str()).collect();
            if !types.is_empty() {
                write!(f, "<{}>", types.join(", "))?;
            }
            let given = self.child(federate, instance).map_or(&[][..], |child| &child.arguments);
            let mut open = "(";
            for (index, parameter) in class.parameters.iter().enumerate() {
                let given = given.get(index).and_then(Option::as_ref);
                if let (None, Some(index), BANK_INDEX) = (given, instance.bank_index, parameter.name.as_str()) {
                    write!(f, "{open}{BANK_INDEX} = {index}")?;
                    open = ", ";
                } else if let Some(value) = given.or(parameter.default.as_ref()) {
                    write!(f, "{open}{} = {}", parameter.name, OneLine(value))?;
                    open = ", ";
                }
            }
            if open == "(" { Ok(()) } else { f.write_str(")") }
        })
    }

    fn render_reaction(&self, federate: &Federate, reaction: &ScheduledReaction, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "level {}: {}", reaction.level, reaction.name)?;
        if let ReactionKind::Body { instance, reaction: number, arguments } = &reaction.kind {
            let class = self.class(&federate.instances[instance.0]);
            let declared = &class.reactions[number - 1];
            write!(f, "  {}", declared.signature)?;
            for (index, (parameter, argument)) in declared.parameters.iter().zip(arguments).enumerate() {
                let open = if index == 0 { "  [" } else { ", " };
                let storage = match argument {
                    Argument::Port(port) => format!("port {port}"),
                    Argument::Ports(ports) | Argument::Bank { ports, .. } => {
                        let ports: Vec<_> = ports.iter().map(ToString::to_string).collect();
                        format!("ports {}", ports.join(" "))
                    }
                    Argument::Trigger(trigger) => format!("trigger {trigger}"),
                    Argument::Mode(mode) => format!("mode {mode}"),
                };
                write!(f, "{open}{}: {storage}", parameter.name)?;
            }
            if !arguments.is_empty() {
                f.write_str("]")?;
            }
        }
        if let ReactionKind::Copy { from, to } = &reaction.kind {
            write!(f, "  copies port {from} to port {to}")?;
        }
        reaction.deadline_ns.map_or(Ok(()), |ns| write!(f, "  deadline {}", Time(ns)))?;
        reaction.mode.map_or(Ok(()), |mode| write!(f, "  in mode {mode}"))?;
        f.write_str(match self.tardy(federate, reaction) {
            None => "",
            Some(Tardy::Handler(_)) => "  with a tardy handler",
            Some(Tardy::Body) => "  tardy too",
        })
    }

    fn render_output(&self, output: &NetworkOutput, f: &mut Formatter<'_>) -> fmt::Result {
        let peer = self.peer(output.federate);
        let (ty, port, after) = (&output.ty.text, output.port, After(output.delay_ns));
        let by = By(output.serializer.as_ref());
        write!(f, "{}: {ty}{by}, from port {}, to {peer} wire port {port}{after}", output.name, output.source)?;
        f.write_str(if output.physical { ", physical" } else { "" })?;
        f.write_str(if output.tells_absence { ", tells absence" } else { "" })
    }

    fn render_input(&self, input: &NetworkInput, f: &mut Formatter<'_>) -> fmt::Result {
        let peer = self.peer(input.federate);
        let (by, after) = (By(input.serializer.as_ref()), After(input.delay_ns));
        write!(f, "{}: {}{by}, trigger {}, from {peer}{after}", input.name, input.ty.text, input.trigger)?;
        if input.level < u16::MAX {
            write!(f, ", seen from level {} on", input.level)?;
        }
        f.write_str(if input.physical { ", physical" } else { "" })?;
        if self.is_decentralized() && input.awaited {
            let (max_wait, absent_after) = (Time(input.max_wait_ns), Time(input.absent_after_ns));
            return write!(f, ", maxwait {max_wait}, absent after {absent_after}");
        }
        f.write_str(if input.awaited { ", awaited" } else { "" })
    }

    fn render_neighbours(&self, federate: &Federate, f: &mut Formatter<'_>) -> fmt::Result {
        let upstream: Vec<String> = federate
            .upstream
            .iter()
            .map(|upstream| format!("{}{}", self.peer(upstream.federate), After(upstream.delay_ns)))
            .collect();
        if !upstream.is_empty() {
            writeln!(f, "  upstream: {}", upstream.join(", "))?;
        }
        let downstream: Vec<&str> = federate.downstream.iter().map(|id| self.peer(*id)).collect();
        if !downstream.is_empty() {
            writeln!(f, "  downstream: {}", downstream.join(", "))?;
        }
        Ok(())
    }

    fn peer(&self, id: u16) -> &str {
        self.federates.get(usize::from(id)).map_or("?", |federate| &federate.name)
    }
}

/// Writes a heading and one numbered line per item; nothing without items.
fn list<T>(
    f: &mut Formatter<'_>,
    heading: &str,
    items: &[T],
    mut render: impl FnMut(&T, &mut Formatter<'_>) -> fmt::Result,
) -> fmt::Result {
    if items.is_empty() {
        return Ok(());
    }
    writeln!(f, "  {heading}")?;
    for (index, item) in items.iter().enumerate() {
        write!(f, "    {index} ")?;
        render(item, f)?;
        writeln!(f)?;
    }
    Ok(())
}

fn render_port(port: &Port, f: &mut Formatter<'_>) -> fmt::Result {
    write!(f, "{}: {}", port.path, port.ty.text)?;
    render_triggered(&port.reactions, f)?;
    for delay in &port.delays {
        write!(f, ", feeds trigger {delay}")?;
    }
    Ok(())
}

fn render_trigger(trigger: &Trigger, f: &mut Formatter<'_>) -> fmt::Result {
    f.write_str(&trigger.path)?;
    match &trigger.kind {
        // The path is sufficient.
        TriggerKind::Startup | TriggerKind::Shutdown | TriggerKind::Reset => {}
        TriggerKind::Timer { offset_ns, period_ns, .. } => {
            write!(f, ": timer at {}", Time(*offset_ns))?;
            match period_ns {
                Some(ns) => write!(f, ", every {}", Time(*ns))?,
                None => f.write_str(", once")?,
            }
        }
        TriggerKind::Action { physical, ty, min_delay_ns, min_spacing_ns, policy, .. } => {
            let kind = if *physical { "physical" } else { "logical" };
            write!(f, ": {kind} action {}, min delay {}", ty.text, Time(*min_delay_ns))?;
            if let Some(ns) = min_spacing_ns {
                write!(f, ", min spacing {} {}", Time(*ns), format!("{policy:?}").to_lowercase())?;
            }
            write!(f, ", holds {}", trigger.capacity)?;
        }
        TriggerKind::Watchdog { timeout_ns, .. } => write!(f, ": watchdog, timeout {}", Time(*timeout_ns))?,
        TriggerKind::Delay { source, fills, delay_ns, physical } => {
            let (delay, physically) = (Time(*delay_ns), if *physical { " physical" } else { "" });
            write!(f, ": port {source} to port {fills} after{physically} {delay}, holds {}", trigger.capacity)?;
        }
        TriggerKind::NetworkInput { input, fills } => {
            write!(f, ": network input {input} to port {fills}, holds {}", trigger.capacity)?;
        }
    }
    render_triggered(&trigger.reactions, f)
}

fn render_triggered(reactions: &[ReactionIndex], f: &mut Formatter<'_>) -> fmt::Result {
    for (index, reaction) in reactions.iter().enumerate() {
        let open = if index == 0 { ", triggers reaction" } else { "," };
        write!(f, "{open} {reaction}")?;
    }
    Ok(())
}
