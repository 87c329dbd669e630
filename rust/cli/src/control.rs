// SPDX-License-Identifier: Apache-2.0
//! The control of a run from another terminal: a socket of the run, over which one line asks and the rest answers.
//!
//! The socket lies in a folder that only this user can enter, under the process id of the run. It goes with the run;
//! one of a run that was killed is removed when its user looks for runs.

use std::fs::{self, DirBuilder};
use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::time::Duration;

/// The time for which each side waits for the other, which runs on the same computer.
const TIME_OUT: Duration = Duration::from_secs(2);
/// The maximum length of a request in bytes: a verb and the name of a federate.
const REQUEST_MAX: u64 = 512;

/// The request of a user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ControlRequest {
    /// Tell which federates there are.
    List,
    /// Start this federate, which does not run.
    Start(String),
    /// Have this transient federate leave.
    Stop(String),
    /// Start another instance of this transient federate, which takes the place of the one that runs.
    Swap(String),
}

impl ControlRequest {
    /// Parses the line of a request.
    pub(crate) fn parse(line: &str) -> Option<Self> {
        Some(match line.trim_end().split_once(' ') {
            None if line.trim_end() == "list" => Self::List,
            Some(("start", name)) => Self::Start(name.to_owned()),
            Some(("stop", name)) => Self::Stop(name.to_owned()),
            Some(("swap", name)) => Self::Swap(name.to_owned()),
            _ => return None,
        })
    }

    fn line(&self) -> String {
        match self {
            Self::List => "list".to_owned(),
            Self::Start(name) => format!("start {name}"),
            Self::Stop(name) => format!("stop {name}"),
            Self::Swap(name) => format!("swap {name}"),
        }
    }
}

/// The socket of a run, which is removed when this is dropped.
#[derive(Debug)]
pub(crate) struct Control {
    listener: UnixListener,
    path: PathBuf,
}

impl Control {
    /// Opens the socket of this run, for a user who has another id in the namespace of this process.
    ///
    /// # Errors
    /// When the folder is not this user's, or the system has no sockets left.
    pub(crate) fn open(user: Option<u32>) -> io::Result<Self> {
        let path = folder(user)?.join(std::process::id().to_string());
        match fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let listener = UnixListener::bind(&path)?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, path })
    }

    /// Returns the descriptor to wait for.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        self.listener.as_fd()
    }

    /// Takes a request, and answers it. A client that says nothing understandable gets no answer.
    pub(crate) fn serve(&self, mut answer: impl FnMut(ControlRequest) -> Result<String, String>) {
        while let Ok((mut stream, _)) = self.listener.accept() {
            let _ = stream.set_nonblocking(false);
            let _ = stream.set_read_timeout(Some(TIME_OUT));
            let _ = stream.set_write_timeout(Some(TIME_OUT));
            let mut line = String::new();
            if (&stream).take(REQUEST_MAX).read_to_string(&mut line).is_ok()
                && let Some(request) = ControlRequest::parse(&line)
            {
                let text = answer(request).unwrap_or_else(|error| format!("error: {error}"));
                // A client that has left needs no answer.
                let _ = stream.write_all(text.as_bytes());
            }
        }
    }
}

impl Drop for Control {
    fn drop(&mut self) {
        // An error means that it is gone already.
        let _ = fs::remove_file(&self.path);
    }
}

/// Returns the process ids of the runs of this user, in order.
///
/// # Errors
/// When the folder of their sockets cannot be read.
pub(crate) fn runs() -> io::Result<Vec<u32>> {
    let mut runs = Vec::new();
    for entry in fs::read_dir(folder(None)?)? {
        let entry = entry?;
        let Some(id) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else { continue };
        match UnixStream::connect(entry.path()) {
            Ok(_) => runs.push(id),
            // Its run was killed.
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => fs::remove_file(entry.path())?,
            Err(_) => {}
        }
    }
    runs.sort_unstable();
    Ok(runs)
}

/// Sends a request to a run, and returns its answer.
///
/// # Errors
/// When there is no such run, or it does not answer.
pub(crate) fn ask(run: u32, request: &ControlRequest) -> io::Result<String> {
    let mut stream = UnixStream::connect(folder(None)?.join(run.to_string()))?;
    stream.set_read_timeout(Some(TIME_OUT))?;
    stream.write_all(request.line().as_bytes())?;
    stream.shutdown(Shutdown::Write)?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer)?;
    Ok(answer)
}

/// Returns the folder of the sockets, which only this user can enter. Its name has the id of the user outside of the
/// namespace of this process.
fn folder(outside: Option<u32>) -> io::Result<PathBuf> {
    let user = rustix::process::getuid().as_raw();
    let folder = match std::env::var_os("XDG_RUNTIME_DIR") {
        Some(own) if !own.is_empty() => PathBuf::from(own).join("lfz"),
        _ => std::env::temp_dir().join(format!("lfz-{}", outside.unwrap_or(user))),
    };
    match DirBuilder::new().mode(0o700).create(&folder) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    let found = fs::symlink_metadata(&folder)?;
    if !found.is_dir() || found.uid() != user || found.mode() & 0o077 != 0 {
        let text = format!("{} is not a folder that only you can enter; remove it", folder.display());
        return Err(io::Error::other(text));
    }
    Ok(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_the_same_on_both_sides() {
        let name = || "filter__3".to_owned();
        let requests = [ControlRequest::Start(name()), ControlRequest::Stop(name()), ControlRequest::Swap(name())];
        for request in requests.into_iter().chain([ControlRequest::List]) {
            assert_eq!(ControlRequest::parse(&request.line()), Some(request));
        }
        for other in ["", "start", "listen", "halt a", "list all"] {
            assert_eq!(ControlRequest::parse(other), None, "{other}");
        }
    }
}
