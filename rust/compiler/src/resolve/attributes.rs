// SPDX-License-Identifier: Apache-2.0
//! Attributes: those for diagrams are accepted, those of queues, waits and sending have an effect, and others are
//! refused.

use super::checker::Checker;
use super::model::{CheckedParameter, Sending, Wait};
use super::of_main;
use crate::diagnostics::{Code, Diagnostic, Span, did_you_mean};
use crate::syntax::ast::{Attribute, Expression, ExpressionKind, Literal};

/// The maximum capacity of a queue.
pub(crate) const CAPACITY_MAX: usize = 65_535;

/// The element that an attribute precedes.
#[derive(Clone, Copy)]
pub(super) enum AttributeTarget<'c, 'p> {
    /// An action, which has a queue.
    Queue,
    /// An input, which has a queue, and whose values may come from another federate.
    Input,
    /// An output, whose values may go to another federate.
    Output,
    /// A state variable, which may be handed over.
    State,
    /// A connection, with the parameters of its reactor.
    Connection(Container<'c, 'p>),
    /// A contained reactor, with the parameters of its container.
    Instance(Container<'c, 'p>),
    /// A main or federated reactor.
    Main,
    /// Any other element.
    Other,
}

/// The reactor that contains a connection or an instance.
#[derive(Clone, Copy)]
pub(super) struct Container<'c, 'p> {
    /// Whether it is a main or federated reactor, whose instances can be federates.
    pub(super) is_main: bool,
    /// Whether it is a federated reactor.
    pub(super) is_federated: bool,
    pub(super) parameters: &'c [CheckedParameter<'p>],
}

/// The attributes with a meaning.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Attributes<'p> {
    pub(super) capacity: Option<usize>,
    pub(super) max_wait: Option<Wait<'p>>,
    pub(super) absent_after: Option<Wait<'p>>,
    pub(super) sending: Sending<'p>,
    /// The place of `@transient`.
    pub(super) transient: Option<Span>,
    /// Whether there is `@handed_over`.
    pub(super) handed_over: bool,
}

/// Attributes that only diagrams use; each takes one string, except for `layout`, which takes an option and its value.
const FOR_DIAGRAMS: &[&str] = &["label", "icon", "side", "layout"];

/// Attributes with a meaning.
const HONOURED: &[&str] =
    &["capacity", "maxwait", "absent_after", "serializer", "max_length", "transient", "handed_over"];

/// Names of `@capacity` in micro LF.
const CAPACITY: [&str; 3] = ["capacity", "max_pending_events", "buffer"];

/// Attributes without an effect in this compiler, each with the reason.
const IDLE: &[(&str, &str)] = &[
    ("sparse", "present channels are found without it"),
    ("enclave", "one event loop runs all reactors of a program, with the same results"),
    ("property", "programs are not verified here"),
    ("wcet", "execution times are measured here: `lfz trace`"),
    ("link", "federates are connected over TCP"),
    ("interface_tcp", "addresses are in the deployment file, or behind `at`"),
    ("interface_coap", "federates are connected over TCP"),
    ("interface_s4noc", "federates are connected over TCP"),
    ("interface_custom", "federates are connected over TCP"),
    ("platform_native", "the deployment file says where a federate runs"),
    ("platform_zephyr", "the deployment file says where a federate runs"),
    ("platform_riot", "the deployment file says where a federate runs"),
    ("platform_freertos", "the deployment file says where a federate runs"),
    ("joining_policy", "a federate that may come later is `@transient`"),
];

/// Attributes of LF that are not supported, each with the alternative.
pub(super) const UNSUPPORTED: &[(&[&str], &str)] =
    &[(&["language"], "remove it: the target declaration chooses the language of all reactors of a program")];

/// Returns the names of the attributes that have an effect or are for diagrams.
pub(super) fn honoured() -> impl Iterator<Item = &'static str> {
    FOR_DIAGRAMS.iter().chain(HONOURED).copied().chain(of_main::ATTRIBUTES.map(|(name, _)| name))
}

impl<'p> Checker<'p> {
    /// Checks the attributes of a declaration, and returns those with a meaning.
    pub(super) fn check_attributes(
        &mut self,
        attributes: &'p [Attribute],
        target: AttributeTarget<'_, 'p>,
    ) -> Attributes<'p> {
        let mut found = Attributes::default();
        for attribute in attributes {
            let name = attribute.name.text.as_str();
            if FOR_DIAGRAMS.contains(&name) {
                self.check_diagram(attribute);
            } else if CAPACITY.contains(&name) {
                found.capacity = self.capacity(attribute, target).or(found.capacity);
            } else if name == "maxwait" || name == "absent_after" {
                let wait = self.wait(attribute, target);
                let place = if name == "maxwait" { &mut found.max_wait } else { &mut found.absent_after };
                if let (Some(first), Some(_)) = (*place, wait) {
                    let message = format!("`@{name}` is given twice");
                    let diagnostic = Diagnostic::new(Code::DuplicateValue, attribute.span, message);
                    self.report(diagnostic.also(first.span, "the first one").hint("remove one of them"));
                }
                *place = wait.or(*place);
            } else if name == "serializer" || name == "max_length" {
                self.check_sending(attribute, target, &mut found.sending);
            } else if name == "transient" {
                found.transient = self.transient(attribute, target).or(found.transient);
            } else if name == "handed_over" {
                found.handed_over |= self.handed_over(attribute, target);
            } else if of_main::ATTRIBUTES.iter().any(|(known, _)| *known == name) {
                self.check_of_main(attribute, target);
            } else if let Some((_, reason)) = IDLE.iter().find(|(idle, _)| *idle == name) {
                let message = format!("`@{name}` has no effect: {reason}");
                self.report(Diagnostic::new(Code::NoEffect, attribute.span, message).hint("remove it, or leave it"));
            } else if let Some((_, instead)) = UNSUPPORTED.iter().find(|(names, _)| names.contains(&name)) {
                let message = format!("the attribute `@{name}` is not supported yet");
                self.report(Diagnostic::new(Code::Unsupported, attribute.span, message).hint(*instead));
            } else {
                self.unknown(attribute);
            }
        }
        found
    }

    /// Reports an attribute that nobody knows: an error if it may be a misspelled one, or else a warning, because other
    /// tools may know it.
    fn unknown(&mut self, attribute: &Attribute) {
        let name = &attribute.name.text;
        let message = format!("there is no attribute `@{name}`");
        if let Some(hint) = did_you_mean(name, honoured()) {
            self.report(Diagnostic::new(Code::UnknownAttribute, attribute.name.span, message).hint(hint));
            return;
        }
        let all = FOR_DIAGRAMS.iter().chain(HONOURED).map(|name| format!("`@{name}`"));
        let hint = format!("attributes are {}", all.collect::<Vec<_>>().join(", "));
        let message = format!("{message}, so it has no effect");
        self.report(Diagnostic::new(Code::NoEffect, attribute.name.span, message).hint(hint));
    }

    /// Checks the place of an attribute that is a target property of the program.
    fn check_of_main(&mut self, attribute: &Attribute, target: AttributeTarget<'_, '_>) {
        let name = &attribute.name.text;
        match target {
            AttributeTarget::Main if of_main::is_property(attribute) => {}
            AttributeTarget::Main | AttributeTarget::Instance(_) if name == "clock_sync" => {
                let message = "this `@clock_sync` has no effect: all clocks follow the RTI's";
                let hint = "the target property `clock-sync` configures it";
                self.report(Diagnostic::new(Code::NoEffect, attribute.span, message).hint(hint));
            }
            AttributeTarget::Other | AttributeTarget::State | AttributeTarget::Instance(_) if name == "platform" => {
                let message = "`@platform` has no effect here: the deployment file says where a federate runs";
                self.report(Diagnostic::new(Code::NoEffect, attribute.span, message).hint("remove it, or leave it"));
            }
            _ => {
                let message = format!("only a main or federated reactor has the attribute `@{name}`");
                let hint = "write it before that reactor, or as a property in the target declaration";
                self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
            }
        }
    }

    fn check_diagram(&mut self, attribute: &Attribute) {
        let name = &attribute.name.text;
        let is_text = |value: &Expression| {
            matches!(value.kind, ExpressionKind::Literal(Literal::Text(_)) | ExpressionKind::Name(_))
        };
        let texts = attribute.parameters.iter().filter(|it| it.value.as_ref().is_some_and(is_text)).count();
        let is_whole = attribute.parameters.len() == texts && texts == if name == "layout" { 2 } else { 1 };
        if !is_whole && name == "layout" {
            let message = "the attribute `@layout` takes an option and its value";
            let hint = "write `@layout(option=\"…\", value=\"…\")`";
            self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
        } else if !is_whole {
            let message = format!("the attribute `@{name}` takes one text");
            let hint = format!("write `@{name}(\"…\")`");
            self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
        }
    }

    /// Returns the place of `@transient`.
    fn transient(&mut self, attribute: &Attribute, target: AttributeTarget<'_, '_>) -> Option<Span> {
        let is_federate = matches!(target, AttributeTarget::Instance(container) if container.is_federated);
        let (message, hint) = if !is_federate {
            ("only a federate can be transient", "write `@transient` before an instance in the federated reactor")
        } else if !attribute.parameters.is_empty() {
            ("the attribute `@transient` takes no value", "write `@transient`")
        } else {
            return Some(attribute.span);
        };
        self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
        None
    }

    /// Returns whether `@handed_over` stands where it can.
    fn handed_over(&mut self, attribute: &Attribute, target: AttributeTarget<'_, '_>) -> bool {
        let (message, hint) = if !matches!(target, AttributeTarget::State) {
            ("only a state variable can be handed over", "write `@handed_over` before `state`")
        } else if !attribute.parameters.is_empty() {
            ("the attribute `@handed_over` takes no value", "write `@handed_over`")
        } else {
            return true;
        };
        self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
        false
    }

    fn capacity(&mut self, attribute: &Attribute, target: AttributeTarget<'_, '_>) -> Option<usize> {
        if !matches!(target, AttributeTarget::Queue | AttributeTarget::Input | AttributeTarget::Connection(_)) {
            let diagnostic = Diagnostic::new(Code::BadAttribute, attribute.span, "nothing here has a queue")
                .hint("`@capacity(n)` stands before an action, an input or a connection");
            self.report(diagnostic);
            return None;
        }
        let value = attribute.single_value().and_then(|value| match &value.kind {
            ExpressionKind::Literal(Literal::Int(digits)) => digits.parse::<usize>().ok(),
            _ => None,
        });
        let value = value.filter(|value| (1..=CAPACITY_MAX).contains(value));
        if value.is_none() {
            let message = format!("a capacity is a number from 1 to {CAPACITY_MAX}");
            let hint = "write `@capacity(16)`, how many events may wait at the same time";
            self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
        }
        value
    }

    /// Returns the time of `@maxwait` or `@absent_after`.
    fn wait(&mut self, attribute: &'p Attribute, target: AttributeTarget<'_, 'p>) -> Option<Wait<'p>> {
        let name = attribute.name.text.as_str();
        let container = match target {
            AttributeTarget::Connection(container) => Some(container),
            AttributeTarget::Instance(container) if name == "maxwait" => Some(container),
            _ => None,
        };
        let Some(container) = container.filter(|container| container.is_main) else {
            let (message, hint) = if name == "maxwait" {
                (
                    "only federates and connections between federates have a `@maxwait`",
                    "write it before an instance or a connection in the federated reactor",
                )
            } else {
                (
                    "only connections between federates have an `@absent_after`",
                    "write it before a connection in the federated reactor",
                )
            };
            self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
            return None;
        };
        let Some(value) = attribute.single_value() else {
            let message = format!("the attribute `@{name}` takes one time");
            let hint = format!("write `@{name}(10 ms)`");
            self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
            return None;
        };
        self.check_time(value, &format!("the time of `@{name}`"), container.parameters, false);
        Some(Wait { value, span: attribute.span })
    }
}
