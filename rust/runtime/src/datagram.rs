// SPDX-License-Identifier: Apache-2.0
//! Datagrams of clock synchronization.

use core::net::SocketAddrV4;

use lf_wire::{Message, MessageType};

use crate::platform::{Platform, SocketId};

/// One byte more than the longest has, so that a longer one is not taken for one.
pub(crate) const BYTES_MAX: usize = MessageType::T4.fixed_bytes() + 1;
/// How many are read before there is something else to do.
pub(crate) const PER_TURN: usize = 64;

/// Sends a message. If it is lost, here or on the way, so is its round.
pub(crate) fn send<P: Platform>(platform: &mut P, socket: SocketId, to: SocketAddrV4, message: &Message<'_>) {
    let mut bytes = [0; BYTES_MAX];
    if let Ok(len) = message.encode(&mut bytes) {
        let _ = platform.send_to(socket, to, bytes.get(..len).unwrap_or_default());
    }
}
