// SPDX-License-Identifier: Apache-2.0
//! Encrypted connections that this end has closed and the other one has not. Each end says in TLS that it closes, and a
//! socket that is gone would answer with a reset, which LF's receivers take for a failure.

use std::os::fd::{AsRawFd as _, OwnedFd};

use rustix::event::epoll;
use rustix::io::Errno;
use rustix::net::{RecvFlags, Shutdown};

/// The bit that tells the epoll key of such a connection from one of a socket of the table. The rest is its descriptor.
const KEY: u64 = 1 << 32;
/// The most connections. One more closes the oldest, so that peers that never close do not use up the descriptors.
const COUNT_MAX: usize = 64;

/// These connections.
#[derive(Default, Debug)]
pub(super) struct Closing(Vec<OwnedFd>);

impl Closing {
    /// Closes this end's direction of a connection, and adds the connection to the epoll set.
    pub(super) fn add(&mut self, epoll: &OwnedFd, descriptor: OwnedFd) {
        let (data, flags) = (epoll::EventData::new_u64(key(&descriptor)), epoll::EventFlags::IN);
        // It is in the set already if the event loop has had an interest.
        let is_watched = epoll::modify(epoll, &descriptor, data, flags)
            .or_else(|_| epoll::add(epoll, &descriptor, data, flags))
            .and_then(|()| rustix::net::shutdown(&descriptor, Shutdown::Write));
        if is_watched.is_err() {
            return;
        }
        if self.0.len() == COUNT_MAX {
            self.0.remove(0);
        }
        self.0.push(descriptor);
    }

    /// Reads from the connection that has this epoll key, and closes it at its end or at an error. Returns whether the
    /// key is one of these connections.
    pub(super) fn go_on(&mut self, of: u64) -> bool {
        if of & KEY == 0 {
            return false;
        }
        let Some(index) = self.0.iter().position(|descriptor| key(descriptor) == of) else { return true };
        let mut ignored = [0; 512];
        match rustix::net::recv(&self.0[index], &mut ignored, RecvFlags::empty()) {
            Ok((_, 1..)) | Err(Errno::AGAIN | Errno::INTR) => {}
            Ok((_, 0)) | Err(_) => drop(self.0.remove(index)),
        }
        true
    }
}

fn key(descriptor: &OwnedFd) -> u64 {
    KEY | u64::from(descriptor.as_raw_fd().unsigned_abs())
}
