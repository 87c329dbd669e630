// SPDX-License-Identifier: Apache-2.0
//! `lfz debug`

use std::env;
use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::args::{DebugArgs, Platform};
use crate::compile::{Built, Request};
use crate::failure::Failure;
use crate::terminal;

/// The debuggers that are looked for in PATH. The first one is gdb, too, and shows values of Rust's types.
const DEBUGGERS: &[&str] = &["rust-gdb", "gdb", "gdb-multiarch", "rust-lldb", "lldb"];

/// Builds a federate for this computer, and becomes the debugger of it.
pub(super) fn debug(arguments: &DebugArgs) -> Result<ExitCode, Failure> {
    let debugger = match &arguments.debugger {
        Some(program) => program.clone(),
        None => debugger_in_path()?,
    };
    let federates: Vec<String> = arguments.federate.iter().cloned().collect();
    let built = Request {
        platform: Some(Platform::Host),
        federates: &federates,
        ..Request::new(&arguments.file, &arguments.places)
    }
    .build()?;
    let program = program(&built, arguments.federate.as_deref())?;
    let words = command(&debugger, program, &arguments.arguments);
    terminal::show_command(words.iter().cloned());
    let mut words = words.into_iter();
    let error = Command::new(words.next().unwrap_or_default()).args(words).exec();
    Err(Failure::message(format!("the debugger {} cannot be run: {error}", debugger.display())))
}

/// Returns the words with which a debugger gets a program and its arguments.
fn command(debugger: &Path, program: &Path, arguments: &[OsString]) -> Vec<OsString> {
    let is_lldb = debugger.file_name().is_some_and(|name| name.to_string_lossy().contains("lldb"));
    let separator = if is_lldb { "--" } else { "--args" };
    let beginning = [debugger.into(), separator.into(), program.into()];
    beginning.into_iter().chain(arguments.iter().cloned()).collect()
}

/// Returns the program of the federate, or of what is not federated.
fn program<'a>(built: &'a Built, federate: Option<&str>) -> Result<&'a PathBuf, Failure> {
    let name = &built.plan.name;
    let mut programs = built.programs.iter();
    match (federate, programs.next(), programs.next()) {
        (_, Some((_, program)), None) => Ok(program),
        (None, ..) => {
            let all = built.programs.keys().cloned().collect::<Vec<_>>().join(", ");
            Err(Failure::message(format!(
                "{name} has several federates: name the one to debug after the file, of {all}"
            )))
        }
        (Some(federate), ..) => Err(Failure::message(format!("there is no program for the federate {federate}"))),
    }
}

fn debugger_in_path() -> Result<PathBuf, Failure> {
    let path = env::var_os("PATH").unwrap_or_default();
    let mut all = DEBUGGERS.iter().flat_map(|name| env::split_paths(&path).map(move |folder| folder.join(name)));
    all.find(|program| program.is_file()).ok_or_else(|| {
        Failure::message(format!(
            "there is no debugger in PATH ({}): install gdb, or name one with --debugger",
            DEBUGGERS.join(", ")
        ))
    })
}
