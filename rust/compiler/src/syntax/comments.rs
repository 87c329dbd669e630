// SPDX-License-Identifier: Apache-2.0
//! Comments that document a declaration.

use core::ops::Range;

/// Returns the comment directly before the declaration of a name: before the line of the name, and before lines of
/// attributes above it. Of several names on a line, only the first one has a comment.
pub(crate) fn comment_before(text: &str, comments: &[Range<usize>], name: usize) -> Option<String> {
    let line_start = |at: usize| text[..at].rfind('\n').map_or(0, |end| end + 1);
    let mut start = line_start(name);
    while start > 0 && text[line_start(start - 1)..start].trim_start().starts_with('@') {
        start = line_start(start - 1);
    }
    let is_first = !text[line_start(name)..name].contains([':', '=', '<', ',']);
    let blanks = text[start..].len() - text[start..].trim_start().len();
    comment_ending(text, comments, start + blanks).filter(|_| is_first)
}

/// Returns the comment that ends directly before a place, without comment marks.
pub(super) fn comment_ending(text: &str, comments: &[Range<usize>], at: usize) -> Option<String> {
    let mut lines = Vec::new();
    let mut start = at;
    let last = comments.partition_point(|comment| comment.end <= at);
    for comment in comments[..last].iter().rev() {
        let between = &text[comment.end..start];
        let alone = text[..comment.start].chars().rev().find(|c| !matches!(c, ' ' | '\t'));
        let trailing = alone.is_some_and(|c| c != '\n');
        if !between.trim().is_empty() || between.matches('\n').count() > 1 || trailing {
            break;
        }
        let comment_text = &text[comment.clone()];
        for line in uncommented(comment_text).into_iter().rev() {
            lines.push(line);
        }
        start = comment.start;
        if comment_text.starts_with("/*") || comment_text.starts_with("'''") {
            break;
        }
    }
    lines.reverse();
    let text = lines.join("\n").trim().to_owned();
    (!text.is_empty()).then_some(text)
}

/// Returns the lines of a comment without its marks.
fn uncommented(comment: &str) -> Vec<&str> {
    if let Some(line) = comment.strip_prefix("//").or_else(|| comment.strip_prefix('#')) {
        return vec![line.trim()];
    }
    let inner = comment.trim_start_matches(['/', '*', '\'']).trim_end_matches(['/', '*', '\'']);
    inner.lines().map(|line| line.trim().trim_start_matches('*').trim()).collect()
}
