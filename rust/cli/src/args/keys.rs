// SPDX-License-Identifier: Apache-2.0
//! The arguments of `lfz keys`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// `lfz keys`
#[derive(Debug, Subcommand)]
pub enum KeysCommand {
    /// Make the missing keys of all participants, or of some; those that are there stay.
    New {
        /// The federation.
        #[command(flatten)]
        of: KeyFolder,
        /// The participants: `rti`, or federates; default: all.
        #[arg(value_name = "NAME")]
        names: Vec<String>,
    },
    /// Print a fingerprint of each participant's public key, for comparison with those on other computers.
    Show {
        /// The federation.
        #[command(flatten)]
        of: KeyFolder,
    },
    /// Accept a participant by the public key (or with TLS the certificate) that was made on another computer.
    Trust {
        /// The federation.
        #[command(flatten)]
        of: KeyFolder,
        /// The participant: `rti`, or a federate.
        #[arg(value_name = "NAME")]
        name: String,
        /// The file with its public key.
        #[arg(value_name = "KEY")]
        key: PathBuf,
    },
    /// Shut out a participant whose board was lost, or whose secret key others may know.
    #[command(long_about = "\
Shut out a participant whose board was lost, or whose secret key others may know.

Its keys are removed, also from what `lfz` has built for the RTI and other federates of this computer. The RTI refuses
it from its next start on; the other boards need not be flashed for that. `lfz keys new` makes a key for its
successor.")]
    Distrust {
        /// The federation.
        #[command(flatten)]
        of: KeyFolder,
        /// The participant: `rti`, or a federate.
        #[arg(value_name = "NAME")]
        name: String,
    },
}

/// The program, and the folder of its keys.
#[derive(Debug, Args)]
pub struct KeyFolder {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// The folder with the keys, instead of `keys/PROGRAM` beside the program's `src` folder.
    #[arg(long = "keys", value_name = "DIR")]
    pub folder: Option<PathBuf>,
    /// The deployment of the program, which may name the folder (deployment.yaml).
    #[arg(long, value_name = "FILE")]
    pub deployment: Option<PathBuf>,
}
