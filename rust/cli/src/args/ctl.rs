// SPDX-License-Identifier: Apache-2.0
//! The options of `lfz ctl`.

use clap::{Args, Subcommand};

/// `lfz ctl`
#[derive(Debug, Args)]
pub struct CtlArgs {
    /// The command for a federate.
    #[command(subcommand)]
    pub verb: Option<CtlVerb>,
    /// The run, if there are several: its process id, as `lfz ctl` shows it.
    #[arg(long, global = true, value_name = "RUN")]
    pub run: Option<u32>,
}

/// The commands of `lfz ctl`.
#[derive(Debug, Subcommand)]
pub enum CtlVerb {
    /// Start a federate that does not run.
    Start {
        /// The federate.
        federate: String,
    },
    /// Have a transient federate leave: it runs its shutdown reactions. One that was asked before is killed.
    Stop {
        /// The federate.
        federate: String,
    },
    /// Start another instance of a transient federate, such as a newer build: it takes the place of the one that runs.
    Swap {
        /// The federate.
        federate: String,
    },
}
