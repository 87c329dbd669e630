// SPDX-License-Identifier: Apache-2.0
//! What a script does to pins of one federate, for images, which do not read scripts themselves.

use std::fmt;

use lf_model::time::Interval;

use super::line::Value;
use super::script::Script;

/// An input becomes active, or is no more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Move {
    /// Since the start.
    pub at: Interval,
    /// Whether the script means this federate alone.
    pub is_own: bool,
    /// The input.
    pub pin: String,
    /// What it is from then on.
    pub active: bool,
}

impl fmt::Display for Move {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, is_own, pin, active } = self;
        let whose = if *is_own { "own" } else { "any" };
        write!(f, "{} {whose} {pin} {}", at.as_nanos(), u8::from(*active))
    }
}

/// All moves of pins that a script has for a federate, in order, and the devices in it that are no pins.
///
/// # Errors
/// The first line of the script that makes no sense.
pub fn moves(script: &str, federate: &str) -> Result<(Vec<Move>, Vec<String>), String> {
    let script = Script::read(script).map_err(|error| error.to_string())?;
    let own = format!("{federate}.");
    let (mut moves, mut others) = (Vec::new(), script.bound.keys().cloned().collect::<Vec<_>>());
    for (name, changes) in &script.devices {
        let pin = name.strip_prefix(&own);
        if pin.is_none() && script.devices.contains_key(&format!("{own}{name}")) {
            continue;
        }
        let level = |value: &Value| match value {
            Value::Number(0.0) => Some(false),
            Value::Number(1.0) => Some(true),
            _ => None,
        };
        let levels: Option<Vec<_>> =
            changes.iter().map(|change| level(&change.value).map(|level| (change.at, level))).collect();
        let Some(levels) = levels else {
            others.push(name.clone());
            continue;
        };
        let is_own = pin.is_some();
        let pin = pin.unwrap_or(name);
        moves.extend(levels.into_iter().map(|(at, active)| Move { at, is_own, pin: pin.to_owned(), active }));
    }
    moves.sort_by_key(|change| change.at);
    Ok((moves, others))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_are_in_order_and_those_for_one_federate_count_first() {
        let script = "2 ms sw0 1 every 2 ms until 4 ms\n3 ms sw0 0\n1 ms b.sw1 1\n1 ms sw1 1\n5 ms line \"text\"\n";
        let told = |federate: &str| {
            let (moves, others) = moves(script, federate).expect("it makes sense");
            assert_eq!(others, ["line"]);
            moves.iter().map(Move::to_string).collect::<Vec<_>>()
        };
        let sw0 = ["2000000 any sw0 1", "3000000 any sw0 0", "4000000 any sw0 1"];
        assert_eq!(told("b"), [&["1000000 own sw1 1"], &sw0[..]].concat());
        assert_eq!(told("a"), [&["1000000 any b.sw1 1", "1000000 any sw1 1"], &sw0[..]].concat());
        assert_eq!(
            moves("1 ms", "a").err(),
            Some("line 1: after the time comes the name of a device, and its value".to_owned())
        );
    }
}
