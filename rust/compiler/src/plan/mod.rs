// SPDX-License-Identifier: Apache-2.0
//! The plan: the results of analysis as plain data, and the only input of the emitters.
//!
//! It can be printed (`Display`, serde), compared and tested by snapshot. It holds no reference to the syntax tree.

mod cargo;
mod class;
mod federate;
mod native;
mod render;
mod serializer;
mod shape;
mod source;

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

pub use crate::lexical::Language;
pub use cargo::{BuildType, Cargo, Dependency, Module};
pub use class::{
    ActionDeclaration, BANK_INDEX, Child, ChildPort, Fixed, Handover, Method, Parameter, PortDeclaration,
    PortDirection, Reaction, ReactionParameter, ReactorClass, StateVariable, Tardy, TimerDeclaration, VariableKind,
};
pub(crate) use federate::port_of;
pub use federate::{
    Argument, Federate, Instance, Mode, NetworkInput, NetworkOutput, Port, ReactionKind, ScheduledReaction,
    SpacingPolicy, Trigger, TriggerKind, Upstream,
};
pub use native::{CompilerFlag, Definition, IncludedFile, NativeCode};
pub(crate) use native::{in_library, library_file};
pub use render::Time;
pub use serializer::Serializer;
pub use shape::Shape;
pub use source::{
    ClassIndex, FileIndex, InputIndex, InstanceIndex, Location, ModeIndex, OutputIndex, PortIndex, ReactionIndex,
    SourceCode, SourceFile, TriggerIndex, Type, Value,
};

/// A program, ready for emission.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// The program's name: that of the main file without its extension.
    pub name: String,
    /// The files that take part; the main file is the first.
    pub files: Vec<SourceFile>,
    /// The target properties that have an effect at run time.
    pub target: Target,
    /// The RTI; `None` for a program that is not federated.
    pub rti: Option<Rti>,
    /// The reactors that are instantiated, the main or federated one included.
    pub classes: Vec<ReactorClass>,
    /// The class of the `main` or `federated` reactor.
    pub main: ClassIndex,
    /// The federates in order of id; exactly one for a program that is not federated.
    pub federates: Vec<Federate>,
}

/// The advance message interval of a program that sets none, as in LF.
pub(crate) const ADVANCE_INTERVAL_NS_DEFAULT: i64 = 10_000_000;

/// The period of clock synchronization of a program that sets none, as in LF.
const CLOCK_SYNC_PERIOD_NS_DEFAULT: i64 = 5_000_000;

/// Target properties, with LF's defaults where the program sets none.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(clippy::struct_excessive_bools, reason = "these are switches, each of its own")]
pub struct Target {
    /// The language of bodies, types and values.
    pub language: Language,
    /// `timeout` in nanoseconds.
    pub timeout_ns: Option<i64>,
    /// `fast`: do not wait for physical time.
    pub fast: bool,
    /// `keepalive`: continue when there are no more events.
    pub keepalive: bool,
    /// `coordination`: the participant that decides when a federate may advance.
    pub coordination: Coordination,
    /// `logging`.
    pub logging: Logging,
    /// `clock-sync`.
    pub clock_sync: ClockSync,
    /// `clock-sync-options: {trials}`: exchanges of the initial clock synchronization.
    pub clock_sync_trials: u16,
    /// `clock-sync-options: {period}` in nanoseconds: the time between rounds with `clock-sync: on`.
    pub clock_sync_period_ns: i64,
    /// `clock-sync-options: {attenuation}`: each round corrects one part in this number of the remaining error.
    pub clock_sync_attenuation: u16,
    /// `clock-sync-options: {local-federates-on}`: whether programs on the RTI's own computer take part, although they
    /// share its clock.
    pub clock_sync_local: bool,
    /// `clock-sync-options: {test-offset}` in nanoseconds: the clock of federate i is ahead by 1 + i times this value.
    pub clock_sync_test_offset_ns: i64,
    /// `coordination-options: {advance-message-interval}` in nanoseconds: the period at which a federate whose outputs
    /// depend on physical actions announces its progress.
    pub advance_interval_ns: i64,
    /// `coordination-options: {log-waits}` in nanoseconds: the duration after which a running participant logs the
    /// reason of its wait, if at all.
    pub log_waits_ns: Option<i64>,
    /// `DNET`: whether the RTI informs federates of next event tags for which no other federate waits.
    pub dnet: bool,
    /// `auth`: the RTI and the federates prove to each other that they know the federation id.
    pub authentication: bool,
    /// `comm-type` and `security`: the encryption of all connections.
    #[serde(default, skip_serializing_if = "Security::is_none")]
    pub security: Security,
    /// `joint-rti`: the RTI is part of the image of a federate, if one is on a board.
    pub joint_rti: bool,
    /// `joint-rti-options: {federation-id}`, if given.
    pub federation_id: Option<String>,
    /// `joint-rti-options: {port}`, if given.
    pub rti_port: Option<u16>,
    /// `platform: {name}`, if given.
    pub platform: Option<String>,
    /// `platform: {board}`, if given.
    pub board: Option<String>,
    /// `platform: {user-threads}`: the maximum number of threads that bodies start; 0 by default.
    pub user_threads: u16,
    /// `workers`: the number of threads that run reactions on Linux.
    #[serde(default = "one_worker", skip_serializing_if = "is_one_worker")]
    pub workers: u16,
    /// The settings for cargo.
    #[serde(default, skip_serializing_if = "Cargo::is_empty")]
    pub cargo: Cargo,
    /// The settings for the C compiler.
    #[serde(default, skip_serializing_if = "NativeCode::is_empty")]
    pub c: NativeCode,
}

fn one_worker() -> u16 {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde gives a reference")]
fn is_one_worker(workers: &u16) -> bool {
    *workers == one_worker()
}

impl Default for Target {
    fn default() -> Self {
        Self {
            language: Language::default(),
            timeout_ns: None,
            fast: false,
            keepalive: false,
            coordination: Coordination::Centralized,
            logging: Logging::Info,
            clock_sync: ClockSync::Init,
            clock_sync_trials: 10,
            clock_sync_period_ns: CLOCK_SYNC_PERIOD_NS_DEFAULT,
            clock_sync_attenuation: 10,
            clock_sync_local: false,
            clock_sync_test_offset_ns: 0,
            advance_interval_ns: ADVANCE_INTERVAL_NS_DEFAULT,
            log_waits_ns: None,
            dnet: true,
            authentication: false,
            security: Security::None,
            joint_rti: false,
            federation_id: None,
            rti_port: None,
            platform: None,
            board: None,
            user_threads: 0,
            workers: one_worker(),
            cargo: Cargo::default(),
            c: NativeCode::default(),
        }
    }
}

/// The participant that decides when a federate may advance to a tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordination {
    /// The RTI, which knows the progress of each federate.
    Centralized,
    /// Each federate by itself: messages go from federate to federate, and each waits as long as one may be in transit.
    Decentralized,
}

/// The encryption of the connections of a federation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Security {
    /// Everybody on the network can read and forge messages.
    #[default]
    None,
    /// Noise, with a key for each participant.
    Noise,
    /// TLS, with a certificate for each participant.
    Tls,
    /// TLS as LF has it: encrypted, with whomever it is.
    UnverifiedTls,
}

impl Security {
    /// Returns whether connections are not encrypted.
    pub fn is_none(&self) -> bool {
        *self == Self::None
    }

    /// Returns whether connections are encrypted by TLS.
    pub fn is_tls(self) -> bool {
        matches!(self, Self::Tls | Self::UnverifiedTls)
    }

    /// Returns the target property that asks for it.
    pub fn property(self) -> &'static str {
        match self {
            Self::None => "security: none",
            Self::Noise => "security: noise",
            Self::Tls | Self::UnverifiedTls => "comm-type: TLS",
        }
    }
}

/// The level of logging.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Logging {
    /// Errors only.
    Error,
    /// And warnings.
    Warn,
    /// And information for users.
    Info,
    /// And information for developers of the program (LF's `LOG`).
    Log,
    /// Everything.
    Debug,
}

/// The mode of clock synchronization.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClockSync {
    /// Not at all.
    Off,
    /// Once, before the start.
    Init,
    /// Before the start, and as long as the federation runs.
    On,
}

/// The address of the RTI, and the name of the federation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rti {
    /// Host name or address.
    pub host: String,
    /// TCP port.
    pub port: u16,
    /// The federation id that the federates present.
    pub federation_id: String,
}

impl Plan {
    /// Returns the number of federates that come and go while the federation runs.
    pub fn transients(&self) -> usize {
        self.federates.iter().filter(|federate| federate.transient).count()
    }

    /// Returns the federates that come and go among this one and its neighbors, in order of id.
    pub fn transient_neighbors(&self, federate: &Federate) -> Vec<u16> {
        let others = federate.upstream.iter().map(|upstream| upstream.federate).chain(federate.downstream.clone());
        let direct = federate.peers_in().into_iter().chain(federate.peers_out());
        let near: BTreeSet<u16> = others.chain(direct).chain([federate.id]).collect();
        let transient = self.federates.iter().filter(|other| other.transient && near.contains(&other.id));
        transient.map(|other| other.id).collect()
    }

    /// Returns the class of an instance.
    ///
    /// # Panics
    /// If the instance is not one of this plan's.
    pub fn class(&self, instance: &Instance) -> &ReactorClass {
        &self.classes[instance.class.0]
    }

    /// Returns a reaction's treatment of late messages, if the program sets it.
    ///
    /// # Panics
    /// If the reaction is not one of this federate's.
    pub fn tardy(&self, federate: &Federate, reaction: &ScheduledReaction) -> Option<&Tardy> {
        let ReactionKind::Body { instance, reaction, .. } = &reaction.kind else { return None };
        self.class(&federate.instances[instance.0]).reactions[reaction - 1].tardy.as_ref()
    }

    /// Returns the declaration of an instance: as a child of its container. `None` for an unfederated main reactor.
    ///
    /// # Panics
    /// If the instance is not one of this federate's.
    pub fn child(&self, federate: &Federate, instance: &Instance) -> Option<&Child> {
        let container = instance.parent.map_or(self.main, |parent| federate.instances[parent.0].class);
        self.classes[container.0].children.get(instance.child?)
    }

    /// Returns the path of a location's file.
    ///
    /// # Panics
    /// If the location is not one of this plan's.
    pub fn path(&self, at: Location) -> &str {
        &self.files[at.file.0].path
    }

    /// Returns whether the coordination is decentralized.
    pub fn is_decentralized(&self) -> bool {
        self.target.coordination == Coordination::Decentralized
    }

    /// Returns whether the program has federates that need an RTI.
    pub fn is_federated(&self) -> bool {
        self.rti.is_some()
    }
}
