// SPDX-License-Identifier: Apache-2.0
//! Running the tools: their output is shown as it comes, and kept where it has to be read.

use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Runs a tool without reading its output; an error to start it counts as its failure.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    show(command);
    match command.stdin(Stdio::null()).status() {
        Ok(status) => status.success(),
        Err(error) => {
            eprintln!("error: cannot start {}: {error}", command.get_program().to_string_lossy());
            false
        }
    }
}

/// Runs a tool, shows its standard output line by line, and returns whether it succeeded and what it printed there.
pub(crate) fn teed(command: &mut Command) -> (bool, String) {
    show(command);
    let started = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
    let mut child = match started {
        Ok(child) => child,
        Err(error) => {
            eprintln!("error: cannot start {}: {error}", command.get_program().to_string_lossy());
            return (false, String::new());
        }
    };
    let mut kept = String::new();
    if let Some(output) = child.stdout.take() {
        let mut reader = BufReader::new(output);
        let mut line = Vec::new();
        while reader.read_until(b'\n', &mut line).is_ok_and(|length| length > 0) {
            let text = String::from_utf8_lossy(&line);
            // A closed terminal is no reason to lose the results.
            let _ = io::stdout().lock().write_all(text.as_bytes());
            kept.push_str(&text);
            line.clear();
        }
    }
    (child.wait().is_ok_and(|status| status.success()), kept)
}

/// What a tool prints, or `None` when it cannot be started or fails. Nothing is shown.
pub(crate) fn captured(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Where a program lies that is looked up in `PATH`.
pub(crate) fn find_program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// The cargo that runs this program, in the repository.
pub(crate) fn cargo(repository: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(repository);
    command
}

fn show(command: &Command) {
    let mut line = command.get_program().to_string_lossy().into_owned();
    // The full path of the tool chain's cargo says nothing.
    if let Some(name) = Path::new(&line).file_name() {
        line = name.to_string_lossy().into_owned();
    }
    for argument in command.get_args() {
        line.push(' ');
        line.push_str(&argument.to_string_lossy());
    }
    println!("$ {line}");
}
