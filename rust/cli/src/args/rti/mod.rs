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
use lf_linux::Credentials;
use lf_linux::model::time::Interval;
use lf_linux::rti::{Options, TRACE_MIB, TRACE_UNLIMITED, Trace};

use crate::time;
use crate::trace::{Table, TableFormat};

pub(super) use stock::{is_rti, readable};

/// The stock RTI's default federation id.
const FEDERATION_ID_DEFAULT: &str = "Unidentified Federation";
/// The stock RTI's port.
pub const PORT_DEFAULT: u16 = 15045;
/// The maximum number of federates in a federation: ids are 16 bits wide on the wire, and a mistyped number should not
/// exhaust the memory of this computer.
const FEDERATES_MAX: u16 = 4096;
/// The file that LF's own tools read as the trace of an RTI.
const TRACE_FILE: &str = "rti.lft";
/// The warning about `-a` without `-i`.
const PUBLIC_KEY: &str =
    "-a, --auth: the federation id is the key, and everybody knows the default one; choose another with -i";
/// The answer to `-tls` alone.
const VERIFIED: &str = "-tls, --tls: programs of LF's own compiler show no certificates, so that TLS keeps nobody out: \
    say --unverified, too, to accept anybody; or start programs of lfz with --keys, by which all prove who they are";
/// The answer to `-sst`.
const SST: &str = "-sst, --sst: connections that SST secures are not supported; write `security: noise` instead of \
    `comm-type: SST`, or `comm-type: TLS`";
/// The warning about TLS without verification.
const UNVERIFIED: &str = "--unverified: connections are encrypted, but anybody can make one, also from between this \
    RTI and a federate";

/// `lfz rti`
#[derive(Debug, Args)]
#[command(args_override_self = true)]
#[allow(clippy::struct_excessive_bools, reason = "these are switches of a command line")]
pub struct RtiArgs {
    /// The number of federates in the federation.
    #[arg(short = 'n', long = "number_of_federates", alias = "number-of-federates", value_name = "N")]
    #[arg(required_unless_present = "version", value_parser = federates())]
    federates: Option<u16>,
    /// The number of transient federates among them (-nt), which may come and go while the federation runs. It lasts
    /// as long as the others.
    #[arg(long = "number_of_transient_federates", alias = "number-of-transient-federates", value_name = "N")]
    #[arg(default_value_t = 0)]
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
    /// Record the messages in the file `rti.lft` of the working directory, for LF's own tools.
    #[arg(short = 't', long = "tracing")]
    tracing: bool,
    /// Record all messages in this file, as text: comma-separated values.
    #[arg(long, value_name = "FILE")]
    trace_csv: Option<PathBuf>,
    /// Record events in this file, which `lfz trace` reads beside those of the federates.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Record the values of messages in the file of --trace, too.
    #[arg(long)]
    trace_values: bool,
    /// The size limit of the file of --trace, in MiB; a full file drops its oldest records. Default: 256, or no limit
    /// if --tracing or --trace-csv is given.
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(1..))]
    trace_limit: Option<u32>,
    /// The folder with this RTI's keys and those of the federates, which `lfz build` makes: all connections are
    /// encrypted, and all participants prove who they are.
    #[arg(long, value_name = "DIR", conflicts_with = "tls")]
    keys: Option<PathBuf>,
    /// Encrypt all connections by TLS with this certificate and its key (-tls), as the stock RTI does.
    #[arg(long, num_args = 2, value_names = ["CERT", "KEY"])]
    tls: Vec<PathBuf>,
    /// With --tls, accept federates without certificates: nobody proves who it is.
    #[arg(long, requires = "tls")]
    unverified: bool,
    /// A configuration of SST.
    #[arg(long, num_args = 0.., hide = true)]
    sst: Option<Vec<String>>,
    /// Delay the start so that its time is a multiple of this: `-m 100 ms`.
    #[arg(short = 'm', long = "start-time-multiple", num_args = 2, value_names = ["VALUE", "UNIT"])]
    #[arg(allow_negative_numbers = true)]
    start_time_multiple: Vec<String>,
    /// Do not send DNET, which tells federates that no other federate waits for some of their next event tags.
    #[arg(short = 'd', long = "dnet_disabled", alias = "disable_dnet", alias = "dnet-disabled")]
    dnet_disabled: bool,
    /// Print the version and exit.
    #[arg(short = 'v', long = "version")]
    pub version: bool,
    /// Say which commands are run, too: the option of all commands, whose letter is another one's here.
    #[arg(long, hide = true)]
    pub verbose: bool,
    /// The longest message payload that the RTI forwards; it drops a federate that sends a longer one. Default: an
    /// eighth of this computer's memory, at most 4 GiB. Buffers grow with their contents, not with this limit.
    #[arg(long, value_name = "BYTES", value_parser = clap::value_parser!(u32).range(1..))]
    max_message: Option<u32>,
    /// Let the others go on when a federate is lost, as the stock RTI does; by default the RTI stops the federation.
    #[arg(long)]
    go_on_after_loss: bool,
    /// While the federation runs, log the reason of each wait of a federate longer than this: a missing grant, or a
    /// full queue.
    #[arg(long, value_name = "TIME", value_parser = log_waits)]
    log_waits: Option<Interval>,
    /// The time that the start waits for a federate that was there and has left; then the federation ends. `off`: no
    /// limit.
    #[arg(long, value_name = "TIME", default_value = "60 s", value_parser = start_time_out)]
    start_time_out: TimeOut,
    /// Take commands from standard input, one in a line: `stop FEDERATE` tells the transient federate with this id to
    /// leave.
    #[arg(long)]
    commands: bool,
}

/// The time after which the RTI gives up, if it does.
#[derive(Clone, Copy, Debug)]
struct TimeOut(Option<Interval>);

impl RtiArgs {
    /// Checks the rules that the grammar of the command line cannot express, and adds warnings about ignored options.
    ///
    /// # Errors
    /// Returns a sentence for the user that names the option.
    pub fn options(&self, warnings: &mut Vec<String>) -> Result<Options, String> {
        self.refuse_what_is_missing()?;
        let federates = self.federates.ok_or("-n, --number_of_federates is missing")?;
        if self.transient_federates >= federates {
            return Err(format!(
                "-nt, --number_of_transient_federates: {} of {federates} federates are transient; at least one has to \
                 be there from the start to the end, because the federation lasts as long as that one",
                self.transient_federates
            ));
        }
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
            federates,
            transients: self.transient_federates,
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
            commands: self.commands,
            credentials: self.credentials(warnings),
            trace: self.trace(),
            payload_bytes_max: match self.max_message {
                None => Options::payload_bytes_max_default(),
                Some(bytes) => usize::try_from(bytes).unwrap_or(usize::MAX),
            },
        })
    }
}

impl RtiArgs {
    /// Returns what encrypts the connections.
    fn credentials(&self, warnings: &mut Vec<String>) -> Credentials {
        if let [certificate, key] = &self.tls[..] {
            warnings.push(UNVERIFIED.to_owned());
            return Credentials::Unverified { certificate: certificate.clone(), key: key.clone() };
        }
        self.keys.clone().map_or(Credentials::None, Credentials::Keys)
    }

    /// Refuses options of the stock RTI that ours does not support.
    fn refuse_what_is_missing(&self) -> Result<(), String> {
        let refused = [(!self.tls.is_empty() && !self.unverified, VERIFIED), (self.sst.is_some(), SST)];
        refused.iter().find(|(is_asked, _)| *is_asked).map_or(Ok(()), |(_, why)| Err((*why).to_owned()))
    }

    /// Returns the RTI's recording: the user's file, or a temporary one that only tables are made of.
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

    /// Returns the tables to make of the RTI's recording at its end.
    pub(crate) fn tables(&self) -> Vec<Table> {
        let lft = self.tracing.then(|| Table { file: PathBuf::from(TRACE_FILE), format: TableFormat::Lft });
        let csv = self.trace_csv.clone().map(|file| Table { file, format: TableFormat::Csv });
        lft.into_iter().chain(csv).collect()
    }

    /// Returns whether to keep the RTI's recording.
    pub(crate) fn keeps_trace(&self) -> bool {
        self.trace.is_some()
    }
}

/// Parses a multiple of time; zero is no restriction, as in the stock RTI.
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
