// SPDX-License-Identifier: Apache-2.0
//! The capabilities that a program needs of a federate, known at compile time: an image carries no others.

use core::fmt::Debug;

/// The capabilities that a program needs. They are a type, so that the compiler generates no code for the others. A
/// computer, where the same code runs programs of any kind, uses [`All`].
pub trait Needs: Copy + Debug + 'static {
    /// The RTI grants its tags, and forwards its messages.
    const CENTRALIZED: bool = true;
    /// Federates send each other their messages, and it begins tags without grants. A program needs at least one of
    /// both.
    const DECENTRALIZED: bool = true;
    /// Other federates send to it through the RTI.
    const INPUTS: bool = true;
    /// The RTI may grant tags provisionally: to federates in a cycle without delay, and at a stop, to revoke what it
    /// has granted to a federate with inputs.
    const CYCLES: bool = true;
    /// The federate and the RTI prove to each other that they know the federation id.
    const AUTHENTICATION: bool = true;
    /// Other federates send to it directly.
    const PEERS_IN: bool = true;
    /// Reactions wait for inputs to become known: in a cycle without delay, and with decentralized coordination.
    const AWAITED: bool = true;
    /// It sends to other federates directly.
    const PEERS_OUT: bool = true;
    /// A direct connection is physical, and carries messages without tags.
    const UNTAGGED: bool = true;
    /// It comes and goes while the federation runs, or a neighbor does.
    const TRANSIENTS: bool = cfg!(feature = "transients");
    /// Physical actions can cause outputs to other federates, through the RTI.
    const PHYSICAL: bool = true;
    /// Its clock is synchronized before the start.
    const CLOCK_SYNC: bool = true;
    /// Its buffers may be too small, so it checks them when it starts. Those of an image have the right size by
    /// construction.
    const BUFFER_CHECK: bool = true;
    /// Its receive buffer may have memory for more messages than usual, so it offers a larger window.
    const WINDOW: bool = true;
    /// The running federate logs what it waits for.
    const WAITS: bool = true;
}

/// All capabilities.
#[derive(Clone, Copy, Debug)]
pub struct All;

impl Needs for All {}
