// SPDX-License-Identifier: Apache-2.0
//! UDP: datagrams that arrive late, in another order, twice or not at all.

use std::net::SocketAddrV4;

use lf_runtime::platform::{NetError, SocketId};

use super::socket::Kind;
use super::switch::Network;
use super::{Medium, address_of};

/// Datagrams on their way to a port: when each comes, from where, and what it carries.
#[derive(Debug, Default)]
pub(crate) struct Arriving(Vec<(u64, SocketAddrV4, Vec<u8>)>);

impl Arriving {
    /// When the first one comes.
    pub(crate) fn next_time(&self) -> Option<u64> {
        self.0.iter().map(|(at, ..)| *at).min()
    }

    fn take(&mut self, now: u64) -> Option<(SocketAddrV4, Vec<u8>)> {
        let first = (0..self.0.len()).min_by_key(|index| self.0[*index].0)?;
        (self.0[first].0 <= now).then(|| self.0.swap_remove(first)).map(|(_, from, bytes)| (from, bytes))
    }
}

impl<M: Medium> Network<M> {
    /// Opens a port for datagrams; port 0 stands for one that no other socket of the participant has.
    ///
    /// # Errors
    /// When the participant is no more, or has no place left.
    pub fn bind(&mut self, owner: usize, port: u16) -> Result<SocketId, NetError> {
        let table = &mut self.tables[owner];
        let port = if port == 0 { table.ephemeral_port() } else { port };
        table.insert(Kind::Datagrams { port, arriving: Arriving::default() })
    }

    /// Takes the first datagram that has come, cut to the length of the buffer; how long it is then, and who sent it.
    ///
    /// # Errors
    /// When the id names no port for datagrams.
    pub fn receive_from(
        &mut self,
        owner: usize,
        id: SocketId,
        buffer: &mut [u8],
        now: u64,
    ) -> Result<Option<(usize, SocketAddrV4)>, NetError> {
        let Kind::Datagrams { arriving, .. } = &mut self.tables[owner].get(id)?.kind else {
            return Err(NetError::Stale);
        };
        let Some((from, bytes)) = arriving.take(now) else { return Ok(None) };
        let count = bytes.len().min(buffer.len());
        buffer[..count].copy_from_slice(&bytes[..count]);
        Ok(Some((count, from)))
    }

    /// Sends a datagram; whether it comes, nobody says.
    ///
    /// # Errors
    /// When the id names no port for datagrams, or nobody has the address.
    pub fn send_to(
        &mut self,
        owner: usize,
        id: SocketId,
        to: SocketAddrV4,
        bytes: &[u8],
        now: u64,
    ) -> Result<(), NetError> {
        let Kind::Datagrams { port, .. } = self.tables[owner].get(id)?.kind else { return Err(NetError::Stale) };
        let from = SocketAddrV4::new(address_of(owner), port);
        let host = self.host_at(*to.ip()).ok_or(NetError::Unreachable)?;
        for _ in 0..self.medium.copies() {
            let at = now + self.medium.latency_ns(owner.max(host), bytes.len());
            // Where nobody listens, nobody notices.
            if let Some(arriving) = self.tables[host].arriving_at(to.port()) {
                arriving.0.push((at, from, bytes.to_vec()));
                self.medium.wake(host, at);
            }
        }
        Ok(())
    }
}
