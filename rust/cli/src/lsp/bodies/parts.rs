// SPDX-License-Identifier: Apache-2.0
//! Parts of generated lines that are text of the program.
//!
//! For Rust the compiler lists them. In C `#line` directives map whole lines, and generated code may begin such a line
//! where the program's begins: what is equal in the same columns of both is the program's.

use std::collections::BTreeMap;
use std::path::Path;

use lf_compiler::emit::VerbatimPart;

/// A part of a line in both files. Lines and columns count from 1, in characters.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct CodePart {
    pub(super) generated: String,
    pub(super) line: usize,
    pub(super) column: usize,
    pub(super) len: usize,
    pub(super) lf: String,
    pub(super) lf_line: usize,
    pub(super) lf_column: usize,
}

impl CodePart {
    /// Returns whether a column of the LF line is in it, or directly behind it.
    pub(super) fn holds_lf(&self, column: usize) -> bool {
        (self.lf_column..=self.lf_column + self.len).contains(&column)
    }

    /// Returns whether a column of the generated line is in it, or directly behind it.
    pub(super) fn holds_generated(&self, column: usize) -> bool {
        (self.column..=self.column + self.len).contains(&column)
    }
}

impl From<VerbatimPart<'_>> for CodePart {
    fn from(VerbatimPart { generated, line, column, len, lf, lf_line, lf_column }: VerbatimPart<'_>) -> Self {
        Self { generated: generated.to_owned(), line, column, len, lf: lf.to_owned(), lf_line, lf_column }
    }
}

/// Returns the parts of a generated file of C or C++; other files have none.
pub(super) fn parts_of_c(path: &str, text: &str, lf_texts: &BTreeMap<String, String>) -> Vec<CodePart> {
    let is_c = Path::new(path).extension().is_some_and(|ending| ["c", "h", "cpp"].iter().any(|one| ending == *one));
    if !is_c {
        return Vec::new();
    }
    let named: BTreeMap<String, (&String, Vec<&str>)> =
        lf_texts.iter().map(|(path, text)| (format!("{path:?}"), (path, text.split('\n').collect()))).collect();
    let mut parts = Vec::new();
    let mut from = None;
    for (index, line) in text.split('\n').enumerate() {
        if let Some((number, name)) = line.strip_prefix("#line ").and_then(|rest| rest.split_once(' ')) {
            from = named.get(name).zip(number.parse::<usize>().ok());
            continue;
        }
        let Some(((lf, lines), lf_line)) = from.as_mut() else { continue };
        let there = lines.get(lf_line.saturating_sub(1)).copied().unwrap_or_default();
        if let Some((column, len)) = equal(line, there) {
            let (generated, lf, lf_line) = (path.to_owned(), (*lf).clone(), *lf_line);
            parts.push(CodePart { generated, line: index + 1, column, len, lf, lf_line, lf_column: column });
        }
        *lf_line += 1;
    }
    parts
}

/// Returns the column from which on two lines are equal, and for how many characters. Blanks before that column stand
/// for what the program has there.
fn equal(generated: &str, lf: &str) -> Option<(usize, usize)> {
    if generated == lf {
        return Some((1, lf.chars().count()));
    }
    let blanks = generated.chars().take_while(|character| character.is_whitespace()).count();
    let (own, there) = (generated.chars().skip(blanks), lf.chars().skip(blanks));
    let len = own.zip(there).take_while(|(own, there)| own == there).count();
    (len > 0).then_some((blanks + 1, len))
}

#[cfg(test)]
mod tests {
    use super::equal;

    #[test]
    fn only_what_is_equal_in_the_same_columns_is_the_programs() {
        assert_eq!(equal("  int x = 1;", "  int x = 1;"), Some((1, 12)));
        assert_eq!(equal("    ", "    "), Some((1, 4)));
        assert_eq!(equal("                    lf_set(y, 1);", "  reaction(x) -> y {= lf_set(y, 1); =}"), None);
        assert_eq!(
            equal("                      lf_set(y, 1);", "  reaction(x) -> y {= lf_set(y, 1); =}"),
            Some((23, 13))
        );
        assert_eq!(equal("           pair_t value;", "  input x: pair_t"), Some((12, 6)));
        assert_eq!(equal("LF_NAME_(\"x\", x);", "  input x: pair_t"), None);
    }
}
