// SPDX-License-Identifier: Apache-2.0
//! UDP: datagrams that arrive late, in another order, twice or not at all.

use lf_runtime::platform::{Endpoint, NetError, SocketId};

use super::socket::{Arriving, Kind};
use super::switch::Network;
use super::{Medium, address_of};

impl<M: Medium> Network<M> {
    /// Opens a port for datagrams; port 0 stands for one that no other socket of the participant has.
    ///
    /// # Errors
    /// If the participant has ended, or has no free slot.
    pub fn bind(&mut self, owner: usize, port: u16) -> Result<SocketId, NetError> {
        let table = &mut self.tables[owner];
        let port = if port == 0 { table.ephemeral_port() } else { port };
        table.insert(Kind::Datagrams { port, arriving: Arriving::default() })
    }

    /// Takes the first datagram that has arrived, truncated to the length of the buffer; returns its length and its
    /// sender.
    ///
    /// # Errors
    /// If the id names no port for datagrams.
    pub fn receive_from(
        &mut self,
        owner: usize,
        id: SocketId,
        buffer: &mut [u8],
        now: u64,
    ) -> Result<Option<(usize, Endpoint)>, NetError> {
        let Kind::Datagrams { arriving, .. } = &mut self.tables[owner].get(id)?.kind else {
            return Err(NetError::Stale);
        };
        let Some((from, bytes)) = arriving.take(now) else { return Ok(None) };
        let count = bytes.len().min(buffer.len());
        buffer[..count].copy_from_slice(&bytes[..count]);
        Ok(Some((count, from)))
    }

    /// Sends a datagram; nothing reports whether it arrives.
    ///
    /// # Errors
    /// If the id names no port for datagrams, or no participant has the address.
    pub fn send_to(
        &mut self,
        owner: usize,
        id: SocketId,
        to: Endpoint,
        bytes: &[u8],
        now: u64,
    ) -> Result<(), NetError> {
        let Kind::Datagrams { port, .. } = self.tables[owner].get(id)?.kind else { return Err(NetError::Stale) };
        let from = Endpoint::new(address_of(owner), port);
        let host = self.host_at(to.ip).ok_or(NetError::Unreachable)?;
        for _ in 0..self.medium.copies() {
            let at = now + self.medium.latency_ns(owner.max(host), bytes.len());
            // Without a listener, nothing reports the loss.
            if let Some(arriving) = self.tables[host].arriving_at(to.port) {
                arriving.0.push((at, from, bytes.to_vec()));
                self.wakes.push((host, at));
            }
        }
        Ok(())
    }
}
