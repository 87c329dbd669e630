// SPDX-License-Identifier: Apache-2.0
//! The tags of a federate that joins late or leaves early, or whose senders do.

use lf_coordination::federate::{Needs, Phase};
use lf_coordination::{FederateId, to_wire};
use lf_model::time::{Instant, Tag};
use lf_model::{NetworkOutput, SendError};
use lf_wire::Message;

use super::execution::{Execution, Outlet as _};
use super::output::Output;
use crate::platform::Platform;

impl<N: Needs> Execution<'_, '_, N> {
    /// Joins the running federation, which has started at this physical time, with this tag.
    pub(super) fn join(&mut self, start: Instant, first: Tag) {
        log::debug!("this federate joins at {first}");
        self.engine.join(start, first);
        self.has_joined = true;
        self.limit_stop();
        if N::AWAITED && self.is_decentralized() {
            let inputs = self.engine.tables().inputs;
            self.awaited.start(first, |port| inputs.get(usize::from(port)).and_then(|input| input.delay));
        }
    }

    /// Returns whether this federate has joined a federation with decentralized coordination since the last call.
    pub(super) fn take_joined(&mut self) -> bool {
        core::mem::take(&mut self.has_joined) && self.is_decentralized()
    }

    /// Returns the execution in which transient federates upstream are absent, until they come.
    pub(super) fn prepared(mut self) -> Self {
        if N::AWAITED && N::TRANSIENTS {
            for (port, input) in (0..).zip(self.engine.tables().inputs) {
                if self.machine.may_be_absent(FederateId(input.federate)) {
                    self.awaited.learn(port, Tag::FOREVER);
                }
            }
        }
        self
    }

    /// Handles that a transient federate upstream has come: its first tag is later than all that have been granted.
    /// With decentralized coordination, a message before the open tag or the last one would be late in any case.
    pub(super) fn upstream_comes(&mut self, federate: u16) {
        let known = if self.is_decentralized() {
            self.engine.current_tag()
        } else {
            let provisional = self.machine.granted_provisionally().unwrap_or(Tag::NEVER);
            self.machine.granted().max(provisional)
        };
        for (port, input) in (0..).zip(self.engine.tables().inputs) {
            if input.federate == federate {
                self.awaited.forget(port, known);
            }
        }
    }

    /// Stops this federate alone, as soon as it can: at the next microstep. It sends nothing there if it has announced
    /// a later event, because others rely on that. With decentralized coordination it is the physical time instead,
    /// because what it sends at an earlier tag would come too late.
    ///
    /// One that has not begun its first tag leaves at once, and none of its reactions runs: others may be slow, and it
    /// has nothing to end.
    pub(super) fn stop_alone(&mut self, now: Instant) {
        if self.phase() == Phase::Running && !self.machine.misses(self.engine.current_tag()) {
            let earliest = if self.is_decentralized() { Tag::at(self.physical(now)) } else { Tag::NEVER };
            self.engine.stop_alone(earliest);
            self.silent |= self.machine.has_announced_beyond(self.engine.stop_tag());
        } else {
            self.finish();
        }
    }

    /// Tells those who may wait for this federate at a tag before its first one that nothing comes, as far as there is
    /// room. They are there provisionally, in a cycle without delay, and learn it from nobody else.
    pub(super) fn pass<P: Platform>(&mut self, output: &mut Output<'_, '_, '_, P, N>) {
        let Some((at, told)) = self.passed.take() else { return };
        let outputs = self.engine.tables().outputs.iter().enumerate().skip(told);
        for (number, NetworkOutput { port, federate, delay, .. }) in outputs.filter(|(_, to)| to.tells_absence) {
            let tag = to_wire(at.delayed(*delay));
            let absent = Message::PortAbsent { port: *port, federate: *federate, tag };
            if output.send_control(&absent).is_err() {
                self.passed = Some((at, number));
                return;
            }
        }
    }

    /// Returns whether this federate has only its states to hand over before it leaves.
    pub(super) fn hands_over(&self) -> bool {
        self.handed_over.is_some()
    }

    /// Hands over the states for which there is room, and leaves after the last one. A state that has no form as bytes
    /// is lost, and the others are not.
    pub(super) fn hand_over<P: Platform>(&mut self, output: &mut Output<'_, '_, '_, P, N>, federate: u16) {
        let (tag, states) = (to_wire(self.engine.current_tag()), self.engine.tables().handed_over);
        while let Some(number) = self.handed_over
            && let Some(state) = states.get(usize::from(number))
        {
            let program = &*self.program;
            match output.hand_over(state, federate, tag, |bytes| program.hand_over(number, bytes)) {
                Err(SendError::NoRoom) => return,
                Err(SendError::Payload(error)) => log::error!("`{}` is not handed over: {error}", state.name),
                Ok(()) => {}
            }
            self.handed_over = Some(number + 1);
        }
        self.machine.finish();
    }

    /// Takes over a state of the instance that this one replaces. Another build of the program may not have it, or may
    /// have it with other values; then its initial value stays.
    pub(super) fn take_over(&mut self, bytes: &[u8]) {
        // LF's RTI returns what this federate has handed over itself.
        if self.hands_over() || self.machine.start_time().is_some() {
            return;
        }
        let found = bytes.split_first_chunk().and_then(|(id, value)| {
            let id = u64::from_le_bytes(*id);
            let mut states = (0..).zip(self.engine.tables().handed_over);
            states.find(|(_, state)| state.id == id).map(|(number, state)| (number, state, value))
        });
        let Some((number, state, value)) = found else {
            log::warn!("the instance that this one replaces hands over a state which this one does not have");
            return;
        };
        match self.program.take_over(number, value) {
            Ok(()) => log::debug!("takes over `{}`", state.name),
            Err(error) => log::warn!("`{}` is not taken over: {error}", state.name),
        }
    }

    /// Handles that messages of a federate are held, of which `first_held` returns the first tag for an input: nothing
    /// earlier follows.
    pub(super) fn learn_of_held(&mut self, from: u16, first_held: impl Fn(u16) -> Option<Tag>) {
        for (port, _) in self.direct_inputs(from).filter(|(_, is_physical)| !is_physical) {
            if let Some(tag) = first_held(port).filter(|tag| tag.is_finite()) {
                self.awaited.learn(port, tag.before());
            }
        }
    }
}
