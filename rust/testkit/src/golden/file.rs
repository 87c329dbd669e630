// SPDX-License-Identifier: Apache-2.0
//! Loads recordings from files.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer};

use super::error::GoldenError;
use super::mask::Mask;
use super::recording::{Coordination, FederateSetup, Fill, Frame, Recording, RelativeTag, Role, RtiSetup, Step};

/// Returns the folder of the recordings in this repository.
pub fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden")
}

/// The folders of recordings, and what their names begin with: of LF 0.12 and 0.13.
const FOLDERS: [&str; 2] = ["", "0.13/"];

/// Loads one recording of this repository by its name, for example `01-handshake`, or `0.13/06-joins-late`.
///
/// # Errors
/// [`GoldenError`] if there is none, or if it is not in the format that the README beside it describes.
pub fn load(name: &str) -> Result<Recording, GoldenError> {
    let path = directory().join(format!("{name}.json"));
    let text = fs::read_to_string(&path).map_err(|error| GoldenError::new(&path.to_string_lossy(), error))?;
    let recording = parse(&text).map_err(|reason| GoldenError::new(name, reason))?;
    if name.rsplit('/').next() != Some(&recording.name) {
        return Err(GoldenError::new(name, format!("calls itself `{}`", recording.name)));
    }
    Ok(Recording { name: name.to_owned(), ..recording })
}

/// Loads all recordings of this repository, in the order of their names.
///
/// # Errors
/// [`GoldenError`] if the folder cannot be read, or as [`load`].
pub fn load_all() -> Result<Vec<Recording>, GoldenError> {
    let mut names = Vec::new();
    for folder in FOLDERS {
        let directory = directory().join(folder);
        let failed = |error: std::io::Error| GoldenError::new(&directory.to_string_lossy(), error);
        for entry in fs::read_dir(&directory).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            if path.extension().is_some_and(|extension| extension == "json") {
                names.extend(path.file_stem().map(|stem| format!("{folder}{}", stem.to_string_lossy())));
            }
        }
    }
    names.sort();
    names.iter().map(|name| load(name)).collect()
}

/// Reads a recording.
///
/// # Errors
/// Returns a sentence that names the defect and its step.
pub fn parse(text: &str) -> Result<Recording, String> {
    let RawRecording {
        name,
        description,
        quirk,
        source,
        role,
        rti,
        rti_exit_code,
        federate,
        federate_exit_code,
        steps,
    } = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let role = match (role, rti, rti_exit_code, federate, federate_exit_code) {
        (RawRole::Rti, Some(rti), Some(exit_code), None, None) => Role::Rti(rti.with_exit_code(exit_code)),
        (RawRole::Federate, None, None, Some(federate), Some(exit_code)) => {
            Role::Federate(federate.with_exit_code(exit_code))
        }
        (RawRole::Rti, ..) => {
            return Err("role `rti` needs `rti` and `rti_exit_code`, and nothing of a federate".into());
        }
        (RawRole::Federate, ..) => {
            return Err("role `federate` needs `federate` and `federate_exit_code`, and nothing of an RTI".into());
        }
    };
    let step = |(index, raw): (usize, RawStep)| raw.check().map_err(|reason| format!("step {index}: {reason}"));
    let steps = steps.into_iter().enumerate().map(step).collect::<Result<_, _>>()?;
    Ok(Recording { name, description, quirk, source, role, steps })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRecording {
    name: String,
    description: String,
    quirk: Option<String>,
    source: String,
    role: RawRole,
    rti: Option<RawRti>,
    #[serde(default, deserialize_with = "present")]
    rti_exit_code: Option<ExitCode>,
    federate: Option<RawFederate>,
    #[serde(default, deserialize_with = "present")]
    federate_exit_code: Option<ExitCode>,
    steps: Vec<RawStep>,
}

/// A number or `null`.
struct ExitCode(Option<i32>);

/// Distinguishes a `null` from a missing key.
fn present<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<ExitCode>, D::Error> {
    Option::deserialize(deserializer).map(|code| Some(ExitCode(code)))
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawRole {
    Rti,
    Federate,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRti {
    federates: u16,
    /// The count of transient federates, in recordings of an RTI that supports them.
    #[serde(default)]
    transient_federates: u16,
    federation_id: String,
    options: Vec<String>,
    auth: bool,
}

impl RawRti {
    fn with_exit_code(self, ExitCode(exit_code): ExitCode) -> RtiSetup {
        let Self { federates, transient_federates, federation_id, options, auth } = self;
        RtiSetup { federates, transient_federates, federation_id, options, auth, exit_code }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFederate {
    id: u16,
    federation_id: String,
    coordination: Coordination,
    upstream: Vec<u16>,
    downstream: Vec<u16>,
    arguments: Vec<String>,
    auth: bool,
    program: String,
}

impl RawFederate {
    fn with_exit_code(self, ExitCode(exit_code): ExitCode) -> FederateSetup {
        let Self { id, federation_id, coordination, upstream, downstream, arguments, auth, program } = self;
        FederateSetup { id, federation_id, coordination, upstream, downstream, arguments, auth, program, exit_code }
    }
}

/// A step as it is written: the key of its action, and all other keys.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RawStep {
    connect: Option<u16>,
    p2p_connect: Option<u16>,
    send: Option<u16>,
    recv: Option<u16>,
    close: Option<u16>,
    closed_by_rti: Option<u16>,
    closed_by_federate: Option<u16>,
    silence: Option<Vec<u16>>,
    until: Option<i64>,
    udp_bind: Option<u16>,
    udp_send: Option<u16>,
    udp_recv: Option<u16>,
    hex: Option<String>,
    fill: Option<RawFill>,
    tag: Option<(i64, u32)>,
    time: Option<i64>,
    from_port: Option<u16>,
    msg: Option<String>,
    note: Option<String>,
}

impl RawStep {
    fn check(mut self) -> Result<Step, String> {
        let mut found = Vec::new();
        let mut number = |taken: Option<u16>, step: fn(u16) -> Step| found.extend(taken.map(step));
        number(self.connect.take(), Step::Connect);
        number(self.p2p_connect.take(), Step::P2pConnect);
        number(self.close.take(), Step::Close);
        number(self.closed_by_rti.take(), Step::ClosedByPeer);
        number(self.closed_by_federate.take(), Step::ClosedByPeer);
        number(self.udp_bind.take(), Step::UdpBind);
        found.extend(self.silence.take().map(Step::Silence));
        found.extend(self.until.take().map(Step::Until));
        if let Some(connection) = self.send.take() {
            found.push(Step::Send(self.frame(connection, true)?));
        }
        if let Some(connection) = self.recv.take() {
            found.push(Step::Recv(self.frame(connection, false)?));
        }
        if let Some(connection) = self.udp_send.take() {
            found.push(Step::UdpSend(self.frame(connection, true)?));
        }
        if let Some(connection) = self.udp_recv.take() {
            let (frame, from_port) = (self.frame(connection, false)?, self.from_port.take());
            found.push(Step::UdpRecv { frame, from_port });
        }
        // A frame has taken its keys; any key that is left is unknown.
        let left = [
            ("hex", self.hex.is_some()),
            ("fill", self.fill.is_some()),
            ("tag", self.tag.is_some()),
            ("time", self.time.is_some()),
            ("from_port", self.from_port.is_some()),
            ("msg", self.msg.is_some()),
        ];
        if let Some((key, _)) = left.into_iter().find(|(_, is_left)| *is_left) {
            return Err(format!("`{key}` does not belong here"));
        }
        match <[Step; 1]>::try_from(found) {
            Ok([step]) => Ok(step),
            Err(found) => Err(format!("has {} actions instead of one", found.len())),
        }
    }

    fn frame(&mut self, connection: u16, sent: bool) -> Result<Frame, String> {
        let text = self.hex.take().ok_or("`hex` is missing")?;
        let bytes: Mask = text.parse().map_err(|error| format!("`hex`: {error}"))?;
        let message = self.msg.take().ok_or("`msg` is missing")?;
        let tag = self.tag.take().or(self.time.take().map(|time_ns| (time_ns, 0)));
        let tag = tag.map(|(time_ns, microstep)| RelativeTag { time_ns, microstep });
        // The start time stands before an effective start.
        let masked: &[usize] = if sent { &[8] } else { &[8, 16] };
        if tag.is_some() && !masked.contains(&bytes.masked_len()) {
            return Err("`tag` stands for the 8 bytes of a time, but another number of bytes is masked".into());
        }
        let written = self.fill.take().map(Fill::from);
        let fill = match (sent, written, tag) {
            (false, Some(_), _) => return Err("`fill` does not belong to what is received".into()),
            (false, None, _) => None,
            (true, Some(_), Some(_)) => return Err("`fill` and `tag` exclude each other".into()),
            (true, written, tag) => written.or(tag.map(|_| Fill::TagTime)),
        };
        let filled = fill.as_ref().map_or(0, Fill::bytes);
        if sent && filled != bytes.masked_len() {
            return Err(format!("{} bytes are masked, but it is said how to fill {filled}", bytes.masked_len()));
        }
        Ok(Frame { connection, bytes, fill, tag, message, note: self.note.take() })
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum RawFill {
    Word(FillWord),
    Hmac(HmacFill),
}

#[derive(Deserialize)]
enum FillWord {
    #[serde(rename = "udp_port")]
    UdpPort,
    #[serde(rename = "p2p_port")]
    P2pPort,
    #[serde(rename = "physical time")]
    PhysicalTime,
    #[serde(rename = "start")]
    Start,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HmacFill {
    hmac_key: String,
}

impl From<RawFill> for Fill {
    fn from(raw: RawFill) -> Self {
        match raw {
            RawFill::Word(FillWord::UdpPort) => Self::UdpPort,
            RawFill::Word(FillWord::P2pPort) => Self::P2pPort,
            RawFill::Word(FillWord::PhysicalTime) => Self::PhysicalTime,
            RawFill::Word(FillWord::Start) => Self::Start,
            RawFill::Hmac(HmacFill { hmac_key: key }) => Self::Hmac { key },
        }
    }
}
