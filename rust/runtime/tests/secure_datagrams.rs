// SPDX-License-Identifier: Apache-2.0
//! Datagrams of an encrypted connection: strangers and repetitions change nothing.

use crate::support::keys::secret;
use lf_coordination::Deadline;
use lf_model::time::Interval;
use lf_runtime::platform::{Endpoint, Interest, NetError, Participant, Platform as _, SocketId};
use lf_runtime::{SecurePlatform, SecureSlot};
use lf_secure::{FederationSecret, HANDSHAKE_BYTES, Keyring, Member};
use lf_testkit::network::{Medium, address_of};
use lf_testkit::random::Random;
use lf_testkit::world::{ComputerSpeed, Shared, Side, Virtual, World};

const RTI: usize = 0;
const FEDERATE: usize = 1;
const STRANGER: usize = 2;
const PORT: u16 = 15045;
/// The number of datagrams that the RTI sends.
const DATAGRAMS: u8 = 40;

/// A network in which each datagram arrives twice.
struct Twice(Random);

impl Medium for Twice {
    fn latency_ns(&mut self, _owner: usize, _bytes: usize) -> u64 {
        1000
    }

    fn pipe_bytes(&self, _owner: usize) -> usize {
        1 << 12
    }

    fn piece(&mut self, most: usize) -> usize {
        most
    }

    fn random(&mut self) -> &mut Random {
        &mut self.0
    }

    fn copies(&mut self) -> usize {
        2
    }
}

type Host<'k> = SecurePlatform<'k, Virtual<Twice>, Vec<u8>>;

/// The sockets of a participant.
#[derive(Default)]
struct Sockets {
    connection: Option<SocketId>,
    is_connected: bool,
    port: Option<SocketId>,
}

impl Sockets {
    /// Lets the handshake go on; returns whether this participant has proved to be at the other end.
    fn shake_hands(&mut self, host: &mut Host<'_>, participant: Participant) -> bool {
        host.wait(Deadline::Now, &mut |_, _| {});
        let Some(connection) = self.connection else { return false };
        if !self.is_connected {
            self.is_connected = host.connected(connection).is_ok();
            host.set_interest(connection, Interest { readable: true, writable: !self.is_connected });
        }
        host.may_be(connection, participant)
    }
}

impl Sockets {
    /// Sends datagrams of a stranger.
    fn disturb(&mut self, stranger: &mut Virtual<Twice>, to: Option<Endpoint>) {
        let port = *self.port.get_or_insert_with(|| stranger.bind(0).unwrap());
        for bytes in [&[19; 9][..], &[0; 37], &[0; 64], &[]] {
            let _ = to.map(|to| stranger.send_to(port, to, bytes));
        }
    }
}

#[test]
fn datagrams_of_strangers_and_repeated_ones_change_nothing() {
    let members = [Member { federate: 7, key: secret(FEDERATE).public() }];
    let world = Shared::new(World::new(Twice(Random::new(1)), Random::new(1)));
    for _ in 0..3 {
        world.lock().join(Side::keep(0, 0), 0, ComputerSpeed::INSTANT);
    }
    let keyring = |own| Keyring::new(secret(own), FederationSecret::new([3; 32]), secret(RTI).public(), &members);
    let slots = || [(); 2].map(|()| SecureSlot::new(vec![0; HANDSHAKE_BYTES], vec![0; HANDSHAKE_BYTES]));
    let (mut rti_slots, mut federate_slots) = (slots(), slots());
    let mut rti = SecurePlatform::new(world.platform(RTI), Some(keyring(RTI)), &mut rti_slots);
    let mut federate = SecurePlatform::new(world.platform(FEDERATE), Some(keyring(FEDERATE)), &mut federate_slots);
    let mut stranger = world.platform(STRANGER);
    let mut sockets: [Sockets; 3] = Default::default();
    let (mut listener, mut to) = (None, None);
    let (mut sent, mut received, mut refused) = (0, Vec::new(), 0_u32);
    for turn in 0.. {
        if received.len() >= usize::from(DATAGRAMS) {
            break;
        }
        assert!(turn < 20_000, "{sent} datagrams are sent, {} have come, {refused} were refused", received.len());
        let participant = world.lock().next_turn(None).expect("there is always a next turn");
        let own = &mut sockets[participant];
        match participant {
            RTI => {
                let listener = *listener.get_or_insert_with(|| rti.listen(PORT).unwrap());
                let port = *own.port.get_or_insert_with(|| rti.bind(0).unwrap());
                if let Ok(Some((socket, _))) = rti.accept(listener) {
                    (own.connection, own.is_connected) = (Some(socket), true);
                    rti.set_interest(socket, Interest::READ);
                }
                let is_known = own.shake_hands(&mut rti, Participant::Federate(7));
                // It is nobody else, before and after.
                assert!(own.connection.is_none_or(|socket| !rti.may_be(socket, Participant::Federate(8))));
                if let (true, Some(to), true) = (is_known, to, sent < DATAGRAMS) {
                    rti.send_to(port, to, &[sent; 9]).unwrap();
                    sent += 1;
                }
            }
            FEDERATE => {
                let port = *own.port.get_or_insert_with(|| federate.bind(0).unwrap());
                to = to.or_else(|| Some(Endpoint::new(address_of(FEDERATE), federate.local_port(port).unwrap())));
                if own.connection.is_none() && listener.is_some() {
                    own.connection = federate.connect(Endpoint::new(address_of(RTI), PORT)).ok();
                    own.connection.iter().for_each(|socket| federate.set_interest(*socket, Interest::WRITE));
                }
                own.shake_hands(&mut federate, Participant::Rti);
                let mut buffer = [0; 10];
                loop {
                    match federate.receive_from(port, &mut buffer) {
                        Ok(Some((count, from))) => {
                            assert_eq!(from.ip, address_of(RTI));
                            received.push(buffer[..count].to_vec());
                        }
                        Ok(None) => break,
                        Err(error) => {
                            assert_eq!(error, NetError::Insecure);
                            refused += 1;
                        }
                    }
                }
            }
            _ => own.disturb(&mut stranger, to),
        }
        let next = world.lock().now() + u64::try_from(Interval::from_micros(100).as_nanos()).unwrap();
        world.lock().after_turn(participant, Some(next));
    }
    let expected: Vec<_> = (0..DATAGRAMS).map(|number| vec![number; 9]).collect();
    assert_eq!(received, expected);
    assert!(refused > u32::from(DATAGRAMS), "{refused}");
}
