// SPDX-License-Identifier: Apache-2.0
//! Zero-delay cycles: what a federate knows of its awaited inputs, and how far it may go within a tag.
//!
//! A provisional grant (PTAG) lets the federates of a cycle without delay be at one tag together. Each of them runs its
//! reactions below the lowest level at which a reaction could see an unknown input, and goes on when a message or a
//! `PORT_ABSENT` makes the input known. This is MLAA, the maximum level allowed to advance.

use lf_model::time::Tag;

use super::machine::Federate;
use super::needs::Needs;

/// An input that a federate waits for. With centralized coordination it comes from a federate in a cycle without delay:
/// the same as this one's, or any cycle if this federate is in none, because the stock RTI grants tags provisionally to
/// all federates upstream of a cycle. With decentralized coordination it is the end of any logical connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct AwaitedInput {
    /// The network input.
    pub port: u16,
    /// The lowest level of the reactions that see it.
    pub level: u16,
}

/// The tag up to which each awaited input is known.
#[derive(Debug)]
pub struct Awaited<'a> {
    inputs: &'a [AwaitedInput],
    /// The tag of each awaited input.
    known: &'a mut [Tag],
}

impl<'a> Awaited<'a> {
    /// Returns a state in which no input is known. `known` is storage with at least one tag per input; `None` if it is
    /// shorter.
    pub fn new(inputs: &'a [AwaitedInput], known: &'a mut [Tag]) -> Option<Self> {
        let known = known.get_mut(..inputs.len())?;
        known.fill(Tag::NEVER);
        Some(Self { inputs, known })
    }

    /// Records that a message or an absence with this tag has come for a network input and has been handled. Nothing
    /// earlier follows, because messages of one federate arrive in order.
    pub fn learn(&mut self, port: u16, tag: Tag) {
        for (_, known) in self.inputs.iter().zip(&mut *self.known).filter(|(input, _)| input.port == port) {
            *known = (*known).max(tag);
        }
    }

    /// Records that a network input is known up to this tag only: its sender, which was absent, has come.
    #[cfg(feature = "transients")]
    pub fn forget(&mut self, port: u16, tag: Tag) {
        for (_, known) in self.inputs.iter().zip(&mut *self.known).filter(|(input, _)| input.port == port) {
            *known = tag;
        }
    }

    /// Returns whether an input is known up to this tag.
    pub fn is_known(&self, port: u16, tag: Tag) -> bool {
        self.known().filter(|(input, _)| input.port == port).all(|(_, known)| known >= tag)
    }

    /// Returns the first input that is not known up to this tag.
    pub fn first_unknown(&self, tag: Tag) -> Option<u16> {
        self.known().find(|(_, known)| *known < tag).map(|(input, _)| input.port)
    }

    pub(super) fn inputs(&mut self) -> impl Iterator<Item = (&AwaitedInput, &mut Tag)> {
        self.inputs.iter().zip(&mut *self.known)
    }

    pub(super) fn known(&self) -> impl Iterator<Item = (&AwaitedInput, Tag)> {
        self.inputs.iter().zip(self.known.iter().copied())
    }

    /// Returns the level below which reactions of the federate's current tag may run; `None` if all of them may.
    pub fn max_level(&self, federate: &Federate<'_, impl Needs>) -> Option<u16> {
        let current = federate.current();
        if federate.knows_all_inputs() {
            return None;
        }
        let inputs = self.inputs.iter().zip(&*self.known);
        inputs.filter(|(_, known)| **known < current).map(|(input, _)| input.level).min()
    }
}
