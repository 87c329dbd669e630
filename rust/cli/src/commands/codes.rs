// SPDX-License-Identifier: Apache-2.0
//! `lfz explain`: converts the codes of images without texts back to sentences.

use std::borrow::Cow;
use std::io::{self, BufRead, Write};
use std::path::Path;
use std::process::ExitCode;

use crate::codes::{sentence, with_sentences};
use crate::compile::Console;
use crate::failure::Failure;
use crate::terminal;

/// Prints the meanings of these codes; without any, converts those in the standard input, and places in a generated
/// crate to places in the program.
pub(super) fn explain(crate_folder: Option<&Path>, codes: &[String]) -> Result<ExitCode, Failure> {
    let console = crate_folder.map(Console::known).transpose()?;
    let mut output = terminal::output();
    if codes.is_empty() {
        let mut input = io::stdin().lock();
        let mut line = Vec::new();
        while input.read_until(b'\n', &mut line)? > 0 {
            let shown = with_sentences(&line);
            let shown = console.as_ref().map_or(Cow::Borrowed(&*shown), |console| console.with_lf_places(&shown));
            output.write_all(&shown)?;
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
