// SPDX-License-Identifier: Apache-2.0
//! UDP as the event loops see it: datagrams that arrive late, in another order, twice or not at all.

use std::net::SocketAddrV4;

use lf_runtime::platform::{NetError, SocketId};

use super::network::{Kind, Network, address_of};
use super::random::Random;

/// The first port that stands for any.
const DYNAMIC_PORT: u16 = 49_152;

/// A port, and the datagrams on their way to it.
#[derive(Debug)]
pub struct Port {
    pub number: u16,
    arriving: Vec<(u64, SocketAddrV4, Vec<u8>)>,
}

impl Port {
    /// When datagrams come.
    pub fn times(&self) -> impl Iterator<Item = u64> {
        self.arriving.iter().map(|(at, ..)| *at)
    }
}

impl Network {
    pub fn bind(&mut self, owner: usize, port: u16) -> Result<SocketId, NetError> {
        let number = if port == 0 { DYNAMIC_PORT } else { port };
        self.insert(owner, Kind::Datagrams(Port { number, arriving: Vec::new() }))
    }

    pub fn receive_from(
        &mut self,
        owner: usize,
        id: SocketId,
        buffer: &mut [u8],
        now: u64,
    ) -> Result<Option<(usize, SocketAddrV4)>, NetError> {
        let Kind::Datagrams(Port { arriving, .. }) = self.kind(owner, id)? else { return Err(NetError::Stale) };
        let first = (0..arriving.len()).filter(|index| arriving[*index].0 <= now);
        let Some(first) = first.min_by_key(|index| arriving[*index].0) else { return Ok(None) };
        let (_, from, bytes) = arriving.swap_remove(first);
        let count = bytes.len().min(buffer.len());
        buffer[..count].copy_from_slice(&bytes[..count]);
        Ok(Some((count, from)))
    }

    pub fn send_to(
        &mut self,
        owner: usize,
        id: SocketId,
        to: SocketAddrV4,
        bytes: &[u8],
        now: u64,
        random: &mut Random,
    ) -> Result<(), NetError> {
        let Kind::Datagrams(port) = self.kind(owner, id)? else { return Err(NetError::Stale) };
        let from = SocketAddrV4::new(address_of(owner), port.number);
        let copies = if random.once_in(20) { 0 } else { 1 + usize::from(random.once_in(50)) };
        let times: Vec<u64> = (0..copies).map(|_| now + self.latency(random)).collect();
        let host = (0..usize::from(u8::MAX)).find(|host| address_of(*host) == *to.ip()).ok_or(NetError::Unreachable)?;
        let bound = self.kinds_of(host).find_map(|kind| match kind {
            Kind::Datagrams(port) if port.number == to.port() => Some(port),
            _ => None,
        });
        if let Some(port) = bound {
            port.arriving.extend(times.into_iter().map(|at| (at, from, bytes.to_vec())));
        }
        Ok(())
    }
}
