// SPDX-License-Identifier: Apache-2.0
//! Messages that come after their tag, and the reactions that see them.
use super::Engine;
use crate::cell::Placed;
use crate::error::DeliverError;
use crate::program::Program;
use crate::state::Last;
use crate::tables::{InputId, PortId, TriggerId};
use crate::time::{Instant, Tag};

/// The outcome of a message that may have come too late.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// It is in time, and takes effect at this tag.
    InTime(Tag),
    /// It is tardy, and takes effect at this tag.
    Tardy(Tag),
    /// It is for after the last tag of the program, and has no effect.
    AfterStop,
    /// It has come so late that the last tag of the program is too early for it, and has no effect.
    Lost,
}

impl Engine<'_> {
    /// Takes a message for an input with [`NetworkInput::tardy`](crate::NetworkInput::tardy).
    ///
    /// One that is in time is taken as by [`deliver`](Self::deliver). A late one takes effect at the next microstep, or
    /// after the messages in the input's queue, and the reactions that see it are marked.
    ///
    /// # Errors
    /// [`DeliverError::Full`] asks to wait, and to try again with the same message; the others are fatal.
    pub fn deliver_tardy(
        &mut self,
        program: &mut dyn Program,
        input: InputId,
        intended: Tag,
        bytes: &[u8],
    ) -> Result<Delivery, DeliverError> {
        let info = self.tables.inputs.get(usize::from(input.0)).ok_or(DeliverError::NoSuchPort { port: input.0 })?;
        let (current, stop) = (self.state.current, self.state.stop);
        if intended > stop || intended.time == Instant::FOREVER {
            return Ok(Delivery::AfterStop);
        }
        let can_see = self.is_in_tag() && self.state.untouched <= info.level && !self.is_filled(info.trigger);
        let is_open = |tag: Tag| tag == current && can_see;
        let last = self.last[usize::from(input.0)];
        let follows = last.happens.next_microstep();
        let (tag, meant) = if last.sent == intended && (follows > current || is_open(follows)) {
            // A second message for one tag takes effect a microstep later, and is in time until that has begun without
            // it.
            (follows, follows)
        } else if intended > current || is_open(intended) {
            (intended, intended)
        } else {
            (current.next_microstep().max(Tag::at(self.state.start)), intended)
        };
        if tag > stop || self.is_done() {
            return Ok(Delivery::Lost);
        }
        let placed = program.deliver_tardy(input, tag, meant, bytes);
        let Placed { tag, tardy } = placed.map_err(|error| error.at(info.name, input.0))?;
        if !tardy {
            self.last[usize::from(input.0)] = Last { sent: intended, happens: tag };
        }
        if tag == current {
            self.activate(program, info.trigger);
        } else {
            let pending = program.trigger(info.trigger).and_then(|cell| cell.pending());
            self.events.set(info.trigger, pending);
        }
        Ok(match tardy {
            _ if tag > stop => Delivery::Lost,
            true => Delivery::Tardy(tag),
            false => Delivery::InTime(tag),
        })
    }

    /// Marks the reactions that see a value which a trigger has just put into its port, if it is tardy.
    pub(super) fn note_tardy(&mut self, program: &mut dyn Program, id: TriggerId, port: PortId) {
        let Some(intended) = program.trigger(id).and_then(|cell| cell.intended()) else { return };
        let mut inputs = self.tables.inputs.iter().zip(&mut *self.tardy.intended);
        let Some((input, place)) = inputs.find(|(input, _)| input.trigger == id) else { return };
        *place = intended;
        self.tardy.reactions.insert_reactions(self.tables.ports[usize::from(port.0)].reactions);
        self.tardy.reactions.insert_reactions(input.readers);
    }
}
