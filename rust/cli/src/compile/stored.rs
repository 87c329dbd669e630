// SPDX-License-Identifier: Apache-2.0
//! Crates that another build compiles, such as Zephyr's: beside each lies a file by which rustc's diagnostics about the
//! crate are converted to diagnostics about the LF program.

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use lf_compiler::emit::{Emitted, SourceMap};
use serde::{Deserialize, Serialize};

use super::messages::CargoMessage;
use super::origin::{included, known};
use super::rustc::{self, LfPlace, Origin};
use super::scopes::Scope;
use super::source::Program;
use crate::debug_info::{self, Generated};
use crate::failure::Failure;

/// The file in the folder of a generated crate.
const FILE: &str = "source-map.json";

/// The content of that file.
#[derive(Debug, Serialize, Deserialize)]
struct Stored {
    /// The LF files at the time of generating the crate, by the paths that the compiler was given, and files of Rust
    /// that the program includes, by their absolute paths.
    texts: BTreeMap<String, String>,
    /// The map from the crate's files to these.
    map: SourceMap,
    /// The folder from which relative paths of the LF files count.
    current: PathBuf,
    /// The bodies of reactions.
    scopes: Vec<Scope>,
}

/// Returns the file by which CMake knows the compiler that made a crate: its path below the output folder, and its
/// text.
pub(super) fn compiler_file(folder: &str) -> (String, String) {
    let program = env::current_exe().unwrap_or_default();
    let text = format!("# SPDX-License-Identifier: Apache-2.0\nset(LF_COMPILER [==[{}]==])\n", program.display());
    (format!("{folder}/compiler.cmake"), text)
}

/// Returns the file for a generated crate: its path below the output folder, and its text.
///
/// # Errors
/// When it cannot be written as JSON.
pub(super) fn file(program: &Program, emitted: &Emitted, folder: &str) -> Result<(String, String), Failure> {
    let sources = program.diagnostics.sources().iter();
    let texts = sources.map(|(_, file)| (file.path().to_owned(), file.text().to_owned()));
    let texts = texts.chain(included(&program.plan)).collect();
    let (map, scopes) = (emitted.source_map.in_folder(folder), Scope::all(&program.plan));
    let stored = Stored { texts, map, current: env::current_dir().unwrap_or_default(), scopes };
    let text = serde_json::to_string(&stored)
        .map_err(|error| Failure::message(format!("the source map of {folder} cannot be written: {error}")))?;
    Ok((format!("{folder}/{FILE}"), text + "\n"))
}

/// Converts rustc's diagnostics about generated crates to diagnostics about the LF program; the files are cargo's
/// messages in JSON. Warnings about other crates are left out.
///
/// # Errors
/// When a file cannot be read.
pub(crate) fn explain(messages: &[PathBuf]) -> Result<String, Failure> {
    let mut crates = Crates::default();
    let mut diagnostics = Vec::new();
    let mut without_std = BTreeMap::new();
    for path in messages {
        for line in read(path)?.lines() {
            let Some(CargoMessage::Diagnostic { manifest_path, target, mut message }) = CargoMessage::read(line) else {
                continue;
            };
            let folder = manifest_path.parent().unwrap_or(&manifest_path);
            if crates.know(folder)? {
                message.resolve(folder);
            } else if !message.is_error() {
                continue;
            } else if message.misses("std") || message.misses("alloc") {
                without_std.insert(target.map(|target| target.name).unwrap_or_default(), folder.to_owned());
                continue;
            }
            diagnostics.push((folder.to_owned(), message));
        }
    }
    // Without `core`, the target is missing, as other messages say.
    if diagnostics.iter().any(|(_, message)| message.misses("core")) {
        without_std.clear();
    }
    // All other errors of such a crate follow from that.
    diagnostics.retain(|(folder, _)| !without_std.values().any(|other| other == folder));
    let diagnostics: Vec<_> = diagnostics.into_iter().map(|(_, message)| message).collect();
    let without_std: String = without_std.keys().map(|name| needs_std(name)).collect();
    Ok(without_std + &rustc::render_all(&diagnostics, &crates, false).text)
}

/// Returns the error about a crate that needs features which images lack.
fn needs_std(name: &str) -> String {
    format!(
        "error: the crate `{name}` needs `std`, which images do not have\n  hint: where it is one of \
         `cargo-dependencies` and has `std` as a default feature, write `default-features: false`; else take a crate \
         that is `no_std`\n\n"
    )
}

/// Makes the debugging information of an image name the program that its generated crate is from.
///
/// # Errors
/// When there is no such crate, or the image cannot be read or written.
pub(crate) fn name_lf_lines(image: &Path, folder: &Path) -> Result<(), Failure> {
    let Some(Stored { map, current, .. }) = load(&folder.join(FILE))? else {
        return Err(Failure::message(format!("{} is no crate that lfz has generated", folder.display())));
    };
    debug_info::name_lf_lines(image, &Generated { folder, map: &map, current: &current })
}

/// Returns the map from the files of a generated crate to the program; `None` for a folder that has not been generated.
///
/// # Errors
/// When the file beside the crate cannot be read.
pub(super) fn map(folder: &Path) -> Result<Option<SourceMap>, Failure> {
    Ok(load(&folder.join(FILE))?.map(|stored| stored.map))
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|error| Failure::message(format!("cannot read {}: {error}", path.display())))
}

/// Crates by their folders; `None` for those that were not generated.
#[derive(Default)]
struct Crates(BTreeMap<PathBuf, Option<Stored>>);

impl Crates {
    /// Returns whether a crate was generated; the file beside it is read once.
    fn know(&mut self, folder: &Path) -> Result<bool, Failure> {
        if !self.0.contains_key(folder) {
            self.0.insert(folder.to_owned(), load(&folder.join(FILE))?);
        }
        Ok(self.0.get(folder).is_some_and(Option::is_some))
    }
}

fn load(path: &Path) -> Result<Option<Stored>, Failure> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(Failure::message(format!("cannot read {}: {error}", path.display()))),
    };
    let stored = serde_json::from_str(&text).map_err(|error| {
        let path = path.display();
        Failure::message(format!("{path} was not made by this version of lfz ({error}); build the program again"))
    })?;
    Ok(Some(stored))
}

impl Origin for Crates {
    fn place(&self, generated: &str, line: usize, column: usize) -> Option<LfPlace> {
        let path = Path::new(generated);
        if let Some(path) = self.0.values().flatten().find_map(|stored| known(&stored.texts, generated)) {
            return Some(LfPlace { path: path.to_owned(), line, column, verbatim: true });
        }
        self.0.iter().find_map(|(folder, stored)| {
            let map = &stored.as_ref()?.map;
            let path = path.strip_prefix(folder).ok()?.to_str()?;
            let (lf_path, lf_line, lf_column) = map.to_lf(path, line, column)?;
            let verbatim = map.is_verbatim(path, line, column);
            Some(LfPlace { path: lf_path.to_owned(), line: lf_line, column: lf_column, verbatim })
        })
    }

    fn text(&self, path: &str) -> Option<&str> {
        self.0.values().flatten().find_map(|stored| stored.texts.get(path)).map(String::as_str)
    }

    fn scopes(&self) -> &[Scope] {
        self.0.values().flatten().next().map_or(&[], |stored| &stored.scopes)
    }
}

#[cfg(test)]
mod tests;
