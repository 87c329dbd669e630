// SPDX-License-Identifier: Apache-2.0
//! The settings of ports and connections for serialization: `@serializer`, `@max_length`, `serializer`.

use super::attributes::{AttributeTarget, Attributes};
use super::checker::Checker;
use super::model::{Given, Sending};
use crate::diagnostics::{Code, Diagnostic, Span, did_you_mean};
use crate::syntax::ast::{self, Attribute, ExpressionKind, Literal};

/// The maximum of a length's bound: the longest message of the protocol.
const LENGTH_MAX: usize = i32::MAX as usize;

impl<'p> Checker<'p> {
    /// Checks `@serializer` or `@max_length`.
    pub(super) fn check_sending(
        &mut self,
        attribute: &'p Attribute,
        target: AttributeTarget<'_, 'p>,
        sending: &mut Sending<'p>,
    ) {
        let (name, span) = (attribute.name.text.as_str(), attribute.span);
        let is_sent = matches!(
            target,
            AttributeTarget::Input | AttributeTarget::Output | AttributeTarget::State | AttributeTarget::Connection(_)
        );
        if !is_sent {
            let message = "nothing here is sent to another federate";
            let hint = format!("`@{name}` stands before a port or a connection");
            self.report(Diagnostic::new(Code::BadAttribute, span, message).hint(hint));
            return;
        }
        let literal = attribute.single_value().and_then(|value| match &value.kind {
            ExpressionKind::Literal(literal) => Some(literal),
            _ => None,
        });
        if name == "max_length" {
            let length = match literal {
                Some(Literal::Int(digits)) => digits.parse().ok().filter(|length| (1..=LENGTH_MAX).contains(length)),
                _ => None,
            };
            sending.max_length = length.map(|value| Given { value, span });
            if length.is_none() {
                let message = format!("a length is a number from 1 to {LENGTH_MAX}");
                let hint = "write `@max_length(200)`: bytes of a text or of a serialized value, or elements of a list";
                self.report(Diagnostic::new(Code::BadAttribute, span, message).hint(hint));
            }
        } else if let Some(Literal::Text(text)) = literal {
            sending.serializer = self.serializer(text.trim_matches('"'), span);
        } else {
            let known = self.language.facts().serializers.last().copied().unwrap_or_default();
            let hint = format!("write `@serializer(\"{known}\")`");
            let diagnostic = Diagnostic::new(Code::BadAttribute, span, "a serializer is named by a text");
            self.report(diagnostic.hint(hint));
        }
    }

    /// Returns the settings in a connection's attributes and in LF's own keyword, which takes precedence.
    pub(super) fn connection_sending(
        &mut self,
        declared: &'p ast::ConnectionSyntax,
        sending: Sending<'p>,
    ) -> Sending<'p> {
        let named = declared.serializer.as_ref().and_then(|name| self.serializer(&name.text, name.span));
        Sending { serializer: named.or(sending.serializer), ..sending }
    }

    /// Returns the settings of a state variable, which count if it is handed over.
    pub(super) fn state_sending(&mut self, attributes: Attributes<'p>) -> Sending<'p> {
        let sending = attributes.sending;
        let serializer = sending.serializer.map(|given| given.span);
        if let Some(span) =
            serializer.or(sending.max_length.map(|given| given.span)).filter(|_| !attributes.handed_over)
        {
            let message = "this state is not sent to another federate";
            let hint = "write `@handed_over` before it too, if the next instance of the federate is to have it";
            self.report(Diagnostic::new(Code::BadAttribute, span, message).hint(hint));
        }
        sending
    }

    fn serializer(&mut self, name: &'p str, span: Span) -> Option<Given<&'p str>> {
        let known = self.language.facts().serializers;
        if known.contains(&name) {
            return Some(Given { value: name, span });
        }
        let message = format!("there is no serializer \"{name}\" here");
        let hint = if name.eq_ignore_ascii_case("ros2") {
            "messages of ROS 2 come from its own compiler, which is not used here: send a struct with the same members"
                .to_owned()
        } else {
            did_you_mean(name, known.iter().copied())
                .unwrap_or_else(|| format!("serializers are \"{}\"", known.join("\" and \"")))
        };
        self.report(Diagnostic::new(Code::BadAttribute, span, message).hint(hint));
        None
    }
}
