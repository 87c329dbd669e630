// SPDX-License-Identifier: Apache-2.0
//! `lfz add`

mod edit;

use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use toml_edit::{DocumentMut, Value};

use crate::args::AddArgs;
use crate::compile::{cargo_program, read_text};
use crate::failure::Failure;
use crate::replace::replace;
use crate::terminal;
use edit::Dependency;

/// Adds crates to the target declaration of a program, with the versions that cargo takes.
pub(super) fn add(arguments: &AddArgs) -> Result<ExitCode, Failure> {
    let file = &arguments.file;
    let shown = file.display();
    let mut text = read_text(file).map_err(|reason| Failure::message(format!("{shown} cannot be read: {reason}")))?;
    // Without a name, cargo reads it in the folder or the repository.
    let crates: Vec<Option<&String>> =
        if arguments.crates.is_empty() { vec![None] } else { arguments.crates.iter().map(Some).collect() };
    let mut added = Vec::new();
    for name in crates {
        for dependency in dependencies(name.map(String::as_str), arguments)? {
            text = edit::with_dependency(&file.to_string_lossy(), &text, &dependency)?;
            added.push(dependency);
        }
    }
    replace(file, text.as_bytes()).map_err(|error| Failure::message(format!("{shown} cannot be written: {error}")))?;
    for Dependency { name, value } in added {
        terminal::inform(format_args!("{shown} has {name}: {value}"));
    }
    Ok(ExitCode::SUCCESS)
}

/// Asks cargo for a crate, which it adds to a package that nobody keeps.
fn dependencies(name: Option<&str>, arguments: &AddArgs) -> Result<Vec<Dependency>, Failure> {
    let folder = tempfile::tempdir()?;
    let manifest = folder.path().join("Cargo.toml");
    fs::create_dir(folder.path().join("src"))?;
    fs::write(folder.path().join("src/lib.rs"), "")?;
    fs::write(&manifest, "[package]\nname = \"lfz-add\"\nversion = \"0.0.0\"\nedition = \"2024\"\n[workspace]\n")?;
    let mut command = Command::new(cargo_program());
    command.args(["add", "--quiet", "--manifest-path"]).arg(&manifest).args(name).stdin(Stdio::null());
    let options = [
        ("--git", &arguments.git),
        ("--branch", &arguments.branch),
        ("--tag", &arguments.tag),
        ("--rev", &arguments.rev),
    ];
    for (option, value) in options {
        command.args(value.iter().flat_map(|value| [option, value.as_str()]));
    }
    if let Some(path) = &arguments.path {
        command.arg("--path").arg(existing(path)?);
    }
    if !arguments.features.is_empty() {
        command.arg("--features").arg(arguments.features.join(","));
    }
    if arguments.no_default_features {
        command.arg("--no-default-features");
    }
    let words = [command.get_program()].into_iter().chain(command.get_args()).map(ToOwned::to_owned);
    terminal::show_command(words.collect::<Vec<_>>());
    let output = command.output().map_err(|error| Failure::message(format!("cargo cannot be run: {error}")))?;
    if !output.status.success() {
        terminal::report(String::from_utf8_lossy(&output.stderr));
        return Err(Failure::Reported);
    }
    let document: DocumentMut = fs::read_to_string(&manifest)?
        .parse()
        .map_err(|error| Failure::message(format!("cargo has written what is no TOML: {error}")))?;
    let table = document.get("dependencies").and_then(|table| table.as_table_like());
    let entries = table.into_iter().flat_map(|table| table.iter());
    entries
        .filter_map(|(name, item)| Some((name, item.as_value()?)))
        .map(|(name, value)| Ok(Dependency { name: name.to_owned(), value: written(value, arguments)? }))
        .collect()
}

/// Returns a dependency of cargo as LF has it.
fn written(value: &Value, arguments: &AddArgs) -> Result<String, Failure> {
    let quoted = |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
    let Some(table) = value.as_inline_table() else { return Ok(quoted(value.as_str().unwrap_or_default())) };
    let mut parts = Vec::new();
    for (key, value) in table {
        let value = match (key, value) {
            ("path", _) => {
                let Some(path) = &arguments.path else { continue };
                quoted(&from_folder_of(&arguments.file, path)?)
            }
            // The version of a crate in a folder or a repository is the one that is there.
            ("version", _) if arguments.path.is_some() || arguments.git.is_some() => continue,
            (_, Value::Array(items)) => {
                let items: Vec<String> = items.iter().filter_map(|item| item.as_str().map(quoted)).collect();
                format!("[{}]", items.join(", "))
            }
            (_, Value::Boolean(flag)) => flag.value().to_string(),
            (_, value) => quoted(value.as_str().unwrap_or_default()),
        };
        parts.push(format!("{key}: {value}"));
    }
    Ok(format!("{{ {} }}", parts.join(", ")))
}

fn existing(path: &Path) -> Result<PathBuf, Failure> {
    fs::canonicalize(path).map_err(|error| Failure::message(format!("{}: {error}", path.display())))
}

/// Returns the path of a folder as seen from the folder of a file.
fn from_folder_of(file: &Path, path: &Path) -> Result<String, Failure> {
    let (file, path) = (existing(file)?, existing(path)?);
    let from: Vec<Component<'_>> = file.parent().unwrap_or(&file).components().collect();
    let to: Vec<Component<'_>> = path.components().collect();
    let common = from.iter().zip(&to).take_while(|(one, other)| one == other).count();
    let mut relative: PathBuf = from[common..].iter().map(|_| Component::ParentDir).collect();
    relative.extend(&to[common..]);
    let text = relative.to_str().map(str::to_owned);
    text.ok_or_else(|| Failure::message(format!("{} is no UTF-8 text", relative.display())))
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;
    use toml_edit::Value;

    use super::written;
    use crate::args::{Cli, Command};

    fn value(toml: &str, options: &[&str]) -> String {
        let cli = Cli::try_parse_from([&["lfz", "add", "P.lf", "a"], options].concat()).expect("it is valid");
        let Command::Add(arguments) = cli.command else { panic!("add was asked for") };
        written(&toml.parse::<Value>().expect("it is TOML"), &arguments).expect("no path is in it")
    }

    #[test]
    fn dependencies_of_cargo_are_written_as_lf_has_them() {
        assert_eq!(value("\"0.2.15\"", &[]), "\"0.2.15\"");
        let features = "{ version = \"1\", default-features = false, features = [\"derive\", \"rc\"] }";
        let written = "{ version: \"1\", default-features: false, features: [\"derive\", \"rc\"] }";
        assert_eq!(value(features, &[]), written);
        let git = "{ git = \"https://a.b/c\", tag = \"v1\", version = \"1.0.0\" }";
        assert_eq!(value(git, &["--git", "https://a.b/c"]), "{ git: \"https://a.b/c\", tag: \"v1\" }");
    }
}
