// SPDX-License-Identifier: Apache-2.0
//! The options of `lfz graph`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `lfz graph`
#[derive(Debug, Args)]
pub struct GraphArgs {
    /// The main LF file; `-` is the standard input, whose imports are in the current folder.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// The file for the picture, instead of the standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Name the board and the address of each federate (deployment.yaml).
    #[arg(long, value_name = "FILE")]
    pub deployment: Option<PathBuf>,
    /// Draw the contents of reactors down to this depth: 1 draws those in the main reactor without what is in them.
    #[arg(long, value_name = "N")]
    pub depth: Option<usize>,
    /// Draw each member of a bank.
    #[arg(long)]
    pub expand_banks: bool,
    /// The colours: `auto` follows the reader's settings.
    #[arg(long, value_enum, default_value_t = GraphTheme::Auto)]
    pub theme: GraphTheme,
}

/// The colours of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GraphTheme {
    /// For a light background or a dark one, as the reader's browser says.
    Auto,
    /// For a light background.
    Light,
    /// For a dark background.
    Dark,
}
