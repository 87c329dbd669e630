// SPDX-License-Identifier: Apache-2.0
//! Builds and runs one application.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::Result;

/// No run takes as long, except one that hangs.
pub(super) const TIME_LIMIT: &str = "5min";

/// On what all federates run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// Programs of this computer.
    Host,
    /// Images on `native_sim`, with the sockets of this computer.
    NativeSim,
}

impl fmt::Display for Board {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Host => "Linux",
            Self::NativeSim => "native_sim",
        })
    }
}

/// What the applications are built and run with.
#[derive(Debug)]
pub struct Applications {
    /// The folder of this repository.
    pub repository: PathBuf,
    /// The program `lfz`, built for release.
    pub lfz: PathBuf,
    /// On what they are run.
    pub boards: Vec<Board>,
    /// Of virtual boards and of images, only the first ones are measured.
    pub quick: bool,
}

impl Applications {
    /// An application's main file, by its path in `applications`.
    pub fn file(&self, path: &str) -> PathBuf {
        self.repository.join("applications").join(path)
    }

    /// The text of an application's main file.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(super) fn read(&self, path: &str) -> Result<String> {
        read(&self.file(path))
    }

    /// The text of one of the programs that are only there to be measured.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(super) fn program(&self, name: &str) -> Result<String> {
        read(&self.repository.join("rust/bench/programs").join(name))
    }

    /// Writes a program beside which nothing lies, such as an application with other numbers in it. Programs of one
    /// name are built in one folder, so that most of an image need not be compiled again.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn variant(&self, name: &str, text: &str) -> Result<PathBuf> {
        let folder = self.folder().join(name).join("src");
        fs::create_dir_all(&folder)?;
        let file = folder.join(name).with_extension("lf");
        fs::write(&file, text)?;
        Ok(file)
    }

    /// Builds all federates of a program.
    ///
    /// # Errors
    /// When that fails; the error has what the build said.
    pub fn build(&self, board: Board, file: &Path) -> Result<()> {
        match board {
            Board::Host => {
                let mut command = Command::new(&self.lfz);
                command.arg("build").arg(file).arg("--release").args(["--platform", "host"]);
                self.host_folders(&mut command, file);
                run(&mut command).map(drop)
            }
            Board::NativeSim => run(self.west("lf-fed-build", file).args(["-w", "-b native_sim/native/64"])).map(drop),
        }
    }

    /// Runs all federates of a program that was built with [`Self::build`], with an RTI; what they print.
    ///
    /// # Errors
    /// When the program fails; the error has what it printed.
    pub fn run(&self, board: Board, file: &Path) -> Result<String> {
        match board {
            Board::Host => {
                let mut command = Command::new(&self.lfz);
                command.arg("run").arg(file).args(["--release", "--timeout", TIME_LIMIT]);
                self.host_folders(&mut command, file);
                run(&mut command)
            }
            Board::NativeSim => run(self.west("lf-fed-run", file).args(["--no-build", "--timeout", TIME_LIMIT])),
        }
    }

    /// A west command on a program.
    pub(super) fn west(&self, name: &str, file: &Path) -> Command {
        self.west_in(name, file, &self.build_folder(file))
    }

    /// A west command on a program whose images are built in this folder.
    pub(super) fn west_in(&self, name: &str, file: &Path, build: &Path) -> Command {
        let mut command = Command::new("python3");
        command.arg(self.repository.join("scripts/lf")).arg(name).arg(file);
        command.env("CARGO_TARGET_DIR", self.folder().join("cargo-zephyr"));
        command.arg("--lfc").arg(&self.lfz).arg("--build-dir").arg(build);
        command
    }

    /// Where the images of a program are built.
    pub(super) fn build_folder(&self, file: &Path) -> PathBuf {
        self.folder().join(name(file)).join("build")
    }

    /// Where all that is made lies.
    pub(super) fn folder(&self) -> PathBuf {
        self.repository.join("target/evaluate")
    }

    fn host_folders(&self, command: &mut Command, file: &Path) {
        let folder = self.folder();
        command.arg("--out").arg(folder.join(name(file)).join("host"));
        command.arg("--target-dir").arg(folder.join("cargo"));
        command.arg("--home").arg(&self.repository);
    }
}

fn read(file: &Path) -> Result<String> {
    fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()).into())
}

/// The name of a program.
fn name(file: &Path) -> PathBuf {
    PathBuf::from(file.file_stem().unwrap_or_default())
}

/// What a command prints, on both outputs.
///
/// # Errors
/// When it cannot be started or fails; the error has what it printed.
pub(super) fn run(command: &mut Command) -> Result<String> {
    let output = command.stdin(Stdio::null()).output().map_err(|error| {
        let program = command.get_program().to_string_lossy().into_owned();
        format!("{program} cannot be started: {error}")
    })?;
    let mut text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.push_str(&String::from_utf8_lossy(&output.stderr));
    if output.status.success() {
        Ok(text)
    } else {
        let words: Vec<_> = command.get_args().map(|word| word.to_string_lossy()).collect();
        Err(format!("{}: {}\n{text}", words.join(" "), output.status).into())
    }
}
