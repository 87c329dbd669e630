// SPDX-License-Identifier: Apache-2.0
//! Rust's strings and comments, which hide the end of a block of code, and brackets.

use crate::lexical::blocks::is_word;

/// Returns the end of the token that begins at a byte: a comment, a literal, a word, or a character.
pub(in crate::lexical) fn skip(text: &str, at: usize) -> usize {
    let bytes = text.as_bytes();
    match bytes[at] {
        b'/' if bytes.get(at + 1) == Some(&b'/') => line_end(bytes, at),
        b'/' if bytes.get(at + 1) == Some(&b'*') => comment_end(bytes, at + 2),
        b'"' => string_end(bytes, at + 1),
        b'\'' => quote_end(text, at),
        byte if is_word(byte) => word_end(bytes, at),
        _ => at + text[at..].chars().next().map_or(1, char::len_utf8),
    }
}

fn line_end(bytes: &[u8], at: usize) -> usize {
    bytes[at..].iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |length| at + length)
}

/// Returns the end of a block comment, which can contain others.
fn comment_end(bytes: &[u8], mut at: usize) -> usize {
    let mut depth = 1_usize;
    while at < bytes.len() && depth > 0 {
        match (bytes[at], bytes.get(at + 1)) {
            (b'/', Some(b'*')) => {
                depth += 1;
                at += 1;
            }
            (b'*', Some(b'/')) => {
                depth -= 1;
                at += 1;
            }
            _ => {}
        }
        at += 1;
    }
    at
}

fn string_end(bytes: &[u8], mut at: usize) -> usize {
    while at < bytes.len() {
        match bytes[at] {
            b'"' => return at + 1,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    bytes.len()
}

/// Returns the end of a character literal, or that of a lifetime's quote.
fn quote_end(text: &str, at: usize) -> usize {
    let mut rest = text[at + 1..].char_indices();
    match rest.next() {
        Some((_, '\\')) => {
            let escaped = rest.next().map_or(text.len(), |(index, character)| at + 1 + index + character.len_utf8());
            text[escaped..].find(['\'', '\n']).map_or(text.len(), |length| escaped + length + 1)
        }
        Some((_, character)) if text[at + 1 + character.len_utf8()..].starts_with('\'') => {
            at + 2 + character.len_utf8()
        }
        _ => at + 1,
    }
}

/// Skips a word; if it begins a raw string (`r"`, `r#"`, `br"` …), skips that too.
fn word_end(bytes: &[u8], at: usize) -> usize {
    let end = bytes[at..].iter().position(|byte| !is_word(*byte)).map_or(bytes.len(), |length| at + length);
    if !matches!(&bytes[at..end], b"r" | b"br" | b"cr") {
        return end;
    }
    let hashes = bytes[end..].iter().take_while(|byte| **byte == b'#').count();
    if bytes.get(end + hashes) != Some(&b'"') {
        return end;
    }
    let body = end + hashes + 1;
    let closes = |at: usize| {
        bytes[at] == b'"' && bytes[at + 1..].iter().take(hashes).filter(|byte| **byte == b'#').count() == hashes
    };
    (body..bytes.len()).find(|at| closes(*at)).map_or(bytes.len(), |at| at + 1 + hashes)
}

#[cfg(test)]
mod tests {
    use super::skip;
    use crate::lexical::BlockEnd;
    use crate::lexical::blocks::block_end;

    fn end(text: &str) -> Option<&str> {
        match block_end(text, skip) {
            BlockEnd::Found(end) => Some(&text[end..]),
            BlockEnd::Hidden { .. } | BlockEnd::Missing => None,
        }
    }

    #[test]
    fn strings_and_comments_hide_the_end() {
        assert_eq!(end(r#" "=}" =} rest"#), Some(" rest"));
        assert_eq!(end(r##" r#"=} " =}"# =} rest"##), Some(" rest"));
        assert_eq!(end(" /* =} /* =} */ =} */ =} rest"), Some(" rest"));
        assert_eq!(end(" // =}\n =} rest"), Some(" rest"));
        assert_eq!(end(r" '\'' '=' 'a fn<'b>() =} rest"), Some(" rest"));
        assert_eq!(end(r#" '"' =} rest"#), Some(" rest"));
        assert_eq!(end(r#" r#in "x\"=}" =} rest"#), Some(" rest"));
    }

    #[test]
    fn a_missing_end_is_told_from_a_hidden_one() {
        assert_eq!(block_end(" x", skip), BlockEnd::Missing);
        assert_eq!(block_end(" // =}", skip), BlockEnd::Hidden { end: 6, by: 1 });
        assert_eq!(block_end(" \"=} \\", skip), BlockEnd::Hidden { end: 4, by: 1 });
        assert_eq!(block_end(" '\\", skip), BlockEnd::Missing);
    }
}
