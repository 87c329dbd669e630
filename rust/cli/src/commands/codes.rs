// SPDX-License-Identifier: Apache-2.0
//! `lfz explain`: from the codes of images without texts back to sentences.

use std::io::{self, BufRead, Write};
use std::process::ExitCode;

use crate::codes::{sentence, with_sentences};
use crate::failure::Failure;

/// Says what these codes mean; without any, what those in the standard input do.
pub(super) fn explain(codes: &[String]) -> Result<ExitCode, Failure> {
    let mut output = io::stdout().lock();
    if codes.is_empty() {
        let mut input = io::stdin().lock();
        let mut line = Vec::new();
        while input.read_until(b'\n', &mut line)? > 0 {
            output.write_all(&with_sentences(&line))?;
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
