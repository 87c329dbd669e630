// SPDX-License-Identifier: Apache-2.0
//! Zero-delay cycles: what a federate knows of its awaited inputs, and how far it may go within a tag.
//!
//! A provisional grant (PTAG) lets the federates of a cycle without delay be at one tag together. Each of them then
//! runs its reactions up to the least level at which one could see an input of which it is not known yet what comes,
//! and goes on when a message or `PORT_ABSENT` has told. This is MLAA, the maximum level allowed to advance.

use lf_model::time::Tag;

use super::machine::Federate;
use super::needs::Needs;

/// With centralized coordination, an input from a federate in a cycle without delay: the same as this one's, or any
/// where this one is in none, because the stock RTI grants tags provisionally to all federates upstream of a cycle.
/// With decentralized coordination, any input that is the end of a logical connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct AwaitedInput {
    /// The network input.
    pub port: u16,
    /// The least level of the reactions that see it.
    pub level: u16,
}

/// Up to which tag it is known what comes at each awaited input.
#[derive(Debug)]
pub struct Awaited<'a> {
    inputs: &'a [AwaitedInput],
    /// By awaited input.
    known: &'a mut [Tag],
}

impl<'a> Awaited<'a> {
    /// Nothing is known yet. `known` is storage of at least as many tags as there are inputs; `None` where it is
    /// shorter.
    pub fn new(inputs: &'a [AwaitedInput], known: &'a mut [Tag]) -> Option<Self> {
        let known = known.get_mut(..inputs.len())?;
        known.fill(Tag::NEVER);
        Some(Self { inputs, known })
    }

    /// A message of this tag, or word that there is none, has come for a network input and has been handled. Nothing
    /// earlier will come there, for what one federate sends arrives in order.
    pub fn learn(&mut self, port: u16, tag: Tag) {
        for (_, known) in self.inputs.iter().zip(&mut *self.known).filter(|(input, _)| input.port == port) {
            *known = (*known).max(tag);
        }
    }

    /// Whether it is known what has come at an input up to this tag.
    pub fn is_known(&self, port: u16, tag: Tag) -> bool {
        self.known().filter(|(input, _)| input.port == port).all(|(_, known)| known >= tag)
    }

    /// The first input of which it is not known what has come up to this tag.
    pub fn first_unknown(&self, tag: Tag) -> Option<u16> {
        self.known().find(|(_, known)| *known < tag).map(|(input, _)| input.port)
    }

    pub(super) fn inputs(&mut self) -> impl Iterator<Item = (&AwaitedInput, &mut Tag)> {
        self.inputs.iter().zip(&mut *self.known)
    }

    pub(super) fn known(&self) -> impl Iterator<Item = (&AwaitedInput, Tag)> {
        self.inputs.iter().zip(self.known.iter().copied())
    }

    /// Reactions of the federate's current tag may run that have a lower level than this; `None`: all of them may.
    pub fn max_level(&self, federate: &Federate<'_, impl Needs>) -> Option<u16> {
        let current = federate.current();
        if federate.knows_all_inputs() {
            return None;
        }
        let inputs = self.inputs.iter().zip(&*self.known);
        inputs.filter(|(_, known)| **known < current).map(|(input, _)| input.level).min()
    }
}
