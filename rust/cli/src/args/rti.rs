// SPDX-License-Identifier: Apache-2.0
//! The options of `lfz rti`, which are those of the stock RTI, with its letters and words.

use std::path::PathBuf;

use clap::Args;
use clap::builder::RangedI64ValueParser;
use lf_host::model::time::Interval;
use lf_host::rti::{CLOCK_SYNC_TRIALS, ClockSync, Options};

use crate::time;

/// The stock RTI's federation id when none is given.
const FEDERATION_ID_DEFAULT: &str = "Unidentified Federation";
/// The stock RTI's port.
pub const PORT_DEFAULT: u16 = 15045;
/// The period of clock synchronization in nanoseconds, as the stock RTI's.
const PERIOD_NS_DEFAULT: i64 = 10_000_000;
/// A shorter period would be nothing but load, and with a longer one drift cannot be told from temperature.
const PERIOD_NS_MIN: i64 = 1_000_000;
const PERIOD_NS_MAX: i64 = 3_600_000_000_000;
/// More would delay the start by minutes on a slow link.
const TRIALS_MAX: u32 = 1000;
/// The most federates of a federation: ids are 16 bits wide on the wire, and a mistyped number should not use up the
/// memory of this computer.
const FEDERATES_MAX: u16 = 4096;
/// Where the trace goes.
const TRACE_FILE: &str = "rti.csv";
/// In bytes.
const MESSAGE_LENGTH_DEFAULT: u32 = 1024 * 1024;

/// `lfz rti`
#[derive(Debug, Args)]
#[allow(clippy::struct_excessive_bools, reason = "these are switches of a command line")]
pub struct RtiArgs {
    /// The number of federates in the federation.
    #[arg(short = 'n', long = "number_of_federates", alias = "number-of-federates", value_name = "N")]
    #[arg(required_unless_present = "version", value_parser = federates())]
    federates: Option<u16>,
    /// The id of the federation that this RTI coordinates; federates with another one are rejected.
    #[arg(short = 'i', long = "id", value_name = "ID", value_parser = federation_id)]
    #[arg(default_value = FEDERATION_ID_DEFAULT)]
    id: String,
    /// The TCP port to listen on; 0 lets the system choose one.
    #[arg(short = 'p', long = "port", value_name = "PORT", default_value_t = PORT_DEFAULT)]
    port: u16,
    /// Clock synchronization: `off`, `init` for once before the start, or `on` for rounds over UDP from then on, too;
    /// then `exchanges-per-interval N` before the start, and with `on` also `period NANOSECONDS`. Programs on this
    /// computer have its clock and take no part, unless `local-federates-on: true` is in `clock-sync-options`.
    #[arg(short = 'c', long = "clock_sync", alias = "clock-sync", num_args = 1.., value_name = "off|init|on")]
    #[arg(default_value = "init")]
    clock_sync: Vec<String>,
    /// Accept only federates that prove with an HMAC that they know the federation id.
    #[arg(short = 'a', long = "auth")]
    auth: bool,
    /// Record all messages in the file `rti.csv` of the working directory.
    #[arg(short = 't', long = "tracing")]
    tracing: bool,
    /// Delay the start so that its time is a multiple of this: `-m 100 ms`.
    #[arg(short = 'm', long = "start-time-multiple", num_args = 2, value_names = ["VALUE", "UNIT"])]
    start_time_multiple: Vec<String>,
    /// Do not tell federates which of their next event tags nobody waits for (DNET).
    #[arg(short = 'd', long = "dnet_disabled", alias = "disable_dnet", alias = "dnet-disabled")]
    dnet_disabled: bool,
    /// Print the version and exit.
    #[arg(short = 'v', long = "version")]
    pub version: bool,
    /// The longest message payload that is forwarded; a connection that sends a longer one is ended.
    #[arg(long, value_name = "BYTES", default_value_t = MESSAGE_LENGTH_DEFAULT)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1 << 30))]
    max_message: u32,
    /// Let the others go on when a federate is lost, as the stock RTI does; otherwise the federation is stopped.
    #[arg(long)]
    go_on_after_loss: bool,
    /// How long the start waits for a federate that was there and has left; then the federation ends. `off`: for ever.
    #[arg(long, value_name = "TIME", default_value = "60 s", value_parser = start_time_out)]
    start_time_out: TimeOut,
}

/// A time after which the RTI gives up; nothing if it does not.
#[derive(Clone, Copy, Debug)]
struct TimeOut(Option<Interval>);

impl RtiArgs {
    /// Checks what the command line's grammar cannot say.
    ///
    /// # Errors
    /// A sentence for the user, which names the option.
    pub fn options(&self) -> Result<Options, String> {
        let start_time_multiple = match self.start_time_multiple.as_slice() {
            [value, unit] => multiple(value, unit).map_err(|error| format!("-m, --start-time-multiple: {error}"))?,
            _ => None,
        };
        Ok(Options {
            federates: self.federates.ok_or("-n, --number_of_federates is missing")?,
            federation_id: self.id.clone(),
            authentication: self.auth,
            port: self.port,
            clock_sync: clock_sync(&self.clock_sync).map_err(|error| format!("-c, --clock_sync: {error}"))?,
            start_time_multiple,
            dnet: !self.dnet_disabled,
            go_on_after_loss: self.go_on_after_loss,
            start_barrier_time_out: self.start_time_out.0,
            trace: self.tracing.then(|| PathBuf::from(TRACE_FILE)),
            payload_bytes_max: usize::try_from(self.max_message).unwrap_or(usize::MAX),
        })
    }
}

/// A multiple of zero is any time, as in the stock RTI.
fn multiple(value: &str, unit: &str) -> Result<Option<Interval>, String> {
    let multiple = time::of_unit(value, unit)?;
    let nanoseconds = i64::try_from(multiple.as_nanos()).unwrap_or(i64::MAX);
    Ok((nanoseconds > 0).then(|| Interval::from_nanos(nanoseconds)))
}

fn start_time_out(text: &str) -> Result<TimeOut, String> {
    if text == "off" {
        return Ok(TimeOut(None));
    }
    let nanoseconds = i64::try_from(time::parse(text)?.as_nanos()).unwrap_or(i64::MAX);
    Ok(TimeOut(Some(Interval::from_nanos(nanoseconds))))
}

fn federates() -> RangedI64ValueParser<u16> {
    clap::value_parser!(u16).range(1..=i64::from(FEDERATES_MAX))
}

fn federation_id(text: &str) -> Result<String, String> {
    match text.len() {
        1..=255 => Ok(text.to_owned()),
        0 => Err("a federation id has at least one character".to_owned()),
        length => Err(format!("a federation id has at most 255 bytes, this one {length}")),
    }
}

/// What the words after `-c` ask for.
fn clock_sync(words: &[String]) -> Result<ClockSync, String> {
    let mut words = words.iter().map(String::as_str);
    let trials = CLOCK_SYNC_TRIALS;
    let mut clock_sync = match words.next() {
        Some("off") => ClockSync::Off,
        Some("init" | "initial") => ClockSync::Init { trials },
        Some("on") => ClockSync::On { trials, period: Interval::from_nanos(PERIOD_NS_DEFAULT) },
        other => return Err(format!("`{}` is none of off, init, on", other.unwrap_or_default())),
    };
    while let Some(word) = words.next() {
        match (word, &mut clock_sync) {
            ("period", ClockSync::On { period, .. }) => *period = number_of_nanoseconds(words.next())?,
            ("period", _) => return Err("`period` only applies to `on`".to_owned()),
            ("exchanges-per-interval", ClockSync::Init { trials } | ClockSync::On { trials, .. }) => {
                *trials = number_of_trials(words.next())?;
            }
            ("exchanges-per-interval", ClockSync::Off) => {
                return Err("`exchanges-per-interval` does not apply to `off`".to_owned());
            }
            (other, _) => return Err(format!("`{other}` is none of period, exchanges-per-interval")),
        }
    }
    Ok(clock_sync)
}

fn number_of_nanoseconds(word: Option<&str>) -> Result<Interval, String> {
    let word = word.unwrap_or_default();
    let valid = word.parse().ok().filter(|period| (PERIOD_NS_MIN..=PERIOD_NS_MAX).contains(period));
    let wrong = || format!("`period` takes nanoseconds from {PERIOD_NS_MIN} to {PERIOD_NS_MAX}, not `{word}`");
    valid.map(Interval::from_nanos).ok_or_else(wrong)
}

fn number_of_trials(word: Option<&str>) -> Result<u32, String> {
    let word = word.unwrap_or_default();
    let valid = word.parse().ok().filter(|trials| (1..=TRIALS_MAX).contains(trials));
    valid.ok_or_else(|| format!("`exchanges-per-interval` takes a number from 1 to {TRIALS_MAX}, not `{word}`"))
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use lf_host::model::time::Interval;
    use lf_host::rti::{ClockSync, Options};

    use super::super::{Cli, Command};

    fn options(arguments: &[&str]) -> Result<Options, String> {
        let all = ["lfz", "rti"].iter().chain(arguments);
        let cli = Cli::try_parse_from(all).map_err(|error| error.to_string())?;
        let Command::Rti(arguments) = cli.command else { panic!("rti was asked for") };
        arguments.options()
    }

    #[test]
    fn the_defaults_are_the_stock_rtis() {
        let options = options(&["-n", "2"]).expect("it is valid");
        assert_eq!(options.federation_id, "Unidentified Federation");
        assert_eq!(options.port, 15045);
        assert_eq!(options.clock_sync, ClockSync::Init { trials: 10 });
        assert!(options.dnet && !options.authentication);
        assert_eq!(options.start_time_multiple, None);
        assert_eq!(options.start_barrier_time_out, Some(Interval::from_secs(60)));
    }

    #[test]
    fn the_time_for_coming_back_is_a_time_or_off() {
        let of = |text| options(&["-n", "2", "--start-time-out", text]).map(|options| options.start_barrier_time_out);
        assert_eq!(of("off"), Ok(None));
        assert_eq!(of("1500 ms"), Ok(Some(Interval::from_millis(1500))));
        assert!(of("soon").is_err());
    }

    #[test]
    fn the_stock_rtis_options_in_its_order_are_understood() {
        let arguments = [
            "-i",
            "f",
            "-n",
            "3",
            "-p",
            "15050",
            "-c",
            "init",
            "exchanges-per-interval",
            "3",
            "-m",
            "7",
            "s",
            "-d",
            "-a",
        ];
        let options = options(&arguments).expect("it is valid");
        assert_eq!(options.federates, 3);
        assert_eq!(options.clock_sync, ClockSync::Init { trials: 3 });
        assert_eq!(options.start_time_multiple, Some(Interval::from_secs(7)));
        assert!(!options.dnet && options.authentication);
    }

    #[test]
    fn rounds_while_the_federation_runs_have_a_period() {
        let of = |arguments: &[&str]| {
            let all = ["-n", "2", "-c", "on"].iter().chain(arguments).copied().collect::<Vec<_>>();
            options(&all).map(|options| options.clock_sync)
        };
        let on = |trials, period_ms| Ok(ClockSync::On { trials, period: Interval::from_millis(period_ms) });
        assert_eq!(of(&[]), on(10, 10));
        assert_eq!(of(&["period", "5000000"]), on(10, 5));
        assert_eq!(of(&["period", "600000000", "exchanges-per-interval", "2"]), on(2, 600));
        assert_eq!(of(&["exchanges-per-interval", "2", "period", "600000000"]), on(2, 600));
    }

    #[test]
    fn wrong_values_are_named() {
        for (arguments, name) in [
            (&["-n", "0"][..], "0"),
            (&["-n", "2", "-m", "7", "moons"], "moons"),
            (&["-n", "2", "-c", "maybe"], "maybe"),
            (&["-n", "2", "-c", "off", "exchanges-per-interval", "3"], "does not apply"),
            (&["-n", "2", "-c", "init", "exchanges-per-interval", "0"], "1 to 1000"),
            (&["-n", "2", "-c", "init", "period", "5"], "only applies to `on`"),
            (&["-n", "2", "-c", "on", "period", "5 ms"], "nanoseconds"),
            (&["-n", "2", "-c", "on", "period", "0"], "from 1000000"),
            (&["-n", "2", "-i", ""], "at least one character"),
            (&["-p", "15050"], "--number_of_federates"),
        ] {
            let error = options(arguments).expect_err("it is wrong");
            assert!(error.contains(name), "{error}");
        }
    }
}
