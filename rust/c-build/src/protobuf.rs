// SPDX-License-Identifier: Apache-2.0
//! Messages of Protocol Buffers, for which protobuf-c's compiler generates C.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{self, Command};

/// The library that the generated code calls.
pub(crate) const LIBRARY: &str = "protobuf-c";

/// The advice of messages about what is missing.
const ADVICE: &str = "install the compiler and the library of protobuf-c (Debian: protobuf-c-compiler and \
                      libprotobuf-c-dev)";

/// Generates a header and a source from each file, in a folder of their own; returns the sources.
///
/// The compiler's messages go to standard error; where it finds errors, the build script ends with status 1.
///
/// # Panics
/// When cargo's folder cannot be written to.
pub(crate) fn generate(files: &[PathBuf], folder: &Path) -> Vec<PathBuf> {
    if files.is_empty() {
        return Vec::new();
    }
    fs::create_dir_all(folder).expect("cargo's folder can be written to");
    // Files import each other by paths from the folders in which they lie.
    let mut folders: Vec<&Path> = Vec::new();
    for around in files.iter().filter_map(|file| file.parent()) {
        if !folders.contains(&around) {
            folders.push(around);
        }
    }
    let generated = |file: &PathBuf| {
        println!("cargo::rerun-if-changed={}", file.display());
        let own = file.parent().into_iter().chain(folders.iter().copied());
        run(file, own, folder);
        folder.join(file.file_stem().unwrap_or_default()).with_extension("pb-c.c")
    };
    files.iter().map(generated).collect()
}

fn run<'p>(file: &Path, folders: impl Iterator<Item = &'p Path>, out: &Path) {
    let mut arguments: Vec<_> = folders.map(|folder| format!("--proto_path={}", folder.display())).collect();
    arguments.dedup();
    arguments.push(format!("--c_out={}", out.display()));
    // The name `protoc-c` ends with version 1.5, of which `protoc` finds the plugin.
    let mut outputs = ["protoc-c", "protoc"]
        .into_iter()
        .filter_map(|compiler| Command::new(compiler).args(&arguments).arg(file).output().ok());
    let Some(output) = outputs.next() else {
        eprintln!("error: `{}` takes protobuf-c's compiler, which is not here: {ADVICE}", file.display());
        process::exit(1);
    };
    let said = String::from_utf8_lossy(&output.stderr);
    let folder = file.parent().unwrap_or(Path::new(""));
    for line in said.lines() {
        eprintln!("{}", as_compilers_say(line, folder, output.status.success()));
    }
    if !output.status.success() {
        if said.contains("protoc-gen-c") {
            eprintln!("error: `{}` takes protobuf-c's plugin: {ADVICE}", file.display());
        }
        process::exit(1);
    }
}

/// Returns a message with the level that C compilers write, and the whole path of the file.
fn as_compilers_say(line: &str, folder: &Path, is_warning: bool) -> String {
    let mut parts = line.splitn(4, ':');
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|one| one.is_ascii_digit());
    let (Some(file), Some(at), Some(column), Some(text)) = (parts.next(), parts.next(), parts.next(), parts.next())
    else {
        return line.to_owned();
    };
    if !is_number(at) || !is_number(column) {
        return line.to_owned();
    }
    let text = text.trim_start();
    let level = if is_warning || text.starts_with("warning:") { "warning" } else { "error" };
    let text = text.strip_prefix("warning:").unwrap_or(text).trim_start();
    format!("{}:{at}:{column}: {level}: {text}", folder.join(file).display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_those_of_compilers() {
        let said = |line: &str| as_compilers_say(line, Path::new("/a b"), false);
        assert_eq!(said("P.proto:3:5: \"Nope\" is not defined."), "/a b/P.proto:3:5: error: \"Nope\" is not defined.");
        assert_eq!(said("P.proto:3:5: warning: unused"), "/a b/P.proto:3:5: warning: unused");
        assert_eq!(said("protoc-gen-c: program not found"), "protoc-gen-c: program not found");
    }
}
