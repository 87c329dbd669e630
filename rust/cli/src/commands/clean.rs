// SPDX-License-Identifier: Apache-2.0
//! `lfz clean`

use std::process::ExitCode;

use crate::args::CleanArgs;
use crate::compile::{Freed, clean_all, clean_program};
use crate::failure::Failure;
use crate::terminal;

/// Removes generated and compiled files, and prints the freed space.
pub(super) fn clean(arguments: &CleanArgs) -> Result<ExitCode, Failure> {
    let mut freed = Freed::default();
    match &arguments.file {
        Some(file) => clean_program(file, &arguments.places, &mut freed)?,
        None => clean_all(&arguments.places, &mut freed)?,
    }
    for folder in &freed.busy {
        terminal::inform(format_args!("{} is left: a build uses it", folder.display()));
    }
    terminal::print(format_args!("{} freed", size(freed.size)))?;
    Ok(ExitCode::SUCCESS)
}

/// Formats a number of bytes.
fn size(bytes: u64) -> String {
    let tenths = bytes / 100_000;
    if tenths < 10_000 { format!("{}.{} MB", tenths / 10, tenths % 10) } else { format!("{} MB", tenths / 10) }
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_are_in_megabytes() {
        assert_eq!([0, 4096, 12_345_678, 2_000_000_000].map(size), ["0.0 MB", "0.0 MB", "12.3 MB", "2000 MB"]);
    }
}
