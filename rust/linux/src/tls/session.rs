// SPDX-License-Identifier: Apache-2.0
//! One end of a connection. It keeps no more of what is to be sent than one write, so that what a program has written
//! is the system's when the write has succeeded, as without TLS.

use std::fmt;
use std::io::{BufRead as _, ErrorKind, Read as _, Write as _};
use std::sync::Arc;

use lf_runtime::platform::{NetError, Participant, Transfer};
use rustls::{AlertDescription, CertificateError, Connection, Error};

use super::verifier::Verifier;
use crate::sockets::{Secured, SecuredStage, Wire};

/// The most bytes of one write.
const WRITE_BYTES_MAX: usize = 1 << 16;

/// One end of a connection.
pub(super) struct Session {
    connection: Connection,
    verifier: Arc<Verifier>,
    /// The bytes at the beginning of what the program writes that are encrypted, but not sent as a whole.
    accepted: usize,
    /// The participant that has to be at the other end.
    expected: Option<Participant>,
    /// Whether that was checked.
    is_checked: bool,
    /// Whether the connection is of no use any more.
    failed: bool,
    /// Whether the other end has closed its direction.
    ended: bool,
}

impl Session {
    pub(super) fn new(mut connection: Connection, verifier: Arc<Verifier>) -> Self {
        connection.set_buffer_limit(Some(WRITE_BYTES_MAX));
        Self { connection, verifier, accepted: 0, expected: None, is_checked: false, failed: false, ended: false }
    }

    /// Reads once from the system. Returns whether anything has come, or the end has.
    fn take_in(&mut self, wire: &mut Wire<'_>) -> Result<bool, String> {
        match self.connection.read_tls(wire) {
            Ok(count) => {
                let state = self.connection.process_new_packets().map_err(|error| {
                    // The other end gets an alert, which says why.
                    self.flush(wire);
                    self.failed = true;
                    sentence(&error)
                })?;
                self.ended |= state.peer_has_closed() || count == 0;
                // An end without a word is that of a program that encrypts nothing, or of one that was killed.
                self.failed |= count == 0 && self.connection.is_handshaking();
                Ok(true)
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(false),
            Err(_) => {
                self.failed = true;
                Ok(true)
            }
        }
    }

    /// Compares who is at the other end with who has to be there, once both ends have proved who they are.
    fn check(&mut self) -> Result<(), String> {
        if self.is_checked || self.stage() != SecuredStage::Open {
            return Ok(());
        }
        self.is_checked = true;
        match (self.expected, self.peer()) {
            (Some(expected), Some(found)) if expected != found => {
                self.failed = true;
                Err(format!("{found} is at the other end, with its own certificate, and {expected} was expected there"))
            }
            _ => Ok(()),
        }
    }

    /// Returns who is at the other end, by its certificate.
    fn peer(&self) -> Option<Participant> {
        self.verifier.owner_of(self.connection.peer_certificates()?.first()?)
    }

    /// Writes what is encrypted, as much as the system takes. Reading finds the end of a broken connection, after the
    /// last bytes of the other end.
    fn flush(&mut self, wire: &mut Wire<'_>) {
        while self.connection.wants_write() && !self.failed {
            match self.connection.write_tls(wire) {
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    self.failed |= error.kind() != ErrorKind::WouldBlock && self.connection.is_handshaking();
                    return;
                }
            }
        }
    }
}

impl Secured for Session {
    fn stage(&self) -> SecuredStage {
        match (self.failed, self.connection.is_handshaking()) {
            (true, _) => SecuredStage::Failed,
            (false, true) => SecuredStage::Handshake,
            (false, false) => SecuredStage::Open,
        }
    }

    fn wants_write(&self) -> bool {
        self.connection.wants_write()
    }

    fn has_more(&mut self) -> bool {
        self.failed || self.ended || self.connection.reader().fill_buf().is_ok_and(|bytes| !bytes.is_empty())
    }

    fn require(&mut self, participant: Participant) {
        self.expected = Some(participant);
    }

    fn may_be(&self, participant: Participant) -> bool {
        self.stage() == SecuredStage::Open && (!self.verifier.verifies() || self.peer() == Some(participant))
    }

    fn handshake(&mut self, wire: &mut Wire<'_>) -> Result<(), String> {
        self.flush(wire);
        while self.stage() == SecuredStage::Handshake && self.take_in(wire)? {
            self.flush(wire);
        }
        self.check()
    }

    fn read(&mut self, wire: &mut Wire<'_>, buffer: &mut [u8]) -> Result<Result<Transfer, NetError>, String> {
        loop {
            self.check()?;
            if self.failed {
                return Ok(Err(NetError::Insecure));
            }
            match self.connection.reader().read(buffer) {
                Ok(0) => return Ok(Ok(Transfer::Closed)),
                Ok(count) => return Ok(Ok(Transfer::Bytes(count))),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                // The system's connection has ended, and the other end has not said so: an attacker may have cut it.
                Err(_) if self.verifier.verifies() => self.failed = true,
                Err(_) => return Ok(Ok(Transfer::Closed)),
            }
            if !self.failed && !self.take_in(wire)? {
                self.flush(wire);
                return Ok(Ok(Transfer::WouldBlock));
            }
            self.flush(wire);
        }
    }

    fn write(&mut self, wire: &mut Wire<'_>, bytes: &[u8]) -> Result<Result<Transfer, NetError>, String> {
        self.handshake(wire)?;
        if self.stage() == SecuredStage::Open && !self.connection.wants_write() && self.accepted == 0 {
            self.accepted = self.connection.writer().write(bytes).unwrap_or_default();
            self.flush(wire);
        }
        Ok(match self.stage() {
            SecuredStage::Failed => Err(NetError::Insecure),
            SecuredStage::Open if !self.connection.wants_write() => {
                Ok(Transfer::Bytes(std::mem::take(&mut self.accepted)))
            }
            SecuredStage::Open | SecuredStage::Handshake => Ok(Transfer::WouldBlock),
        })
    }

    fn close(&mut self, wire: &mut Wire<'_>) {
        self.connection.send_close_notify();
        self.flush(wire);
    }
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Session")
            .field("accepted", &self.accepted)
            .field("failed", &self.failed)
            .finish_non_exhaustive()
    }
}

/// Returns why an error ends a connection, and what to do.
fn sentence(error: &Error) -> String {
    let text = match error {
        Error::InvalidMessage(_) => {
            "the other end does not speak TLS: it needs `comm-type: TLS` in its program, or the option -tls"
        }
        Error::InvalidCertificate(CertificateError::ApplicationVerificationFailure) => {
            "the other end has a certificate that is not known here: compare the fingerprints of `lfz keys show`, and \
             `lfz keys trust` it"
        }
        Error::NoCertificatesPresented => {
            "the other end shows no certificate, as programs of LF's own compiler do: `security: unverified` in the \
             program, or the option --unverified, accepts anybody"
        }
        Error::AlertReceived(
            AlertDescription::BadCertificate
            | AlertDescription::CertificateUnknown
            | AlertDescription::UnknownCA
            | AlertDescription::AccessDenied,
        ) => "the other end does not know the certificate of this program: `lfz keys trust` it there",
        Error::AlertReceived(AlertDescription::CertificateRequired) => {
            "the other end demands a certificate: start this program with --keys"
        }
        error => return format!("TLS ends the connection: {error}"),
    };
    text.to_owned()
}
