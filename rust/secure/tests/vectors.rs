// SPDX-License-Identifier: Apache-2.0
//! The official test vectors: those of cacophony for X25519, ChaCha20-Poly1305 and SHA-256, of all interactive patterns
//! with and without a shared secret. `tests/vectors/cacophony.json` has them unchanged, as `snow` distributes them.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

use lf_secure::{FederationSecret, Handshake, HandshakeKeys, Pattern, PublicKey, Role, Session, StaticSecret, Token};
use serde::Deserialize;

#[derive(Deserialize)]
struct Vector {
    protocol_name: String,
    init_prologue: String,
    init_ephemeral: String,
    init_static: Option<String>,
    init_remote_static: Option<String>,
    #[serde(default)]
    init_psks: Vec<String>,
    resp_prologue: String,
    resp_ephemeral: String,
    resp_static: Option<String>,
    resp_remote_static: Option<String>,
    #[serde(default)]
    resp_psks: Vec<String>,
    handshake_hash: String,
    messages: Vec<VectorMessage>,
}

#[derive(Deserialize)]
struct VectorMessage {
    payload: String,
    ciphertext: String,
}

/// The patterns of the specification.
const PATTERNS: &[(&str, &[&str])] = &[
    ("NN", &["e", "e ee"]),
    ("NK", &["e es", "e ee"]),
    ("NX", &["e", "e ee s es"]),
    ("XN", &["e", "e ee", "s se"]),
    ("XK", &["e es", "e ee", "s se"]),
    ("XX", &["e", "e ee s es", "s se"]),
    ("KN", &["e", "e ee se"]),
    ("KK", &["e es ss", "e ee se"]),
    ("KX", &["e", "e ee se s es"]),
    ("IN", &["e s", "e ee se"]),
    ("IK", &["e es s ss", "e ee se"]),
    ("IX", &["e s", "e ee se s es"]),
];

#[test]
fn every_official_vector_comes_out_byte_by_byte() {
    let vectors: Vec<Vector> = serde_json::from_str(include_str!("vectors/cacophony.json")).unwrap();
    assert_eq!(vectors.len(), 30);
    for vector in &vectors {
        check(vector);
    }
}

fn check(vector: &Vector) {
    let name = &vector.protocol_name;
    let pattern = pattern(name);
    let mut initiator = End::new(
        (pattern, Role::Initiator, &vector.init_prologue, &vector.init_ephemeral),
        (&vector.init_static, &vector.init_remote_static, &vector.init_psks),
    );
    let mut responder = End::new(
        (pattern, Role::Responder, &vector.resp_prologue, &vector.resp_ephemeral),
        (&vector.resp_static, &vector.resp_remote_static, &vector.resp_psks),
    );
    let mut sessions: Option<[Session; 2]> = None;
    for (number, VectorMessage { payload, ciphertext }) in vector.messages.iter().enumerate() {
        let (payload, expected) = (bytes(payload), bytes(ciphertext));
        let ends = if number % 2 == 0 { [0, 1] } else { [1, 0] };
        if let Some(sessions) = &mut sessions {
            let mut message = payload.clone();
            let tag = sessions[ends[0]].seal(&mut message);
            assert_eq!([&message[..], &tag].concat(), expected, "{name}: message {number}");
            sessions[ends[1]].open(&mut message, &tag).unwrap();
            assert_eq!(message, payload, "{name}: message {number}");
            continue;
        }
        let mut message = [0; 1024];
        let (writer, reader) =
            if number % 2 == 0 { (&mut initiator, &mut responder) } else { (&mut responder, &mut initiator) };
        let count = writer.handshake.write(writer.keys.credentials(), &payload, &mut message).unwrap();
        assert_eq!(message[..count], expected, "{name}: message {number}");
        let read = reader.handshake.read(reader.keys.credentials(), &mut message[..count]).unwrap();
        assert_eq!(*read, payload, "{name}: message {number}");
        if writer.handshake.is_complete() {
            assert_eq!(*writer.handshake.hash(), *bytes(&vector.handshake_hash), "{name}");
            assert_eq!(writer.handshake.hash(), reader.handshake.hash(), "{name}");
            sessions = Some([&initiator, &responder].map(|end| end.handshake.session().unwrap()));
        }
    }
    assert!(sessions.is_some(), "{name}");
}

struct Keys {
    secret: StaticSecret,
    public: PublicKey,
    federation: FederationSecret,
}

impl Keys {
    fn credentials(&self) -> HandshakeKeys<'_> {
        HandshakeKeys { secret: &self.secret, public: &self.public, federation: &self.federation }
    }
}

struct End {
    keys: Keys,
    handshake: Handshake,
}

impl End {
    fn new(
        (pattern, role, prologue, ephemeral): (&'static Pattern, Role, &str, &str),
        (secret, remote, psks): (&Option<String>, &Option<String>, &[String]),
    ) -> Self {
        let secret = StaticSecret::new(secret.as_deref().map_or([0; 32], key));
        let federation = FederationSecret::new(psks.first().map_or([0; 32], |psk| key(psk)));
        let keys = Keys { public: secret.public(), secret, federation };
        let remote = remote.as_deref().map(|remote| PublicKey::new(key(remote)));
        let ephemeral = StaticSecret::new(key(ephemeral));
        let handshake = Handshake::new(pattern, role, &bytes(prologue), keys.credentials(), ephemeral, remote);
        Self { keys, handshake }
    }
}

/// Returns the pattern of a protocol's name, which lasts as long as the test.
fn pattern(protocol: &str) -> &'static Pattern {
    let name = protocol.split('_').nth(1).unwrap();
    let (base, modifier) = name.split_at(2);
    let (_, messages) = PATTERNS.iter().find(|(name, _)| *name == base).unwrap();
    let mut messages: Vec<Vec<Token>> = messages.iter().map(|text| text.split(' ').map(token).collect()).collect();
    match modifier.strip_prefix("psk").map(|place| place.parse::<usize>().unwrap()) {
        Some(0) => messages[0].insert(0, Token::Psk),
        Some(place) => messages[place - 1].push(Token::Psk),
        None => {}
    }
    let messages = messages.into_iter().map(|tokens| &*tokens.leak()).collect::<Vec<_>>();
    let [initiator, responder] = base.as_bytes() else { unreachable!("a name has two letters") };
    Box::leak(Box::new(Pattern {
        protocol: protocol.to_owned().leak(),
        knows_initiator: *initiator == b'K',
        knows_responder: *responder == b'K',
        messages: messages.leak(),
    }))
}

fn token(text: &str) -> Token {
    match text {
        "e" => Token::E,
        "s" => Token::S,
        "ee" => Token::Ee,
        "es" => Token::Es,
        "se" => Token::Se,
        "ss" => Token::Ss,
        other => unreachable!("no token: {other}"),
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|place| u8::from_str_radix(&hex[place..place + 2], 16).unwrap()).collect()
}

fn key(hex: &str) -> [u8; 32] {
    bytes(hex).try_into().unwrap()
}
