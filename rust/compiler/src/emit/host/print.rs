// SPDX-License-Identifier: Apache-2.0
//! Prints constant expressions: structs without default fields, times, numbers.

use core::fmt::Display;

use lf_model::time::Interval;

/// An expression for a struct: the fields that differ from its default, on one line.
pub(super) struct Fields {
    ty: &'static str,
    /// The name of the struct's default.
    default: &'static str,
    written: Vec<String>,
    omits: bool,
}

impl Fields {
    pub(super) fn of(ty: &'static str) -> Self {
        Self::with_default(ty, "DEFAULT")
    }

    /// Returns an expression whose default has another name.
    pub(super) fn with_default(ty: &'static str, default: &'static str) -> Self {
        Self { ty, default, written: Vec::new(), omits: false }
    }

    /// Adds a field.
    pub(super) fn set(&mut self, name: &str, value: impl Display) -> &mut Self {
        self.written.push(format!("{name}: {value}"));
        self
    }

    /// Adds a field that differs from the default.
    pub(super) fn set_if(&mut self, wanted: bool, name: &str, value: impl Display) -> &mut Self {
        if wanted {
            return self.set(name, value);
        }
        self.omits = true;
        self
    }

    /// Returns the expression on one line.
    pub(super) fn row(&self) -> String {
        let rest = if self.omits { format!(", ..{}::{}", self.ty, self.default) } else { String::new() };
        format!("{} {{ {}{rest} }}", self.ty, self.written.join(", "))
    }

    /// Returns the expression with a field per line.
    pub(super) fn block(&self) -> String {
        let mut text = format!("{} {{\n", self.ty);
        for field in &self.written {
            text = text + "    " + field + ",\n";
        }
        if self.omits {
            text = text + "    .." + self.ty + "::" + self.default + "\n";
        }
        text + "}"
    }
}

/// Returns an interval as a constant expression, in the largest unit that divides it.
pub(in crate::emit) fn interval(interval: Interval) -> String {
    const UNITS: [(i64, &str); 3] = [(1_000_000_000, "secs"), (1_000_000, "millis"), (1_000, "micros")];
    match interval.as_nanos() {
        0 => "Interval::ZERO".to_owned(),
        i64::MAX => "Interval::FOREVER".to_owned(),
        ns => {
            let (length, unit) = UNITS.into_iter().find(|(length, _)| ns % length == 0).unwrap_or((1, "nanos"));
            format!("Interval::from_{unit}({})", grouped(ns / length))
        }
    }
}

/// Returns an integer with its digits in groups of three, if there are more than four.
pub(super) fn grouped(number: i64) -> String {
    let digits = number.unsigned_abs().to_string();
    let mut text = String::from(if number < 0 { "-" } else { "" });
    for (index, digit) in digits.chars().enumerate() {
        if digits.len() > 4 && index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('_');
        }
        text.push(digit);
    }
    text
}

/// Returns an interval that may be missing, as an expression.
pub(super) fn optional(value: Option<Interval>) -> String {
    value.map_or_else(|| "None".to_owned(), |value| format!("Some({})", interval(value)))
}

/// Returns nanoseconds that may be missing, as an expression.
pub(super) fn optional_ns(ns: Option<i64>) -> String {
    optional(ns.map(Interval::from_nanos))
}
