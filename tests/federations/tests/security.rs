// SPDX-License-Identifier: Apache-2.0
//! Encrypted federations of real processes, with keys of `lfz keys`: by Noise, and by TLS.

use std::fs;
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{Receiver, channel};
use std::thread;

use lf_federations::{Finished, Lfz, Run, TIME_LIMIT, programs};
use rustix::process::Signal;

/// The last words of the program: messages have come through the RTI, and directly.
const RESULT: &str = "the sum is 666, and directly came true";

/// A program whose connections are encrypted, with its keys.
pub(crate) struct Encrypted {
    pub(crate) folder: tempfile::TempDir,
    name: String,
    /// The generated files.
    pub(crate) out: PathBuf,
}

impl Encrypted {
    fn with(test: &str, property: &str) -> Self {
        Self::of(test, "Encrypted.lf", property)
    }

    /// Returns this program with this property instead of `security: noise`, in a folder of its own.
    pub(crate) fn of(test: &str, program: &str, property: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let source = fs::read_to_string(programs().join(program)).expect("it is there");
        fs::write(folder.path().join(program), source.replace("security: noise", property)).expect("it can be");
        Self { folder, name: program.to_owned(), out: Lfz::path().with_file_name("federations").join(test) }
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join(&self.name)
    }

    /// Runs `lfz` with these words, the program and its folder of generated files.
    pub(crate) fn lfz(&self, words: &[&str], rest: &[&str]) -> Finished {
        let mut command = Lfz::command(words.iter().copied());
        command.arg(self.file()).args(rest);
        Run::start(command).succeed()
    }

    pub(crate) fn build(&self) {
        self.lfz(&["build", "--out", self.out.to_str().expect("it is a text")], &[]);
    }

    /// Starts an RTI with these options.
    fn rti(options: &[&str]) -> (Run, u16) {
        Lfz::rti(&[&["-n", "2", "-i", "a federation id", "-c", "on"], options].concat())
    }

    fn keys_of(&self, name: &str) -> String {
        self.out.join("keys").join(name).to_str().expect("it is a text").to_owned()
    }

    /// Returns the executable of a federate.
    pub(crate) fn program(&self, federate: &str) -> PathBuf {
        let mut command = Lfz::command(["build", "--json", "--out"]);
        let output = command.arg(&self.out).arg(self.file()).output().expect("lfz can be started");
        let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("lfz prints JSON");
        let all = value["participants"].as_array().expect("it has participants").clone();
        let one = all.iter().find(|one| one["name"] == federate).expect("it is there");
        one["program"].as_str().expect("it is a text").into()
    }

    /// Starts a federate with these options.
    fn federate(program: &Path, port: u16, options: &[&str]) -> Run {
        let mut command = Command::new(program);
        command.args(["--rti", &format!("127.0.0.1:{port}"), "--id", "a federation id"]).args(options);
        Run::start(command)
    }
}

/// Relays the connections to a port; returns its own port, and what each has carried when all are over.
fn relay(port: u16) -> (u16, Receiver<Vec<u8>>) {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a listener");
    let own = listener.local_addr().expect("its address").port();
    let (tell, hear) = channel();
    thread::spawn(move || {
        for client in listener.incoming().flatten() {
            let Ok(server) = TcpStream::connect((Ipv4Addr::LOCALHOST, port)) else { continue };
            for (mut from, mut to) in [
                (client.try_clone().expect("it"), server.try_clone().expect("it")),
                (server.try_clone().expect("it"), client.try_clone().expect("it")),
            ] {
                let tell = tell.clone();
                thread::spawn(move || {
                    let (mut all, mut buffer) = (Vec::new(), [0; 4096]);
                    while let Ok(count @ 1..) = from.read(&mut buffer) {
                        all.extend_from_slice(&buffer[..count]);
                        if to.write_all(&buffer[..count]).is_err() {
                            break;
                        }
                    }
                    let _ = to.shutdown(Shutdown::Write);
                    let _ = tell.send(all);
                });
            }
        }
    });
    (own, hear)
}

/// Runs the whole life of a federation with keys: nobody reads it, and nobody without a key takes part.
fn check(test: &str, property: &str, public: &str) {
    let encrypted = Encrypted::with(test, property);

    // Without keys, `lfz run` makes some for the run.
    let out = encrypted.out.to_str().expect("it is a text").to_owned();
    let run = encrypted.lfz(&["run", TIME_LIMIT, "--out", &out], &[]);
    assert!(run.of("sink").any(|line| line == RESULT), "{run}");
    run.line(&["encrypted with keys for this run"]);

    // With lasting ones all participants can be started by hand.
    encrypted.lfz(&["keys", "new"], &[]);
    encrypted.build();
    let (source, sink) = (encrypted.program("source"), encrypted.program("sink"));
    let (rti, port) = Encrypted::rti(&["--keys", &encrypted.keys_of("rti")]);
    let (through, heard) = relay(port);
    let federates = [(&source, "source"), (&sink, "sink")]
        .map(|(program, name)| Encrypted::federate(program, through, &["--keys", &encrypted.keys_of(name)]));
    let [_, sink_said] = federates.map(Run::succeed);
    sink_said.line(&[RESULT]);
    rti.succeed();
    for bytes in heard.iter().take(4) {
        assert!(bytes.len() > 100 && !bytes.windows(15).any(|part| part == b"a federation id"));
    }

    // Without keys a federate does not begin, and one of another federation is refused by both ends.
    let missing = Encrypted::federate(&source, port, &[]).finish();
    assert_eq!(missing.code(), 1, "{missing}");
    missing.line(&["error:", "encrypts its connections, and has no keys"]);
    let (mut rti, port) = Encrypted::rti(&["--keys", &encrypted.keys_of("rti")]);
    let stranger = Encrypted::with(test, property);
    stranger.lfz(&["keys", "new"], &[]);
    let folder = stranger.folder.path().join("keys of strangers");
    let folder = folder.to_str().expect("it is a text");
    stranger.lfz(&["build", "--out", folder], &[]);
    let mut other = Encrypted::federate(&source, port, &["--keys", &format!("{folder}/keys/source")]);
    other.wait_for("is not secure");
    rti.wait_for("is not secure");
    other.signal(Signal::TERM);
    other.finish();

    // A program that does not encrypt is refused, too.
    let mut plain = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).expect("the RTI listens");
    plain.write_all(&[1, 0, 0, 15]).expect("there is room");
    plain.write_all(b"a federation id").expect("there is room");
    let mut answer = Vec::new();
    let _ = plain.read_to_end(&mut answer);
    assert!(!answer.contains(&255), "it is not acknowledged: {answer:?}");
    rti.signal(Signal::TERM);
    rti.finish();

    // A lost board is shut out, and the others stay as they are.
    let kept = fs::read(encrypted.out.join("keys/sink/own.key")).expect("it is there");
    let stolen = encrypted.folder.path().join("stolen");
    fs::create_dir(&stolen).expect("it can be made");
    for file in fs::read_dir(encrypted.keys_of("source")).expect("it is there").flatten() {
        fs::copy(file.path(), stolen.join(file.file_name())).expect("it can be copied");
    }
    encrypted.lfz(&["keys", "distrust"], &["source"]);
    encrypted.lfz(&["keys", "new"], &["source"]);
    encrypted.build();
    assert_eq!(fs::read(encrypted.out.join("keys/sink/own.key")).expect("it is there"), kept);
    assert!(encrypted.out.join("keys/rti").join(public).is_file());
    let (mut rti, port) = Encrypted::rti(&["--keys", &encrypted.keys_of("rti")]);
    let mut thief = Encrypted::federate(&source, port, &["--keys", stolen.to_str().expect("it is a text")]);
    thief.wait_for("is not secure");
    rti.wait_for("is not secure");
    thief.signal(Signal::TERM);
    thief.finish();
    rti.signal(Signal::TERM);
    rti.finish();
}

#[test]
fn a_federation_is_encrypted_by_noise() {
    check("encrypted_by_noise", "security: noise", "0.pub");
}

#[test]
fn a_federation_is_encrypted_by_tls() {
    check("encrypted_by_tls", "comm-type: TLS", "0.crt");
}

/// As with LF's own programs: all is encrypted, and nobody proves who it is.
#[test]
fn tls_without_verification_needs_a_word_and_has_a_warning() {
    let encrypted = Encrypted::with("unverified_by_tls", "comm-type: TLS, security: unverified");
    let out = encrypted.out.to_str().expect("it is a text").to_owned();
    let run = encrypted.lfz(&["run", TIME_LIMIT, "--out", &out], &[]);
    assert!(run.of("sink").any(|line| line == RESULT), "{run}");
    run.line(&["warning: --unverified: connections are encrypted, but anybody can make one"]);
}
