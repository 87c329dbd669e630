// SPDX-License-Identifier: Apache-2.0
//! TLS between two socket tables over TCP, also with a relay between them.

use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::os::unix::net::UnixStream;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use lf_runtime::platform::{Endpoint, Interest, NetError, Participant, SocketId, Transfer};
use rcgen::KeyPair;

use super::*;
use crate::keys::Others;
use crate::sockets::Sockets;

/// The time without a byte after which a connection with a changed one is cut.
const QUIET: Duration = Duration::from_millis(300);

/// A participant's secret key and certificate.
struct Identity {
    key: String,
    certificate: Vec<u8>,
}

fn identity() -> Identity {
    let key = KeyPair::generate().expect("random numbers");
    let certificate = rcgen::CertificateParams::default().self_signed(&key).expect("a key signs");
    Identity { key: key.serialize_pem(), certificate: certificate.der().to_vec() }
}

impl Identity {
    /// Returns the settings of this participant, which knows the others.
    fn knows(&self, rti: Option<&Self>, federates: &[(u16, &Self)]) -> Tls {
        let federates: BTreeMap<_, _> = federates.iter().map(|(id, one)| (*id, one.certificate.clone())).collect();
        let others = Others { rti: rti.map(|rti| rti.certificate.clone()), federates };
        let (own, certificate) = (self.key.clone().into_bytes(), self.certificate.clone());
        Tls::verified(TlsKeys { own, certificate, others }).expect("they are a pair")
    }

    fn accepts_all(&self) -> Tls {
        let pem = crate::keys::certificate_text(&self.certificate);
        Tls::unverified(pem.as_bytes(), self.key.as_bytes()).expect("they are a pair")
    }
}

/// One end of a connection, in a table of its own.
struct End {
    sockets: Sockets,
    id: SocketId,
    /// Whether a wait has reported it since it was looked at.
    ready: bool,
    is_closed: bool,
    _wake: (UnixStream, UnixStream),
}

impl End {
    fn table(tls: Option<Tls>) -> (Sockets, (UnixStream, UnixStream)) {
        let wake = UnixStream::pair().expect("a pair of sockets");
        let mut sockets = Sockets::new(&wake.0).expect("an epoll");
        if let Some(tls) = tls {
            sockets.encrypt(Box::new(tls));
        }
        (sockets, wake)
    }

    fn wait(&mut self, interest: Interest) {
        self.sockets.set_interest(self.id, interest);
        let (id, ready) = (self.id, &mut self.ready);
        self.sockets.wait(Some(Duration::from_millis(1)), &mut |socket, _| *ready |= socket == id);
    }

    fn read(&mut self, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        self.ready = false;
        self.sockets.read(self.id, buffer)
    }

    fn may_be(&self, participant: Participant) -> bool {
        self.sockets.may_be(self.id, participant)
    }
}

/// Returns both ends of a connection, which goes to a relay if there is one; `through` gets the server's port, and
/// returns the port to connect to.
fn connection(client: Option<Tls>, server: Option<Tls>, through: impl FnOnce(u16) -> u16) -> (End, End) {
    let (mut server, server_wake) = End::table(server);
    let listener = server.listen(0).expect("a listener");
    let port = through(server.local_port(listener).expect("its port"));
    let (mut client, client_wake) = End::table(client);
    let id = client.connect(Endpoint::new(Ipv4Addr::LOCALHOST, port)).expect("an attempt");
    let accepted = loop {
        if let Some((accepted, _)) = server.accept(listener).expect("no error") {
            break accepted;
        }
        server.set_interest(listener, Interest::READ);
        server.wait(None, &mut |_, _| {});
    };
    let client = End { sockets: client, id, ready: false, is_closed: false, _wake: client_wake };
    (client, End { sockets: server, id: accepted, ready: false, is_closed: false, _wake: server_wake })
}

/// Waits at both ends until the client's attempt has an outcome. As an event loop does, the server closes a connection
/// that is of no use.
fn outcome(client: &mut End, server: &mut End) -> Result<(), NetError> {
    while !client.ready {
        client.wait(Interest::WRITE);
        server.wait(Interest::READ);
        if server.ready && server.read(&mut []).is_err() {
            server.sockets.close(server.id);
            server.is_closed = true;
        }
    }
    client.ready = false;
    client.sockets.connected(client.id)
}

/// Sends bytes from one end to the other, which reads a few at a time. Returns what arrives until the other end or an
/// error, if there is one.
fn send(from: &mut End, to: &mut End, bytes: &[u8], piece: usize) -> (Vec<u8>, Option<NetError>) {
    let (mut sent, mut received, mut buffer) = (0, Vec::new(), vec![0; piece]);
    loop {
        if from.is_closed || to.is_closed {
            return (received, Some(NetError::Insecure));
        }
        if sent < bytes.len() {
            from.wait(Interest { readable: true, writable: true });
            match from.sockets.write(from.id, &bytes[sent..]) {
                Ok(Transfer::Bytes(count)) => sent += count,
                Ok(_) => {}
                Err(error) => return (received, Some(error)),
            }
            if sent == bytes.len() {
                from.sockets.shut_down_writing(from.id);
            }
        }
        to.wait(Interest::READ);
        // As the event loops do, it reads only what a wait has reported.
        if !to.ready {
            continue;
        }
        match to.read(&mut buffer) {
            Ok(Transfer::Bytes(count)) => received.extend_from_slice(&buffer[..count]),
            Ok(Transfer::WouldBlock) => {}
            Ok(Transfer::Closed) => return (received, None),
            Err(error) => return (received, Some(error)),
        }
    }
}

fn direct(port: u16) -> u16 {
    port
}

/// Relays one connection, byte by byte: `change` gets what the client sends and its place. Returns the port, and all
/// that the client has sent when the connection is over.
fn relay(port: u16, change: impl Fn(usize, u8) -> Option<u8> + Send + 'static) -> (u16, Receiver<Vec<u8>>) {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a listener");
    let (tell, hear) = channel();
    let own = listener.local_addr().expect("its address").port();
    thread::spawn(move || {
        let (mut client, _) = listener.accept().expect("a client");
        let mut server = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).expect("a server");
        let (mut back_from, mut back_to) = (server.try_clone().expect("it"), client.try_clone().expect("it"));
        let back = thread::spawn(move || std::io::copy(&mut back_from, &mut back_to));
        let mut seen = Vec::new();
        let mut byte = [0];
        // A receiver may wait for the rest of a record whose length was changed. Where nothing more comes, it is cut.
        while client.read(&mut byte).is_ok_and(|count| count == 1) {
            let changed = change(seen.len(), byte[0]);
            if changed != Some(byte[0]) {
                let _ = client.set_read_timeout(Some(QUIET));
            }
            seen.push(byte[0]);
            let Some(changed) = changed else { break };
            if server.write_all(&[changed]).is_err() {
                break;
            }
        }
        let _ = (server.shutdown(Shutdown::Write), client.set_read_timeout(None));
        let _ = back.join();
        let _ = tell.send(seen);
    });
    (own, hear)
}

#[test]
fn both_ends_prove_who_they_are_and_nobody_between_reads_what_they_say() {
    let (rti, federate) = (identity(), identity());
    let mut heard = None;
    let (mut client, mut server) =
        connection(Some(federate.knows(Some(&rti), &[])), Some(rti.knows(None, &[(7, &federate)])), |port| {
            let (port, hear) = relay(port, |_, byte| Some(byte));
            heard = Some(hear);
            port
        });
    assert_eq!(outcome(&mut client, &mut server), Ok(()));
    let secret = b"a federation id, a tag and a value".repeat(100);
    let (received, error) = send(&mut client, &mut server, &secret, 7);
    assert_eq!((received == secret, error), (true, None));
    for participant in [Participant::Rti, Participant::Federate(7), Participant::Federate(8)] {
        assert_eq!(client.may_be(participant), participant == Participant::Rti);
        assert_eq!(server.may_be(participant), participant == Participant::Federate(7));
    }
    drop((client, server));
    let seen = heard.expect("there is a relay").recv().expect("the connection is over");
    assert!(seen.len() > secret.len() && !seen.windows(8).any(|part| secret.windows(8).any(|other| part == other)));
}

/// More than the system's buffers hold goes through in order, in both directions, however little is read at a time.
#[test]
fn writing_stops_when_the_other_end_does_not_read() {
    let (rti, federate) = (identity(), identity());
    let (mut client, mut server) =
        connection(Some(federate.knows(Some(&rti), &[])), Some(rti.knows(None, &[(0, &federate)])), direct);
    assert_eq!(outcome(&mut client, &mut server), Ok(()));
    let bytes: Vec<u8> = (0..6_000_000_u32).map(|index| (index % 251) as u8).collect();
    assert!(send(&mut client, &mut server, &bytes, 50_000).0 == bytes);
    assert!(send(&mut server, &mut client, &bytes[..300_000], 1000).0 == bytes[..300_000]);
}

/// An end that has closed a connection still takes what the other one writes to close it. A reset would be the answer
/// of a socket that is gone.
#[test]
fn an_end_that_writes_after_the_other_one_has_closed_finds_the_connection() {
    let (mut client, mut server) = connection(Some(identity().accepts_all()), Some(identity().accepts_all()), direct);
    assert_eq!(outcome(&mut client, &mut server), Ok(()));
    client.sockets.close(client.id);
    let wait = Some(Duration::from_secs(10));
    while server.read(&mut [0; 9]) == Ok(Transfer::WouldBlock) {
        server.sockets.set_interest(server.id, Interest::READ);
        server.sockets.wait(wait, &mut |_, _| {});
    }
    for _ in 0..3 {
        assert_eq!(server.sockets.write(server.id, b"late"), Ok(Transfer::Bytes(4)));
        client.sockets.wait(wait, &mut |_, _| panic!("the event loop has closed it"));
        assert_eq!(server.sockets.connected(server.id), Ok(()));
    }
    server.sockets.close(server.id);
    // Once both ends have closed it, no wait ends for it any more.
    assert!((0..100).any(|_| !client.sockets.wait(Some(Duration::ZERO), &mut |_, _| {}).came));
}

/// Neither end uses a connection with a participant that it does not know.
#[test]
fn strangers_are_refused_at_both_ends() {
    let (rti, federate, stranger) = (identity(), identity(), identity());
    // The RTI does not know the federate: that end hears of it when it reads.
    let (mut client, mut server) =
        connection(Some(stranger.knows(Some(&rti), &[])), Some(rti.knows(None, &[(0, &federate)])), direct);
    if outcome(&mut client, &mut server).is_ok() {
        assert!(send(&mut client, &mut server, b"hello", 9).0.is_empty());
        assert_eq!(send(&mut server, &mut client, b"hello", 9), (Vec::new(), Some(NetError::Insecure)));
    }
    assert!(!server.may_be(Participant::Federate(0)));
    // The federate does not know the RTI.
    let (mut client, mut server) =
        connection(Some(federate.knows(Some(&stranger), &[])), Some(rti.knows(None, &[(0, &federate)])), direct);
    assert_eq!(outcome(&mut client, &mut server), Err(NetError::Insecure));
    assert!(server.read(&mut [0; 9]).is_err());
    // Programs of LF's own compiler show no certificate, and one that does without TLS has none.
    for client in [None, Some(stranger.accepts_all())] {
        let (mut client, mut server) = connection(client, Some(rti.knows(None, &[(0, &federate)])), direct);
        let _ = outcome(&mut client, &mut server);
        assert!(send(&mut client, &mut server, &[1; 500], 9).0.is_empty());
        assert!(!server.may_be(Participant::Federate(0)));
    }
    // A server without TLS.
    let (mut client, mut server) = connection(Some(federate.knows(Some(&rti), &[])), None, direct);
    server.sockets.write(server.id, &[0, 1, 2, 3, 4, 5, 6, 7]).expect("there is room");
    assert_eq!(outcome(&mut client, &mut server), Err(NetError::Insecure));
}

/// A federate with a key of its own cannot take the RTI's place, nor that of another federate.
#[test]
fn a_known_participant_in_the_place_of_another_is_refused() {
    let (rti, one, other) = (identity(), identity(), identity());
    let knows = one.knows(Some(&rti), &[(1, &other)]);
    for (expected, is_right) in [(Participant::Federate(1), true), (Participant::Rti, false)] {
        let (mut client, mut server) =
            connection(Some(knows.clone()), Some(other.knows(Some(&rti), &[(0, &one)])), direct);
        client.sockets.require(client.id, expected);
        assert_eq!(outcome(&mut client, &mut server).is_ok(), is_right);
        assert_eq!(client.sockets.failure(client.id).is_none(), is_right);
        assert_eq!(client.may_be(expected), is_right);
    }
}

#[test]
fn without_verification_anybody_is_accepted() {
    let (rti, federate) = (identity(), identity());
    let (mut client, mut server) = connection(Some(federate.accepts_all()), Some(rti.accepts_all()), direct);
    assert_eq!(outcome(&mut client, &mut server), Ok(()));
    assert_eq!(send(&mut client, &mut server, b"hello", 9), (b"hello".to_vec(), None));
    assert!(client.may_be(Participant::Rti) && server.may_be(Participant::Federate(0)));
}

/// Whichever byte of the client's is changed, no changed byte arrives; and a connection that is cut has an error.
#[test]
fn a_changed_byte_or_a_cut_is_noticed() {
    let (rti, federate) = (identity(), identity());
    let text = b"what the federation says";
    let run = |change: fn(usize, usize, u8) -> Option<u8>, at: usize| {
        let mut heard = None;
        let (mut client, mut server) =
            connection(Some(federate.knows(Some(&rti), &[])), Some(rti.knows(None, &[(0, &federate)])), |port| {
                let (port, hear) = relay(port, move |place, byte| change(at, place, byte));
                heard = Some(hear);
                port
            });
        let made = outcome(&mut client, &mut server);
        let (received, error) = match made {
            Ok(()) => send(&mut client, &mut server, text, 100),
            Err(error) => (Vec::new(), Some(error)),
        };
        drop((client, server));
        (received, error, heard.expect("there is a relay").recv().expect("the connection is over").len())
    };
    let (received, error, length) = run(|_, _, byte| Some(byte), 0);
    assert_eq!((&received[..], error), (&text[..], None));
    for at in (0..length).step_by(29) {
        let flipped = run(|at, place, byte| Some(if at == place { byte ^ 1 } else { byte }), at);
        assert!(text.starts_with(&flipped.0), "byte {at}");
        assert!(flipped.1.is_some() || flipped.0 == text, "byte {at}: {:?}", flipped.1);
        let cut = run(|at, place, byte| (place < at).then_some(byte), at);
        assert!(text.starts_with(&cut.0) && cut.1.is_some(), "cut at byte {at}: {:?}", cut.1);
    }
}

#[test]
fn certificates_and_keys_that_do_not_belong_together_are_refused() {
    let (one, other) = (identity(), identity());
    assert_eq!(is_pair(one.key.as_bytes(), &one.certificate), Some(true));
    assert_eq!(is_pair(one.key.as_bytes(), &other.certificate), Some(false));
    assert_eq!(is_pair(b"no key", &other.certificate), None);
    assert_eq!(is_pair(one.key.as_bytes(), &other.certificate[..40]), None);
    let others = Others { rti: None, federates: BTreeMap::new() };
    let keys = TlsKeys { own: one.key.into_bytes(), certificate: other.certificate, others };
    let error = Tls::verified(keys).expect_err("they do not").to_string();
    assert_eq!(error, "the certificate and the key do not belong together");
}
