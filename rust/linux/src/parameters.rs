// SPDX-License-Identifier: Apache-2.0
//! Parameters of the main reactor that the command line sets: `--name value`, `--name 10 msec`.

use std::ffi::{CStr, CString};
use std::fmt::Write as _;

use crate::words::{UsageError, interval};

/// A parameter of the main reactor.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// Its type, as the program spells it.
    pub ty: &'static str,
    /// The kind of its values on the command line.
    pub kind: ParameterKind,
    /// Its default in the program.
    pub default: &'static str,
}

/// The kind of a parameter's values on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterKind {
    /// A number and a unit.
    Time,
    /// `true` or `false`.
    Bool,
    /// A whole number.
    Whole,
    /// A number.
    Real,
    /// Any text.
    Text,
    /// A value that the command line cannot have.
    Other,
    /// No value: the number of reactors or ports follows from it.
    FixedWidth,
    /// No value: a time that the compiler has to know follows from it.
    FixedTime,
}

/// The parameters of a program.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    /// The list of parameters.
    pub rows: &'static [Parameter],
    /// Sets one of them, by its position: to a whole number, a number or a text. Returns whether its type has this
    /// value.
    pub give: fn(u16, i64, f64, &'static CStr) -> bool,
}

impl Parameters {
    /// No parameters.
    pub const NONE: Self = Self { rows: &[], give: |_, _, _, _| false };

    /// Returns the position of the parameter with this name.
    pub(crate) fn position(&self, name: &str) -> Option<usize> {
        self.rows.iter().position(|row| row.name == name)
    }

    /// Sets a parameter to the next value on the command line.
    ///
    /// # Errors
    /// The error, as a phrase.
    pub(crate) fn take(&self, position: usize, parser: &mut lexopt::Parser) -> Result<(), UsageError> {
        let Parameter { name, ty, kind, .. } = self.rows[position];
        let wrong = |reason: String| UsageError(format!("--{name}: {reason}"));
        let (mut whole, mut real, mut text) = (0, 0.0, c"");
        let mut given = String::new();
        match kind {
            ParameterKind::FixedWidth | ParameterKind::FixedTime => {
                let what = if kind == ParameterKind::FixedTime {
                    "times of timers, actions, connections or deadlines follow"
                } else {
                    "how many reactors or ports there are follows"
                };
                let message = format!("{what} from it when the program is compiled: change its default there");
                return Err(wrong(message));
            }
            ParameterKind::Other => {
                return Err(wrong(format!("a value of the type `{ty}` cannot be given here: change its default")));
            }
            ParameterKind::Time => {
                whole = interval(parser).map_err(|error| wrong(error.to_string()))?.as_nanos();
            }
            _ => given = parser.value().and_then(lexopt::ValueExt::string).map_err(|error| wrong(error.to_string()))?,
        }
        match kind {
            ParameterKind::Bool => {
                whole = match given.as_str() {
                    "true" | "1" => 1,
                    "false" | "0" => 0,
                    _ => return Err(wrong(format!("\"{given}\" is neither true nor false"))),
                };
            }
            ParameterKind::Whole => {
                whole = given.parse().map_err(|_| wrong(format!("\"{given}\" is no whole number of 64 bits")))?;
            }
            ParameterKind::Real => real = given.parse().map_err(|_| wrong(format!("\"{given}\" is no number")))?,
            ParameterKind::Text => {
                // The program may keep it as long as it likes.
                text = CString::new(given.clone())
                    .map(|text| &*Box::leak(text.into_boxed_c_str()))
                    .map_err(|_| wrong("it has a byte 0".to_owned()))?;
            }
            _ => {}
        }
        let number = u16::try_from(position).map_err(|_| wrong("it has too many before it".to_owned()))?;
        if (self.give)(number, whole, real, text) {
            Ok(())
        } else {
            Err(wrong(format!("{given} is no value of the type `{ty}`")))
        }
    }

    /// Returns the part of `--help` about them.
    pub(crate) fn usage(&self) -> String {
        let mut text = String::new();
        for Parameter { name, ty, kind, default } in self.rows {
            let value = match kind {
                ParameterKind::Time => "TIME UNIT",
                ParameterKind::Bool => "true|false",
                ParameterKind::Whole | ParameterKind::Real => "NUMBER",
                ParameterKind::Text => "TEXT",
                ParameterKind::Other | ParameterKind::FixedWidth | ParameterKind::FixedTime => continue,
            };
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  {:<25} {ty} (default: {default})", format!("--{name} {value}"));
        }
        if text.is_empty() { text } else { format!("\nParameters of the main reactor:\n{text}") }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    static GIVEN: Mutex<Vec<(u16, i64, f64, &CStr)>> = Mutex::new(Vec::new());

    const fn row(name: &'static str, ty: &'static str, kind: ParameterKind) -> Parameter {
        Parameter { name, ty, kind, default: "1" }
    }

    const ALL: Parameters = Parameters {
        rows: &[
            row("t", "interval_t", ParameterKind::Time),
            row("b", "bool", ParameterKind::Bool),
            row("n", "uint8_t", ParameterKind::Whole),
            row("r", "float", ParameterKind::Real),
            row("s", "string", ParameterKind::Text),
            row("o", "pair_t", ParameterKind::Other),
            row("w", "int", ParameterKind::FixedWidth),
        ],
        // Like a type without negative numbers.
        give: |index, whole, real, text| {
            GIVEN.lock().expect("no test panics with it").push((index, whole, real, text));
            whole >= 0
        },
    };

    fn take(line: &[&str]) -> Result<(), String> {
        let mut parser = lexopt::Parser::from_args(line);
        while let Some(argument) = parser.next().map_err(|error| error.to_string())? {
            let lexopt::Arg::Long(name) = argument else { panic!("{argument:?} is left") };
            let position = ALL.position(name).expect("there is such a parameter");
            ALL.take(position, &mut parser).map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    #[test]
    fn values_are_those_of_the_types() {
        let line = ["--t", "10", "msec", "--t=3s", "--b", "true", "--n", "7", "--r", "-1.5", "--s", "a b"];
        assert_eq!(take(&line), Ok(()));
        let given = core::mem::take(&mut *GIVEN.lock().expect("no test panics with it"));
        let expected = [
            (0, 10_000_000, 0.0, c""),
            (0, 3_000_000_000, 0.0, c""),
            (1, 1, 0.0, c""),
            (2, 7, 0.0, c""),
            (3, 0, -1.5, c""),
            (4, 0, 0.0, c"a b"),
        ];
        assert_eq!(given, expected);
        for (line, told) in [
            (&["--b", "maybe"][..], "--b: \"maybe\" is neither true nor false"),
            (&["--n", "1.5"], "--n: \"1.5\" is no whole number of 64 bits"),
            (&["--n", "-1"], "--n: -1 is no value of the type `uint8_t`"),
            (&["--r", "x"], "--r: \"x\" is no number"),
            (&["--o", "x"], "--o: a value of the type `pair_t` cannot be given here: change its default"),
            (
                &["--w", "3"],
                "--w: how many reactors or ports there are follows from it when the program is compiled: change its \
                 default there",
            ),
        ] {
            assert_eq!(take(line), Err(told.to_owned()));
        }
        assert!(take(&["--t", "10", "parsecs"]).is_err_and(|told| told.starts_with("--t: ")));
        assert!(take(&["--n"]).is_err_and(|told| told.starts_with("--n: ")));
        assert_eq!(ALL.usage().lines().count(), 7, "{}", ALL.usage());
    }
}
