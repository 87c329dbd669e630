// SPDX-License-Identifier: Apache-2.0
//! Programs in folders of their own, and the output of `lfz` about them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Returns a folder with these files, of which `P.lf` is the program.
pub(crate) fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in files {
        write(folder.path(), name, text);
    }
    folder
}

pub(crate) fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("it is in the folder")).expect("it can be made");
    fs::write(path, text).expect("it can be written");
}

/// Returns a command for the program in a folder.
pub(crate) fn lfz(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder).args(arguments).args(["P.lf", "--out"]).arg(folder.join("out"));
    command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0").env("CARGO_NET_OFFLINE", "true");
    command
}

pub(crate) fn said(command: &mut Command) -> Output {
    command.output().expect("lfz can be started")
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
