// SPDX-License-Identifier: Apache-2.0
//! The options of `lfz rti`, which are those of the stock RTI, with its letters and words.

mod clock_sync;
#[cfg(test)]
mod launched;
mod stock;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use clap::Args;
use clap::builder::RangedI64ValueParser;
use lf_linux::model::time::Interval;
use lf_linux::rti::{Options, TRACE_MIB, TRACE_UNLIMITED, Trace};

use crate::time;
use crate::trace::{Table, TableFormat};

pub(super) use stock::{is_rti, readable};

/// The stock RTI's federation id when none is given.
const FEDERATION_ID_DEFAULT: &str = "Unidentified Federation";
/// The stock RTI's port.
pub const PORT_DEFAULT: u16 = 15045;
/// The most federates of a federation: ids are 16 bits wide on the wire, and a mistyped number should not use up the
/// memory of this computer.
const FEDERATES_MAX: u16 = 4096;
/// Where LF's own tools look for the trace of an RTI.
const TRACE_FILE: &str = "rti.lft";
/// A warning where `-a` stands without `-i`.
const PUBLIC_KEY: &str =
    "-a, --auth: the federation id is the key, and everybody knows the default one; choose another with -i";
/// The answer to `-nt`, which launch scripts of lfc 0.14 and later have.
const TRANSIENT: &str = "-nt, --number_of_transient_federates: transient federates, which join and leave a running \
    federation, are not supported; take `@transient` away from the program, or run it with LF's own RTI";
/// The answer to `-tls`.
const TLS: &str = "-tls, --tls: encrypted connections (TLS) are not supported; take `comm-type: TLS` away from the \
    program, and let the federation talk over a network that only its computers reach, such as a VPN";
/// The answer to `-sst`.
const SST: &str = "-sst, --sst: connections that SST secures are not supported; take `comm-type: SST` away from the \
    program, and let the federation talk over a network that only its computers reach, such as a VPN";

/// `lfz rti`
#[derive(Debug, Args)]
#[command(args_override_self = true)]
#[allow(clippy::struct_excessive_bools, reason = "these are switches of a command line")]
pub struct RtiArgs {
    /// The number of federates in the federation.
    #[arg(short = 'n', long = "number_of_federates", alias = "number-of-federates", value_name = "N")]
    #[arg(required_unless_present = "version", value_parser = federates())]
    federates: Option<u16>,
    /// How many of them are transient.
    #[arg(long = "number_of_transient_federates", hide = true, value_name = "N", default_value_t = 0)]
    transient_federates: u16,
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
    /// Record the messages in the file `rti.lft` of the working directory, which LF's own tools read.
    #[arg(short = 't', long = "tracing")]
    tracing: bool,
    /// Record all messages in this file, as text: comma-separated values.
    #[arg(long, value_name = "FILE")]
    trace_csv: Option<PathBuf>,
    /// Record what happens in this file, which `lfz trace` reads beside those of the federates.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Record the values of messages in the file of --trace, too.
    #[arg(long)]
    trace_values: bool,
    /// How large the file of --trace may be, in MiB; when it is full, the oldest records are dropped. It is 256 unless
    /// given, or as large as it has to be if --tracing or --trace-csv is given.
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(1..))]
    trace_limit: Option<u32>,
    /// A certificate and its key.
    #[arg(long, num_args = 0.., hide = true)]
    tls: Option<Vec<String>>,
    /// A configuration of SST.
    #[arg(long, num_args = 0.., hide = true)]
    sst: Option<Vec<String>>,
    /// Delay the start so that its time is a multiple of this: `-m 100 ms`.
    #[arg(short = 'm', long = "start-time-multiple", num_args = 2, value_names = ["VALUE", "UNIT"])]
    #[arg(allow_negative_numbers = true)]
    start_time_multiple: Vec<String>,
    /// Do not tell federates which of their next event tags nobody waits for (DNET).
    #[arg(short = 'd', long = "dnet_disabled", alias = "disable_dnet", alias = "dnet-disabled")]
    dnet_disabled: bool,
    /// Print the version and exit.
    #[arg(short = 'v', long = "version")]
    pub version: bool,
    /// The longest message payload that is forwarded; a federate that sends a longer one is lost. Unless given, an
    /// eighth of this computer's memory, at most 4 GiB. A buffer is as long as what it has to hold, not as this.
    #[arg(long, value_name = "BYTES", value_parser = clap::value_parser!(u32).range(1..))]
    max_message: Option<u32>,
    /// Let the others go on when a federate is lost, as the stock RTI does; otherwise the federation is stopped.
    #[arg(long)]
    go_on_after_loss: bool,
    /// While the federation runs, log of each federate that waits for longer than this what it waits for: whose grant,
    /// or room at whom.
    #[arg(long, value_name = "TIME", value_parser = log_waits)]
    log_waits: Option<Interval>,
    /// How long the start waits for a federate that was there and has left; then the federation ends. `off`: for ever.
    #[arg(long, value_name = "TIME", default_value = "60 s", value_parser = start_time_out)]
    start_time_out: TimeOut,
}

/// A time after which the RTI gives up; nothing if it does not.
#[derive(Clone, Copy, Debug)]
struct TimeOut(Option<Interval>);

impl RtiArgs {
    /// Checks what the command line's grammar cannot say, and adds warnings about what is left out of account.
    ///
    /// # Errors
    /// A sentence for the user, which names the option.
    pub fn options(&self, warnings: &mut Vec<String>) -> Result<Options, String> {
        self.refuse_what_is_missing()?;
        if self.auth && self.id == FEDERATION_ID_DEFAULT {
            warnings.push(PUBLIC_KEY.to_owned());
        }
        let start_time_multiple = match self.start_time_multiple.last_chunk() {
            Some([value, unit]) => {
                multiple(value, unit).map_err(|error| format!("-m, --start-time-multiple: {error}"))?
            }
            None => None,
        };
        Ok(Options {
            federates: self.federates.ok_or("-n, --number_of_federates is missing")?,
            federation_id: self.id.clone(),
            authentication: self.auth,
            port: self.port,
            clock_sync: clock_sync::clock_sync(&self.clock_sync, warnings)
                .map_err(|error| format!("-c, --clock_sync: {error}"))?,
            start_time_multiple,
            dnet: !self.dnet_disabled,
            go_on_after_loss: self.go_on_after_loss,
            start_barrier_time_out: self.start_time_out.0,
            log_waits: self.log_waits,
            trace: self.trace(),
            payload_bytes_max: match self.max_message {
                None => Options::payload_bytes_max_default(),
                Some(bytes) => usize::try_from(bytes).unwrap_or(usize::MAX),
            },
        })
    }
}

impl RtiArgs {
    /// Refuses options that the stock RTI has and ours does not.
    fn refuse_what_is_missing(&self) -> Result<(), String> {
        let refused = [(self.transient_federates > 0, TRANSIENT), (self.tls.is_some(), TLS), (self.sst.is_some(), SST)];
        refused.iter().find(|(is_asked, _)| *is_asked).map_or(Ok(()), |(_, why)| Err((*why).to_owned()))
    }

    /// The file in which the RTI records what happens; one for a while, if only tables are made of it.
    fn trace(&self) -> Option<Trace> {
        let tables = self.tables();
        let of_table = || {
            let mut file = tables.first()?.file.clone().into_os_string();
            file.push(".lftrace");
            Some(file.into())
        };
        let usual = if tables.is_empty() { TRACE_MIB } else { TRACE_UNLIMITED };
        Some(Trace {
            file: self.trace.clone().or_else(of_table)?,
            limit_mib: self.trace_limit.unwrap_or(usual),
            values: self.trace_values,
        })
    }

    /// The files that are made of what the RTI has recorded when it has ended.
    pub(crate) fn tables(&self) -> Vec<Table> {
        let lft = self.tracing.then(|| Table { file: PathBuf::from(TRACE_FILE), format: TableFormat::Lft });
        let csv = self.trace_csv.clone().map(|file| Table { file, format: TableFormat::Csv });
        lft.into_iter().chain(csv).collect()
    }

    /// Whether what the RTI has recorded is kept.
    pub(crate) fn keeps_trace(&self) -> bool {
        self.trace.is_some()
    }
}

/// A multiple of zero is any time, as in the stock RTI.
fn multiple(value: &str, unit: &str) -> Result<Option<Interval>, String> {
    let multiple = time::of_unit(value, unit)?;
    let nanoseconds = i64::try_from(multiple.as_nanos()).unwrap_or(i64::MAX);
    Ok((nanoseconds > 0).then(|| Interval::from_nanos(nanoseconds)))
}

fn log_waits(text: &str) -> Result<Interval, String> {
    let nanoseconds = i64::try_from(time::parse(text)?.as_nanos()).unwrap_or(i64::MAX);
    if nanoseconds > 0 { Ok(Interval::from_nanos(nanoseconds)) } else { Err("give a time longer than 0".to_owned()) }
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
