// SPDX-License-Identifier: Apache-2.0
//! Reads a program, and prints its errors.

use std::env;
use std::fs;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use lf_compiler::characters::{SOURCE_BYTES_MAX, check_size, decode};
use lf_compiler::diagram::{BankView, Diagram};
use lf_compiler::plan::Plan;
use lf_compiler::{Compilation, Diagnostics, DrawnCompilation, SourceProvider};

use super::places::{from_root, text_of};
use crate::failure::Failure;
use crate::terminal;

/// The name of the standard input, as an argument.
pub(crate) const STANDARD_INPUT: &str = "-";

/// Reads LF files from this computer.
pub(crate) struct Files;

impl SourceProvider for Files {
    fn read(&self, path: &str) -> Result<String, String> {
        read_text(Path::new(path))
    }

    fn exists(&self, path: &str) -> bool {
        fs::metadata(path).is_ok_and(|found| found.is_file() || found.is_dir())
    }

    fn real_path(&self, path: &str) -> Option<PathBuf> {
        fs::canonicalize(path).ok()
    }

    fn package_folders(&self) -> Vec<String> {
        let folders = env::var_os(PACKAGES).unwrap_or_default();
        env::split_paths(&folders)
            .filter_map(|folder| folder.into_os_string().into_string().ok())
            .filter(|it| !it.is_empty())
            .collect()
    }
}

/// The environment variable with folders of packages; LF's own compiler takes one.
const PACKAGES: &str = "LF_PACKAGES";

/// The file that the standard input stands for.
const INPUT_FILE: &str = "standard_input.lf";

/// Reads a main file from a text, and what it imports from this computer.
struct Input(String);

impl SourceProvider for Input {
    fn read(&self, path: &str) -> Result<String, String> {
        if path == INPUT_FILE { Ok(self.0.clone()) } else { Files.read(path) }
    }

    fn exists(&self, path: &str) -> bool {
        path == INPUT_FILE || Files.exists(path)
    }

    fn real_path(&self, path: &str) -> Option<PathBuf> {
        Files.real_path(path)
    }

    fn package_folders(&self) -> Vec<String> {
        Files.package_folders()
    }
}

/// Returns the text of the standard input.
///
/// # Errors
/// The reason, as the end of a sentence.
pub(crate) fn standard_input() -> Result<String, String> {
    let mut bytes = Vec::new();
    let read = std::io::stdin().lock().take(SOURCE_BYTES_MAX as u64 + 1).read_to_end(&mut bytes);
    read.map_err(|error| error.to_string())?;
    check_size(bytes.len() as u64)?;
    decode(bytes)
}

/// Returns the text of a file that users write.
///
/// # Errors
/// The reason, as the end of a sentence. Devices and pipes are not read, because they may have no end.
pub(crate) fn read_text(path: &Path) -> Result<String, String> {
    let reason = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => "it does not exist".to_owned(),
        ErrorKind::IsADirectory => "it is a folder".to_owned(),
        ErrorKind::PermissionDenied => "it may not be read".to_owned(),
        _ => error.to_string(),
    };
    // Opening a pipe would wait for a writer.
    let found = fs::metadata(path).map_err(reason)?;
    if found.is_dir() {
        return Err("it is a folder".to_owned());
    }
    if !found.is_file() {
        return Err("it is a device or a pipe, and no file".to_owned());
    }
    check_size(found.len())?;
    let mut bytes = Vec::new();
    let file = fs::File::open(path).map_err(reason)?;
    file.take(SOURCE_BYTES_MAX as u64 + 1).read_to_end(&mut bytes).map_err(reason)?;
    decode(bytes)
}

/// A program without errors.
#[derive(Debug)]
pub(crate) struct Program {
    /// The compiler's result.
    pub(crate) plan: Plan,
    /// Its warnings, and the texts of its files.
    pub(crate) diagnostics: Diagnostics,
}

impl Program {
    /// Compiles a main file to a plan; prints the diagnostics to standard error.
    ///
    /// # Errors
    /// When it has no plan; the user has seen the reasons.
    pub(crate) fn load(file: &Path) -> Result<Self, Failure> {
        Self::of(compile(file)?, text_of(file)?)
    }

    /// Compiles a main file, or the standard input, to a plan and a diagram; prints the diagnostics to standard error.
    ///
    /// # Errors
    /// When it has no plan; the user has seen the reasons.
    pub(crate) fn drawn(file: &Path, banks: BankView) -> Result<(Self, Diagram), Failure> {
        let (DrawnCompilation { compilation, diagram }, name) = if file == Path::new(STANDARD_INPUT) {
            (lf_compiler::diagram(INPUT_FILE, &Input(input_text()?), banks), "standard input")
        } else {
            let path = text_of(file)?;
            from_root(file)?;
            (lf_compiler::diagram(path, &Files, banks), path)
        };
        let program = Self::of(compilation, name)?;
        diagram.map(|diagram| (program, diagram)).ok_or(Failure::Reported)
    }

    /// Returns the program that was compiled from a file of this path; prints the diagnostics to standard error.
    ///
    /// # Errors
    /// When it has no plan; the user has seen the reasons.
    pub(crate) fn of(compilation: Compilation, path: &str) -> Result<Self, Failure> {
        let diagnostics = compilation.diagnostics;
        terminal::report(diagnostics.render(terminal::style()));
        match compilation.plan {
            Some(plan) if !diagnostics.has_errors() => Ok(Self { plan, diagnostics }),
            _ => {
                let (errors, warnings) = diagnostics.counts();
                terminal::report(format_args!("{path}: {}", count(errors, warnings)));
                Err(Failure::Reported)
            }
        }
    }
}

/// Compiles a main file, and returns what the compiler says.
///
/// # Errors
/// When the compiler cannot be given the file's path.
pub(crate) fn compile(file: &Path) -> Result<Compilation, Failure> {
    let path = text_of(file)?;
    from_root(file)?;
    Ok(lf_compiler::compile(path, &Files))
}

/// Compiles the program in the standard input, and returns what the compiler says.
///
/// # Errors
/// When it cannot be read.
pub(crate) fn compile_input() -> Result<Compilation, Failure> {
    Ok(lf_compiler::compile(INPUT_FILE, &Input(input_text()?)))
}

fn input_text() -> Result<String, Failure> {
    standard_input().map_err(|error| Failure::message(format!("the standard input cannot be read: {error}")))
}

/// Formats the numbers: `2 errors and 1 warning`.
pub(crate) fn count(errors: usize, warnings: usize) -> String {
    let plural = |number: usize, word: &str| match number {
        0 => format!("no {word}s"),
        1 => format!("1 {word}"),
        _ => format!("{number} {word}s"),
    };
    match warnings {
        0 => plural(errors, "error"),
        _ => format!("{} and {}", plural(errors, "error"), plural(warnings, "warning")),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use lf_compiler::SourceProvider;

    use super::{Files, count};

    #[test]
    fn why_a_file_cannot_be_read_ends_a_sentence() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("P.lf");
        let text = path.to_str().expect("temporary paths are UTF-8");
        assert_eq!(Files.read(text), Err("it does not exist".to_owned()));
        fs::write(&path, b"target \xff").expect("it can be written");
        let wrong = "it is no UTF-8 text (line 1, column 8: byte 0xFF); save it as UTF-8";
        assert_eq!(Files.read(text), Err(wrong.to_owned()));
        assert_eq!(Files.read(folder.path().to_str().expect("UTF-8")), Err("it is a folder".to_owned()));
        assert_eq!(Files.read("/dev/zero"), Err("it is a device or a pipe, and no file".to_owned()));
        fs::File::create(&path).and_then(|file| file.set_len(1 << 40)).expect("holes take no room");
        assert_eq!(Files.read(text), Err("it has more than 16 MiB, which no program needs".to_owned()));
    }

    #[test]
    fn counts_are_words() {
        assert_eq!(count(0, 0), "no errors");
        assert_eq!(count(1, 0), "1 error");
        assert_eq!(count(2, 1), "2 errors and 1 warning");
    }
}
