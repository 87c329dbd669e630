// SPDX-License-Identifier: Apache-2.0
//! Runs tools, shows their output as it comes, and keeps it if it has to be read.

use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// The longest silence of a tool: longer than the workspace takes to compile on a machine with other work.
const SILENCE_MAX: Duration = Duration::from_secs(20 * 60);

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

/// Runs a tool, shows its standard output as it comes, and returns whether it succeeded and its output. After
/// [`SILENCE_MAX`] without output, its processes are killed: a test that waits forever fails alone.
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
    let mut kept = Vec::new();
    let (sender, pieces) = mpsc::channel();
    if let Some(mut output) = child.stdout.take() {
        thread::spawn(move || {
            let mut piece = [0; 4096];
            while let Ok(length @ 1..) = output.read(&mut piece) {
                if sender.send(piece[..length].to_vec()).is_err() {
                    return;
                }
            }
        });
    }
    loop {
        match pieces.recv_timeout(SILENCE_MAX) {
            Ok(piece) => {
                // A closed terminal is no reason to lose the results.
                let mut output = io::stdout().lock();
                let _ = output.write_all(&piece).and_then(|()| output.flush());
                kept.extend(piece);
            }
            Err(RecvTimeoutError::Timeout) => {
                eprintln!("error: nothing printed for {} s: what runs there is killed", SILENCE_MAX.as_secs());
                succeeds(Command::new("pkill").args(["-KILL", "-P", &child.id().to_string()]));
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    (child.wait().is_ok_and(|status| status.success()), String::from_utf8_lossy(&kept).into_owned())
}

/// Returns the output of a tool, or `None` when it cannot be started or fails. Nothing is shown.
pub(crate) fn captured(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Returns the path of a program that is found in `PATH`.
pub(crate) fn find_program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// Returns the cargo that runs this program, in the repository.
pub(crate) fn cargo(repository: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(repository);
    command
}

/// Returns cargo's target folder.
pub(crate) fn target_folder(repository: &Path) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| repository.join("target"), |folder| repository.join(folder))
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
    // A list of all files says nothing either.
    if let Some((end, _)) = line.char_indices().nth(500) {
        line.truncate(end);
        line.push('…');
    }
    println!("$ {line}");
}
