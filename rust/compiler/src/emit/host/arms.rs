// SPDX-License-Identifier: Apache-2.0
//! Arms of a `match` over numbers, and cases of a `switch`: those that differ only in numbers that grow with theirs
//! become one.

/// An arm: `ReactionId(5) => self.workers[2].reaction_1(ctx)`.
struct Arm<'a> {
    number: usize,
    /// The pieces of its text, between the numbers in it that may differ from those of others.
    pieces: Vec<&'a str>,
    numbers: Vec<usize>,
}

/// The texts before numbers that may differ, with the type of these. Lists of reactions are constants.
const BEFORE: [(&str, &str); 4] =
    [("[", "usize"), ("PortId(", "u16"), ("TriggerId(", "u16"), ("(self, ReactionId(", "u16")];

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

    /// Returns the text of an arm that stands for this and those to `last`.
    fn merged(&self, last: usize, steps: &[usize], syntax: ArmSyntax) -> String {
        let mut call = String::new();
        for ((piece, number), step) in self.pieces[1..].iter().zip(&self.numbers).zip(steps) {
            call += piece;
            let (_, ty) = BEFORE.iter().find(|(before, _)| piece.ends_with(before)).unwrap_or(&BEFORE[0]);
            call += &match step {
                0 => number.to_string(),
                step => syntax.grown(self.number, ty, *step, *number),
            };
        }
        call += self.pieces.last().unwrap_or(&"");
        let (name, pattern) = (self.pieces[0], syntax.pattern(self.number, last, steps.iter().any(|step| *step > 0)));
        if name.is_empty() { format!("{pattern} => {call}") } else { format!("{name}{pattern}) => {call}") }
    }
}

/// The syntax of the arms.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ArmSyntax {
    /// The number of an arm that stands for several is bound as `id`.
    Rust,
    /// It is a parameter, `id`.
    C,
}

impl ArmSyntax {
    fn pattern(self, first: usize, last: usize, uses_id: bool) -> String {
        match self {
            Self::Rust if uses_id => format!("id @ {first}..={last}"),
            Self::Rust => format!("{first}..={last}"),
            Self::C => format!("{first} ... {last}"),
        }
    }

    /// Returns the expression of a number that is `number` in the first arm, and grows by `step`.
    fn grown(self, first: usize, ty: &str, step: usize, number: usize) -> String {
        if step == 1 && number == first && (self == Self::C || ty != "usize") {
            return "id".to_owned();
        }
        let from = if first == 0 { "id".to_owned() } else { format!("id - {first}") };
        let distance = match self {
            Self::Rust if ty == "usize" => format!("usize::from({from})"),
            _ if first == 0 => from,
            _ => format!("({from})"),
        };
        let product = if step == 1 { distance } else { format!("{distance} * {step}") };
        if number == 0 { product } else { format!("{product} + {number}") }
    }
}

/// Returns the arms with as few as possible of them; the pattern of each is a number, or has one in parentheses.
pub(super) fn merge(texts: &[String]) -> Vec<String> {
    merge_in(ArmSyntax::Rust, texts)
}

/// Returns the cases of a `switch` over `id` that make these calls, with as few as possible of them:
/// `case 3 ... 5: call(ports[id]); break;`
pub(in crate::emit) fn merge_cases(calls: &[(usize, String)]) -> Vec<String> {
    let arms: Vec<_> = calls.iter().map(|(id, call)| format!("{id} => {call}")).collect();
    let case = |arm: &String| format!("    case {};\n        break;", arm.replacen(" => ", ":\n        ", 1));
    merge_in(ArmSyntax::C, &arms).iter().map(case).collect()
}

fn merge_in(syntax: ArmSyntax, texts: &[String]) -> Vec<String> {
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
        merged.push(first.merged(first.number + last - at, &common, syntax));
        at = last + 1;
    }
    merged
}

/// Returns the arms that make these calls, each for a reaction. Neighbors that may run in turn have one arm, which goes
/// on with those that are ready.
pub(super) fn arms_in_turn(calls: &[(usize, String)], may: impl Fn(usize) -> bool) -> Vec<String> {
    let runs = calls.chunk_by(|(one, _), (next, _)| *next == one + 1 && may(*one) && may(*next));
    let arm = |run: &[(usize, String)]| {
        let each: Vec<_> = run.iter().map(reaction_arm).collect();
        let ([(first, _), .., (last, _)], merged) = (run, merge(&each)) else { return each };
        let arms: String = merged.iter().flat_map(|arm| ["                ", arm, ",\n"]).collect();
        vec![format!(
            "ReactionId(first @ {first}..={last}) => ctx.in_turn(first, {last}, |ctx, id| match id {{\n{arms}\
             \x20               _ => {{}}\n            }})"
        )]
    };
    runs.flat_map(arm).collect()
}

/// Returns the arm that makes a call for a reaction.
pub(super) fn reaction_arm((id, call): &(usize, String)) -> String {
    format!("ReactionId({id}) => {call}")
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
    fn reactions_run_in_turn_if_they_may() {
        let calls: Vec<_> = (0..5).map(|id| (id, format!("c::react(self, ReactionId({id}), ctx)"))).collect();
        let in_turn = "ReactionId(first @ 0..=1) => ctx.in_turn(first, 1, |ctx, id| match id {\n                \
                       ReactionId(id @ 0..=1) => c::react(self, ReactionId(id), ctx),\n                \
                       _ => {}\n            })";
        let others = [2, 3, 4].map(|id| reaction_arm(&calls[id]));
        let arms = arms_in_turn(&calls, |id| id < 2);
        assert_eq!(arms[0], in_turn);
        assert_eq!(arms[1..], others);
    }

    #[test]
    fn ids_of_ports_grow_too_and_other_texts_are_as_they_are() {
        let arms =
            ["0 => c::copy(ctx, c::Port::new(PortId(2)))", "1 => c::copy(ctx, c::Port::new(PortId(3)))", "_ => {}"];
        assert_eq!(merged(&arms), ["id @ 0..=1 => c::copy(ctx, c::Port::new(PortId(id + 2)))", "_ => {}"]);
        let others =
            ["ModeId(1) => self.a.reset_1()", "ModeId(2) => self.a.reset_2()", "ModeId(4) => self.a.reset_2()"];
        assert_eq!(merged(&others), others);
        let calls = [(2, "react(selfs[5], ports[2])"), (3, "react(selfs[6], ports[4])"), (4, "stop(selfs[7])")];
        let calls = calls.map(|(id, call)| (id, call.to_owned()));
        let case = |ids: &str, call: &str| format!("    case {ids}:\n        {call};\n        break;");
        let one = case("2 ... 3", "react(selfs[(id - 2) + 5], ports[(id - 2) * 2 + 2])");
        assert_eq!(merge_cases(&calls), [one, case("4", &calls[2].1)]);
        let lists = ["2 => share(&[ReactionId(2), ReactionId(3)])", "3 => share(&[ReactionId(3), ReactionId(4)])"];
        assert_eq!(merged(&lists), lists);
        let falling = ["PortId(1) => self.a[2].clear()", "PortId(2) => self.a[1].clear()"];
        assert_eq!(merged(&falling), falling);
    }
}
