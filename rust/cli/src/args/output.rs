// SPDX-License-Identifier: Apache-2.0
//! The options of all commands: how much they say, and in which colours.

use clap::{Args, ValueEnum};

/// The heading of these options in the help of each command.
const HEADING: &str = "Options of all commands";

/// The options of all commands: how much they say, and in which colours.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct OutputArgs {
    /// Say only what is wrong.
    #[arg(short, long, global = true, help_heading = HEADING, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say which commands are run, too.
    #[arg(short, long, global = true, help_heading = HEADING)]
    pub verbose: bool,
    /// Colours: `auto` has them on a terminal unless the variable `NO_COLOR` is set.
    #[arg(long, global = true, help_heading = HEADING)]
    #[arg(value_enum, value_name = "WHEN", default_value_t = ColorChoice::Auto)]
    pub color: ColorChoice,
}

/// When texts have colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ColorChoice {
    /// On a terminal.
    #[default]
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}
