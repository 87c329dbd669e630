// SPDX-License-Identifier: Apache-2.0
//! What the event loop does with its connections to other federates.

use lf_coordination::federate::Phase;
use lf_model::{Engine, InputId};
use lf_wire::june_2026::Message;

use super::FederateLoop;
use crate::error::{PeerFault, RunError};
use crate::platform::Platform;

impl<P: Platform> FederateLoop<'_, '_, P> {
    /// Makes the connections to other federates, and takes those that come from them.
    pub(super) fn meet_peers(&mut self) -> Result<(), RunError> {
        self.peers.welcome(self.platform, self.federation_id, self.federation.peers_in);
        self.peers.look_for_ends(self.platform);
        let Some(index) = self.meeting.filter(|_| self.machine.phase() == Phase::Meeting) else { return Ok(()) };
        let introduction = Message::P2pSendingFedId { federate: self.federation.id, federation_id: self.federation_id };
        let outcome = self.peers.establish(self.platform, index, &introduction);
        let now = self.platform.now();
        if let Some(connected) = outcome {
            self.meeting = None;
            if connected {
                self.machine.peer_connected(now);
            } else {
                self.machine.peer_lost(now)?;
            }
        }
        Ok(())
    }

    /// Takes what other federates have sent, as far as there is room for it.
    pub(super) fn receive_directly(&mut self) -> Result<(), RunError> {
        self.peers.stale = false;
        if self.machine.phase() != Phase::Running {
            return Ok(());
        }
        for inbound in self.peers.inbound.iter_mut() {
            let Some(from) = inbound.from else { continue };
            inbound.fill(self.platform);
            let fault = |fault| RunError::Peer { federate: from.0, fault };
            loop {
                let next = inbound.input.next(&self.limits).map_err(|error| fault(PeerFault::Bytes(error)))?;
                let Some((message, length)) = next else { break };
                let Message::P2pMessage { port, federate, payload } = message else {
                    return Err(fault(PeerFault::Unexpected(message.name())));
                };
                if federate != self.federation.id || !is_from(&self.engine, port, from.0) {
                    return Err(fault(PeerFault::WrongInput { federate, port }));
                }
                if !self.engine.has_room(self.program, InputId(port)) {
                    break;
                }
                let now = self.machine.clock().physical(self.platform.now());
                self.engine.deliver_physical(self.program, InputId(port), now, payload)?;
                inbound.input.consume(length);
            }
            let is_whole = matches!(inbound.input.next(&self.limits), Ok(Some(_)));
            if inbound.has_ended() && !is_whole {
                inbound.close(self.platform);
            }
        }
        Ok(())
    }
}

/// Whether this input is the end of a physical connection from this federate.
fn is_from(engine: &Engine<'_>, port: u16, federate: u16) -> bool {
    let input = engine.tables().inputs.get(usize::from(port));
    input.is_some_and(|input| input.physical && input.federate == federate)
}
