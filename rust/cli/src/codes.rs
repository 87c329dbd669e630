// SPDX-License-Identifier: Apache-2.0
//! Converts the codes that images without texts log (`CONFIG_LF_TEXTS=n`) back to sentences.

use std::borrow::Cow;

use lf_linux::runtime::{CODE_PREFIX, explain};

/// Returns the meaning of a code; `None` if it is not one of this release.
pub(crate) fn sentence(code: &str) -> Option<String> {
    let mut sentence = None;
    // Sentences name parts of a program, which are static in the program itself. There are few, and this process ends
    // soon.
    explain(code, |text| text.to_owned().leak(), &mut |said| sentence = Some(said.to_string()));
    sentence
}

/// Returns a line with its codes replaced by sentences. The rest is unchanged: texts that only look like a code, and
/// bytes that are not a text.
pub(crate) fn with_sentences(line: &[u8]) -> Cow<'_, [u8]> {
    let Ok(mut rest) = str::from_utf8(line) else { return Cow::Borrowed(line) };
    let mut text = String::new();
    while let Some(start) = rest.find(CODE_PREFIX) {
        let (before, code) = rest.split_at(start);
        let (code, behind) = code.split_at(length(code));
        text += before;
        text += sentence(code).as_deref().unwrap_or(code);
        rest = behind;
    }
    if text.is_empty() { Cow::Borrowed(line) } else { Cow::Owned((text + rest).into_bytes()) }
}

/// Returns the length of the code at the beginning of a text: numbers, and texts between quotation marks, behind
/// points.
fn length(text: &str) -> usize {
    let digits = |text: &str| text.find(|sign: char| !sign.is_ascii_hexdigit()).unwrap_or(text.len());
    let mut length = CODE_PREFIX.len();
    length += digits(&text[length..]);
    while let Some(part) = text[length..].strip_prefix('.') {
        let bytes = match part.strip_prefix('"') {
            Some(quoted) => quoted.find('"').map_or(0, |end| end + 2),
            None => digits(part),
        };
        if bytes == 0 {
            break;
        }
        length += 1 + bytes;
    }
    length
}

#[cfg(test)]
mod tests {
    use super::with_sentences;

    #[test]
    fn codes_in_a_line_become_sentences_and_all_else_stays() {
        let line = "[00:00:12.3] <err> lf: lf#0.2.8.\"a.out -> b.in\" lf#3.1\r\n";
        let sentence = "the queue of a.out -> b.in and the receive buffer are full, and what would empty them \
                        cannot come before they have room: raise the capacity of that connection with \
                        `@capacity(n)`, or slow its sender";
        let key = "the federation id is the key of `auth`, and others can guess this one: choose another with --id, or \
                   CONFIG_LF_FEDERATION_ID";
        let explained = format!("[00:00:12.3] <err> lf: {sentence} {key}\r\n");
        assert_eq!(*with_sentences(line.as_bytes()), *explained.as_bytes());
        for line in ["", "no code\n", "lf# lf#. lf#ff.1 lf#0.2.8 lf#0.2.8.\"open lf#3.1.0\n"] {
            assert_eq!(*with_sentences(line.as_bytes()), *line.as_bytes());
        }
    }
}
