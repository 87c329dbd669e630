// SPDX-License-Identifier: Apache-2.0
//! `lfz explain`: from the codes of images without texts back to sentences.

use std::borrow::Cow;
use std::io::{self, BufRead, Write};
use std::process::ExitCode;

use lf_host::runtime::{CODE_PREFIX, explain as decode};

use crate::failure::Failure;

/// Says what these codes mean; without any, what those in the standard input do.
pub(super) fn explain(codes: &[String]) -> Result<ExitCode, Failure> {
    let mut output = io::stdout().lock();
    if codes.is_empty() {
        let mut input = io::stdin().lock();
        let mut line = Vec::new();
        while input.read_until(b'\n', &mut line)? > 0 {
            // A console can show anything, and only what is a text has codes in it.
            match str::from_utf8(&line) {
                Ok(text) => output.write_all(with_sentences(text).as_bytes())?,
                Err(_) => output.write_all(&line)?,
            }
            output.flush()?;
            line.clear();
        }
        return Ok(ExitCode::SUCCESS);
    }
    for code in codes {
        let sentence = sentence(code).ok_or_else(|| {
            Failure::message(format!("{code} is no code of this release: use the lfz with which the image was built"))
        })?;
        writeln!(output, "{sentence}")?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A line with sentences in place of its codes. What looks like a code and is none stays as it is.
fn with_sentences(line: &str) -> Cow<'_, str> {
    let (mut text, mut rest) = (String::new(), line);
    while let Some(start) = rest.find(CODE_PREFIX) {
        let (before, code) = rest.split_at(start);
        let (code, behind) = code.split_at(length(code));
        text += before;
        text += sentence(code).as_deref().unwrap_or(code);
        rest = behind;
    }
    if text.is_empty() { Cow::Borrowed(line) } else { Cow::Owned(text + rest) }
}

/// The length of the code with which a text begins: numbers, and texts between quotation marks, behind points.
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

/// What a code means.
fn sentence(code: &str) -> Option<String> {
    let mut sentence = None;
    // Sentences name parts of a program, which for a program itself are static. There are few, and this one ends soon.
    decode(code, |text| text.to_owned().leak(), &mut |said| sentence = Some(said.to_string()));
    sentence
}

#[cfg(test)]
mod tests {
    use super::with_sentences;

    #[test]
    fn codes_in_a_line_become_sentences_and_all_else_stays() {
        let line = "[00:00:12.3] <err> lf: lf#0.2.8.\"a.out -> b.in\" lf#3.1\r\n";
        let sentence = "the queue of a.out -> b.in and the receive buffer are full, and the grant that would empty \
                        them lies behind still more messages: raise the capacity of that connection with \
                        `@capacity(n)`, or slow its sender";
        let key = "the federation id is the key of `auth`, and others can guess this one: choose another with --id, or \
                   CONFIG_LF_FEDERATION_ID";
        assert_eq!(with_sentences(line), format!("[00:00:12.3] <err> lf: {sentence} {key}\r\n"));
        for line in ["", "no code\n", "lf# lf#. lf#ff.1 lf#0.2.8 lf#0.2.8.\"open lf#3.1.0\n"] {
            assert_eq!(with_sentences(line), line);
        }
    }
}
