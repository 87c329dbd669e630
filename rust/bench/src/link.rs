// SPDX-License-Identifier: Apache-2.0
//! The connection of a raw federate with the RTI, plain or encrypted, and the keys of the participants.

use std::fmt;
use std::fs::{self, OpenOptions};
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::{Duration, Instant};

use lf_linux::keys::{FEDERATION_SECRET, OWN_SECRET, PUBLIC, federation_text, public_text, secret_text};
use lf_secure::{Channel, ChannelStage, FederationSecret, Keyring, Participant, Role, StaticSecret};

use crate::Result;

/// The secret of the federation, and of the RTI. Nothing secret goes over these connections.
const FEDERATION_KEY: [u8; 32] = [0x5A; 32];
const RTI_KEY: [u8; 32] = [0xA5; 32];
/// The length of a channel's buffers: that of our programs on Linux, for one record.
const BUFFER_BYTES: usize = (1 << 14) + lf_secure::RECORD_OVERHEAD;
/// The time in which a connection is tried while the RTI starts.
const CONNECT_TIME_OUT: Duration = Duration::from_secs(10);
/// The time within which an RTI has to answer.
const ANSWER_TIME_OUT: Duration = Duration::from_secs(10);

/// The way to an RTI.
#[derive(Clone, Copy, Debug)]
pub struct Access {
    /// Its TCP port on this computer.
    pub port: u16,
    /// Whether it has the keys of [`write_keys`].
    pub is_encrypted: bool,
}

/// Returns the secret key of a federate.
fn secret_of(federate: u16) -> StaticSecret {
    let [high, low] = federate.to_be_bytes();
    let mut bytes = [1; 32];
    (bytes[0], bytes[1]) = (high, low);
    StaticSecret::new(bytes)
}

/// Writes the keys of an RTI for this number of federates into a folder that only this user can read.
///
/// # Errors
/// When the files cannot be written.
pub fn write_keys(folder: &Path, federates: u16) -> Result<()> {
    let secret = |name: &str, text: String| -> Result<()> {
        let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(folder.join(name))?;
        Ok(file.write_all(text.as_bytes())?)
    };
    secret(OWN_SECRET, secret_text(&RTI_KEY))?;
    secret(FEDERATION_SECRET, federation_text(&FEDERATION_KEY))?;
    for federate in 0..federates {
        fs::write(folder.join(format!("{federate}.{PUBLIC}")), public_text(secret_of(federate).public().bytes()))?;
    }
    Ok(())
}

/// A connection with an RTI.
pub(crate) struct Link {
    stream: TcpStream,
    encryption: Option<Box<Encryption>>,
}

struct Encryption {
    channel: Channel<Vec<u8>>,
    keyring: Keyring<'static>,
}

impl fmt::Debug for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Link").field("stream", &self.stream).finish_non_exhaustive()
    }
}

impl Link {
    /// Connects as this federate, and makes the connection an encrypted one where the RTI demands it.
    pub(crate) fn new(rti: Access, federate: u16) -> Result<Self> {
        let stream = connect(rti.port)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(ANSWER_TIME_OUT))?;
        let mut link = Self { stream, encryption: None };
        if rti.is_encrypted {
            link.encrypt(federate)?;
        }
        Ok(link)
    }

    fn encrypt(&mut self, federate: u16) -> Result<()> {
        let (rti, federation) = (StaticSecret::new(RTI_KEY).public(), FederationSecret::new(FEDERATION_KEY));
        let keyring = Keyring::new(secret_of(federate), federation, rti, &[]);
        let mut ephemeral = [0; 32];
        fs::File::open("/dev/urandom")?.read_exact(&mut ephemeral)?;
        let mut channel = Channel::new(vec![0; BUFFER_BYTES], vec![0; BUFFER_BYTES]);
        channel.begin(Role::Initiator, &keyring, ephemeral, 0, 0);
        channel.expect(Participant::Rti);
        while channel.stage() == ChannelStage::Handshake {
            self.stream.write_all(channel.pending())?;
            channel.sent(channel.pending().len());
            let count = self.stream.read(channel.space())?;
            if count == 0 {
                return Err("the RTI ends the handshake".into());
            }
            channel.filled(count, &keyring)?;
        }
        // The last message of the handshake goes out with what is written first, as from our programs.
        self.encryption = Some(Box::new(Encryption { channel, keyring }));
        Ok(())
    }

    pub(crate) fn stream(&self) -> &TcpStream {
        &self.stream
    }
}

impl Read for Link {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let Self { stream, encryption } = self;
        let Some(encryption) = encryption else { return stream.read(buffer) };
        let Encryption { channel, keyring } = &mut **encryption;
        loop {
            let count = channel.take(buffer).map_err(io::Error::other)?;
            if count > 0 {
                return Ok(count);
            }
            match stream.read(channel.space())? {
                0 => return Ok(0),
                count => channel.filled(count, keyring).map_err(io::Error::other)?,
            }
        }
    }
}

impl Write for Link {
    /// Writes as `SecurePlatform` does: bytes count once their record has gone.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Self { stream, encryption } = self;
        let Some(encryption) = encryption else { return stream.write(bytes) };
        let channel = &mut encryption.channel;
        loop {
            while !channel.pending().is_empty() {
                let count = stream.write(channel.pending())?;
                channel.sent(count);
            }
            match channel.take_sent() {
                0 if channel.seal(bytes) => {}
                count => return Ok(count),
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Connects as soon as the RTI listens.
pub(crate) fn connect(port: u16) -> Result<TcpStream> {
    let until = Instant::now() + CONNECT_TIME_OUT;
    loop {
        match TcpStream::connect((Ipv4Addr::LOCALHOST, port)) {
            Ok(stream) => return Ok(stream),
            Err(error) if Instant::now() > until => return Err(format!("no RTI listens: {error}").into()),
            Err(_) => std::thread::sleep(Duration::from_millis(2)),
        }
    }
}
