// SPDX-License-Identifier: Apache-2.0
//! The description of a run: the processes of a federation, and the arguments of each.
//!
//! `lfz run` makes one for a program that it has built; `lfz supervise` reads it as JSON, in the form of these types,
//! from other programs. Times are in nanoseconds.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use lf_linux::RTI_VARIABLE;
use serde::{Deserialize, Deserializer};

use crate::commands::listening_port;
use crate::compile::Console;
use crate::control::Control;
use crate::descendants::Descendants;
use crate::failure::Failure;
use crate::pins::PinRecording;
use crate::supervisor::{Ending, Interrupts, Launch, Limits, Output, Role, Streams, Supervisor};
use crate::terminal;

/// The processes of one run. The RTI is the first, and the others start when it listens.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Federation {
    /// The form of the description.
    pub(crate) version: Version,
    /// The name in front of messages about the run itself; without it no line has a name.
    pub(crate) speaker: Option<String>,
    /// The name of the federation.
    pub(crate) id: FederationId,
    /// The id of the user who controls the run, where this process has another one, in a namespace.
    pub(crate) user: Option<u32>,
    /// The time after which all are stopped.
    pub(crate) timeout_ns: Option<u64>,
    /// The time in which the others have to end by themselves after the first failure, and after the federation.
    pub(crate) grace_ns: Option<u64>,
    /// The time from the request to stop until a process is killed.
    pub(crate) terminate_ns: Option<u64>,
    /// The RTI; none if it runs elsewhere, or there is none.
    pub(crate) rti: Option<Process>,
    /// The port of the RTI, if it does not print it itself.
    pub(crate) rti_port: Option<u16>,
    /// All others.
    pub(crate) federates: Vec<Process>,
    /// Those that the user starts.
    #[serde(default)]
    pub(crate) left_out: Vec<Process>,
    /// The recording of their pins, if there is one.
    pub(crate) oscilloscope: Option<PinRecording>,
}

/// The only existing form: 1.
#[derive(Debug, Default, Deserialize)]
#[serde(try_from = "u32")]
pub(crate) struct Version;

impl TryFrom<u32> for Version {
    type Error = String;

    fn try_from(number: u32) -> Result<Self, String> {
        let other = format!("this lfz reads descriptions of version 1, and not {number}; use one of the same version");
        if number == 1 { Ok(Self) } else { Err(other) }
    }
}

/// The name of a federation.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum FederationId {
    /// Exactly this name, because other programs know it already.
    Exactly(String),
    /// A unique name with this beginning, so that a federate that outlives its federation cannot join another one.
    BeginsWith(String),
}

/// A process, which runs in a process group of its own.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Process {
    /// The beginning of its lines.
    pub(crate) name: String,
    /// The program and its arguments.
    pub(crate) words: Vec<Argument>,
    /// Variables beside those of this program.
    #[serde(default)]
    pub(crate) environment: BTreeMap<String, String>,
    /// Its working folder, if not this program's.
    pub(crate) folder: Option<PathBuf>,
    /// The folder of the generated crate in an image.
    #[serde(rename = "crate")]
    pub(crate) crate_folder: Option<PathBuf>,
    /// Whether it may come and go while the others run.
    #[serde(default)]
    pub(crate) transient: bool,
    /// Whether it is started again when it has failed; only for one that may come and go.
    #[serde(default)]
    pub(crate) restarts: bool,
    /// The id by which the RTI tells it to leave, for an image, which understands no signal.
    pub(crate) image_id: Option<u16>,
    /// The number of its instances that can run at the same time.
    #[serde(default)]
    pub(crate) instances: Instances,
    /// Its input, and the form of its output.
    #[serde(default)]
    pub(crate) streams: Streams,
    /// The beginning of the line of a simulator's standard output that contains the program's exit status; the
    /// simulator continues after the program in it has ended.
    pub(crate) status_line: Option<String>,
}

/// The number of instances of a participant that can run at the same time.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Instances {
    /// Any number.
    #[default]
    Any,
    /// One, because it has a network interface of its own.
    One,
    /// Two: one at the first place, and one with these words at another one.
    Spare(Vec<Argument>),
}

/// An argument of a command line, or its program.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a word is a text, or { before: TEXT, known: rti_port or federation_id }")]
pub(crate) enum Argument {
    /// A fixed text.
    Text(#[serde(deserialize_with = "os_string")] OsString),
    /// A text that is known only when the process starts.
    Known(LateArgument),
}

/// A text, followed by one that is known only when the process starts.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LateArgument {
    /// The text.
    #[serde(default)]
    before: String,
    known: LateValue,
}

/// A text that is known only when a process starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LateValue {
    /// The port of the RTI.
    RtiPort,
    /// The name of the federation in this run.
    FederationId,
}

impl Instances {
    fn is_incomplete(&self) -> bool {
        matches!(self, Self::Spare(words) if words.is_empty())
    }
}

impl<T: Into<OsString>> From<T> for Argument {
    fn from(text: T) -> Self {
        Self::Text(text.into())
    }
}

impl Argument {
    /// Returns a text, followed by one that is known only when the process starts.
    pub(crate) fn known(before: &str, known: LateValue) -> Self {
        Self::Known(LateArgument { before: before.to_owned(), known })
    }

    fn is_port(&self) -> bool {
        matches!(self, Self::Known(word) if word.known == LateValue::RtiPort)
    }

    fn text(&self, id: &str, port: Option<u16>) -> OsString {
        match self {
            Self::Text(text) => text.clone(),
            Self::Known(LateArgument { before, known: LateValue::FederationId }) => format!("{before}{id}").into(),
            Self::Known(LateArgument { before, known: LateValue::RtiPort }) => {
                let port = port.map(|port| port.to_string()).unwrap_or_default();
                (before.clone() + &port).into()
            }
        }
    }
}

impl FederationId {
    fn of_this_run(&self) -> String {
        match self {
            Self::Exactly(name) => name.clone(),
            Self::BeginsWith(name) => {
                // With the addition it has to fit into 255 bytes.
                let name: String = name.chars().take(40).collect();
                // Programs in C pass it to a shell.
                let name = name.replace(|char: char| char.is_whitespace() || char.is_control(), "-");
                format!("{name}-{}", name_of_run())
            }
        }
    }
}

/// Returns a name that no other run has.
fn name_of_run() -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos());
    format!("{}-{now:x}", std::process::id())
}

impl Federation {
    /// Reads a description.
    ///
    /// # Errors
    /// The error, and its position.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let read: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        read.check()?;
        Ok(read)
    }

    /// Returns all processes, those that the user starts included.
    fn processes(&self) -> impl Iterator<Item = &Process> {
        self.rti.iter().chain(&self.federates).chain(&self.left_out)
    }

    /// Checks the rules that the types alone do not express.
    fn check(&self) -> Result<(), String> {
        let Self { version: Version, .. } = self;
        let mut names = BTreeSet::new();
        for Process { name, words, .. } in self.processes() {
            if words.is_empty() {
                return Err(format!("`{name}` has no words, of which the first is the program"));
            }
            if !names.insert(name) {
                return Err(format!("there are two processes with the name `{name}`"));
            }
        }
        if let Some(Process { name, .. }) = self.processes().find(|process| process.instances.is_incomplete()) {
            return Err(format!("`{name}` has a spare without words, of which the first is the program"));
        }
        let first: &[Process] = self.rti.as_ref().map_or(&self.federates, std::slice::from_ref);
        let knows_early = |process: &&Process| process.words.iter().any(Argument::is_port);
        match first.iter().find(knows_early) {
            Some(Process { name, .. }) if self.rti_port.is_none() => {
                Err(format!("`{name}` is to be told the RTI's port, which nobody knows when it starts"))
            }
            _ => Ok(()),
        }
    }

    /// Runs all processes to their end.
    ///
    /// # Errors
    /// When one cannot be started, or the system's calls fail; no process is left running then.
    pub(crate) fn run(&self, interrupts: Interrupts) -> Result<Ending, Failure> {
        let Some(recording) = &self.oscilloscope else { return self.run_processes(interrupts) };
        recording.clear();
        let ending = self.run_processes(interrupts)?;
        recording.merge()?;
        Ok(ending)
    }

    fn run_processes(&self, interrupts: Interrupts) -> Result<Ending, Failure> {
        let names = self.processes().map(|process| process.name.as_str());
        let output = Output::of_this_process(self.speaker.as_deref(), names).with_consoles(self.consoles()?);
        // It is dropped last, when no process is left that would start more.
        let descendants = Descendants::of_run(name_of_run())?;
        let mut supervisor = Supervisor::new(self.limits(), interrupts, output);
        let id = self.id.of_this_run();
        let mut port = self.rti_port;
        if let Some(rti) = &self.rti {
            rti.start(&mut supervisor, rti.launch(&descendants, Role::Rti, &id, port))?;
            if port.is_none() {
                port = supervisor.wait_for_line(listening_port)?;
            }
            if port.is_none() {
                return Ok(supervisor.finish()?);
            }
        }
        for federate in &self.left_out {
            let command = terminal::command_line(federate.words.iter().map(|word| word.text(&id, port)));
            supervisor.note(&format!("{} takes part when you start it: {command}", federate.name));
            supervisor.leave_out(federate.launch(&descendants, federate.role(), &id, port));
        }
        for federate in &self.federates {
            federate.start(&mut supervisor, federate.launch(&descendants, federate.role(), &id, port))?;
        }
        match Control::open(self.user) {
            Ok(control) => supervisor.obey(control),
            Err(error) => supervisor.note(&format!("`lfz ctl` cannot control this run: {error}")),
        }
        Ok(supervisor.finish()?)
    }

    /// Returns the consoles of images, by the names of the processes.
    fn consoles(&self) -> Result<BTreeMap<String, Console>, Failure> {
        let mut consoles = BTreeMap::new();
        for Process { name, crate_folder, .. } in self.processes() {
            if let Some(console) = crate_folder.as_deref().map_or(Ok(None), Console::of)? {
                consoles.insert(name.clone(), console);
            }
        }
        Ok(consoles)
    }

    fn limits(&self) -> Limits {
        let usual = Limits::default();
        Limits {
            run: self.timeout_ns.map(Duration::from_nanos),
            grace: self.grace_ns.map_or(usual.grace, Duration::from_nanos),
            terminate: self.terminate_ns.map_or(usual.terminate, Duration::from_nanos),
        }
    }
}

impl Process {
    fn role(&self) -> Role {
        if self.transient { Role::Transient } else { Role::Federate }
    }

    /// Returns how to start it in this run.
    fn launch(&self, descendants: &Descendants, role: Role, id: &str, port: Option<u16>) -> Launch {
        let own = self.environment.iter().map(|(name, value)| (OsString::from(name), OsString::from(value)));
        let (name, mark) = descendants.mark();
        // What a federate starts finds the RTI, too.
        let texts = |words: &[Argument]| words.iter().map(|word| word.text(id, port)).collect();
        let rti = port.map(|port| (RTI_VARIABLE.into(), format!("127.0.0.1:{port}").into()));
        Launch {
            name: self.name.clone(),
            role,
            restarts: self.transient && self.restarts,
            status_line: self.status_line.clone(),
            streams: self.streams,
            is_exclusive: !matches!(self.instances, Instances::Any),
            places: match &self.instances {
                Instances::Any | Instances::One => vec![texts(&self.words)],
                Instances::Spare(words) => vec![texts(&self.words), texts(words)],
            },
            image_id: self.image_id,
            environment: own.chain([(name.into(), mark.into())]).chain(rti).collect(),
            folder: self.folder.clone(),
        }
    }

    fn start(&self, supervisor: &mut Supervisor, launch: Launch) -> Result<(), Failure> {
        terminal::show_command(launch.places.iter().flatten().take(self.words.len()).cloned());
        let started = supervisor.launch(launch);
        started.map_err(|error| Failure::message(format!("{} cannot be started: {error}", self.name)))
    }
}

fn os_string<'de, D: Deserializer<'de>>(deserializer: D) -> Result<OsString, D::Error> {
    String::deserialize(deserializer).map(OsString::from)
}

#[cfg(test)]
mod tests {
    use super::{Federation, FederationId};

    #[test]
    fn federation_ids_differ_and_are_short_enough_for_the_wire() {
        let id_of = |name: &str| FederationId::BeginsWith(name.to_owned()).of_this_run();
        let name = "é".repeat(300);
        assert_ne!(id_of(&name), id_of(&name));
        assert!(id_of(&name).len() <= 255);
        assert!(id_of("Grid").starts_with("Grid-"));
    }

    /// Reads a description with these participants, the second of its three lines.
    fn read(participants: &str) -> Result<Federation, String> {
        Federation::read(&format!(r#"{{"version": 1, "id": {{"exactly": "f"}},{}{participants}}}"#, '\n'))
    }

    #[test]
    fn errors_of_a_description_name_their_place() {
        for (participants, words) in [
            (r#""federates": [{"name": "a", "words": ["x"], "word": 1}]"#, "unknown field `word`"),
            (r#""federates": [{"name": "a", "words": ["x", 1]}]"#, "a word is a text, or { before: TEXT, known:"),
            (r#""federates": [{"words": ["x"]}]"#, "missing field `name` at line 2"),
            (r#""federates": [{"name": "a", "words": []}]"#, "`a` has no words"),
            (r#""rti": null"#, "missing field `federates` at line 2"),
            (r#""federates": [{"name": "a", "words": [{"known": "rti_port"}]}]"#, "`a` is to be told the RTI's port"),
            (r#""federates": [{"name": "a", "words": ["x"]}, {"name": "a", "words": ["x"]}]"#, "the name `a`"),
        ] {
            let error = read(participants).expect_err(participants);
            assert!(error.contains(words), "{participants}: {error}");
        }
        let error = Federation::read(r#"{"version": 2, "processes": []}"#).expect_err("it is of another version");
        assert!(error.contains("version 1, and not 2") && error.contains("line 1"), "{error}");
    }

    #[test]
    fn federates_are_told_the_port_of_an_rti_that_says_it() {
        let rti = r#""rti": {"name": "r", "words": ["x"]}, "#;
        let federate = r#""federates": [{"name": "a", "words": ["x", {"before": "p=", "known": "rti_port"}]}]"#;
        let federation = read(&format!("{rti}{federate}")).expect("it is right");
        assert_eq!(federation.federates[0].words[1].text("f", Some(7)), "p=7");
        assert!(read(&format!(r#""rti_port": 7, {federate}"#)).is_ok());
    }
}
