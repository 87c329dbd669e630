// SPDX-License-Identifier: Apache-2.0
//! The changes of pins of one federate in a script, for images, which do not read scripts themselves.

use std::fmt;

use lf_model::time::Interval;

use super::line::Value;
use super::script::{Change, Script, ScriptError};

/// An input becomes active or inactive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Move {
    /// The time since the start.
    pub at: Interval,
    /// The input, which the federate has to have.
    pub pin: String,
    /// Its state from then on.
    pub active: bool,
    /// The line of the script.
    pub line: u32,
}

impl fmt::Display for Move {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, pin, active, line } = self;
        write!(f, "{} {pin} {} {line}", at.as_nanos(), u8::from(*active))
    }
}

/// A participant of a federation, and the part of a script that it can use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reader {
    /// The federate.
    pub name: String,
    /// The usable part.
    pub takes: AcceptedMoves,
}

/// The part of a script that a participant can use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AcceptedMoves {
    /// Everything: a program for Linux finds values of all devices, and reports itself what it cannot use.
    All,
    /// Levels of pins: an image on `native_sim`.
    Pins,
    /// Nothing: an image without emulated pins, or on a board of another kind.
    Nothing,
}

/// Checks that each line of a script is valid, that its participant can use it, and that it names the participant if an
/// image is among several.
///
/// # Errors
/// All lines that are not so, and why.
pub fn check(script: &str, readers: &[Reader]) -> Result<(), String> {
    checked(script, readers).map(drop).map_err(|error| error.to_string())
}

fn checked(script: &str, readers: &[Reader]) -> Result<Script, ScriptError> {
    let script = Script::read(script)?;
    let mut lines = refused(&script, readers);
    lines.sort_by_key(|(line, _)| *line);
    if lines.is_empty() { Ok(script) } else { Err(ScriptError { lines }) }
}

/// Returns all changes of pins that a script has for a federate, in order. Without readers, the federate is alone.
///
/// # Errors
/// All lines of the script that are invalid, that none of their participants can use, or that do not name one of
/// several participants although one of them is an image.
pub fn moves(script: &str, federate: &str, readers: &[Reader]) -> Result<Vec<Move>, String> {
    let alone = [Reader { name: federate.to_owned(), takes: AcceptedMoves::Pins }];
    let readers = if readers.is_empty() { &alone } else { readers };
    let script = checked(script, readers).map_err(|error| error.to_string())?;
    let own = format!("{federate}.");
    let mut moves = Vec::new();
    for (name, changes) in &script.devices {
        let (owner, device) = owner_and_device(name);
        let is_for_it = owner.is_none_or(|owner| owner == federate);
        if !is_for_it || (owner.is_none() && script.devices.contains_key(&format!("{own}{name}"))) {
            continue;
        }
        moves.extend(changes.iter().filter_map(|Change { at, value, line }| {
            let active = level(value)?;
            Some(Move { at: *at, pin: device.to_owned(), active, line: *line })
        }));
    }
    moves.sort_by_key(|change| change.at);
    Ok(moves)
}

/// Returns the lines that none of their participants can use, and why.
fn refused(script: &Script, readers: &[Reader]) -> Vec<(u32, String)> {
    let changed = script.devices.iter().flat_map(|(name, changes)| {
        // One line can stand for many changes.
        let mut lines: Vec<_> = changes.iter().map(|it| (it.line, level(&it.value).is_some())).collect();
        lines.sort_unstable();
        lines.dedup();
        lines.into_iter().map(move |(line, is_level)| (line, name, is_level))
    });
    let bound = script.bound.iter().map(|(name, bound)| (bound.line, name, false));
    changed.chain(bound).filter_map(|(line, name, is_level)| Some((line, refusal(name, is_level, readers)?))).collect()
}

/// Returns why no participant can use a value of a device, if that is so.
fn refusal(name: &str, is_level: bool, readers: &[Reader]) -> Option<String> {
    let (owner, device) = owner_and_device(name);
    let meant: Vec<_> = readers.iter().filter(|reader| owner.is_none_or(|owner| reader.name == owner)).collect();
    let is_level = is_level && !device.contains('@') && !is_part(device);
    let takes = |reader: &&Reader| match reader.takes {
        AcceptedMoves::All => true,
        AcceptedMoves::Pins => is_level,
        AcceptedMoves::Nothing => false,
    };
    let able: Vec<_> = meant.iter().copied().filter(takes).collect();
    if let Some(first) = able.first() {
        // A program asks for its devices by name when it runs. What an image lacks becomes known only then, too, so an
        // unknown or ambiguous name would stay undetected.
        let is_clear = able.len() == 1 || able.iter().all(|reader| reader.takes == AcceptedMoves::All);
        return (owner.is_none() && !is_clear).then(|| {
            let names: Vec<_> = able.iter().map(|reader| reader.name.as_str()).collect();
            let (names, first) = (names.join(", "), &first.name);
            format!("{device}: {names} can take this, and an image is among them; say who: {first}.{device}")
        });
    }
    let who = match (owner, &meant[..]) {
        (Some(owner), []) => return Some(format!("there is no federate {owner}")),
        (_, [one]) => format!("{} is an image, which finds", one.name),
        _ => "all participants are images, which find".to_owned(),
    };
    Some(if meant.iter().any(|reader| reader.takes == AcceptedMoves::Pins) {
        format!("{device}: {who} levels of pins, 0 or 1, and nothing else; a program for Linux finds it")
    } else {
        format!("{device}: {who} nothing of a script: only images on native_sim with emulated pins do")
    })
}

/// Returns whether a name in brackets is not a number within the device's own name, as in `keys[1]`.
fn is_part(device: &str) -> bool {
    let inside = device.split_once('[').and_then(|(_, rest)| rest.strip_suffix(']'));
    inside.is_some_and(|name| name.parse::<u8>().is_err())
}

/// Splits the name in a line into the federate, if there is one, and its device.
fn owner_and_device(name: &str) -> (Option<&str>, &str) {
    name.split_once('.').map_or((None, name), |(owner, device)| (Some(owner), device))
}

fn level(value: &Value) -> Option<bool> {
    match value {
        Value::Number(0.0) => Some(false),
        Value::Number(1.0) => Some(true),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn readers(takes: &[(&str, AcceptedMoves)]) -> Vec<Reader> {
        takes.iter().map(|(name, takes)| Reader { name: (*name).to_owned(), takes: *takes }).collect()
    }

    #[test]
    fn moves_are_in_order_and_those_of_others_are_left_out() {
        let script =
            "2 ms b.sw0 1 every 2 ms until 4 ms\n3 ms b.sw0 0\n1 ms b.sw1 1\n1 ms a.sw1 1\n5 ms line \"text\"\n";
        let readers = readers(&[("a", AcceptedMoves::Pins), ("b", AcceptedMoves::Pins), ("c", AcceptedMoves::All)]);
        let told = |federate: &str| {
            let moves = moves(script, federate, &readers).expect("it makes sense");
            moves.iter().map(Move::to_string).collect::<Vec<_>>()
        };
        assert_eq!(told("b"), ["1000000 sw1 1 3", "2000000 sw0 1 1", "3000000 sw0 0 2", "4000000 sw0 1 1"]);
        assert_eq!(told("a"), ["1000000 sw1 1 4"]);
        assert_eq!(
            moves("1 ms", "a", &readers).err(),
            Some("line 1: after the time comes the name of a device, and its value".to_owned())
        );
    }

    /// A pin without a federate belongs to the one participant that can have it, whatever kinds there are.
    #[test]
    fn a_pin_that_may_be_of_an_image_or_of_another_participant_has_to_say_whose_it_is() {
        let kinds = [AcceptedMoves::All, AcceptedMoves::Pins, AcceptedMoves::Nothing];
        for (a, b, c) in kinds.iter().flat_map(|a| kinds.iter().flat_map(move |b| kinds.map(|c| (*a, *b, c)))) {
            let readers = readers(&[("a", a), ("b", b), ("c", c)]);
            let takes: Vec<_> = readers.iter().filter(|reader| reader.takes != AcceptedMoves::Nothing).collect();
            let images = takes.iter().filter(|reader| reader.takes == AcceptedMoves::Pins).count();
            let result = check("1 ms sw0 1", &readers);
            assert_eq!(
                result.is_ok(),
                takes.len() == 1 || (images == 0 && !takes.is_empty()),
                "{readers:?}: {result:?}"
            );
            for reader in takes {
                let own = moves(&format!("1 ms {}.sw0 1", reader.name), &reader.name, &readers);
                assert!(own.is_ok_and(|moves| moves[0].to_string() == "1000000 sw0 1 1"), "{readers:?}");
                assert!(check("1 ms sw0 1", std::slice::from_ref(reader)).is_ok());
            }
        }
        let error = check("1 ms x 1\n1 ms sw0 1", &readers(&[("a", AcceptedMoves::All), ("b", AcceptedMoves::Pins)]));
        let says = error.expect_err("nobody knows whose pins these are");
        assert!(
            says.ends_with("line 2: sw0: a, b can take this, and an image is among them; say who: a.sw0"),
            "{says}"
        );
    }

    /// For every kind of device, a participant uses a line, or the line is refused with its number.
    #[test]
    fn a_line_that_nobody_can_carry_out_is_an_error_that_names_it() {
        let text = "0 s t@48[0x00] 0x1980\n0 s t[ambient_temp] 1\n0 s adc0 1500\n0 s uart \"x\"\n0 s b.sw0 1\n\
                    led0 gpio /dev/gpiochip0 17\n0 s sw0 1\n0 s keys[1] 1\n0 s x.sw0 1\n";
        let lines = |takes: &[(&str, AcceptedMoves)]| {
            let refused = moves(text, "a", &readers(takes)).expect_err("some are refused");
            let number = |line: &str| line.strip_prefix("line ")?.split(':').next()?.parse::<u32>().ok();
            refused.lines().filter_map(number).collect::<Vec<_>>()
        };
        assert_eq!(lines(&[("a", AcceptedMoves::Pins), ("b", AcceptedMoves::Nothing)]), [1, 2, 3, 4, 5, 6, 9]);
        assert_eq!(lines(&[("a", AcceptedMoves::Nothing), ("b", AcceptedMoves::Nothing)]), [1, 2, 3, 4, 5, 6, 7, 8, 9]);
        assert_eq!(lines(&[("a", AcceptedMoves::Pins), ("b", AcceptedMoves::All)]), [7, 8, 9]);
        let error =
            moves("\n0 s t[0x00] 7", "a", &readers(&[("a", AcceptedMoves::Pins)])).expect_err("it has no registers");
        assert!(error.starts_with("line 2: t[0x00]: a is an image, which finds levels of pins"), "{error}");
    }
}
