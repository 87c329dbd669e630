// SPDX-License-Identifier: Apache-2.0
//! Reads the values of target properties, and reports wrong ones.

use lf_model::units::UNITS;

use super::sources::SourceProvider;
use crate::diagnostics::{Code, Diagnostic, SourceTexts, did_you_mean};
use crate::plan;
use crate::syntax::ast::{Literal, Name, Property, PropertyKind, PropertyValue, TimeValue};
use crate::syntax::{TimeError, nanoseconds};

/// Reads a value of a property, or of an option in one, into the target.
pub(super) type Read = fn(&mut TargetReader<'_>, &Name, &PropertyValue);

/// The contents of a program's target declarations.
pub(super) struct TargetReader<'p> {
    pub(super) target: plan::Target,
    pub(super) found: Vec<Diagnostic>,
    pub(super) sources: &'p dyn SourceProvider,
    pub(super) texts: &'p SourceTexts,
}

impl TargetReader<'_> {
    pub(super) fn unique(&mut self, properties: &[Property]) {
        for (index, property) in properties.iter().enumerate() {
            let first = properties[..index].iter().find(|first| first.key.text == property.key.text);
            if let Some(first) = first {
                let message = format!("`{}` is given twice", property.key.text);
                let diagnostic = Diagnostic::new(Code::DuplicateProperty, property.key.span, message);
                self.found.push(diagnostic.also(first.key.span, "the first one").hint("remove one of them"));
            }
        }
    }

    /// Reads the options of a property by a table of them; `refused` are further ones of LF, with the alternatives.
    pub(super) fn options(
        &mut self,
        key: &Name,
        value: &PropertyValue,
        known: &[(&'static str, Read)],
        refused: &[(&str, &str)],
    ) {
        let PropertyKind::Map(properties) = &value.kind else {
            return self.bad(key, value, "a list of options in braces");
        };
        self.unique(properties);
        for Property { key, value } in properties {
            let refusal = refused.iter().find(|(name, _)| *name == key.text);
            match (known.iter().find(|(name, _)| *name == key.text), refusal) {
                (Some((_, read)), _) => read(self, key, value),
                (None, Some((_, instead))) => self.refuse_value(key, value, instead),
                (None, None) => self.unknown(key, known.iter().map(|(name, _)| *name), &[]),
            }
        }
    }

    /// Reports a property that does not exist; `refused` are those of LF that are not suggested.
    pub(super) fn unknown<'a>(
        &mut self,
        key: &Name,
        known: impl Iterator<Item = &'a str> + Clone,
        refused: &[(&'a str, &str)],
    ) {
        let message = format!("there is no property `{}` here", key.text);
        let all = known.clone().chain(refused.iter().map(|(name, _)| *name));
        let hint = did_you_mean(&key.text, all).unwrap_or_else(|| {
            let names: Vec<_> = known.map(|name| format!("`{name}`")).collect();
            format!("properties are {}", names.join(", "))
        });
        self.found.push(Diagnostic::new(Code::UnknownProperty, key.span, message).hint(hint));
    }

    pub(super) fn idle(&mut self, key: &Name, reason: &str) {
        let message = format!("`{}` has no effect: {reason}", key.text);
        self.found.push(Diagnostic::new(Code::IdleProperty, key.span, message).hint("remove it"));
    }

    pub(super) fn refuse_value(&mut self, key: &Name, value: &PropertyValue, hint: &str) {
        let written = text_of(value).map_or_else(String::new, |text| format!(": {text}"));
        let message = format!("`{}{written}` is not supported yet", key.text);
        self.found.push(Diagnostic::new(Code::UnsupportedProperty, key.span.to(value.span), message).hint(hint));
    }

    pub(super) fn bad(&mut self, key: &Name, value: &PropertyValue, expected: &str) {
        let message = format!("`{}` takes {expected}", key.text);
        self.found.push(Diagnostic::new(Code::BadPropertyValue, value.span, message));
    }

    pub(super) fn word(&mut self, key: &Name, value: &PropertyValue, words: &[&'static str]) -> Option<&'static str> {
        let text = text_of(value);
        let found = words.iter().find(|word| text.as_deref() == Some(**word)).copied();
        if found.is_none() {
            let quoted: Vec<_> = words.iter().map(|word| format!("`{word}`")).collect();
            self.bad(key, value, &format!("one of {}", quoted.join(", ")));
        }
        found
    }

    pub(super) fn boolean(&mut self, key: &Name, value: &PropertyValue) -> Option<bool> {
        let boolean = match &value.kind {
            PropertyKind::Literal(Literal::Bool(value)) => Some(*value),
            _ => None,
        };
        if boolean.is_none() {
            self.bad(key, value, "`true` or `false`");
        }
        boolean
    }

    pub(super) fn number(&mut self, key: &Name, value: &PropertyValue, max: u64) -> Option<u64> {
        let number = match &value.kind {
            PropertyKind::Literal(Literal::Int(digits)) => digits.parse().ok().filter(|number| *number <= max),
            _ => None,
        };
        if number.is_none() {
            let limit = if max == u64::MAX { String::new() } else { format!(" up to {max}") };
            self.bad(key, value, &format!("a whole number{limit}"));
        }
        number
    }

    /// Returns a number from 1 on, if there is one.
    pub(super) fn count(&mut self, key: &Name, value: &PropertyValue) -> Option<u16> {
        let count = self.number(key, value, u64::from(u16::MAX)).and_then(|count| u16::try_from(count).ok());
        if count == Some(0) {
            self.bad(key, value, "a number from 1 to 65535");
        }
        count.filter(|count| *count > 0)
    }

    /// Returns nanoseconds; `None` for `forever`.
    pub(super) fn time(&mut self, key: &Name, value: &PropertyValue) -> Option<i64> {
        let (code, message, span, hint) = match &value.kind {
            PropertyKind::Time(TimeValue::Forever) => return None,
            PropertyKind::Time(TimeValue::Interval { negative, digits, unit }) => {
                match nanoseconds(digits, &unit.text) {
                    Ok(ns) if !negative || ns == 0 => return Some(ns),
                    Ok(_) => (Code::NegativeTime, "is negative", value.span, "write a time from 0 on".to_owned()),
                    // A time of the parser has digits.
                    Err(TimeError::TooLarge(..) | TimeError::NotANumber(_)) => {
                        let hint = "write `forever` for a time that never comes".to_owned();
                        (Code::NumberTooLarge, "is longer than 292 years", value.span, hint)
                    }
                    Err(TimeError::UnknownUnit(_)) => {
                        let units = UNITS.iter().flat_map(|(names, _)| names.iter().copied());
                        let hint = did_you_mean(&unit.text, units)
                            .unwrap_or_else(|| "units of time are ns, us, ms, s, min, h, d and wk".to_owned());
                        (Code::BadUnit, "has a unit of time that does not exist", unit.span, hint)
                    }
                }
            }
            PropertyKind::Literal(Literal::Int(digits)) => {
                if digits.bytes().all(|byte| byte == b'0') {
                    return Some(0);
                }
                (Code::MissingUnit, "needs a unit of time", value.span, format!("write `{digits} ms`"))
            }
            _ => (Code::NotATime, "is not a time", value.span, "write a number with a unit, like `10 s`".to_owned()),
        };
        let message = format!("`{}` {message}", key.text);
        self.found.push(Diagnostic::new(code, span, message).hint(hint));
        None
    }
}

/// Returns a word, a path or a string, without quotes.
pub(super) fn text_of(value: &PropertyValue) -> Option<String> {
    match &value.kind {
        PropertyKind::Literal(Literal::Text(text)) => Some(text.trim_matches('"').to_owned()),
        PropertyKind::Path(text) | PropertyKind::Literal(Literal::Int(text)) => Some(text.clone()),
        PropertyKind::Literal(Literal::Bool(value)) => Some(value.to_string()),
        _ => None,
    }
}
