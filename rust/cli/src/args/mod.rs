// SPDX-License-Identifier: Apache-2.0
//! The command line.

mod rti;
mod scope;

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::pins;
use crate::time;
use lf_compiler::maxwait::parse_time;
use lf_linux::devices::moves::Reader;
use lf_linux::rti::TRACE_MIB;

pub use rti::{PORT_DEFAULT, RtiArgs};
pub use scope::{EdgeKind, ScopeArgs};

/// Lingua Franca for Zephyr: compiles, runs and coordinates federated Lingua Franca programs in Rust.
#[derive(Debug, Parser)]
#[command(name = "lfz", version, propagate_version = false, max_term_width = 100)]
#[command(after_help = "`lfz help COMMAND` says more about a command.")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Reads a command line, the program's name first: under the name `RTI`, the program is `lfz rti`, so that launch
    /// scripts of `lfc` find it.
    ///
    /// # Errors
    /// What is wrong with it, or what the user has asked for instead: help, or the version.
    pub fn read(words: impl IntoIterator<Item = OsString>) -> Result<Self, clap::Error> {
        let mut words = words.into_iter().peekable();
        if words.peek().is_some_and(|name| rti::is_rti(name)) {
            return Ok(Self { command: Command::Rti(RtiAlone::try_parse_from(rti::readable(words))?.arguments) });
        }
        let words: Vec<OsString> = words.collect();
        match words.split_at_checked(2) {
            Some((command, rest)) if command[1] == "rti" => {
                Self::try_parse_from(command.iter().cloned().chain(rti::readable(rest.iter().cloned())))
            }
            _ => Self::try_parse_from(words),
        }
    }
}

/// The RTI of `lfz`: coordinates one federation. It has the options of the stock RTI, and more.
#[derive(Debug, Parser)]
#[command(name = "RTI", disable_version_flag = true, max_term_width = 100)]
struct RtiAlone {
    #[command(flatten)]
    arguments: RtiArgs,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Check a program, and print what is wrong with it.
    #[command(long_about = "\
Check a program, and print what is wrong with it.

The language of LF and the syntax of bodies are checked at once. With --bodies, rustc looks at the bodies, too, as they
are in programs for this computer.")]
    Check(CheckArgs),
    /// Print what the compiler worked out: federates, connections, the order of reactions, capacities.
    #[command(long_about = "\
Print what the compiler worked out: federates, connections, the order of reactions, capacities.

With --stp or one of the bounds, print instead how long each federate of a decentralized program has to wait for
messages (`@maxwait`) so that none comes too late, with the connections that demand it; where the program itself waits
for too short a time; and what is left of deadlines. Options go before what the file says for all.")]
    Plan(PlanArgs),
    /// Generate the Rust crates of a program and compile them; nothing is run.
    Build(BuildArgs),
    /// Build all federates for this computer and run them together with their RTI.
    #[command(long_about = "\
Build all federates for this computer and run them together with their RTI.

Each line of output bears the name of the participant that wrote it. ^C stops all participants, and so does the first
one that fails. A program without `federated` runs as a single process.

Exit status: 0 when all participants ended well; 1 when the program does not compile or a participant failed (a program
without `federated` passes its own status on); 124 when --timeout ended the run; 130 after ^C.")]
    Run(RunArgs),
    /// Remove what was generated and compiled of a program, or what was compiled of all.
    #[command(long_about = "\
Remove what was generated and compiled of a program, or with --all what was compiled of all, and say how much room that
has made.

Of a program that is what `lfz build`, `lfz run` and `lfz check --bodies` have left; images are in folders of their own
(`build/zephyr`). With --all it is what cargo keeps of all programs and images, and the crates that they have in common;
it is compiled again when it is needed. A build that is going on is left alone.")]
    Clean(CleanArgs),
    /// Compare edges of pins in recordings: delays, drift, what is missing.
    #[command(long_about = "\
Compare edges of pins in recordings: delays, drift, what is missing.

The recordings are what `lfz run --vcd`, `west lf-fed-run --vcd` or a logic analyser has written (VCD). Each signal is
compared with the reference: edges of one kind that are each other's nearest belong together. Printed are how much later
those of the signal are, in microseconds; the straight line through these delays over time, whose slope is the drift of
one clock against the other; and a histogram of the distances from that line.")]
    Scope(ScopeArgs),
    /// Run the RTI alone, with the options of the stock RTI.
    #[command(disable_version_flag = true)]
    Rti(RtiArgs),
    /// Put what the participants of a run have recorded together: a file for Perfetto, and where time went.
    #[command(long_about = "\
Put what the participants of a run have recorded together: a file for Perfetto, and where time went.

FOLDER has the files that `lfz run --trace FOLDER` or the option --trace of programs have written, and logs (`*.log`,
`*.txt`) of the consoles of boards whose images have CONFIG_LF_TRACE=y. The result is opened at
https://ui.perfetto.dev, which keeps it on this computer.

With --lft, --csv or --bounds, only those files are written, unless --output is there, too.")]
    Trace(TraceArgs),
    /// Say in sentences what the codes mean that images without texts log, such as `lf#0.2.2.b.6`.
    #[command(long_about = "\
Say in sentences what the codes mean that images without texts (CONFIG_LF_TEXTS=n) log, such as `lf#0.2.2.b.6`.

Without a code, copy the standard input to the standard output with sentences in place of codes, line by line, as they
come: `lfz explain < /dev/ttyACM0` shows the console of a board. With --crate, places in generated files, such as those
of panics, become places in the LF program.")]
    Explain {
        /// The folder of the crate that the image was made of: build/lfz/PROGRAM/zephyr/FEDERATE.
        #[arg(long = "crate", value_name = "DIR")]
        crate_folder: Option<PathBuf>,
        /// Codes.
        #[arg(value_name = "CODE")]
        codes: Vec<String>,
    },
    /// Run the processes of a description; what `west lf-fed-run` ends with.
    #[command(
        hide = true,
        long_about = "\
Run the processes of a description, as `lfz run` runs those of a program: the RTI first, then the federates when it
listens, their output prefixed. All end together: the first failure, ^C or the time limit gives the others a while, then
SIGTERM, then SIGKILL.

The description is JSON: { version: 1, speaker: NAME, id: { exactly: ID } or { begins_with: ID }, timeout_ns,
grace_ns, terminate_ns, rti: PROCESS, rti_port, federates: [PROCESS, ...], oscilloscope }. The oscilloscope is
{ file, parts: [{ name, file, is_trace }] }: what is to be one file, recordings of participants and traces of QEMU. A
PROCESS is { name, words: [WORD, ...],
environment: { NAME: TEXT }, folder, crate, status_line }, a WORD a text or { before: TEXT, known: rti_port or
federation_id }.

Exit status: that of the first participant that failed; 124 after the time limit; 130 after ^C."
    )]
    Supervise {
        /// The description; `-` is standard input.
        file: PathBuf,
    },
    /// Print how a script for devices moves the pins of a federate, for `-lf-devices` of images.
    #[command(
        hide = true,
        long_about = "\
Print how a script for devices moves the pins of a federate, for native_sim's -lf-devices: a line for each move with
nanoseconds since the start, the pin, 0 or 1, and the script's line. Lines that nobody of --readers can carry out, or
that do not say whose pin they mean although an image may have it, are errors."
    )]
    Moves {
        /// What inputs do: a file of lines such as `100 ms button0 1`.
        script: PathBuf,
        /// The federate.
        federate: String,
        /// All federates, and what each takes of a script: `a=all,b=pins,c=nothing`. If it is left out, the federate is
        /// alone and takes pins.
        #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = pins::reader)]
        readers: Vec<Reader>,
    },
    /// Print how many nanoseconds a time is, for programs that do not read LF's units themselves.
    #[command(hide = true)]
    Nanoseconds {
        /// `90`, `90s`, `1.5 min`
        #[arg(value_parser = time::parse)]
        time: Duration,
    },
    /// Print what rustc says about crates for Zephyr as said about the LF program; what the west commands show.
    #[command(hide = true)]
    ExplainErrors {
        /// What cargo has printed with `--message-format=json`.
        #[arg(required = true, value_name = "MESSAGES")]
        messages: Vec<PathBuf>,
    },
    /// Run a program that is killed when its parent ends; what participants are started with.
    #[command(hide = true)]
    Guard {
        /// The process that has to be the parent.
        #[arg(long)]
        parent: u32,
        /// The program and its arguments.
        #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
        program: Vec<OsString>,
    },
    /// Wait for the end of the process that holds standard input, and end what its run has left; what runs are watched
    /// over by.
    #[command(hide = true)]
    EndDescendants {
        /// What marks the processes of the run.
        mark: String,
    },
}

/// `lfz check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// Have rustc look at bodies, preambles and values.
    #[arg(long)]
    pub bodies: bool,
    /// Where files are generated and compiled, with --bodies.
    #[command(flatten)]
    pub places: Places,
}

/// `lfz plan`
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// As JSON, for other programs.
    #[arg(long)]
    pub json: bool,
    /// The smallest safe offsets, from this file of bounds (bounds.yaml).
    #[arg(long, value_name = "BOUNDS")]
    pub stp: Option<PathBuf>,
    /// A bound of the time from sending a message to its arrival: `5ms`.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub latency: Option<i64>,
    /// A bound of the difference between any two clocks: `100us`.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub clock_error: Option<i64>,
    /// A bound of the time that a reaction takes: `200us`.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub execution: Option<i64>,
}

impl PlanArgs {
    /// Returns whether the user asks for offsets, and not for the plan.
    pub fn wants_offsets(&self) -> bool {
        self.stp.is_some() || self.latency.is_some() || self.clock_error.is_some() || self.execution.is_some()
    }
}

/// The platform of the generated programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Platform {
    /// Programs for this computer.
    Host,
    /// Zephyr images: crates, Kconfig fragments and overlays, which the west commands compile.
    Zephyr,
}

/// `lfz build`
#[derive(Debug, Args)]
pub struct BuildArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// Only what runs there. `zephyr` without --deployment takes all federates for Zephyr.
    #[arg(long, value_enum)]
    pub platform: Option<Platform>,
    /// The board of all federates, for `--platform zephyr` without --deployment; default: the one that the program's
    /// target property `platform` names, else `native_sim/native/64`.
    #[arg(long, conflicts_with = "deployment")]
    pub board: Option<String>,
    /// Only these federates; all when it is left out.
    #[arg(short, long = "federate", value_name = "FEDERATE", num_args = 1..)]
    pub federates: Vec<String>,
    /// Where each federate runs: its board, its addresses (deployment.yaml).
    #[arg(long, value_name = "FILE")]
    pub deployment: Option<PathBuf>,
    /// Print what was built and where it is as JSON, for other programs.
    #[arg(long)]
    pub json: bool,
    /// Where files are generated and compiled.
    #[command(flatten)]
    pub places: Places,
}

/// `lfz run`
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// Stop the program after this time, counted from its start: `90`, `90s`, `1.5 min`.
    #[arg(long, value_name = "TIME", value_parser = time::parse)]
    pub timeout: Option<Duration>,
    /// Run this RTI instead of the one in `lfz`: a program with the stock RTI's options.
    #[arg(long, value_name = "PROGRAM")]
    pub rti: Option<PathBuf>,
    /// Write bounds that the run of a decentralized program has shown into this file, for `lfz plan --stp`.
    #[arg(long, value_name = "BOUNDS")]
    pub measure: Option<PathBuf>,
    /// Record what happens in all participants in this folder, for `lfz trace`.
    #[arg(long, value_name = "FOLDER")]
    pub trace: Option<PathBuf>,
    /// Record the values of messages that come and of physical actions, too.
    #[arg(long, requires = "trace")]
    pub trace_values: bool,
    /// How large the file of each participant may be, in MiB; when it is full, the oldest records are dropped.
    #[arg(long, value_name = "MIB", requires = "trace", default_value_t = TRACE_MIB,
          value_parser = clap::value_parser!(u32).range(1..))]
    pub trace_limit: u32,
    /// What inputs do, and which devices are real: a file of lines such as `100 ms button0 1` and
    /// `led0 gpio /dev/gpiochip0 17`.
    #[arg(long, value_name = "SCRIPT")]
    pub devices: Option<PathBuf>,
    /// Write down what the pins of all federates do, for `PulseView` or `GTKWave`.
    #[arg(long, value_name = "FILE")]
    pub vcd: Option<PathBuf>,
    /// Where files are generated and compiled.
    #[command(flatten)]
    pub places: Places,
    /// Arguments for every federate, after `--`.
    #[arg(last = true, value_name = "ARGUMENT")]
    pub arguments: Vec<OsString>,
}

/// `lfz clean`
#[derive(Debug, Args)]
pub struct CleanArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf", required_unless_present = "all")]
    pub file: Option<PathBuf>,
    /// What cargo keeps of all programs and images.
    #[arg(long, conflicts_with = "file")]
    pub all: bool,
    /// Where files were generated and compiled.
    #[command(flatten)]
    pub places: Places,
}

/// `lfz trace`
#[derive(Debug, Args)]
pub struct TraceArgs {
    /// The folder of one run.
    pub folder: PathBuf,
    /// The file for Perfetto; FOLDER/trace.perfetto-trace if it is left out.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The names of the program's parts: the trace.json that `lfz build` writes beside what it generates. If it is left
    /// out, that in FOLDER.
    #[arg(long, value_name = "FILE")]
    pub names: Option<PathBuf>,
    /// Write the messages of the RTI into this file, which LF's own tools read.
    #[arg(long, value_name = "FILE")]
    pub lft: Option<PathBuf>,
    /// Write the messages of the RTI into this file, as text: comma-separated values.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write bounds that the run of a decentralized program has shown into this file, for `lfz plan --stp`.
    #[arg(long, value_name = "FILE")]
    pub bounds: Option<PathBuf>,
}

/// Where files are generated and compiled, and how.
#[derive(Debug, Default, Args)]
pub struct Places {
    /// Compile with optimizations.
    #[arg(long)]
    pub release: bool,
    /// Where to generate the crates, instead of `build/lfz/PROGRAM/PLATFORM` beside the program's `src` folder.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Where cargo keeps what it compiles, shared by all programs.
    #[arg(long, value_name = "DIR", env = "LFZ_TARGET_DIR")]
    pub target_dir: Option<PathBuf>,
    /// The lf-zephyr-rs repository with the runtime crates.
    #[arg(long, value_name = "DIR", env = "LFZ_HOME")]
    pub home: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::{Cli, Command};

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn several_federates_may_follow_one_option() {
        let cli = Cli::try_parse_from(["lfz", "build", "P.lf", "-f", "a", "b", "--release"]).expect("it is valid");
        let Command::Build(arguments) = cli.command else { panic!("build was asked for") };
        assert_eq!(arguments.federates, ["a", "b"]);
        assert!(arguments.places.release);
    }

    #[test]
    fn arguments_after_two_dashes_are_the_programs() {
        let cli = Cli::try_parse_from(["lfz", "run", "P.lf", "--timeout", "2 s", "--", "--fast"]).expect("it is valid");
        let Command::Run(arguments) = cli.command else { panic!("run was asked for") };
        assert_eq!(arguments.arguments, ["--fast"]);
        assert_eq!(arguments.timeout.map(|timeout| timeout.as_secs()), Some(2));
    }
}
