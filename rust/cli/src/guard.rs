// SPDX-License-Identifier: Apache-2.0
//! Programs that cannot outlive this one, however it ends.
//!
//! A signal handler cannot act on SIGKILL. So `lfz` starts processes through `lfz guard`, which asks the kernel to kill
//! it when its parent ends and then becomes the program; the kernel keeps the request across that. The kernel does not
//! apply it to processes that the program starts, for which there is the module `descendants`.

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::unix::process::CommandExt;
use std::process::Command;

use rustix::process::{Signal, getppid, set_parent_process_death_signal};

/// The executable of the running program, independent of its path: it may have been replaced by another version, moved,
/// or deleted.
pub(crate) const THIS_PROGRAM: &str = "/proc/self/exe";

/// The number of arguments of such a command before the program.
pub(crate) const WORDS: usize = 4;

/// Returns a command that runs a program under the guard. The thread that lives longest has to start it, because the
/// kernel watches the thread.
pub(crate) fn command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(THIS_PROGRAM);
    command.arg0("lfz").args(["guard", "--parent", &std::process::id().to_string(), "--"]).arg(program);
    command
}

/// Becomes the program; returns only when that fails.
pub(crate) fn become_program(parent: u32, program: &[OsString]) -> io::Error {
    if let Err(error) = set_parent_process_death_signal(Some(Signal::KILL)) {
        return error.into();
    }
    // The parent may have ended before the request was made.
    if getppid().map(|pid| pid.as_raw_nonzero().get().cast_unsigned()) != Some(parent) {
        return io::Error::other("the process that started this one has ended");
    }
    let Some((name, arguments)) = program.split_first() else { return io::Error::other("there is no program to run") };
    let mut command = Command::new(name);
    if name == THIS_PROGRAM {
        command.arg0("lfz");
    }
    command.args(arguments).exec()
}
