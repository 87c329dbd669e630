// SPDX-License-Identifier: Apache-2.0
//! The commands of `lfz`, one module each.

mod add;
mod build;
mod check;
mod clean;
mod codes;
mod ctl;
mod debug;
mod doctor;
mod explain;
mod fmt;
mod graph;
mod keys;
mod manual;
mod new;
mod package;
mod plan;
mod rti;
mod run;
mod supervise;
mod test;
mod trace;
mod west;

use std::process::ExitCode;

use crate::args::{Cli, Command};
use crate::compile::home;
use crate::descendants;
use crate::edges;
use crate::failure::Failure;
use crate::guard;
use crate::lsp;
use crate::pins;
use crate::terminal;

pub(crate) use rti::listening_port;

/// Runs the command that a command line asks for, and returns this program's exit status.
pub fn execute(read: Result<Cli, clap::Error>) -> ExitCode {
    let result = match read {
        Ok(cli) => {
            terminal::set(cli.output);
            execute_command(cli.command)
        }
        // It may also be help, or the version, at the user's request.
        Err(error) => match error.print() {
            Ok(()) => Ok(ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(u8::MAX))),
            Err(error) => Err(terminal::named(error).into()),
        },
    };
    result.unwrap_or_else(|failure| {
        if let Failure::Message(text) = failure {
            terminal::report(format_args!("error: {text}"));
        }
        ExitCode::FAILURE
    })
}

fn execute_command(command: Command) -> Result<ExitCode, Failure> {
    match command {
        Command::Check(arguments) => check::check(&arguments),
        Command::Plan(arguments) => plan::plan(&arguments),
        Command::Graph(arguments) => graph::graph(&arguments),
        Command::Build(arguments) => build::build(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Ctl(arguments) => ctl::ctl(&arguments),
        Command::Debug(arguments) => debug::debug(&arguments),
        Command::Fmt(arguments) => Ok(fmt::fmt(&arguments)),
        Command::Add(arguments) => add::add(&arguments),
        Command::Package(command) => package::package(&command),
        Command::West { arguments } => west::west(&arguments),
        Command::Home(arguments) => {
            Ok(terminal::print(home(&arguments.places)?.display()).map(|()| ExitCode::SUCCESS)?)
        }
        Command::Keys(command) => keys::keys(&command),
        Command::New(arguments) => new::new(&arguments),
        Command::Test(arguments) => test::test(&arguments),
        Command::Doctor(arguments) => doctor::doctor(&arguments),
        Command::Clean(arguments) => clean::clean(&arguments),
        Command::Scope(arguments) => edges::execute(&arguments),
        Command::Rti(arguments) => rti::rti(&arguments),
        Command::Trace(arguments) => trace::trace(&arguments),
        Command::Explain { crate_folder, codes } => codes::explain(crate_folder.as_deref(), &codes),
        Command::Lsp => lsp::serve().map(|()| ExitCode::SUCCESS),
        Command::Completions { shell } => manual::completions(shell),
        Command::Man { folder } => manual::man(&folder),
        Command::Supervise { file } => supervise::supervise(&file),
        Command::Moves { script, federate, readers } => pins::print_moves(&script, &federate, &readers),
        Command::Nanoseconds { time } => {
            terminal::print(time.as_nanos()).map(|()| ExitCode::SUCCESS).map_err(Failure::from)
        }
        Command::ExplainErrors { messages } => explain::explain(&messages),
        Command::NameLines { image, crate_folder } => explain::name_lines(&image, &crate_folder),
        Command::Guard { parent, program } => {
            let error = guard::become_program(parent, &program);
            let name = program.first().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            Err(Failure::message(format!("cannot run {name}: {error}")))
        }
        Command::EndDescendants { mark } => descendants::end(&mark).map(|()| ExitCode::SUCCESS).map_err(Failure::from),
    }
}
