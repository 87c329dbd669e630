// SPDX-License-Identifier: Apache-2.0
//! The common part of all instances of a reactor: declarations and reaction bodies.

use serde::{Deserialize, Serialize};

use super::serializer::Serializer;
use super::source::{ClassIndex, FileIndex, Location, SourceCode, Type, Value};

/// The parameter that contains the index of a bank's member.
pub const BANK_INDEX: &str = "bank_index";

/// A reactor that at least one federate instantiates.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReactorClass {
    /// The name in LF; names are unique within a file, not within a program.
    pub name: String,
    /// The place of the name's declaration.
    pub at: Location,
    /// The comment directly before the declaration, without comment marks.
    pub docs: Option<String>,
    /// The types that stand for its type parameters, by their names.
    pub types: Vec<(String, Type)>,
    /// Further files in which names of its code may be declared: those of inherited code, and those that contain
    /// `types`.
    pub files: Vec<FileIndex>,
    /// The reactors whose declarations `types` may name.
    pub users: Vec<ClassIndex>,
    /// The reactor's preambles, in order.
    pub preambles: Vec<SourceCode>,
    /// Parameters, in order of declaration.
    pub parameters: Vec<Parameter>,
    /// State variables, in order of declaration.
    pub state: Vec<StateVariable>,
    /// Inputs and outputs, in order of declaration.
    pub ports: Vec<PortDeclaration>,
    /// Logical and physical actions, in order of declaration.
    pub actions: Vec<ActionDeclaration>,
    /// Timers, in order of declaration.
    pub timers: Vec<TimerDeclaration>,
    /// Watchdogs, in order of declaration.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub watchdogs: Vec<TimerDeclaration>,
    /// Contained reactors, in order of declaration; of the federated reactor, the federates.
    pub children: Vec<Child>,
    /// Methods, in order of declaration.
    pub methods: Vec<Method>,
    /// Reactions, in order of declaration; the handlers of watchdogs come first.
    pub reactions: Vec<Reaction>,
}

impl ReactorClass {
    /// Returns whether state in this mode, or outside of modes, is reset. A reactor without reactions has no visible
    /// state.
    pub fn has_resets(&self, mode: Option<usize>) -> bool {
        !self.reactions.is_empty() && self.state.iter().any(|state| state.resets && state.mode == mode)
    }

    /// Returns the class without its code: it has its ports, and constructs its contained reactors.
    pub(crate) fn only_containing(&self) -> Self {
        Self {
            name: self.name.clone(),
            at: self.at,
            docs: self.docs.clone(),
            types: self.types.clone(),
            files: self.files.clone(),
            users: self.users.clone(),
            preambles: Vec::new(),
            parameters: Vec::new(),
            state: Vec::new(),
            ports: self.ports.clone(),
            actions: Vec::new(),
            timers: Vec::new(),
            watchdogs: Vec::new(),
            children: self.children.clone(),
            methods: Vec::new(),
            reactions: Vec::new(),
        }
    }
}

/// A method of a reactor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Method {
    /// Its name.
    pub name: String,
    /// Whether it leaves the state as it is.
    pub constant: bool,
    /// Its arguments with their types.
    pub arguments: Vec<(String, Type)>,
    /// The type of its result.
    pub ty: Option<Type>,
    /// The body.
    pub body: SourceCode,
    /// The place of the declaration.
    pub at: Location,
}

/// A parameter of a reactor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Its default, which may name earlier parameters.
    pub default: Option<Value>,
    /// Of the main reactor: the reason why the program has to know the value at compile time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed: Option<Fixed>,
    /// The place of the declaration.
    pub at: Location,
}

/// The property that follows from a parameter of the main reactor at compile time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fixed {
    /// The number of a bank's members, or of a port's channels.
    Width,
    /// The time of a timer, an action, a connection or a deadline.
    Time,
}

/// A contained reactor: `sensor = new VoltageSensor(unit = unit)`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Child {
    /// The name of the instance.
    pub name: String,
    /// Its reactor.
    pub class: ClassIndex,
    /// The arguments in the order of that reactor's parameters: a value as it is written, which may name parameters of
    /// the containing reactor; `None` for the parameter's default.
    pub arguments: Vec<Option<Value>>,
    /// Whether it is a bank, whose members have their index in the parameter `bank_index`.
    pub is_bank: bool,
    /// The place of the declaration.
    pub at: Location,
}

/// A state variable of a reactor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StateVariable {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Its initial value, which may name the reactor's parameters; `Default::default()` if there is none.
    pub init: Option<Value>,
    /// Whether it gets this value again when its mode, or that of its reactor, is entered by reset.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub resets: bool,
    /// Whether and how a transient federate hands it over to the instance that takes its place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub handed_over: Option<Handover>,
    /// The position of its mode in the class.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<usize>,
    /// The place of the declaration.
    pub at: Location,
}

/// The way in which a state variable is handed over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Handover {
    /// The serializer, if it is not the layout of the type itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serializer: Option<Serializer>,
}

/// The direction of a port, seen from its own reactor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PortDirection {
    /// `input`
    Input,
    /// `output`
    Output,
}

/// An input or output of a reactor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PortDeclaration {
    /// Its name.
    pub name: String,
    /// Input or output.
    pub direction: PortDirection,
    /// The type of its values.
    pub ty: Type,
    /// Whether it is a `mutable input`, so that bodies may change its value. Bodies in Rust have a copy or a reference
    /// of it anyway.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub mutable: bool,
    /// Whether it is a multiport; the width may differ per instance.
    pub is_wide: bool,
    /// The place of the declaration.
    pub at: Location,
}

/// An action of a reactor; its timing belongs to the instance's trigger.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActionDeclaration {
    /// Its name.
    pub name: String,
    /// Whether it is a `physical action`.
    pub physical: bool,
    /// The type of its values, `()` when it carries none.
    pub ty: Type,
    /// The place of the declaration.
    pub at: Location,
}

/// A timer or a watchdog of a reactor; its timing belongs to the instance's trigger.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimerDeclaration {
    /// Its name.
    pub name: String,
    /// The place of the declaration.
    pub at: Location,
}

/// A reaction of a reactor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reaction {
    /// Its number within the reactor, from 1.
    pub number: usize,
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Triggers, uses and effects as they are written, on one line: `reaction(t) x -> y`.
    pub signature: String,
    /// The variables that the body sees besides `self` and `ctx`, in the order of the signature, each once.
    /// `startup` and `shutdown` are triggers without a variable.
    pub parameters: Vec<ReactionParameter>,
    /// The body.
    pub body: SourceCode,
    /// Whether the body is the function of the reaction's name, elsewhere in the program.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub external: bool,
    /// The deadline's handler; the deadline's value may differ per instance and stands in the federate's reaction.
    pub deadline: Option<SourceCode>,
    /// The treatment of late messages in decentralized coordination; `None` if the program does not set it.
    pub tardy: Option<Tardy>,
    /// The place of the keyword `reaction`.
    pub at: Location,
}

/// A reaction's treatment of late messages.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tardy {
    /// This code runs instead of the body.
    Handler(SourceCode),
    /// The body runs and handles tardy inputs itself: `tardy` without code.
    Body,
}

/// A variable in the scope of a reaction's body.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReactionParameter {
    /// The name that the body uses: `port`, or for a port of a contained reactor the language's form of it.
    pub name: String,
    /// The port of a contained reactor, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub child: Option<ChildPort>,
    /// The kind of the variable.
    pub kind: VariableKind,
    /// Whether it is among the triggers.
    pub triggers: bool,
    /// Whether it is among the uses.
    pub uses: bool,
    /// Whether it is among the effects, so that the body may set or schedule it.
    pub effect: bool,
    /// The place of its first occurrence.
    pub at: Location,
}

impl ReactionParameter {
    /// Returns whether bodies may change the variable. A timer among the effects is only seen.
    pub fn is_mutable(&self) -> bool {
        self.effect && self.kind != VariableKind::Timer
    }
}

/// A port of a contained reactor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChildPort {
    /// The name of the instance, or of the bank.
    pub child: String,
    /// Whether it is a bank.
    pub is_bank: bool,
    /// The name of the port.
    pub port: String,
    /// Whether it is a multiport.
    pub is_wide: bool,
}

/// The meaning of a reaction's variable.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VariableKind {
    /// A port of this reactor or of a contained one.
    Port {
        /// The type of its values.
        ty: Type,
    },
    /// A multiport, or a port of each member of a bank.
    Multiport {
        /// The type of its values.
        ty: Type,
    },
    /// A logical action.
    LogicalAction {
        /// The type of its values.
        ty: Type,
    },
    /// A physical action.
    PhysicalAction {
        /// The type of its values.
        ty: Type,
    },
    /// A timer.
    Timer,
    /// A watchdog.
    Watchdog,
    /// A mode that the reaction can change to.
    Mode {
        /// Whether it continues where it was left.
        history: bool,
    },
}
