// SPDX-License-Identifier: Apache-2.0
//! Virtual time and a virtual network for the programs of a federation: one other program has both, and lets them run
//! one after the other, so that a run is the same each time.
//!
//! A participant makes its calls over a local socket, one after the other. Between two waits its clock stands still.

mod frame;
mod serve;
#[cfg(test)]
mod tests;

use std::os::unix::net::UnixStream;
use std::{env, io};

use lf_coordination::Deadline;
use lf_model::time::Instant;
use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, RandomError, SocketId, Transfer};

use crate::clock::VIRTUAL_START;
use frame::{Call, Frame};
pub use serve::{participant, serve};

/// The environment variable of a participant: its number, a colon, and the path of the local socket.
pub const VARIABLE: &str = "LF_VIRTUAL_NETWORK";

/// Returns whether this process is a participant of a virtual network.
pub(crate) fn is_asked_for() -> bool {
    env::var_os(VARIABLE).is_some()
}

/// This process as a participant.
#[derive(Debug)]
pub(crate) struct VirtualNetwork {
    stream: UnixStream,
    /// Whether it has to end: it is asked to, or the other program is gone.
    interrupted: bool,
}

impl VirtualNetwork {
    /// Takes part, and waits for the first turn. Returns the time then.
    ///
    /// # Errors
    /// When the other program is gone.
    pub(crate) fn begin() -> io::Result<(Self, Instant)> {
        let place = env::var(VARIABLE).map_err(io::Error::other)?;
        let wrong =
            || io::Error::new(io::ErrorKind::InvalidInput, format!("{VARIABLE}: \"{place}\" is no NUMBER:PATH"));
        let (number, path) = place.split_once(':').ok_or_else(wrong)?;
        let number: u16 = number.parse().map_err(|_| wrong())?;
        Self::begin_at(UnixStream::connect(path)?, number)
    }

    fn begin_at(stream: UnixStream, number: u16) -> io::Result<(Self, Instant)> {
        Frame::call(Call::Begin).with_number(number.into()).write(&stream)?;
        let time = Frame::read(&stream)?.time();
        Ok((Self { stream, interrupted: false }, moved_by(time, VIRTUAL_START)))
    }

    /// Makes a call that has no answer. Where nobody hears it, the next answer does not come.
    fn send(&mut self, call: &Frame) {
        self.interrupted |= call.write(&self.stream).is_err();
    }

    /// Makes a call, and returns its answer.
    fn ask(&mut self, call: &Frame) -> Result<Frame, NetError> {
        let answer = call.write(&self.stream).and_then(|()| Frame::read(&self.stream));
        self.interrupted |= answer.is_err();
        answer.unwrap_or_else(|_| Frame::failed(NetError::Unreachable)).outcome()
    }

    pub(crate) fn random(&mut self, buffer: &mut [u8]) -> Result<(), RandomError> {
        let answer = self.ask(&Frame::call(Call::Random).with_number(buffer.len())).map_err(|_| RandomError(0))?;
        if answer.bytes.len() != buffer.len() {
            return Err(RandomError(0));
        }
        buffer.copy_from_slice(&answer.bytes);
        Ok(())
    }

    pub(crate) fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        self.ask(&Frame::call(Call::Connect).with_address(address)).map(|answer| answer.socket())
    }

    pub(crate) fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        self.ask(&Frame::call(Call::Connected).about(socket)).map(drop)
    }

    pub(crate) fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.ask(&Frame::call(Call::Listen).with_number(port.into())).map(|answer| answer.socket())
    }

    pub(crate) fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.ask(&Frame::call(Call::Bind).with_number(port.into())).map(|answer| answer.socket())
    }

    pub(crate) fn receive_from(
        &mut self,
        socket: SocketId,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, Endpoint)>, NetError> {
        let answer = self.ask(&Frame::call(Call::ReceiveFrom).about(socket).with_number(buffer.len()))?;
        let Some((from, bytes)) = answer.address().filter(|_| !answer.is_nothing()) else { return Ok(None) };
        Ok(Some((copy(bytes, buffer), from)))
    }

    pub(crate) fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        self.ask(&Frame::call(Call::SendTo).about(socket).with_bytes(bytes).with_address(to)).map(drop)
    }

    pub(crate) fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.ask(&Frame::call(Call::LocalPort).about(listener)).map(|answer| answer.port())
    }

    pub(crate) fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        let answer = self.ask(&Frame::call(Call::Accept).about(listener))?;
        Ok(answer.address().map(|(from, _)| (answer.socket(), from.ip)))
    }

    pub(crate) fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        let answer = self.ask(&Frame::call(Call::Read).about(socket).with_number(buffer.len()))?;
        copy(&answer.bytes, buffer);
        Ok(answer.transfer())
    }

    pub(crate) fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        self.ask(&Frame::call(Call::Write).about(socket).with_bytes(bytes)).map(|answer| answer.transfer())
    }

    pub(crate) fn shut_down_writing(&mut self, socket: SocketId) {
        self.send(&Frame::call(Call::ShutDownWriting).about(socket));
    }

    pub(crate) fn close(&mut self, socket: SocketId) {
        self.send(&Frame::call(Call::Close).about(socket));
    }

    pub(crate) fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        self.send(&Frame::call(Call::SetInterest).about(socket).with_interest(interest));
    }

    /// Ends this turn. Returns the time at the beginning of the next one, which comes when a socket matches its
    /// interest, or at `until`.
    pub(crate) fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) -> Option<Instant> {
        let call = match until {
            Deadline::Never => Frame::call(Call::Wait),
            Deadline::At(time) => Frame::call(Call::WaitUntil).with_time(moved_by(time, -VIRTUAL_START)),
            Deadline::Now => Frame::call(Call::WaitUntil).with_time(Instant::NEVER),
        };
        let answer = self.ask(&call).ok()?;
        answer.ready().for_each(|(socket, interest)| ready(socket, interest));
        self.interrupted |= answer.is_interrupted();
        Some(moved_by(answer.time(), VIRTUAL_START))
    }

    pub(crate) fn interrupted(&self) -> bool {
        self.interrupted
    }
}

/// Returns a time of the other program as this one has it, or the other way around: its clock begins in another year.
fn moved_by(time: Instant, ns: i64) -> Instant {
    Instant::from_nanos(time.as_nanos().saturating_add(ns))
}

/// Copies what there is room for; returns its length.
fn copy(bytes: &[u8], buffer: &mut [u8]) -> usize {
    let count = bytes.len().min(buffer.len());
    buffer[..count].copy_from_slice(&bytes[..count]);
    count
}
