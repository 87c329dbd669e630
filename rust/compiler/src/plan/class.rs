// SPDX-License-Identifier: Apache-2.0
//! What is common to all instances of a reactor: declarations and reaction bodies.

use serde::{Deserialize, Serialize};

use super::source::{ClassIndex, FileIndex, Location, SourceCode, Type, Value};

/// The parameter that tells a member of a bank its number.
pub const BANK_INDEX: &str = "bank_index";

/// A reactor that at least one federate instantiates.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReactorClass {
    /// The name in LF; names are unique within a file, not within a program.
    pub name: String,
    /// Where the name is declared.
    pub at: Location,
    /// The comment directly before the declaration, without comment marks.
    pub docs: Option<String>,
    /// The types that stand for its type parameters, by their names.
    pub types: Vec<(String, Type)>,
    /// The files in which names of its code may be declared, beside its own: those of what it inherits, and those in
    /// which `types` are written.
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
    /// Whether state in this mode, or in none, is reset. A reactor without reactions has no state that anybody sees.
    pub fn has_resets(&self, mode: Option<usize>) -> bool {
        !self.reactions.is_empty() && self.state.iter().any(|state| state.resets && state.mode == mode)
    }

    /// Returns the class without what code runs in it: it has its ports, and makes what it contains.
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
    /// What it returns.
    pub ty: Option<Type>,
    /// The body.
    pub body: SourceCode,
    /// Where it is declared.
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
    /// Of the main reactor: why the program has to know the value when it is compiled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed: Option<Fixed>,
    /// Where it is declared.
    pub at: Location,
}

/// What follows from a parameter of the main reactor when the program is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fixed {
    /// How many members a bank has, or channels a port.
    Width,
    /// When a timer, an action, a connection or a deadline is due.
    Time,
}

/// A contained reactor: `sensor = new VoltageSensor(unit = unit)`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Child {
    /// The name of the instance.
    pub name: String,
    /// Its reactor.
    pub class: ClassIndex,
    /// One per parameter of that reactor, in the order of declaration: the value as it is written, which may name
    /// parameters of the containing reactor; `None` for the parameter's default.
    pub arguments: Vec<Option<Value>>,
    /// Whether it is a bank, whose members know their numbers by the parameter `bank_index`.
    pub is_bank: bool,
    /// Where it is declared.
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
    /// The mode of the class that it is in, by its position.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<usize>,
    /// Where it is declared.
    pub at: Location,
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
    /// Whether it is a `mutable input`, so that bodies may change what comes. Those in Rust have a copy or a reference
    /// of it anyway.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub mutable: bool,
    /// Whether it is a multiport; how wide it is may differ per instance.
    pub is_wide: bool,
    /// Where it is declared.
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
    /// Where it is declared.
    pub at: Location,
}

/// A timer or a watchdog of a reactor; its timing belongs to the instance's trigger.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimerDeclaration {
    /// Its name.
    pub name: String,
    /// Where it is declared.
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
    /// Whether the body is a function of the reaction's name, which is elsewhere in the program.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub external: bool,
    /// The deadline's handler; the deadline's value may differ per instance and stands in the federate's reaction.
    pub deadline: Option<SourceCode>,
    /// What happens in decentralized coordination with a message that comes too late; `None` if nothing is said.
    pub tardy: Option<Tardy>,
    /// Where the keyword `reaction` stands.
    pub at: Location,
}

/// What a reaction does with messages that come too late.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tardy {
    /// This runs in place of the body.
    Handler(SourceCode),
    /// The body runs, which knows what to do: `tardy` without code.
    Body,
}

/// A variable in the scope of a reaction's body.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReactionParameter {
    /// The name that the body uses: `port`, or for a port of a contained reactor what the language makes of it.
    pub name: String,
    /// The port of a contained reactor that it is; `None` for all else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub child: Option<ChildPort>,
    /// What the variable is.
    pub kind: VariableKind,
    /// Whether it is among the triggers.
    pub triggers: bool,
    /// Whether it is among the uses.
    pub uses: bool,
    /// Whether it is among the effects, so that the body may set or schedule it.
    pub effect: bool,
    /// Where it is written for the first time.
    pub at: Location,
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

/// What a variable of a reaction stands for.
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
        /// Whether it goes on where it was left.
        history: bool,
    },
}
