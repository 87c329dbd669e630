// SPDX-License-Identifier: Apache-2.0
//! Attributes: those for diagrams are accepted, `@capacity` counts, others are refused.

use super::checker::Checker;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::syntax::ast::{Attribute, ExpressionKind, Literal};

/// How many events a queue may be told to hold.
pub(crate) const CAPACITY_MAX: usize = 65_535;

/// What an attribute stands before.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    /// Something with a queue: an action, an input or a connection.
    Queue,
    /// Anything else.
    Other,
}

/// Attributes that only diagrams use; each takes one string.
const FOR_DIAGRAMS: &[&str] = &["label", "icon", "side", "layout"];

/// Attributes of LF that mean something and are not supported.
const UNSUPPORTED: &[&str] = &["maxwait", "absent_after", "sparse", "enclave", "property", "enabled"];

impl Checker<'_> {
    /// Checks the attributes of a declaration; returns the capacity that they give.
    pub(super) fn check_attributes(&mut self, attributes: &[Attribute], target: Target) -> Option<usize> {
        let mut capacity = None;
        for attribute in attributes {
            let name = attribute.name.text.as_str();
            if FOR_DIAGRAMS.contains(&name) {
                self.check_diagram(attribute);
            } else if name == "capacity" {
                capacity = self.capacity(attribute, target).or(capacity);
            } else if UNSUPPORTED.contains(&name) {
                let message = format!("the attribute `@{name}` is not supported yet");
                self.report(Diagnostic::new(Code::Unsupported, attribute.span, message).hint("remove it"));
            } else {
                let message = format!("there is no attribute `@{name}`");
                let known = FOR_DIAGRAMS.iter().copied().chain(["capacity"]);
                let hint = did_you_mean(name, known)
                    .unwrap_or_else(|| "attributes are `@label`, `@icon`, `@side`, `@layout` and `@capacity`".into());
                self.report(Diagnostic::new(Code::UnknownAttribute, attribute.name.span, message).hint(hint));
            }
        }
        capacity
    }

    fn check_diagram(&mut self, attribute: &Attribute) {
        let text = matches!(
            &attribute.parameters[..],
            [one] if one.name.is_none() && one.value.as_ref().is_some_and(|value| {
                matches!(value.kind, ExpressionKind::Literal(Literal::Text(_)) | ExpressionKind::Name(_))
            })
        );
        if !text {
            let name = &attribute.name.text;
            let message = format!("the attribute `@{name}` takes one text");
            let hint = format!("write `@{name}(\"…\")`");
            self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
        }
    }

    fn capacity(&mut self, attribute: &Attribute, target: Target) -> Option<usize> {
        if target == Target::Other {
            let diagnostic = Diagnostic::new(Code::BadAttribute, attribute.span, "nothing here has a queue")
                .hint("`@capacity(n)` stands before an action, an input or a connection");
            self.report(diagnostic);
            return None;
        }
        let value = match &attribute.parameters[..] {
            [one] if one.name.is_none() => one.value.as_ref().and_then(|value| match &value.kind {
                ExpressionKind::Literal(Literal::Int(digits)) => digits.parse::<usize>().ok(),
                _ => None,
            }),
            _ => None,
        };
        let value = value.filter(|value| (1..=CAPACITY_MAX).contains(value));
        if value.is_none() {
            let message = format!("a capacity is a number from 1 to {CAPACITY_MAX}");
            let hint = "write `@capacity(16)`, how many events may wait at the same time";
            self.report(Diagnostic::new(Code::BadAttribute, attribute.span, message).hint(hint));
        }
        value
    }
}
