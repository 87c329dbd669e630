// SPDX-License-Identifier: Apache-2.0
//! Arms of a `match` over numbers: those that differ only in numbers that grow with theirs become one.

use std::ops::RangeInclusive;

/// An arm: `ReactionId(5) => self.workers[2].reaction_1(ctx)`.
struct Arm<'a> {
    number: usize,
    /// The pieces of its text, between the numbers in it that may differ from those of others.
    pieces: Vec<&'a str>,
    numbers: Vec<usize>,
}

/// The texts before numbers that may differ, with the type of these.
const BEFORE: [(&str, &str); 3] = [("[", "usize"), ("PortId(", "u16"), ("TriggerId(", "u16")];

impl<'a> Arm<'a> {
    fn of(text: &'a str) -> Option<Self> {
        let (before, after) = text.split_once(" => ")?;
        let digits = before.trim_end_matches(')').rsplit('(').next()?;
        let name = before.len() - before.trim_end_matches(')').len() + digits.len();
        let mut arm =
            Arm { number: digits.parse().ok()?, pieces: vec![&before[..before.len() - name]], numbers: vec![] };
        let (mut begin, mut at) = (0, 0);
        while let Some(found) = after[at..].find(['[', '(']) {
            at += found + 1;
            let end = after[at..].find(|c: char| !c.is_ascii_digit()).map_or(after.len(), |end| at + end);
            if BEFORE.iter().any(|(before, _)| after[..at].ends_with(before))
                && after[end..].starts_with([']', ')'])
                && let Ok(number) = after[at..end].parse()
            {
                arm.pieces.push(&after[begin..at]);
                arm.numbers.push(number);
                begin = end;
            }
        }
        arm.pieces.push(&after[begin..]);
        Some(arm)
    }

    /// Returns by how much the numbers of the next arm are larger, if it can be one with this.
    fn steps_to(&self, next: &Self) -> Option<Vec<usize>> {
        let is_next = next.number == self.number + 1 && next.pieces == self.pieces;
        let pairs = || self.numbers.iter().zip(&next.numbers);
        is_next.then(|| pairs().map(|(one, other)| other.checked_sub(*one)).collect())?
    }

    /// Returns the text of an arm that stands for several.
    fn merged(&self, numbers: RangeInclusive<usize>, steps: &[usize]) -> String {
        let binds = if steps.iter().any(|step| *step > 0) { "id @ " } else { "" };
        let pattern = format!("{binds}{}..={}", numbers.start(), numbers.end());
        let name = self.pieces[0];
        let mut text = if name.is_empty() { pattern } else { format!("{name}{pattern})") } + " => ";
        let from = if self.number == 0 { "id".to_owned() } else { format!("id - {}", self.number) };
        for ((piece, number), step) in self.pieces[1..].iter().zip(&self.numbers).zip(steps) {
            text += piece;
            let (_, ty) = BEFORE.iter().find(|(before, _)| piece.ends_with(before)).unwrap_or(&BEFORE[0]);
            text += &match (step, *ty) {
                (0, _) => number.to_string(),
                (_, "usize") => grown(&format!("usize::from({from})"), *step, *number),
                _ if self.number == 0 => grown("id", *step, *number),
                _ => grown(&format!("({from})"), *step, *number),
            };
        }
        text + self.pieces.last().unwrap_or(&"")
    }
}

fn grown(distance: &str, step: usize, first: usize) -> String {
    let product = if step == 1 { distance.to_owned() } else { format!("{distance} * {step}") };
    if first == 0 { product } else { format!("{product} + {first}") }
}

/// Returns the arms with as few as possible of them; the pattern of each is a number, or has one in parentheses.
pub(super) fn merge(texts: &[String]) -> Vec<String> {
    let arms: Vec<_> = texts.iter().map(|text| Arm::of(text)).collect();
    let (mut merged, mut at) = (Vec::new(), 0);
    while at < arms.len() {
        let steps = |one: usize| arms[one].as_ref().zip(arms.get(one + 1)?.as_ref()).and_then(|(a, b)| a.steps_to(b));
        let Some((first, common)) = arms[at].as_ref().zip(steps(at)) else {
            merged.push(texts[at].clone());
            at += 1;
            continue;
        };
        let mut last = at + 1;
        while steps(last).as_ref() == Some(&common) {
            last += 1;
        }
        merged.push(first.merged(first.number..=first.number + last - at, &common));
        at = last + 1;
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merged(texts: &[&str]) -> Vec<String> {
        merge(&texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn arms_whose_numbers_grow_with_theirs_become_one() {
        let arms = [
            "ReactionId(0) => self.a.reaction_1(ctx)",
            "ReactionId(3) => self.w[0].reaction_1(ctx, &self.x, &mut self.y[5][0])",
            "ReactionId(4) => self.w[1].reaction_1(ctx, &self.x, &mut self.y[7][0])",
            "ReactionId(5) => self.w[2].reaction_1(ctx, &self.x, &mut self.y[9][0])",
            "ReactionId(6) => self.w[3].reaction_1(ctx, &self.x, &mut self.y[9][0])",
        ];
        let one = "ReactionId(id @ 3..=5) => self.w[usize::from(id - 3)].reaction_1(ctx, &self.x, \
                   &mut self.y[usize::from(id - 3) * 2 + 5][0])";
        assert_eq!(merged(&arms), [arms[0], one, arms[4]]);
    }

    #[test]
    fn ids_of_ports_grow_too_and_other_texts_are_as_they_are() {
        let arms =
            ["0 => c::copy(ctx, c::Port::new(PortId(2)))", "1 => c::copy(ctx, c::Port::new(PortId(3)))", "_ => {}"];
        assert_eq!(merged(&arms), ["id @ 0..=1 => c::copy(ctx, c::Port::new(PortId(id + 2)))", "_ => {}"]);
        let others =
            ["ModeId(1) => self.a.reset_1()", "ModeId(2) => self.a.reset_2()", "ModeId(4) => self.a.reset_2()"];
        assert_eq!(merged(&others), others);
        let falling = ["PortId(1) => self.a[2].clear()", "PortId(2) => self.a[1].clear()"];
        assert_eq!(merged(&falling), falling);
    }
}
