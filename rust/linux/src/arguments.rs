// SPDX-License-Identifier: Apache-2.0
//! The command line of a generated program: the options that stock LF programs have.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::PathBuf;

use lexopt::prelude::{Long, Short, Value, ValueExt as _};
use lf_model::Settings;
use lf_model::time::Interval;
use lf_runtime::Description;

use crate::credentials::Credentials;
use crate::devices::Script;
use crate::parameters::Parameters;
use crate::trace_file::TRACE_MIB;
use crate::words::{UsageError, interval};

/// The user's request.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Invocation {
    /// Run the program.
    Run(Arguments),
    /// Print the options.
    Help,
}

/// The options of the user; the program has defaults for all of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Arguments {
    /// `-o`: the last tag's time after the start.
    pub(crate) timeout: Option<Interval>,
    /// `-f`
    pub(crate) fast: Option<bool>,
    /// `--virtual-time`: the clock shows the next time that the program waits for, at once.
    pub(crate) virtual_time: bool,
    /// `-k`
    pub(crate) keepalive: Option<bool>,
    /// `-i`: the federation to join.
    pub(crate) federation_id: Option<String>,
    /// `-r HOST`
    pub(crate) rti_host: Option<String>,
    /// `-r HOST:PORT`
    pub(crate) rti_port: Option<u16>,
    /// `--trace FILE`: the recording of events.
    pub(crate) trace: Option<PathBuf>,
    /// `--trace-limit MIB`: the maximum size of that file.
    pub(crate) trace_limit: Option<u32>,
    /// `--trace-values`: with the values of what comes in.
    pub(crate) trace_values: bool,
    /// `--devices FILE`: the script for inputs.
    pub(crate) devices: Option<PathBuf>,
    /// `--vcd FILE`: the recording of pins.
    pub(crate) vcd: Option<PathBuf>,
    /// `--keys FOLDER`, or `--tls CERTIFICATE KEY --unverified`.
    pub(crate) credentials: Credentials,
}

impl Arguments {
    /// Parses a command line, the program's name first; values of parameters go to the program itself.
    ///
    /// # Errors
    /// The error, as a phrase.
    pub(crate) fn parse(
        line: impl IntoIterator<Item = OsString, IntoIter: 'static>,
        federated: bool,
        parameters: &Parameters,
    ) -> Result<Invocation, UsageError> {
        let mut parser = lexopt::Parser::from_iter(line);
        let (mut arguments, mut unverified) = (Self::default(), false);
        while let Some(argument) = parser.next()? {
            // The program's own names have precedence.
            let parameter = match argument {
                Long(name) => parameters.position(name),
                _ => None,
            };
            if let Some(parameter) = parameter {
                parameters.take(parameter, &mut parser)?;
                continue;
            }
            match argument {
                Short('h') | Long("help") => return Ok(Invocation::Help),
                Short('o') | Long("timeout") => arguments.timeout = Some(interval(&mut parser)?),
                Short('f') | Long("fast") => arguments.fast = Some(boolean(&mut parser)?),
                Short('k') | Long("keepalive") => arguments.keepalive = Some(boolean(&mut parser)?),
                Long("virtual-time") if !federated => arguments.virtual_time = true,
                Long("virtual-time") => {
                    let message = "--virtual-time: the clocks of federates cannot wait for each other";
                    return Err(UsageError(message.to_owned()));
                }
                Short('i') | Long("id") if federated => arguments.federation_id = Some(parser.value()?.string()?),
                Short('r') | Long("rti") if federated => arguments.set_rti(&parser.value()?.string()?)?,
                Long("trace") => arguments.trace = Some(parser.value()?.into()),
                Long("trace-values") => arguments.trace_values = true,
                Long("trace-limit") => arguments.trace_limit = Some(mebibytes(&mut parser)?),
                Long("devices") => arguments.devices = Some(parser.value()?.into()),
                Long("vcd") => arguments.vcd = Some(parser.value()?.into()),
                Long("keys") if federated => arguments.credentials = Credentials::Keys(parser.value()?.into()),
                Long("tls") if federated => {
                    let (certificate, key) = (parser.value()?.into(), parser.value()?.into());
                    arguments.credentials = Credentials::Unverified { certificate, key };
                }
                Long("unverified") if federated => unverified = true,
                Short('i' | 'r') | Long("id" | "rti" | "keys" | "tls" | "unverified") => {
                    return Err(UsageError(
                        "this program is not federated: it has no RTI and no federation".to_owned(),
                    ));
                }
                other => return Err(other.unexpected().into()),
            }
        }
        if arguments.virtual_time && arguments.devices.is_some() {
            let message = "--virtual-time and --devices exclude each other: inputs move in physical time";
            return Err(UsageError(message.to_owned()));
        }
        if matches!(arguments.credentials, Credentials::Unverified { .. }) != unverified {
            let message = "--tls and --unverified belong together: with --keys all participants prove who they are";
            return Err(UsageError(message.to_owned()));
        }
        Ok(Invocation::Run(arguments))
    }

    /// Returns the script of the command line for inputs.
    ///
    /// # Errors
    /// When it cannot be read or parsed.
    pub(crate) fn script(&self) -> Result<Script, UsageError> {
        let Some(path) = &self.devices else { return Ok(Script::default()) };
        let wrong = |what: &dyn std::fmt::Display| UsageError(format!("{}: {what}", path.display()));
        let text = std::fs::read_to_string(path).map_err(|error| wrong(&error))?;
        Script::read(&text).map_err(|error| wrong(&error))
    }

    /// Returns the program's settings with the user's changes.
    pub(crate) fn settings(&self, program: Settings) -> Settings {
        Settings {
            timeout: self.timeout.or(program.timeout),
            fast: self.fast.unwrap_or(program.fast),
            keepalive: self.keepalive.unwrap_or(program.keepalive),
            ..program
        }
    }

    /// Takes the address of the RTI from the environment, unless the command line has one.
    ///
    /// # Errors
    /// When it is none.
    pub(crate) fn inherit_rti(&mut self, text: &str) -> Result<(), UsageError> {
        if self.rti_host.is_some() || self.rti_port.is_some() { Ok(()) } else { self.set_rti(text) }
    }

    /// Parses `HOST`, `HOST:PORT` or `USER@HOST:PORT`; the user is for remote starts and has no effect here. An IPv6
    /// address is between brackets if a port follows.
    fn set_rti(&mut self, text: &str) -> Result<(), UsageError> {
        let place = text.rsplit_once('@').map_or(text, |(_, place)| place);
        let (host, port) = match place.strip_prefix('[') {
            Some(rest) => {
                let parts = rest.split_once(']').and_then(|(host, rest)| match rest {
                    "" => Some((host, None)),
                    rest => Some((host, Some(rest.strip_prefix(':')?))),
                });
                parts.ok_or_else(|| UsageError(format!("\"{place}\" is no address such as [::1] or [::1]:15045")))?
            }
            // More than one colon is an IPv6 address, which cannot have a port here.
            None => match place.split_once(':').filter(|(_, rest)| !rest.contains(':')) {
                Some((host, port)) => (host, Some(port)),
                None => (place, None),
            },
        };
        let number = |port: &str| {
            let number = port.parse().ok().filter(|port| *port != 0);
            number.ok_or_else(|| UsageError(format!("\"{port}\" is no TCP port")))
        };
        self.rti_port = port.map(number).transpose()?;
        self.rti_host = Some(host).filter(|host| !host.is_empty()).map(str::to_owned);
        Ok(())
    }
}

/// Parses a size in MiB.
fn mebibytes(parser: &mut lexopt::Parser) -> Result<u32, UsageError> {
    let text = parser.value()?.string()?;
    let size = text.parse().ok().filter(|size| *size > 0);
    size.ok_or_else(|| UsageError(format!("\"{text}\" is no size: it has to be a number of MiB, such as {TRACE_MIB}")))
}

/// Parses `true` or `false`; the default is `true`.
fn boolean(parser: &mut lexopt::Parser) -> Result<bool, UsageError> {
    let next = parser.try_raw_args().and_then(|arguments| arguments.as_slice().first().cloned());
    let value = match next.as_deref().and_then(std::ffi::OsStr::to_str) {
        Some("true") => true,
        Some("false") => false,
        _ => return Ok(true),
    };
    match parser.next()? {
        Some(Value(_)) | None => Ok(value),
        Some(other) => Err(other.unexpected().into()),
    }
}

/// Returns the text of `--help`.
pub(crate) fn usage(description: &Description) -> String {
    let mut text = format!(
        "Runs {} of the Lingua Franca program {}.\n\nOptions:\n\
         \x20 -o, --timeout TIME UNIT   last tag, counted from the start, such as 500 msec\n\
         \x20 -f, --fast [true|false]   do not wait for physical time\n\
         \x20 -k, --keepalive [true|false]  do not stop when there are no events\n\
         \x20     --trace FILE          record tags, reactions, messages and waits, for lfz trace\n\
         \x20     --trace-limit MIB     how large that file may be (default: {TRACE_MIB})\n\
         \x20     --trace-values        record the values of messages that come and of physical actions, too\n\
         \x20     --devices FILE        what inputs do, and which devices are real: lines such as 100 ms button0 1\n\
         \x20                           and led0 gpio /dev/gpiochip0 17\n\
         \x20     --vcd FILE            write down what pins do, for PulseView or GTKWave\n",
        description.name, description.program
    );
    if description.federation.is_none() {
        text.push_str("      --virtual-time        let the clock show at once what the program waits for\n");
    }
    if let Some(federation) = &description.federation {
        let _ = write!(
            text,
            "\x20 -r, --rti HOST[:PORT]     where the RTI listens, or [IPV6]:PORT (default: {}:{})\n\
             \x20 -i, --id FEDERATION       the federation to join (default: {})\n\
             \x20     --keys FOLDER         its keys, as `lfz build` hands them out: connections are encrypted\n\
             \x20     --tls CERT KEY        with --unverified: encrypt connections by TLS, with whomever it is\n",
            federation.rti_host, federation.rti_port, federation.federation_id
        );
    }
    text + "  -h, --help                this text"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Invocation, UsageError> {
        let words = std::iter::once("program").chain(line.split_whitespace()).map(OsString::from).collect::<Vec<_>>();
        Arguments::parse(words, true, &Parameters::NONE)
    }

    fn run(line: &str) -> Arguments {
        match parse(line) {
            Ok(Invocation::Run(arguments)) => arguments,
            other => panic!("{other:?}"),
        }
    }

    /// All spellings of stock programs are accepted.
    #[test]
    fn options_of_stock_programs_are_understood() {
        assert_eq!(run(""), Arguments::default());
        assert_eq!(run("-o 500 msec").timeout, Some(Interval::from_millis(500)));
        assert_eq!(run("--timeout 2sec").timeout, Some(Interval::from_secs(2)));
        assert_eq!(run("-o 1 wk").timeout, Some(Interval::from_secs(7 * 86_400)));
        assert_eq!(run("-o 0").timeout, Some(Interval::ZERO));
        assert_eq!(run("-o 0 msec -f").timeout, Some(Interval::ZERO));
        assert_eq!(run("-o 0 -f").timeout, Some(Interval::ZERO));
        assert_eq!(run("-f").fast, Some(true));
        assert_eq!(run("-f false -k true").fast, Some(false));
        assert_eq!(run("-f -k").keepalive, Some(true));
        let arguments = run("-r user@host.example:15046 -i grid");
        assert_eq!(arguments.rti_host.as_deref(), Some("host.example"));
        assert_eq!(arguments.rti_port, Some(15046));
        assert_eq!(arguments.federation_id.as_deref(), Some("grid"));
        assert_eq!(run("-r 10.0.0.1").rti_port, None);
        for (text, host, port) in [
            ("::1", "::1", None),
            ("[::1]", "::1", None),
            ("[::1]:15046", "::1", Some(15046)),
            ("user@[fe80::2%eth0]:15046", "fe80::2%eth0", Some(15046)),
            ("fe80::2%eth0", "fe80::2%eth0", None),
        ] {
            let arguments = run(&format!("-r {text}"));
            assert_eq!((arguments.rti_host.as_deref(), arguments.rti_port), (Some(host), port), "{text}");
        }
        assert!(run("--trace seen.lftrace --trace-values").trace_values);
        assert!(matches!(parse("-o 1 sec --help"), Ok(Invocation::Help)));
    }

    /// An error names the wrong argument.
    #[test]
    fn nonsense_is_refused_by_name() {
        for (line, word) in [
            ("-o", "missing"),
            ("-o 5 parsecs", "parsecs"),
            ("-o 99999999999999999999 sec", "99999999999999999999"),
            ("-r host:port", "port"),
            ("-r host:0", "0"),
            ("-r [::1", "[::1"),
            ("-r [::1]15045", "[::1]15045"),
            ("-r [::1]:port", "port"),
            ("--frobnicate", "frobnicate"),
            ("stray", "stray"),
        ] {
            let error = parse(line).expect_err(line).to_string();
            assert!(error.contains(word), "{line}: {error}");
        }
        let unfederated = Arguments::parse(["program", "-i", "grid"].map(OsString::from), false, &Parameters::NONE);
        assert!(unfederated.expect_err("not federated").to_string().contains("not federated"));
    }
}
