// SPDX-License-Identifier: Apache-2.0
//! Makes the debugging information of an executable name the LF program, so that debuggers stop at lines of bodies and
//! backtraces show them.
//!
//! The compiler says for each instruction from which line of a generated file it comes. What was copied from the
//! program gets its place there; the scaffolding around it keeps its own. A converted table is longer, so it stands
//! behind the others, and the unit that it belongs to refers to it there. Nothing that is loaded into memory changes.

mod elf;
mod lines;
mod origins;

use std::fs;
use std::io;
use std::path::Path;

pub(crate) use origins::Generated;

use elf::Elf;
use origins::Origins;

use crate::failure::Failure;
use crate::replace::replace;

/// Makes the debugging information of an executable name the program. One without such information stays as it is, and
/// so does one that names the program already.
///
/// # Errors
/// When the file cannot be read or written, or its debugging information is damaged.
pub(crate) fn name_lf_lines(executable: &Path, generated: &Generated<'_>) -> Result<(), Failure> {
    convert(executable, generated).map_err(|error| {
        let executable = executable.display();
        Failure::message(format!("cannot lead debuggers from {executable} to the program: {error}"))
    })
}

fn convert(executable: &Path, generated: &Generated<'_>) -> io::Result<()> {
    let bytes = fs::read(executable)?;
    let mut origins = Origins::new(generated)?;
    let damaged = |error: gimli::write::ConvertError| io::Error::new(io::ErrorKind::InvalidData, error.to_string());
    let Some(mut elf) = Elf::read(bytes) else { return Ok(()) };
    let Some(converted) = lines::convert(&elf, &mut origins).map_err(damaged)? else { return Ok(()) };
    for (section, contents) in converted {
        elf.replace(section, &contents)?;
    }
    replace(executable, &elf.into_bytes())
}
