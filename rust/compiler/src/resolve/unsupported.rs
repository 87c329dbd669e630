// SPDX-License-Identifier: Apache-2.0
//! Features of the language that are read and then refused by name, so that nothing is ignored silently.

use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{Connection, Reaction, Reactor, ReactorKind, Reference};

/// Declares the features, each with what to do instead; the README's table is made of them.
macro_rules! features {
    ($($feature:ident: $name:literal $verb:ident, $instead:literal;)*) => {
        /// A feature that is refused.
        #[derive(Clone, Copy)]
        pub(super) enum Feature {
            $($feature,)*
        }

        impl Feature {
            pub(super) const ALL: &[Self] = &[$(Self::$feature,)*];

            pub(super) const fn name(self) -> &'static str {
                match self {
                    $(Self::$feature => $name,)*
                }
            }

            const fn verb(self) -> &'static str {
                match self {
                    $(Self::$feature => stringify!($verb),)*
                }
            }

            pub(super) const fn instead(self) -> &'static str {
                match self {
                    $(Self::$feature => $instead,)*
                }
            }
        }
    };
}

features! {
    Multiport: "multiports" are, "declare one port for each channel";
    Bank: "banks of reactors" are, "write one instance for each member";
    Interleaved: "`interleaved`" is, "name the ports one by one";
    Extends: "`extends`" is, "contain the other reactor, or repeat its declarations";
    TypeParameters: "type parameters of reactors" are, "write one reactor for each type";
    TypeArguments: "type arguments of reactors" are, "write one reactor for each type";
    Mode: "modes" are, "keep the mode in a state variable and test it in the reactions";
    Transition: "mode transitions" are, "keep the mode in a state variable";
    ResetState: "`reset` state variables" are, "remove the word; without modes nothing is reset";
    ResetTrigger: "the trigger `reset`" is, "without modes nothing is reset; remove it";
    Method: "methods" are, "write a function in a preamble that takes what it needs";
    Watchdog: "watchdogs" are, "schedule a logical action with a delay, or use a deadline";
    Mutation: "mutations" are, "use a reaction";
    Mutable: "`mutable` inputs" are, "remove the word and copy the value in the reaction";
    Realtime: "`realtime` reactors" are, "remove the word";
    Alias: "other names for ports" are, "use the port's own name in the body";
    Package: "imports from packages" are, "import from a file: `import X from \"path/to/File.lf\"`";
}

impl Feature {
    /// The refusal where the feature is used.
    pub(super) fn refused(self, span: Span) -> Diagnostic {
        let message = format!("{} {} not supported yet", self.name(), self.verb());
        Diagnostic::new(Code::Unsupported, span, message).hint(self.instead())
    }
}

/// Reports every unsupported feature in a reactor.
pub(super) fn check(reactor: &Reactor, found: &mut Vec<Diagnostic>) {
    let mut refuse = |feature: Feature, span: Span| found.push(feature.refused(span));
    if let Some(span) = reactor.realtime {
        refuse(Feature::Realtime, span);
    }
    if let Some(span) = reactor.type_parameters.first() {
        refuse(Feature::TypeParameters, *span);
    }
    reactor.extends.iter().for_each(|name| refuse(Feature::Extends, name.span));
    let body = &reactor.body;
    body.modes.iter().for_each(|mode| refuse(Feature::Mode, mode.span));
    body.methods.iter().for_each(|method| refuse(Feature::Method, method.name.span));
    body.watchdogs.iter().for_each(|watchdog| refuse(Feature::Watchdog, watchdog.name.span));
    body.states.iter().filter_map(|state| state.reset).for_each(|span| refuse(Feature::ResetState, span));
    for port in &body.ports {
        if let Some(span) = port.mutable {
            refuse(Feature::Mutable, span);
        }
        if let Some(span) = port.width {
            refuse(Feature::Multiport, span);
        }
    }
    for instance in &body.instances {
        if let Some(span) = instance.width {
            refuse(Feature::Bank, span);
        }
        if let Some(span) = instance.type_arguments {
            refuse(Feature::TypeArguments, span);
        }
    }
    check_hosts(reactor, found);
    body.connections.iter().for_each(|connection| check_connection(connection, found));
    body.reactions.iter().for_each(|reaction| check_reaction(reaction, found));
}

/// Only a federated reactor says where the RTI is, and only its instances can be placed.
fn check_hosts(reactor: &Reactor, found: &mut Vec<Diagnostic>) {
    if reactor.kind == ReactorKind::Federated {
        return;
    }
    for host in reactor.body.instances.iter().filter_map(|instance| instance.host.as_ref()) {
        let message = "only the instances in a federated reactor can be placed";
        let hint = "remove `at …`, or make the containing reactor `federated`";
        found.push(Diagnostic::new(Code::MisplacedHost, host.span, message).hint(hint));
    }
    if let Some(host) = &reactor.host {
        let message = "only a federated reactor can say where its RTI is";
        let hint = "remove `at …`, or make the reactor `federated`";
        found.push(Diagnostic::new(Code::MisplacedHost, host.span, message).hint(hint));
    }
}

fn check_connection(connection: &Connection, found: &mut Vec<Diagnostic>) {
    for reference in connection.left.iter().chain(&connection.right) {
        check_reference(reference, found);
    }
}

fn check_reference(reference: &Reference, found: &mut Vec<Diagnostic>) {
    if reference.interleaved {
        found.push(Feature::Interleaved.refused(reference.span));
    }
    found.extend(reference.alias.as_ref().map(|alias| Feature::Alias.refused(alias.span)));
    if reference.transition {
        found.push(Feature::Transition.refused(reference.span));
    }
}

fn check_reaction(reaction: &Reaction, found: &mut Vec<Diagnostic>) {
    if reaction.mutation {
        found.push(Feature::Mutation.refused(reaction.keyword));
    }
    for trigger in reaction.triggers.iter().filter(|trigger| trigger.name.text == "reset") {
        found.push(Feature::ResetTrigger.refused(trigger.span));
    }
    for reference in reaction.triggers.iter().chain(&reaction.uses).chain(&reaction.effects) {
        check_reference(reference, found);
    }
}
