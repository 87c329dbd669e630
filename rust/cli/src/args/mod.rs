// SPDX-License-Identifier: Apache-2.0
//! The command line.

mod ctl;
mod graph;
mod keys;
mod output;
mod project;
mod rti;
mod scope;
mod source;

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;

use crate::pins;
use crate::time;
use lf_linux::devices::moves::Reader;
use lf_linux::rti::TRACE_MIB;

pub use ctl::{CtlArgs, CtlVerb};
pub use graph::{GraphArgs, GraphTheme};
pub use keys::{KeyFolder, KeysCommand};
pub use output::{ColorChoice, OutputArgs};
pub use project::{AddArgs, DoctorArgs, HomeArgs, NewArgs, NewLanguage, PackageCommand, TestArgs};
pub use rti::{PORT_DEFAULT, RtiArgs};
pub use scope::{EdgeKind, ScopeArgs};
pub use source::{CheckArgs, FmtArgs, Places, PlanArgs, Platform};

/// The text that `lfz --version` prints behind the name; `-V` prints the number alone.
const LONG_VERSION: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    "\ncommit:   ",
    env!("LFZ_COMMIT"),
    "\nlanguage: Lingua Franca 0.13 with bodies in Rust, C and C++, and micro LF",
    "\nprotocol: that of LF 0.12 and 0.13",
);

/// Lingua Franca for Zephyr: compiles, runs and coordinates federated Lingua Franca programs in Rust.
#[derive(Debug, Parser)]
#[command(name = "lfz", version, long_version = LONG_VERSION, propagate_version = false, max_term_width = 100)]
#[command(after_help = "`lfz help COMMAND` says more about a command.")]
pub struct Cli {
    /// The options of all commands.
    #[command(flatten)]
    pub output: OutputArgs,
    /// The command to run.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Parses a command line, the program's name first: under the name `RTI`, the program is `lfz rti`, so that launch
    /// scripts of `lfc` find it.
    ///
    /// # Errors
    /// Returns the reason why it is invalid, or the text that the user asks for instead: help, or the version.
    pub fn read(words: impl IntoIterator<Item = OsString>) -> Result<Self, clap::Error> {
        let mut words = words.into_iter().peekable();
        if words.peek().is_some_and(|name| rti::is_rti(name)) {
            let command = Command::Rti(RtiAlone::try_parse_from(rti::readable(words))?.arguments);
            return Ok(Self { output: OutputArgs::default(), command });
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
    /// Check programs, and print their errors.
    #[command(long_about = "\
Check programs, and print their errors.

The command always checks the LF code and the syntax of bodies. With --bodies, rustc checks the bodies, too, in the form
that they have in programs for this computer.")]
    Check(CheckArgs),
    /// Print the results of the compiler's analysis: federates, connections, the order of reactions, capacities.
    #[command(long_about = "\
Print the results of the compiler's analysis: federates, connections, the order of reactions, capacities.

With --stp or one of the bounds, print instead how long each federate of a decentralized program has to wait for
messages (`@maxwait`) so that none is late, with the connections that demand it; the waits of the program itself that
are too short; and the remaining time of deadlines. Options override the values in the file.")]
    Plan(PlanArgs),
    /// Draw a program: reactors, ports, reactions, and the connections between them, as SVG.
    #[command(long_about = "\
Draw a program: reactors, ports, reactions, and the connections between them, as SVG.

The picture has the reactors in each other, with modes, timers and actions, and the delays on the connections; of a
federation also the coordination and, with --deployment, the board of each federate. A bank is one reactor with the
number of its members. The guide explains the signs.")]
    Graph(GraphArgs),
    /// Generate the Rust crates of a program and compile them, without running them.
    Build(BuildArgs),
    /// Build all federates for this computer and run them together with their RTI.
    #[command(long_about = "\
Build all federates for this computer and run them together with their RTI.

Each line of output bears the name of the participant that wrote it. ^C stops all participants, and so does the first
one that fails. A program without `federated` runs as a single process.

Exit status: 0 when all participants ended well; 1 when the program does not compile or a participant failed (a program
without `federated` passes its own status on); 124 when --timeout ended the run; 130 after ^C.")]
    Run(RunArgs),
    /// Start, stop and swap transient federates of a federation that `lfz run` runs.
    #[command(long_about = "\
Start, stop and swap transient federates of a federation that `lfz run` runs in another terminal. Without a command, \
show all such runs and their federates.")]
    Ctl(CtlArgs),
    /// Build a program, or one federate, and start a debugger with it.
    #[command(long_about = "\
Build a program, or one federate, and start a debugger with it: breakpoints are at lines of the LF file, as in
`break Program.lf:12`.

The others of a federation run in another terminal, by `lfz run FILE.lf --without FEDERATE`, which prints the arguments
that the federate needs.")]
    Debug(DebugArgs),
    /// Format LF files: indentation, blanks between tokens, empty lines.
    #[command(long_about = "\
Format LF files: indentation, blanks between tokens, empty lines.

Comments keep their words, and code of the target language stays as it is. Lines end where you end them. A file with
errors of syntax is left alone.

Exit status: 0 when all files are formatted; 1 when a file cannot be, or with --check is not.")]
    Fmt(FmtArgs),
    /// Make the folder of a new program, which runs and has a test.
    New(NewArgs),
    /// Run the tests of a project: programs that check themselves, and described tests of reactors.
    #[command(long_about = "\
Run the tests of a project: programs that check themselves, and described tests of reactors.

A test is a file of LF with a main or federated reactor, which passes if it ends with status 0, or a case in a file
whose name ends in .test.yaml: values of a reactor's inputs at their times, and those that its outputs have then, in
virtual time. The guide has a chapter about both.

Exit status: 0 when all tests pass; 1 when one fails, or there is none.")]
    Test(TestArgs),
    /// Add packages of reactors to the project in this folder, or fetch those that it has.
    #[command(
        subcommand,
        long_about = "\
Add packages of reactors to the project in this folder, or fetch those that it has.

A package is a repository of git whose folder `src/lib` has reactors. It becomes a folder in `lf-packages/`, beside
`src`, and programs import from it: `import Filter from <filters>`. The file lf-packages.json has the commit of each,
and belongs into the project's own repository; `lfz package fetch` makes the folders of it."
    )]
    Package(PackageCommand),
    /// Make, show, trust and distrust the keys of a federation whose connections are encrypted.
    #[command(
        subcommand,
        long_about = "\
Make, show, trust and distrust the keys of a federation whose connections are encrypted.

Each participant has a secret key, and the others have its public one. They are in `keys/PROGRAM` beside the program's
`src` folder, or where --keys or `security: { keys: FOLDER }` of the deployment file says: `NAME.key` is secret,
`NAME.pub` (with TLS a certificate, `NAME.crt`) is not. Only this user can read the folder, and git ignores it.
`lfz run` and `lfz build` give each participant its own secret key only."
    )]
    Keys(KeysCommand),
    /// Add crates to a program, for its bodies: an entry in `cargo-dependencies` of its target declaration.
    #[command(long_about = "\
Add crates to a program, for its bodies: an entry in `cargo-dependencies` of its target declaration.

Cargo finds the newest version, as `cargo add` does. An entry that is there already is replaced; the rest of the file
stays as it is.")]
    Add(AddArgs),
    /// Tell which programs in a folder work, what has no effect, and what to change.
    #[command(long_about = "\
Tell which programs in a folder work, what has no effect, and what to change: for programs that were written for another
compiler of Lingua Franca.

All files of LF and micro LF in the folder, and in those in it, are checked as by `lfz check`; folders of builds and
hidden ones are left out. Reasons are listed once, with their first places. At the end stand the tools that builds need.

Exit status: 0 when all programs for this compiler work; 1 when one needs a change, or cannot be read.")]
    Doctor(DoctorArgs),
    /// Remove the generated and compiled files of a program, or the compiled files of all programs.
    #[command(long_about = "\
Remove the generated and compiled files of a program, or with --all the compiled files of all programs, and print the
freed space.

The files of a program are those of `lfz build`, `lfz run` and `lfz check --bodies`; images have folders of their own
(`build/zephyr`). With --all they are cargo's files of all programs and images, and of the crates that they share; the
next build compiles these again. The command does not touch a running build.")]
    Clean(CleanArgs),
    /// Compare edges of pins in recordings: delays, drift, missing edges.
    #[command(long_about = "\
Compare edges of pins in recordings: delays, drift, missing edges.

The recordings are VCD files of `lfz run --vcd`, `west lf-fed-run --vcd` or a logic analyser. The command compares each
signal with the reference: edges of one kind that are each other's nearest belong together. It prints the delays of the
signal's edges, in microseconds; the straight line through these delays over time, whose slope is the drift of one clock
against the other; and a histogram of the distances from that line.")]
    Scope(ScopeArgs),
    /// Run the RTI alone, with the options of the stock RTI.
    #[command(disable_version_flag = true)]
    Rti(RtiArgs),
    /// Merge the recordings of a run's participants: a file for Perfetto, and a table of times.
    #[command(long_about = "\
Merge the recordings of a run's participants: a file for Perfetto, and a table of times.

FOLDER has the files that `lfz run --trace FOLDER` or the option --trace of programs have written, and logs (`*.log`,
`*.txt`) of the consoles of boards whose images have CONFIG_LF_TRACE=y. Open the result at https://ui.perfetto.dev; it
does not leave this computer.

With --lft, --csv or --bounds, the command writes only those files, unless --output is given, too.")]
    Trace(TraceArgs),
    /// Explain codes such as `lf#0.2.2.b.6` that images without texts log.
    #[command(long_about = "\
Explain codes such as `lf#0.2.2.b.6` that images without texts (CONFIG_LF_TEXTS=n) log.

Without a code, copy the standard input to the standard output and replace codes by sentences, line by line:
`lfz explain < /dev/ttyACM0` shows the console of a board. With --crate, places in generated files, such as those of
panics, become places in the LF program.")]
    Explain {
        /// The folder of the image's crate: build/lfz/PROGRAM/zephyr/FEDERATE.
        #[arg(long = "crate", value_name = "DIR")]
        crate_folder: Option<PathBuf>,
        /// Codes.
        #[arg(value_name = "CODE")]
        codes: Vec<String>,
    },
    /// Build and run images in a Zephyr workspace: `lfz west lf-fed-build src/Program.lf`.
    #[command(long_about = "\
Build and run images in a Zephyr workspace: `lfz west lf-fed-build src/Program.lf`.

The commands are lf-build, lf-run, lf-fed-build, lf-fed-run and lf-fed-flash; each says more with --help. They are those
that west has in a workspace whose manifest names this project, and take the workspace around the current folder, that
of ZEPHYR_BASE, or the registered one.")]
    West {
        /// The command, and its arguments.
        #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<OsString>,
    },
    /// Print the folder with the sources of the runtime, with which programs are compiled.
    Home(HomeArgs),
    /// Serve an editor: the language server protocol over standard input and output.
    Lsp,
    /// Print the script by which a shell completes command lines of `lfz`.
    #[command(long_about = "\
Print the script by which a shell completes command lines of `lfz`.

For bash: `lfz completions bash > ~/.local/share/bash-completion/completions/lfz`. For fish:
`lfz completions fish > ~/.config/fish/completions/lfz.fish`. For zsh: into a file `_lfz` in a folder of `fpath`.")]
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Write manual pages, for `man lfz` and `man lfz-run`.
    Man {
        /// The folder of the pages, such as `~/.local/share/man/man1`.
        folder: PathBuf,
    },
    /// Run the processes of a description, as the last step of `west lf-fed-run`.
    #[command(
        hide = true,
        long_about = "\
Run the processes of a description, as `lfz run` runs those of a program: the RTI first, then the federates when it
listens, their output prefixed. All end together: the first failure, ^C or the time limit gives the others a while, then
SIGTERM, then SIGKILL.

The description is JSON: { version: 1, speaker: NAME, id: { exactly: ID } or { begins_with: ID }, user, timeout_ns,
grace_ns, terminate_ns, rti: PROCESS, rti_port, federates: [PROCESS, ...], left_out: [PROCESS, ...], oscilloscope }.
Those of left_out are started by `lfz ctl`. The oscilloscope is { file, parts: [{ name, file, is_trace }] }: what is to
be one file, recordings of participants and traces of QEMU. A PROCESS is { name, words: [WORD, ...],
environment: { NAME: TEXT }, folder, crate, status_line, transient, restarts, image_id, instances, streams }, a WORD a
text or { before: TEXT, known: rti_port or federation_id }. image_id is the id of a federate that understands no signal,
which an RTI with streams: commands tells to leave; instances is any, one, or { spare: [WORD, ...] } for two, the second
of which is started so.

Exit status: that of the first participant that failed; 124 after the time limit; 130 after ^C."
    )]
    Supervise {
        /// The description; `-` is standard input.
        file: PathBuf,
    },
    /// Print the part of a script for devices that moves the pins of a federate, for `-lf-devices` of images.
    #[command(
        hide = true,
        long_about = "\
Print how a script for devices moves the pins of a federate, for native_sim's -lf-devices: a line for each move with
nanoseconds since the start, the pin, 0 or 1, and the script's line. Lines that nobody of --readers can carry out, or
that do not say whose pin they mean although an image may have it, are errors."
    )]
    Moves {
        /// The behavior of inputs: a file of lines such as `100 ms button0 1`.
        script: PathBuf,
        /// The federate.
        federate: String,
        /// All federates, with the lines of a script that each reads: `a=all,b=pins,c=nothing`. By default the federate
        /// is alone and reads pins.
        #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = pins::reader)]
        readers: Vec<Reader>,
    },
    /// Convert a time to nanoseconds, for programs that do not parse LF's units themselves.
    #[command(hide = true)]
    Nanoseconds {
        /// `90`, `90s`, `1.5 min`
        #[arg(value_parser = time::parse)]
        time: Duration,
    },
    /// Print rustc's errors in crates for Zephyr as errors of the LF program, for the west commands.
    #[command(hide = true)]
    ExplainErrors {
        /// The output of cargo with `--message-format=json`.
        #[arg(required = true, value_name = "MESSAGES")]
        messages: Vec<PathBuf>,
    },
    /// Make the debugging information of an image name the LF program, for Zephyr's build.
    #[command(hide = true)]
    NameLines {
        /// The image, in the format ELF.
        image: PathBuf,
        /// The folder of its crate.
        crate_folder: PathBuf,
    },
    /// Run a program, and kill it when its parent ends; participants are started with this command.
    #[command(hide = true)]
    Guard {
        /// The process that has to be the parent.
        #[arg(long)]
        parent: u32,
        /// The program and its arguments.
        #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
        program: Vec<OsString>,
    },
    /// Wait for the end of the process that holds standard input, and end all other processes of its run.
    #[command(hide = true)]
    EndDescendants {
        /// The mark of the run's processes.
        mark: String,
    },
}

/// `lfz build`
#[derive(Debug, Args)]
pub struct BuildArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// Build only the federates for this platform. `zephyr` without --deployment selects all federates for Zephyr.
    #[arg(long, value_enum)]
    pub platform: Option<Platform>,
    /// The board of all federates, for `--platform zephyr` without --deployment; default: the one that the program's
    /// target property `platform` names, else `native_sim/native/64`.
    #[arg(long, conflicts_with = "deployment")]
    pub board: Option<String>,
    /// Build only these federates; default: all.
    #[arg(short, long = "federate", value_name = "FEDERATE", num_args = 1..)]
    pub federates: Vec<String>,
    /// The board and the addresses of each federate (deployment.yaml).
    #[arg(long, value_name = "FILE")]
    pub deployment: Option<PathBuf>,
    /// The folder with the keys of the federation, instead of `keys/PROGRAM` beside the program's `src` folder.
    #[arg(long, value_name = "DIR")]
    pub keys: Option<PathBuf>,
    /// Print the built files and their paths as JSON, for other programs.
    #[arg(long)]
    pub json: bool,
    /// The folders for generated and compiled files.
    #[command(flatten)]
    pub places: Places,
}

/// `lfz run`
#[derive(Clone, Debug, Args)]
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
    /// Write the measured bounds of a decentralized program into this file, for `lfz plan --stp`.
    #[arg(long, value_name = "BOUNDS")]
    pub measure: Option<PathBuf>,
    /// Record the events of all participants in this folder, for `lfz trace`.
    #[arg(long, value_name = "FOLDER")]
    pub trace: Option<PathBuf>,
    /// Record the values of received messages and of physical actions, too.
    #[arg(long, requires = "trace")]
    pub trace_values: bool,
    /// The size limit of each participant's file, in MiB; a full file drops its oldest records.
    #[arg(long, value_name = "MIB", requires = "trace", default_value_t = TRACE_MIB,
          value_parser = clap::value_parser!(u32).range(1..))]
    pub trace_limit: u32,
    /// The behavior of inputs, and the real devices: a file of lines such as `100 ms button0 1` and `led0 gpio
    /// /dev/gpiochip0 17`.
    #[arg(long, value_name = "SCRIPT")]
    pub devices: Option<PathBuf>,
    /// Record the pins of all federates in this file, for `PulseView` or `GTKWave`.
    #[arg(long, value_name = "FILE")]
    pub vcd: Option<PathBuf>,
    /// The folder with the keys of the federation, instead of `keys/PROGRAM` beside the program's `src` folder. Without
    /// that folder, the participants get keys for this run.
    #[arg(long, value_name = "DIR")]
    pub keys: Option<PathBuf>,
    /// Run in virtual time. This number decides how long messages travel between the participants, which datagrams are
    /// lost, and how far clocks differ; the same number gives the same run.
    #[arg(long, value_name = "SEED", conflicts_with_all = ["rti", "devices", "without"])]
    pub seed: Option<u64>,
    /// Build these federates and leave their start to you: the command line of each is printed.
    #[arg(long, value_name = "FEDERATE", num_args = 1..)]
    pub without: Vec<String>,
    /// Build and start the program again whenever one of its files changes. While a program has errors, its last
    /// version goes on.
    #[arg(long)]
    pub watch: bool,
    /// The folders for generated and compiled files.
    #[command(flatten)]
    pub places: Places,
    /// Arguments for every federate, after `--`.
    #[arg(last = true, value_name = "ARGUMENT")]
    pub arguments: Vec<OsString>,
}

/// `lfz debug`
#[derive(Debug, Args)]
pub struct DebugArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf")]
    pub file: PathBuf,
    /// The federate to debug.
    pub federate: Option<String>,
    /// The debugger, which has the options of gdb or lldb; default: the first of rust-gdb, gdb, gdb-multiarch,
    /// rust-lldb and lldb in PATH.
    #[arg(long, value_name = "PROGRAM")]
    pub debugger: Option<PathBuf>,
    /// The folders for generated and compiled files.
    #[command(flatten)]
    pub places: Places,
    /// Arguments for the program, after `--`.
    #[arg(last = true, value_name = "ARGUMENT")]
    pub arguments: Vec<OsString>,
}

/// `lfz clean`
#[derive(Debug, Args)]
pub struct CleanArgs {
    /// The main LF file.
    #[arg(value_name = "FILE.lf", required_unless_present = "all")]
    pub file: Option<PathBuf>,
    /// Remove cargo's files of all programs and images.
    #[arg(long, conflicts_with = "file")]
    pub all: bool,
    /// The folders for generated and compiled files.
    #[command(flatten)]
    pub places: Places,
}

/// `lfz trace`
#[derive(Debug, Args)]
pub struct TraceArgs {
    /// The folder of one run.
    pub folder: PathBuf,
    /// The file for Perfetto; default: FOLDER/trace.perfetto-trace.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The names of the program's parts: the trace.json that `lfz build` writes beside the generated files; default:
    /// that in FOLDER.
    #[arg(long, value_name = "FILE")]
    pub names: Option<PathBuf>,
    /// Write the messages of the RTI into this file, for LF's own tools.
    #[arg(long, value_name = "FILE")]
    pub lft: Option<PathBuf>,
    /// Write the messages of the RTI into this file, as text: comma-separated values.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write the measured bounds of a decentralized program into this file, for `lfz plan --stp`.
    #[arg(long, value_name = "FILE")]
    pub bounds: Option<PathBuf>,
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
