// SPDX-License-Identifier: Apache-2.0
//! The parts of a program that a picture of it shows, as plain data: reactors in each other with their ports, the
//! elements in each, and the edges between them. Where they lie in the picture is not decided here.

mod builder;

pub(crate) use builder::diagram_of;

use crate::plan::Coordination;

/// A program as a picture shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagram {
    /// The program's name.
    pub name: String,
    /// The coordination of a federated program.
    pub coordination: Option<Coordination>,
    /// The reactors, containers before their contents. The first is the main or federated one.
    pub reactors: Vec<DiagramReactor>,
}

/// The view of banks in a diagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BankView {
    /// One reactor stands for all members of a bank.
    Collapsed,
    /// Each member is a reactor.
    Expanded,
}

/// An instance of a reactor, or a bank whose first member stands for all of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagramReactor {
    /// The position of the containing reactor.
    pub parent: Option<usize>,
    /// The name of the instance: `sensor`, or `sensors[2]` for a member of a bank.
    pub name: String,
    /// The name of its reactor.
    pub class: String,
    /// The number of members, if it stands for a bank.
    pub members: Option<usize>,
    /// The names of the federates that it stands for; none if it is no federate.
    pub federates: Vec<String>,
    /// The host of the federate, or of the RTI for the federated reactor, if the program names it.
    pub host: Option<String>,
    /// The mode of the containing reactor that it is in.
    pub mode: Option<usize>,
    /// The inputs and outputs, in order of declaration.
    pub ports: Vec<DiagramPort>,
    /// The modes, in order of declaration.
    pub modes: Vec<DiagramMode>,
    /// The reactions, and whatever triggers them.
    pub elements: Vec<DiagramElement>,
    /// The edges between its elements, its ports, and those of the reactors in it.
    pub edges: Vec<DiagramEdge>,
}

/// An input or output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagramPort {
    /// Its name.
    pub name: String,
    /// Whether it is an input.
    pub is_input: bool,
    /// The type of its values.
    pub ty: String,
    /// The number of channels of a multiport.
    pub width: Option<usize>,
}

/// A mode.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagramMode {
    /// Its name; empty if it cannot be entered.
    pub name: String,
    /// Whether its reactor begins in it.
    pub is_initial: bool,
}

/// A reaction, or what triggers reactions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagramElement {
    /// The kind.
    pub kind: ElementKind,
    /// The mode that it is in.
    pub mode: Option<usize>,
    /// Its name; of a reaction without one, its number.
    pub name: String,
    /// Its times in words: `every 20 ms`. Empty if it has none.
    pub timing: String,
    /// The declaration, on one line.
    pub declaration: String,
}

/// The kinds of elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ElementKind {
    /// The beginning of the execution.
    Startup,
    /// The end of the execution.
    Shutdown,
    /// The entry into a mode by reset.
    Reset,
    /// A timer.
    Timer,
    /// A logical action.
    LogicalAction,
    /// A physical action.
    PhysicalAction,
    /// A watchdog.
    Watchdog,
    /// A reaction.
    Reaction,
}

/// One end of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EdgeEnd {
    /// A port of the reactor that has the edge.
    Own(usize),
    /// A port of a contained reactor.
    Contained {
        /// The position of the contained reactor in the diagram.
        reactor: usize,
        /// The position of the port in it.
        port: usize,
    },
    /// An element.
    Element(usize),
    /// A mode.
    Mode(usize),
}

/// A line from one thing to another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagramEdge {
    /// Where it begins.
    pub from: EdgeEnd,
    /// Where it ends.
    pub to: EdgeEnd,
    /// Its meaning.
    pub kind: EdgeKind,
}

/// The meaning of an edge.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EdgeKind {
    /// A connection of ports.
    Connection {
        /// The delay as text; none without `after`.
        delay: Option<String>,
        /// Whether it is physical: the tag of a value is the time of its arrival.
        physical: bool,
    },
    /// From a trigger to its reaction.
    Trigger,
    /// From a port that a reaction reads, and that does not trigger it.
    Use,
    /// From a reaction to what it sets or schedules.
    Effect,
    /// From a reaction to the mode that it enters.
    Transition {
        /// Whether the mode continues where it was left.
        history: bool,
    },
}
