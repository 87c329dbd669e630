// SPDX-License-Identifier: Apache-2.0
//! Direct messages between federates: delivered in time, and logged when they are too late.

#[cfg(feature = "transients")]
use lf_coordination::FederateId;
#[cfg(feature = "transients")]
use lf_coordination::federate::CONNECT_RETRY;
use lf_coordination::federate::{Needs, Phase};
use lf_model::InputId;
use lf_model::time::Instant;

use super::execution::{Execution, Failed};
use super::from_peer::FromPeer;
use super::late::Late;
use super::peers::{Outputs, Peers};
use crate::error::RunError;
use crate::log_event::{PeerEvent, report};
use crate::platform::Platform;
use crate::trace::Recording;
use log::Level;

/// The direct connections, and the messages that came too late over them.
#[derive(Debug)]
pub(super) struct Direct<'a, 's, N> {
    pub(super) peers: Peers<'a, 's, N>,
    late: Late,
    /// The id of this federate.
    id: u16,
}

impl<'a, 's, N: Needs> Direct<'a, 's, N> {
    /// Returns the state before the first message.
    pub(super) fn new(peers: Peers<'a, 's, N>, id: u16) -> Self {
        Self { peers, late: Late::default(), id }
    }

    /// Returns the number of messages that have come too late.
    pub(super) fn late_messages(&self) -> u64 {
        self.late.messages()
    }

    /// Returns the number of messages that are known not to have reached their receivers.
    pub(super) fn lost_messages(&self) -> u64 {
        self.peers.receivers().fold(0, |sum, (_, outbound)| sum.saturating_add(outbound.lost))
    }

    /// Makes the connections to other federates, and accepts theirs.
    pub(super) fn meet<P: Platform>(
        &mut self,
        platform: &mut P,
        execution: &mut Execution<'_, '_, N>,
    ) -> Result<(), Failed> {
        let machine = &mut execution.machine;
        self.peers.accept(platform, machine.phase() >= Phase::Running);
        self.peers.detect_ends(platform);
        #[cfg(feature = "transients")]
        self.meet_transients(platform, execution);
        let machine = &mut execution.machine;
        if machine.phase() != Phase::Meeting && !(N::TRANSIENTS && machine.phase() == Phase::Running) {
            return Ok(());
        }
        match self.peers.establish(platform) {
            None => {}
            Some(Ok(())) => machine.peer_connected(platform.now()),
            Some(Err((federate, fault))) => {
                log::debug!("federate {federate} {fault}");
                #[cfg(feature = "transients")]
                self.peers.look_again(federate, platform.now() + CONNECT_RETRY);
                machine.peer_lost(platform.now()).map_err(|_| execution.fail(RunError::Peer { federate, fault }))?;
            }
        }
        Ok(())
    }

    /// Notes which federates have connected to this one while the federation runs, and looks for one that has come to
    /// which this one sends.
    #[cfg(feature = "transients")]
    fn meet_transients<P: Platform>(&mut self, platform: &mut P, execution: &mut Execution<'_, '_, N>) {
        if !N::TRANSIENTS {
            return;
        }
        for inbound in self.peers.inbound().iter_mut().filter(|inbound| inbound.is_new) {
            inbound.is_new = false;
            let machine = &execution.machine;
            let may_come = |federate: &FederateId| machine.is_transient() || machine.may_be_absent(*federate);
            if let Some(federate) = inbound.from.filter(may_come) {
                log::debug!("federate {federate} has connected");
                execution.upstream_comes(federate.0);
            }
        }
        if execution.take_joined() {
            // They may have left before this federate came. They are waited for once they connect.
            for federate in self.peers.strangers() {
                execution.end_inputs(federate, |_| false);
            }
        }
        if execution.phase() == Phase::Running
            && let Some(federate) = self.peers.wanted(platform.now())
            && execution.machine.find_peer(federate)
            && let Some(outbound) = self.peers.to(federate.0)
        {
            outbound.look_again(None);
        }
    }

    /// Reads what other federates have sent, as far as a wait has reported it, and delivers what there is room for.
    pub(super) fn receive<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        execution: &mut Execution<'_, '_, N>,
    ) -> Result<(), Failed> {
        if takes_messages(execution) {
            for inbound in self.peers.inbound() {
                inbound.fill(platform);
            }
        }
        self.take(platform, recording, execution)
    }

    /// Does the same, though no wait has reported input. Returns `true` when there was some.
    pub(super) fn sweep<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        execution: &mut Execution<'_, '_, N>,
    ) -> Result<bool, Failed> {
        let mut any = false;
        if takes_messages(execution) {
            for inbound in self.peers.inbound() {
                any |= inbound.fill_now(platform);
            }
        }
        self.take(platform, recording, execution)?;
        Ok(any)
    }

    /// Delivers held messages that may have room now.
    pub(super) fn take_held<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        execution: &mut Execution<'_, '_, N>,
    ) -> Result<(), Failed> {
        if self.peers.take_stale() { self.take(platform, recording, execution) } else { Ok(()) }
    }

    /// Delivers messages as far as there is room; bounded by the sizes of the buffers.
    fn take<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        execution: &mut Execution<'_, '_, N>,
    ) -> Result<(), Failed> {
        self.peers.take_stale();
        if !takes_messages(execution) {
            return Ok(());
        }
        let (now, to) = (execution.physical(platform.now()), self.id);
        for inbound in self.peers.inbound() {
            let Some(from) = inbound.from else { continue };
            inbound.receiver.resume();
            let (platform, recording, late) = (&mut *platform, recording.reborrow(), &mut self.late);
            let physical_over = &mut inbound.physical_over;
            let mut policy = FromPeer { platform, recording, execution, late, from: from.0, to, physical_over, now };
            while inbound.receiver.next(&mut policy)?.is_some() {}
            let tables = execution.engine.tables();
            let first_held =
                |input| inbound.receiver.first_held::<FromPeer<'_, '_, '_, P, N>>(tables.port_of(InputId(input)));
            // Messages that its earlier incarnation has sent may fill the queue: only their tags make room.
            #[cfg(feature = "transients")]
            if N::TRANSIENTS && inbound.receiver.held.bytes > 0 && execution.machine.may_be_absent(from) {
                execution.learn_of_held(from.0, first_held);
            }
            if !inbound.has_ended() {
                continue;
            }
            let is_held = |input| first_held(input).is_some();
            // A federate of this project says so when it ends in order.
            if !execution.is_over(from.0, inbound.physical_over, is_held) && !execution.machine.has_left(from) {
                continue;
            }
            // A tag that makes room for held messages may have to wait for the other inputs.
            execution.end_inputs(from.0, is_held);
            if inbound.receiver.held.bytes == 0 {
                log::debug!("federate {from} has left");
                if !inbound.receiver.rest().is_empty() {
                    report(Level::Warn, &PeerEvent::LeftInMessage(from.0));
                }
                inbound.close(platform);
            }
        }
        Ok(())
    }

    /// Returns the input of the held messages if this federate and a sender deadlock: the receive buffer is full of
    /// messages without room, and only behind them can come a message or an absence for another input, for which this
    /// federate waits without end.
    pub(super) fn deadlocked_input(&mut self, execution: &Execution<'_, '_, N>) -> Option<InputId> {
        self.peers.inbound().iter_mut().find_map(|inbound| {
            let (from, input) = (inbound.from?, inbound.receiver.full_input()?);
            execution.deadlocks_with(from.0).then_some(input)
        })
    }

    /// In the last tag, sends the end of connections with a delay: what is sent now would come after that tag. The
    /// receivers need not wait for the end of this federate, which may have to wait for them.
    pub(super) fn send_ends<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        execution: &Execution<'_, '_, N>,
    ) {
        if execution.is_decentralized() && execution.has_sent_all() {
            self.peers.send_ends(platform, recording, &outputs(execution), false);
        }
    }

    /// Sends other federates what is still pending, and closes the connections to them. A federate that has `resigned`
    /// sends the end of each connection first. With decentralized coordination it also reads the messages of others
    /// until they end too: what comes now is late. Returns `false` when nothing is left to do.
    pub(super) fn leave<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        execution: &mut Execution<'_, '_, N>,
        (resigned, may_hear): (bool, bool),
        until: Instant,
    ) -> bool {
        let in_time = platform.now() < until;
        let ends = resigned.then(|| outputs(execution));
        let hears = may_hear && self.drain(platform, recording, execution, in_time);
        let sends = self.peers.leave(platform, recording, ends.as_ref(), hears) && in_time;
        if !hears && !sends {
            self.peers.close(platform);
        }
        hears || sends
    }

    /// Reads once what other federates send at their end. Returns `true` while more can come, and there is time.
    fn drain<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        execution: &mut Execution<'_, '_, N>,
        in_time: bool,
    ) -> bool {
        let _ = self.sweep(platform, recording, execution);
        if let Some(error) = execution.failure.take() {
            report(Level::Warn, &PeerEvent::LastMessages(error));
            return false;
        }
        if !in_time {
            for from in self.peers.senders() {
                report(Level::Warn, &PeerEvent::DoesNotEnd(from.0));
            }
        }
        in_time && self.peers.senders().next().is_some()
    }

    /// Logs the number of messages that have come too late or were lost.
    pub(super) fn report_losses(&self, execution: &Execution<'_, '_, N>) {
        if !execution.is_decentralized() {
            return;
        }
        self.late.sum_up();
        for (to, outbound) in self.peers.receivers().filter(|(to, _)| !self.peers.may_be_absent(*to)) {
            if outbound.lost > 0 {
                report(Level::Warn, &PeerEvent::Lost { messages: outbound.lost, to });
            } else if outbound.left_early {
                report(Level::Warn, &PeerEvent::LeftBefore(to));
            }
        }
    }
}

/// Returns the outputs of a federate.
fn outputs(execution: &Execution<'_, '_, impl Needs>) -> Outputs {
    Outputs::new(execution.engine.tables().outputs, execution.is_decentralized())
}

/// Returns whether messages of other federates can be delivered. After its end a federate still looks for late ones.
fn takes_messages<N: Needs>(execution: &Execution<'_, '_, N>) -> bool {
    match execution.phase() {
        Phase::Running => N::PEERS_IN,
        Phase::Resigning | Phase::Ended => N::PEERS_IN && execution.is_decentralized(),
        _ => false,
    }
}
