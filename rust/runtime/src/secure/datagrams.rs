// SPDX-License-Identifier: Apache-2.0
//! Datagrams of encrypted connections: each is for one connection, and of the participant at its other end.

use lf_coordination::Endpoint;
use lf_secure::{DatagramKeys, Participant};
use log::Level;

use super::{SecurePlatform, SecureSlot, SecurityEvent, name_of};
use crate::log_event::report;
use crate::platform::{NetError, Platform, SocketId};

/// The length of a buffer for an encrypted datagram: any of clock synchronization, and a longer one is none.
const DATAGRAM_BYTES: usize = 64;

impl<P: Platform, B: AsRef<[u8]> + AsMut<[u8]>> SecurePlatform<'_, P, B> {
    /// Receives a datagram of a connection.
    pub(super) fn receive_datagram(
        &mut self,
        socket: SocketId,
        buffer: &mut [u8],
    ) -> Result<Option<(usize, Endpoint)>, NetError> {
        let mut datagram = [0; DATAGRAM_BYTES];
        let Some((count, from)) = self.platform.receive_from(socket, &mut datagram)? else { return Ok(None) };
        let datagram = datagram.get_mut(..count).unwrap_or_default();
        if let Some(count) = self.open_datagram(from, datagram, buffer) {
            return Ok(Some((count, from)));
        }
        let times = self.forged.count();
        if times.is_logged() {
            report(Level::Warn, &SecurityEvent::Datagram { from, times });
        }
        // The loop takes the next one.
        Err(NetError::Insecure)
    }

    /// Sends a datagram of a connection.
    pub(super) fn send_datagram(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        let mut datagram = [0; DATAGRAM_BYTES];
        let keys = self.for_datagrams(to).and_then(|slot| slot.channel.datagrams());
        let count = keys.and_then(|keys| keys.seal(bytes, &mut datagram)).ok_or(NetError::Insecure)?;
        self.platform.send_to(socket, to, datagram.get(..count).unwrap_or_default())
    }

    /// Returns the connection with the participant that takes datagrams at this address: a federate that has told its
    /// port, or else the RTI.
    fn for_datagrams(&mut self, to: Endpoint) -> Option<&mut SecureSlot<B>> {
        let is_it = |slot: &SecureSlot<B>| match slot.channel.peer() {
            Some(Participant::Federate(_)) => Endpoint::new(slot.address, slot.channel.remote_port()) == to,
            Some(Participant::Rti) => true,
            None => false,
        };
        self.slots.iter_mut().find(|slot| is_it(slot))
    }

    /// Decrypts a datagram into `buffer`. Returns its length, or `None` if it is none of a connection here.
    fn open_datagram(&mut self, from: Endpoint, datagram: &mut [u8], buffer: &mut [u8]) -> Option<usize> {
        let name = DatagramKeys::name_in(datagram)?;
        let slot = self.slots.iter_mut().find(|slot| slot.socket.is_some_and(|socket| name_of(socket) == name))?;
        // A federate may not speak for another one, whose address it forges.
        let is_there = match slot.channel.peer()? {
            Participant::Federate(_) => Endpoint::new(slot.address, slot.channel.remote_port()) == from,
            Participant::Rti => true,
        };
        let content = slot.channel.datagrams().filter(|_| is_there)?.open(datagram)?;
        buffer.get_mut(..content.len())?.copy_from_slice(content);
        Some(content.len())
    }
}
