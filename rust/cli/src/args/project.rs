// SPDX-License-Identifier: Apache-2.0
//! The arguments of commands about whole projects: new ones, foreign ones, their tests and their packages.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand, ValueEnum};

use super::Places;
use crate::time;

/// `lfz new`
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The folder, after which the program is named.
    #[arg(value_name = "NAME")]
    pub folder: PathBuf,
    /// The language of the bodies.
    #[arg(long, value_enum, default_value_t = NewLanguage::Rust)]
    pub target: NewLanguage,
    /// Make each reactor a federate, a program of its own.
    #[arg(long)]
    pub federated: bool,
    /// Say how an image for this board is built; of a federation, the sensor is on it.
    #[arg(long)]
    pub board: Option<String>,
}

/// The languages of new programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NewLanguage {
    /// Bodies in Rust.
    Rust,
    /// Bodies in C.
    C,
}

/// `lfz test`
#[derive(Debug, Args)]
pub struct TestArgs {
    /// The folders with tests, or single files.
    #[arg(value_name = "PATH", default_value = "test")]
    pub paths: Vec<PathBuf>,
    /// Run tests only whose names contain this.
    #[arg(long, value_name = "TEXT")]
    pub filter: Option<String>,
    /// Print the names of the tests, and run none.
    #[arg(long)]
    pub list: bool,
    /// Write the outcomes into this file, in the format of `JUnit`.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Stop a test that takes longer, which fails then.
    #[arg(long, value_name = "TIME", value_parser = time::parse, default_value = "60 s")]
    pub timeout: Duration,
    /// Compile with optimizations.
    #[arg(long, conflicts_with = "board")]
    pub release: bool,
    /// Run the tests as images on this board, which `native_sim` or QEMU plays: `native_sim/native/64`.
    #[arg(long, value_name = "BOARD")]
    pub board: Option<String>,
    /// Run programs in virtual time. Seeds, `7` or `0..20`, decide how long messages travel between federates, which
    /// datagrams are lost, and how far clocks differ: a federated program runs once with each of them.
    #[arg(long, value_name = "SEEDS", value_parser = seeds, conflicts_with = "board")]
    pub seed: Option<Range<u64>>,
}

/// Parses `7` or `0..20`, without the last.
fn seeds(text: &str) -> Result<Range<u64>, String> {
    let number =
        |text: &str| text.parse::<u64>().map_err(|_| format!("\"{text}\" is no number; seeds are `7` or `0..20`"));
    let (first, end) = match text.split_once("..") {
        Some((first, end)) => (number(first)?, number(end)?),
        None => (number(text)?, number(text)?.saturating_add(1)),
    };
    if first < end { Ok(first..end) } else { Err("there are no seeds between these two: write `0..20`".to_owned()) }
}

/// `lfz add`
#[derive(Debug, Args)]
pub struct AddArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// Crates, each with the accepted versions if they are not those that fit the newest one: `libm` or `libm@0.2`.
    #[arg(value_name = "CRATE", required_unless_present_any = ["path", "git"])]
    pub crates: Vec<String>,
    /// Features of the crates to enable.
    #[arg(long, value_name = "FEATURE", value_delimiter = ',')]
    pub features: Vec<String>,
    /// Leave out the features that the crates have by default; images need that of many crates.
    #[arg(long)]
    pub no_default_features: bool,
    /// The folder of the crate.
    #[arg(long, value_name = "DIR", conflicts_with = "git")]
    pub path: Option<PathBuf>,
    /// The repository of the crate.
    #[arg(long, value_name = "URL")]
    pub git: Option<String>,
    /// A branch of the repository.
    #[arg(long, value_name = "NAME", requires = "git", group = "revision")]
    pub branch: Option<String>,
    /// A tag of the repository.
    #[arg(long, value_name = "NAME", requires = "git", group = "revision")]
    pub tag: Option<String>,
    /// A commit of the repository.
    #[arg(long, value_name = "COMMIT", requires = "git", group = "revision")]
    pub rev: Option<String>,
}

/// `lfz package`
#[derive(Debug, Subcommand)]
pub enum PackageCommand {
    /// Add a package.
    Add {
        /// The address of its repository, or the path.
        git: String,
        /// A branch, a tag or a commit, instead of the newest commit.
        #[arg(long, value_name = "REVISION")]
        revision: Option<String>,
        /// Its name in imports, instead of the repository's.
        #[arg(long)]
        name: Option<String>,
    },
    /// Fetch the packages that lf-packages.json names, at their commits.
    Fetch,
    /// List them.
    List,
}

/// `lfz home`
#[derive(Debug, Args)]
pub struct HomeArgs {
    /// The folders for generated and compiled files.
    #[command(flatten)]
    pub places: Places,
}

/// `lfz doctor`
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// The folders, or single files.
    #[arg(value_name = "FOLDER", default_value = ".")]
    pub folders: Vec<PathBuf>,
}
