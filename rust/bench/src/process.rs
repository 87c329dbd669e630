// SPDX-License-Identifier: Apache-2.0
//! The measured programs, as child processes.

use std::fs;
use std::io::{BufRead, BufReader, Lines};
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::{Access, FEDERATION, Result, write_keys};

/// An RTI to measure.
#[derive(Clone, Debug)]
pub enum Program {
    /// `lfz rti`, by the path of `lfz`.
    Ours(PathBuf),
    /// The same with keys, so that all connections are encrypted.
    Encrypted(PathBuf),
    /// The stock RTI, by its path.
    Stock(PathBuf),
}

impl Program {
    /// Returns the name in the rows.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ours(_) => "lfz rti",
            Self::Encrypted(_) => "lfz rti, encrypted",
            Self::Stock(_) => "stock RTI",
        }
    }

    /// Starts it for this number of federates, on a free port, without clock synchronization.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(&self, federates: u16) -> Result<RunningRti> {
        self.start_with(federates, &["off"])
    }

    /// Starts it with this value of its option `-c`.
    pub(crate) fn start_with(&self, federates: u16, clock_sync: &[&str]) -> Result<RunningRti> {
        let port = free_port()?;
        let mut command = match self {
            Self::Ours(path) | Self::Encrypted(path) => {
                let mut command = Command::new(path);
                command.arg("rti");
                command
            }
            Self::Stock(path) => Command::new(path),
        };
        let keys = match self {
            Self::Encrypted(_) => Some(tempfile::tempdir()?),
            Self::Ours(_) | Self::Stock(_) => None,
        };
        if let Some(folder) = &keys {
            write_keys(folder.path(), federates)?;
            command.arg("--keys").arg(folder.path());
        }
        command.args(["-i", FEDERATION, "-n", &federates.to_string(), "-p", &port.to_string(), "-c"]);
        command.args(clock_sync);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let child = command.spawn().map_err(|error| format!("{} cannot be started: {error}", self.name()))?;
        Ok(RunningRti { child: ChildGuard(child), port, keys })
    }
}

/// A running RTI, killed on drop.
#[derive(Debug)]
pub struct RunningRti {
    child: ChildGuard,
    /// Its TCP port on this computer.
    pub port: u16,
    /// The folder of its keys, if it has some, which ends with this.
    keys: Option<TempDir>,
}

impl RunningRti {
    /// Returns the way to it.
    pub fn access(&self) -> Access {
        Access { port: self.port, is_encrypted: self.keys.is_some() }
    }

    /// Returns the resources that it has used so far.
    pub fn usage(&self) -> Usage {
        usage(self.child.0.id())
    }

    /// Waits at most this long until the process has ended by itself.
    ///
    /// # Errors
    /// When it has not.
    pub fn wait(&mut self, time_out: Duration) -> Result<ExitStatus> {
        let until = Instant::now() + time_out;
        loop {
            if let Some(status) = self.child.0.try_wait()? {
                return Ok(status);
            }
            if Instant::now() > until {
                return Err("the RTI has not ended although all federates have left".into());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Returns a port without a listener. Another program could take it before the RTI does; then the measurement reports a
/// failure.
fn free_port() -> Result<u16> {
    Ok(TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr()?.port())
}

/// The output of a child process.
pub(crate) type Output = Lines<BufReader<ChildStdout>>;

/// Starts this program in another role, which prints its port first. The process is killed on drop.
pub(crate) fn start_self(role: &str) -> Result<(ChildGuard, u16, Output)> {
    let mut command = Command::new(std::env::current_exe()?);
    let mut child = ChildGuard(command.arg(role).stdin(Stdio::null()).stdout(Stdio::piped()).spawn()?);
    let mut output = BufReader::new(child.0.stdout.take().ok_or("a program has no output")?).lines();
    let port = output.next().ok_or_else(|| format!("{role:?} does not say its port"))??.trim().parse()?;
    Ok((child, port, output))
}

/// A child process that does not outlive its owner.
#[derive(Debug)]
pub(crate) struct ChildGuard(Child);

impl Drop for ChildGuard {
    fn drop(&mut self) {
        // Both fail only if the process has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The resources that a process has used.
#[derive(Clone, Copy, Debug, Default)]
pub struct Usage {
    /// The time on a processor, user and system.
    pub cpu: Duration,
    /// The resident memory in bytes.
    pub resident: u64,
    /// The part of it that is private to the process, without the files that processes share in memory.
    pub own: u64,
}

/// Returns the usage of a process as Linux reports it; zero if it does not.
fn usage(process: u32) -> Usage {
    let read = |file: &str| fs::read_to_string(format!("/proc/{process}/{file}")).unwrap_or_default();
    // The name of the program stands in parentheses and may contain any character.
    let stat = read("stat");
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |index: usize| fields.get(index).and_then(|field| field.parse::<u64>().ok()).unwrap_or(0);
    let nanoseconds = (ticks(11) + ticks(12)) * 1_000_000_000 / rustix::param::clock_ticks_per_second().max(1);
    let status = read("status");
    let memory = |name: &str| status.lines().find_map(|line| line.strip_prefix(name).map(bytes)).unwrap_or(0);
    Usage { cpu: Duration::from_nanos(nanoseconds), resident: memory("VmRSS:"), own: memory("RssAnon:") }
}

fn bytes(text: &str) -> u64 {
    text.split_whitespace()
        .next()
        .and_then(|kibibytes| kibibytes.parse().ok())
        .map_or(0, |kibibytes: u64| kibibytes * 1024)
}
