// SPDX-License-Identifier: Apache-2.0
//! The names that are in scope in bodies, and the other names of their reactors.

use lf_compiler::plan::{Plan, PortDirection, Reaction, ReactorClass, SourceCode, Tardy};
use serde::{Deserialize, Serialize};

/// The body of a reaction or of one of its handlers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Scope {
    path: String,
    /// The first line and the last one.
    lines: (usize, usize),
    /// The name of the reactor.
    pub(crate) reactor: String,
    /// The variables that the signature declares for the body, and whether it may change each.
    variables: Vec<(String, bool)>,
    names: Vec<SignatureName>,
}

/// A name that the signature of a reaction can contain.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SignatureName {
    /// Its name in bodies.
    pub(crate) name: String,
    /// Its name in signatures.
    pub(crate) written: String,
    /// Its kind.
    pub(crate) kind: Kind,
}

/// The kind of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Kind {
    Input,
    Output,
    Action,
    Watchdog,
    Timer,
    /// An input of a contained reactor.
    ChildInput,
    /// An output of a contained reactor.
    ChildOutput,
}

impl Scope {
    /// Returns the bodies of all reactions.
    pub(crate) fn all(plan: &Plan) -> Vec<Self> {
        let of_class = |class: &ReactorClass| -> Vec<Self> {
            let names = names(plan, class);
            let bodies = class.reactions.iter().flat_map(|reaction| codes(reaction).map(move |code| (reaction, code)));
            let scope = |(reaction, code): (&Reaction, &SourceCode)| Self {
                path: plan.path(code.at).to_owned(),
                lines: (code.at.line, code.at.line + code.text.matches('\n').count()),
                reactor: class.name.clone(),
                variables: reaction.parameters.iter().map(|one| (one.name.clone(), one.effect)).collect(),
                names: names.clone(),
            };
            bodies.map(scope).collect()
        };
        plan.classes.iter().flat_map(of_class).collect()
    }

    /// Returns whether a line is one of the body's.
    pub(crate) fn has(&self, path: &str, line: usize) -> bool {
        self.path == path && (self.lines.0..=self.lines.1).contains(&line)
    }

    /// Returns the element of the signature that has this name in bodies.
    pub(crate) fn signature_name(&self, name: &str) -> Option<&SignatureName> {
        self.names.iter().find(|signature_name| signature_name.name == name)
    }

    /// Returns whether the signature names it.
    pub(crate) fn has_variable(&self, name: &str) -> bool {
        self.variables.iter().any(|(variable, _)| variable == name)
    }

    /// Returns the ports of a contained reactor, if there is one of this name.
    pub(crate) fn ports_of_child(&self, name: &str) -> impl Iterator<Item = &SignatureName> {
        self.names.iter().filter(move |signature_name| {
            signature_name.written.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'))
                && signature_name.kind.is_of_child()
        })
    }
}

impl Kind {
    fn is_of_child(self) -> bool {
        matches!(self, Self::ChildInput | Self::ChildOutput)
    }

    /// Returns whether a reaction can have it among its effects.
    pub(crate) fn is_effect(self) -> bool {
        matches!(self, Self::Output | Self::Action | Self::Watchdog | Self::ChildInput)
    }

    /// Returns whether it can trigger a reaction.
    pub(crate) fn is_trigger(self) -> bool {
        matches!(self, Self::Input | Self::Action | Self::Watchdog | Self::Timer | Self::ChildOutput)
    }

    /// Returns the name of the kind, with its article.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Input => "an input",
            Self::Output => "an output",
            Self::Action => "an action",
            Self::Watchdog => "a watchdog",
            Self::Timer => "a timer",
            Self::ChildInput => "an input of a contained reactor",
            Self::ChildOutput => "an output of a contained reactor",
        }
    }
}

fn codes(reaction: &Reaction) -> impl Iterator<Item = &SourceCode> {
    let tardy = match &reaction.tardy {
        Some(Tardy::Handler(code)) => Some(code),
        Some(Tardy::Body) | None => None,
    };
    [&reaction.body].into_iter().chain(&reaction.deadline).chain(tardy)
}

fn names(plan: &Plan, class: &ReactorClass) -> Vec<SignatureName> {
    let own = |name: &String, kind| SignatureName { name: name.clone(), written: name.clone(), kind };
    let ports = class.ports.iter().map(|port| match port.direction {
        PortDirection::Input => own(&port.name, Kind::Input),
        PortDirection::Output => own(&port.name, Kind::Output),
    });
    let actions = class.actions.iter().map(|action| own(&action.name, Kind::Action));
    let watchdogs = class.watchdogs.iter().map(|watchdog| own(&watchdog.name, Kind::Watchdog));
    let timers = class.timers.iter().map(|timer| own(&timer.name, Kind::Timer));
    let children = class.children.iter().flat_map(|child| {
        plan.classes[child.class.0].ports.iter().map(|port| SignatureName {
            name: format!("{}__{}", child.name, port.name),
            written: format!("{}.{}", child.name, port.name),
            kind: match port.direction {
                PortDirection::Input => Kind::ChildInput,
                PortDirection::Output => Kind::ChildOutput,
            },
        })
    });
    ports.chain(actions).chain(watchdogs).chain(timers).chain(children).collect()
}
