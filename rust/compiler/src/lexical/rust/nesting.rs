// SPDX-License-Identifier: Apache-2.0
//! Limits the nesting of code before a recursive parser runs.
//!
//! A parser of Rust takes stack for each bracket, for each word or operator in front of an operand, for each list of
//! types and each closure; and dropping its result takes stack for each link of a chain such as `a + b + c` or
//! `a.b().c()`. This module counts all of them in one pass. The count is never less than the number of open levels at a
//! place; where it is more, it is far from the limit for code that people write.

use super::code_block::skip;
use crate::lexical::CodeProblem;
use crate::lexical::blocks::{BRACKETS_MAX, is_word};

/// The maximum number of open levels at a place: this number of recursions of a parser, or [`DEEP`] times as many links
/// of chains. A thread's usual stack of 2 MiB suffices for it without optimization.
const OPEN_MAX: usize = BRACKETS_MAX * DEEP;

/// The number of links of a chain that take as much stack as one level of a parser.
const DEEP: usize = 8;

/// Words in front of operands, types and patterns.
const PREFIXES: [&str; 27] = [
    "as", "async", "await", "break", "const", "continue", "dyn", "else", "extern", "fn", "for", "if", "impl", "in",
    "let", "loop", "match", "move", "mut", "raw", "ref", "return", "static", "unsafe", "where", "while", "yield",
];

/// The open levels within a pair of brackets, up to the next comma and the next semicolon.
#[derive(Default)]
struct Level {
    /// The levels that end with a comma.
    to_comma: usize,
    /// The levels that end with a semicolon: lists of types, and parameters of closures, have commas of their own.
    to_semicolon: usize,
}

impl Level {
    fn sum(&self) -> usize {
        self.to_comma + self.to_semicolon
    }
}

/// Returns the problem of code that is nested too deeply. Its brackets have counterparts.
pub(super) fn problem(text: &str) -> Option<CodeProblem> {
    let bytes = text.as_bytes();
    let mut outer: Vec<Level> = Vec::new();
    let (mut level, mut outer_sum) = (Level::default(), 0);
    // Whether an operand precedes the place, so that an operator is a binary one; the token before the place, and
    // whether it can be the first half of such an operator.
    let (mut behind_operand, mut before, mut is_half) = (false, "", false);
    let mut at = 0;
    while at < bytes.len() {
        let end = skip(text, at);
        let token = &text[at..end];
        if bytes[at].is_ascii_whitespace() || token.starts_with("//") || token.starts_with("/*") {
            at = end;
            continue;
        }
        let is_chained = |sign: u8| bytes.get(end) == Some(&sign) || (at > 0 && bytes[at - 1] == sign);
        let (mut deep, mut operand) = (false, false);
        match bytes[at] {
            b'(' | b'[' | b'{' => {
                level.to_comma += DEEP;
                outer_sum += level.sum();
                outer.push(std::mem::take(&mut level));
            }
            b')' | b']' | b'}' => {
                level = outer.pop().unwrap_or_default();
                outer_sum -= level.sum().min(outer_sum);
                level.to_comma -= (DEEP - 1).min(level.to_comma);
                operand = true;
            }
            b';' => level = Level::default(),
            b',' => level.to_comma = 0,
            // Behind the arrow of a match an expression begins, and the pattern before it has ended.
            b'>' if before == "=" => level = Level::default(),
            b'>' if before == "-" => deep = true,
            b'>' => {
                level.to_semicolon = level.to_semicolon.saturating_sub(DEEP);
                operand = true;
            }
            b'<' => level.to_semicolon += DEEP,
            b'|' if !(behind_operand || is_half && is_chained(b'|')) => level.to_semicolon += DEEP,
            b'=' => deep = !is_chained(b'=') && !matches!(before, "<" | ">" | "!") && bytes.get(end) != Some(&b'>'),
            b'!' | b'-' | b'*' | b'&' | b'.' | b'+' | b'/' | b'%' | b'^' | b'|' | b'?' | b':' => {
                deep = !behind_operand && bytes[at] != b':' && !(is_half && is_chained(bytes[at]));
                operand = bytes[at] == b'?';
            }
            b'@' => deep = true,
            b'#' if before == "}" => level = Level::default(),
            first if is_word(first) => {
                let is_prefix = PREFIXES.contains(&token) && before != ".";
                // A word behind a block begins another statement or item.
                if before == "}" && !matches!(token, "else" | "as") {
                    level = Level::default();
                }
                deep = is_prefix && token != "else" && before != "else";
                operand = !is_prefix;
            }
            _ => operand = true,
        }
        level.to_comma += if deep { DEEP } else { usize::from(!matches!(bytes[at], b',' | b';')) };
        if outer.len() > BRACKETS_MAX || outer_sum + level.sum() > OPEN_MAX {
            return Some(CodeProblem::too_deep(at..end));
        }
        is_half = behind_operand && matches!(bytes[at], b'|' | b'&');
        (behind_operand, before, at) = (operand, token, end);
    }
    None
}
