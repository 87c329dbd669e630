// SPDX-License-Identifier: Apache-2.0
//! UDP as the event loops see it: datagrams that arrive late, in another order, twice or not at all.

use std::net::SocketAddrV4;

use lf_runtime::platform::{NetError, SocketId};

use super::network::{Kind, Network, address_of};

/// How many datagrams of a hundred are lost, and how many come twice.
const LOST_PERCENT: u64 = 5;
const DOUBLE_PERCENT: u64 = 2;
/// The first port that stands for any.
const DYNAMIC_PORT: u16 = 49_152;

/// Datagrams on their way to a port.
#[derive(Debug, Default)]
pub(super) struct Arriving(Vec<(u64, SocketAddrV4, Vec<u8>)>);

impl Arriving {
    /// When the first one comes.
    pub(super) fn next_time(&self) -> Option<u64> {
        self.0.iter().map(|(at, ..)| *at).min()
    }

    fn take(&mut self, now: u64) -> Option<(SocketAddrV4, Vec<u8>)> {
        let first = (0..self.0.len()).min_by_key(|index| self.0[*index].0)?;
        (self.0[first].0 <= now).then(|| self.0.swap_remove(first)).map(|(_, from, bytes)| (from, bytes))
    }
}

impl Network {
    pub(super) fn bind(&mut self, owner: usize, port: u16) -> Result<SocketId, NetError> {
        let port = if port == 0 { DYNAMIC_PORT } else { port };
        self.insert(owner, Kind::Datagrams { port, arriving: Arriving::default() })
    }

    pub(super) fn receive_from(
        &mut self,
        owner: usize,
        id: SocketId,
        buffer: &mut [u8],
        now: u64,
    ) -> Result<Option<(usize, SocketAddrV4)>, NetError> {
        let Kind::Datagrams { arriving, .. } = &mut self.socket(owner, id)?.kind else { return Err(NetError::Stale) };
        let Some((from, bytes)) = arriving.take(now) else { return Ok(None) };
        let count = bytes.len().min(buffer.len());
        buffer[..count].copy_from_slice(&bytes[..count]);
        Ok(Some((count, from)))
    }

    pub(super) fn send_to(
        &mut self,
        owner: usize,
        id: SocketId,
        to: SocketAddrV4,
        bytes: &[u8],
        now: u64,
    ) -> Result<(), NetError> {
        let Kind::Datagrams { port, .. } = self.socket(owner, id)?.kind else { return Err(NetError::Stale) };
        let from = SocketAddrV4::new(address_of(owner), port);
        let host = (0..self.host_count()).find(|host| address_of(*host) == *to.ip());
        let Some(host) = host else { return Err(NetError::Unreachable) };
        let copies = if self.chance(LOST_PERCENT) { 0 } else { 1 + usize::from(self.chance(DOUBLE_PERCENT)) };
        for _ in 0..copies {
            // The wire is that of the federate, whichever end it is.
            let at = now + self.latency(owner.max(host), bytes.len());
            if self.deliver(host, to.port(), (at, from, bytes.to_vec())) {
                self.wakes.push((host, at));
            }
        }
        Ok(())
    }

    /// Puts a datagram on its way. `false` if nobody listens.
    fn deliver(&mut self, host: usize, port: u16, datagram: (u64, SocketAddrV4, Vec<u8>)) -> bool {
        let found = self.kinds_of(host).find_map(|kind| match kind {
            Kind::Datagrams { port: bound, arriving } if *bound == port => Some(arriving),
            _ => None,
        });
        found.map(|arriving| arriving.0.push(datagram)).is_some()
    }
}
