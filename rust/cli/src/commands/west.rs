// SPDX-License-Identifier: Apache-2.0
//! `lfz west`

use std::ffi::OsString;
use std::os::unix::process::CommandExt as _;
use std::process::{Command, ExitCode};

use crate::failure::Failure;
use crate::home;

/// Becomes the command for a Zephyr workspace; returns only if that cannot be run.
pub(super) fn west(arguments: &[OsString]) -> Result<ExitCode, Failure> {
    let mut command = Command::new("python3");
    command.arg(home::folder()?.join("scripts/lf")).args(arguments);
    // The commands call this very program.
    command.env("LFZ", std::env::current_exe()?);
    let error = command.exec();
    Err(Failure::message(format!("python3, which the commands for Zephyr need, cannot be run: {error}")))
}
