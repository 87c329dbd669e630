// SPDX-License-Identifier: Apache-2.0
//! Integers that are known at compile time.

use crate::languages::integer::operation;
use crate::lexical::Language;

/// Returns the value of an expression of integers and parameters, which can be written as members of `self`; `None` for
/// any other one.
pub(super) fn value(code: &str, parameter: &dyn Fn(&str) -> Option<i64>) -> Option<i64> {
    let mut reader = IntegerParser { words: words(code), parameter };
    reader.words.reverse();
    let value = reader.sum(0)?;
    reader.words.is_empty().then_some(value)
}

/// Splits code into names, numbers and marks.
fn words(code: &str) -> Vec<&str> {
    let is_comment = |piece: &str| piece.starts_with("//") || piece.starts_with("/*");
    Language::C.pieces(code).filter(|piece| !is_comment(piece) && !piece.trim().is_empty()).collect()
}

struct IntegerParser<'a> {
    /// The remaining words in reverse order.
    words: Vec<&'a str>,
    parameter: &'a dyn Fn(&str) -> Option<i64>,
}

/// The binary operators, those of the lowest precedence first.
const OPERATORS: [&[&str]; 3] = [&["<<", ">>"], &["+", "-"], &["*", "/", "%"]];

/// The maximum nesting of operators and brackets.
const DEPTH_MAX: usize = 64;

impl IntegerParser<'_> {
    /// Evaluates the words between brackets, or all.
    fn sum(&mut self, depth: usize) -> Option<i64> {
        if depth > DEPTH_MAX { None } else { self.operands(0, depth) }
    }

    fn operands(&mut self, binding: usize, depth: usize) -> Option<i64> {
        let Some(operators) = OPERATORS.get(binding) else { return self.operand(depth) };
        let mut value = self.operands(binding + 1, depth)?;
        while let Some(operator) = operators.iter().find(|operator| self.eat(operator)) {
            let other = self.operands(binding + 1, depth)?;
            value = operation(operator, value, other)?;
        }
        Some(value)
    }

    fn operand(&mut self, depth: usize) -> Option<i64> {
        let next = self.words.pop()?;
        match next {
            "-" if depth < DEPTH_MAX => self.operand(depth + 1)?.checked_neg(),
            "(" if super::types::literals(self.words.last()?).is_some() => {
                // A conversion does not change a number that fits.
                while self.words.pop()? != ")" {}
                if depth < DEPTH_MAX { self.operand(depth + 1) } else { None }
            }
            "(" => {
                let value = self.sum(depth + 1)?;
                self.eat(")").then_some(value)
            }
            "self" if self.eat("->") => (self.parameter)(self.words.pop()?),
            _ if next.starts_with(|first: char| first.is_ascii_digit()) => number(next),
            _ if self.words.last() == Some(&"(") => None,
            _ => (self.parameter)(next),
        }
    }

    /// Takes a mark of one or two characters.
    fn eat(&mut self, mark: &str) -> bool {
        let next = self.words.iter().rev().take(mark.len()).copied();
        let found = next.eq(mark.split("").filter(|part| !part.is_empty()));
        if found {
            self.words.truncate(self.words.len() - mark.len());
        }
        found
    }
}

/// Returns a number with or without suffix, decimal, octal, binary or hexadecimal.
fn number(text: &str) -> Option<i64> {
    let plain = text.replace('\'', "").to_ascii_lowercase();
    let (digits, radix) = match plain.as_bytes() {
        [b'0', b'x', ..] => (&plain[2..], 16),
        [b'0', b'b', ..] => (&plain[2..], 2),
        [b'0', _, ..] => (&plain[1..], 8),
        _ => (&plain[..], 10),
    };
    i64::from_str_radix(digits.trim_end_matches(['u', 'l']), radix).ok()
}

#[cfg(test)]
mod tests {
    use super::value;

    #[test]
    fn arithmetic_of_parameters_is_worked_out_and_nothing_else() {
        let parameter = |name: &str| (name == "n").then_some(4);
        for (code, expected) in [
            (" 3 ", Some(3)),
            ("n * 2 + 1", Some(9)),
            ("self->n - 1 - 1", Some(2)),
            ("((int) n - 1) % 2 /* odd */", Some(1)),
            ("1u << n", Some(16)),
            ("0x10 + 010 + 0b11", Some(27)),
            ("-n", Some(-4)),
            ("n / 0", None),
            ("f(n)", None),
            ("n +", None),
            ("n 1", None),
            ("1.5", None),
            ("9223372036854775807 + n", None),
        ] {
            assert_eq!(value(code, &parameter), expected, "{code}");
        }
    }
}
