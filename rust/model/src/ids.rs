// SPDX-License-Identifier: Apache-2.0
//! The numbers by which the tables identify the parts of a program.

/// A reaction: its index in [`Tables::reactions`](crate::Tables::reactions), which is also its rank in the order of
/// execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ReactionId(pub u16);

/// A trigger: its index in [`Tables::triggers`](crate::Tables::triggers).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TriggerId(pub u16);

/// A port that stores a value: its index in [`Tables::ports`](crate::Tables::ports).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PortId(pub u16);

/// A connection to another federate: its index in [`Tables::outputs`](crate::Tables::outputs).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OutputId(pub u16);

/// A connection from another federate: its index in [`Tables::inputs`](crate::Tables::inputs).
/// [`Tables::input_of`](crate::Tables::input_of) finds it by its port number on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InputId(pub u16);

/// A mode of an instance: its index in [`Modes::modes`](crate::Modes::modes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ModeId(pub u16);
