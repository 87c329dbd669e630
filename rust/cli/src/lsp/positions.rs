// SPDX-License-Identifier: Apache-2.0
//! Places as the protocol counts them: lines and UTF-16 code units, both from 0.

use lf_compiler::diagnostics::{SourceText, Span};
use lsp_types::{Position, Range};

/// Returns the place of a byte of a source.
pub(super) fn position(source: &SourceText, byte: usize) -> Position {
    let text = source.text();
    let byte = (0..=byte.min(text.len())).rev().find(|byte| text.is_char_boundary(*byte)).unwrap_or(0);
    let before = &text[..byte];
    let line = before.rfind('\n').map_or(0, |end| end + 1);
    let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    Position::new(number(source.position(byte).line - 1), number(before[line..].encode_utf16().count()))
}

/// Returns the byte of a text at a place; one behind the end of its line is at the end.
pub(super) fn byte(text: &str, position: Position) -> usize {
    let lines = text.split_inclusive('\n').take(usize::try_from(position.line).unwrap_or(usize::MAX));
    let start: usize = lines.map(str::len).sum();
    let line = text[start..].split('\n').next().unwrap_or_default();
    let mut units = 0;
    let wanted = usize::try_from(position.character).unwrap_or(usize::MAX);
    let before = line.chars().take_while(|c| {
        units += c.len_utf16();
        units <= wanted
    });
    start + before.map(char::len_utf8).sum::<usize>()
}

/// Returns the range of a span.
pub(super) fn range(source: &SourceText, span: Span) -> Range {
    Range::new(position(source, span.start), position(source, span.end))
}

#[cfg(test)]
mod tests {
    use lf_compiler::parse;
    use lsp_types::Position;

    use super::{byte, position};

    #[test]
    fn columns_are_utf_16() {
        let text = "ab\nü𝄞x\n";
        let parsed = parse("a.lf", text);
        let source = parsed.diagnostics.sources().iter().next().expect("the text is there").1;
        for (at, line, column) in [(0, 0, 0), (2, 0, 2), (3, 1, 0), (5, 1, 1), (9, 1, 3), (10, 1, 4), (11, 2, 0)] {
            assert_eq!(position(source, at), Position::new(line, column), "{at}");
            assert_eq!(byte(text, Position::new(line, column)), at, "{line}:{column}");
        }
        assert_eq!(byte(text, Position::new(1, 99)), 10, "behind the line");
        assert_eq!(byte(text, Position::new(99, 0)), text.len(), "behind the text");
        assert_eq!(byte(text, Position::new(1, 2)), 5, "within a character");
        assert_eq!(position(source, 6), Position::new(1, 1), "within a character");
    }
}
