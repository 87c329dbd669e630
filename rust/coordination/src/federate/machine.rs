// SPDX-License-Identifier: Apache-2.0
//! The state of a federate, and what its event loop calls.

use lf_model::time::{Instant, Tag};
use lf_wire::{Message, RejectCode};

use super::config::{Config, Coordination};
use super::error::{ConfigError, FederateError};
use super::event::{Disconnected, Event};
use super::handshake::Synchronization;
use super::net_rules::NetRules;
use super::outbox::Outbox;
use super::pace::Pace;
use super::peers::Meeting;
use super::phase::Phase;
use super::stop::Stop;
use crate::Deadline;
use crate::auth::Nonce;
use crate::clock_sync::{ClockCorrection, Responder, Tracker};

/// One federate; see the module's description for how to drive it.
#[derive(Clone, Debug)]
pub struct Federate<'a> {
    pub(super) config: Config<'a>,
    pub(super) phase: Phase,
    pub(super) outbox: Outbox,
    /// What the RTI has to authenticate.
    pub(super) nonce: Nonce,
    pub(super) sync: Synchronization,
    pub(super) meeting: Meeting,
    pub(super) clock: ClockCorrection,
    pub(super) responder: Responder,
    pub(super) tracker: Tracker,
    /// When to give up waiting for the RTI, before the start.
    pub(super) patience: Deadline,
    pub(super) start: Option<Instant>,
    pub(super) net: NetRules,
    pub(super) pace: Pace,
    /// The last PTAG.
    pub(super) provisional: Option<Tag>,
    /// The PTAG that this federate has not followed yet.
    pub(super) summons: Option<Tag>,
    /// The tag from which on grants have been taken back, until it is confirmed that all before it is complete.
    pub(super) taken_back: Option<Tag>,
    /// The RTI is to be told when the open tag is complete, for it has been granted by a PTAG.
    pub(super) confirm: bool,
    /// The last LTC.
    pub(super) confirmed: Tag,
    pub(super) stop: Stop,
    /// The last tag begun.
    pub(super) current: Tag,
    /// Whether it has not been completed.
    pub(super) open: bool,
    /// The next event, as last told and not begun since.
    pub(super) next: Option<Tag>,
    /// When the bound of the NET by physical time is to be renewed.
    pub(super) renewal: Deadline,
    /// When what was left out is to be told, because others may need it after all.
    pub(super) silence: Deadline,
    /// Something outside of the program can cause physical actions.
    pub(super) has_physical_sources: bool,
}

impl<'a> Federate<'a> {
    /// A federate that has not connected.
    ///
    /// # Errors
    /// When no federate can work with this configuration.
    pub fn new(config: Config<'a>) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            phase: Phase::Disconnected,
            outbox: Outbox::default(),
            nonce: Nonce::default(),
            sync: Synchronization::new(),
            meeting: Meeting::default(),
            clock: ClockCorrection::with_offset(config.test_offset),
            responder: Responder::new(),
            tracker: Tracker::new(),
            patience: Deadline::Never,
            start: None,
            net: match config.coordination {
                Coordination::Centralized => NetRules::new(!config.upstream.is_empty(), !config.downstream.is_empty()),
                Coordination::Decentralized => NetRules::new(false, false),
            },
            pace: Pace::default(),
            provisional: None,
            summons: None,
            taken_back: None,
            confirm: false,
            confirmed: Tag::NEVER,
            stop: Stop::new(),
            current: Tag::NEVER,
            open: false,
            next: None,
            renewal: Deadline::Never,
            silence: Deadline::Never,
            has_physical_sources: true,
            config,
        })
    }

    /// How tags are kept in order.
    pub fn coordination(&self) -> Coordination {
        self.config.coordination
    }

    /// Where this federate is.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// From this participant's own clock to the federation's physical time.
    ///
    /// It makes one step, with [`Event::ClockCorrected`], before the start. Afterwards only its rate changes, with
    /// [`Received::corrected`](super::Received::corrected).
    pub fn clock(&self) -> ClockCorrection {
        self.clock
    }

    /// The physical time at which logical time begins; `None` before [`Event::Started`].
    pub fn start_time(&self) -> Option<Instant> {
        self.start
    }

    /// The last tag that the RTI has granted; `NEVER` before the first grant. A provisional grant counts as one of all
    /// that is before its tag.
    pub fn granted(&self) -> Tag {
        self.net.granted()
    }

    /// When something is likely to come, on the participant's own clock: what the RTI grants ends just before the
    /// earliest event of those upstream, as far as their connections have no delay.
    pub fn next_arrival(&self) -> Deadline {
        match self.net.granted().time {
            Instant::NEVER | Instant::FOREVER => Deadline::Never,
            time => Deadline::At(self.clock.local(time)),
        }
    }

    /// The last provisional grant, if it is later than [`Federate::granted`].
    pub fn granted_provisionally(&self) -> Option<Tag> {
        self.provisional.filter(|tag| *tag > self.net.granted())
    }

    /// The last tag that was begun; `NEVER` before the first.
    pub fn current(&self) -> Tag {
        self.current
    }

    /// The tag to which a PTAG calls this federate, though it may have no event there: to be begun when no event is
    /// earlier. Others of its cycle wait for what it sends at that tag, or for word that there is nothing.
    pub fn summons(&self) -> Option<Tag> {
        self.summons.filter(|tag| *tag > self.current && *tag <= self.stop.last_tag())
    }

    /// Whether it is known of all inputs what comes at the current tag.
    pub(super) fn knows_all_inputs(&self) -> bool {
        self.net.allows(self.current)
    }

    /// Whether this tag may be begun now, as far as the federation is concerned.
    ///
    /// Physical time is not looked at. A federate that has sent much must also wait until the RTI has taken it.
    pub fn may_advance(&self, tag: Tag) -> bool {
        self.phase == Phase::Running
            && tag > self.current
            && self.stop.allows(tag)
            && (self.net.allows(tag) || self.provisional == Some(tag))
            && self.pace.allows()
    }

    /// The tag at which the whole federation stops; `None` before [`Event::StopGranted`].
    pub fn stop_tag(&self) -> Option<Tag> {
        self.stop.granted()
    }

    /// Whether this federate has named a tag to stop at, and the RTI has not decided.
    pub fn awaits_stop_tag(&self) -> bool {
        self.stop.is_open()
    }

    /// Whether a message with this tag may be sent: not after this federate's last tag, for nobody will get there.
    pub fn may_send(&self, tag: Tag) -> bool {
        tag <= self.stop.last_tag()
    }

    /// The connection to the RTI is there.
    ///
    /// With [`Config::authentication`], `nonce` has to be unpredictable and new for each connection; otherwise it is
    /// not used. Ignored when the RTI has accepted this federate before: it cannot come back to the federation.
    pub fn handle_connected(&mut self, now: Instant, nonce: Nonce) {
        if matches!(self.phase, Phase::Disconnected | Phase::Authenticating | Phase::Introducing) {
            self.introduce(now, nonce);
        }
    }

    /// A message from the RTI has come.
    ///
    /// `now` is the time at which its last byte was read; the clock synchronization is as good as it is.
    ///
    /// # Errors
    /// Why this federate cannot go on. It has then failed, and FAILED is to be sent where that is of use.
    pub fn handle_message<'m>(&mut self, now: Instant, message: Message<'m>) -> Result<Event<'m>, FederateError> {
        let result = match self.phase {
            Phase::Disconnected => Err(self.unexpected(&message)),
            Phase::Authenticating | Phase::Introducing | Phase::Synchronizing | Phase::Meeting | Phase::Starting => {
                self.handle_early(now, &message)
            }
            Phase::Running => self.handle_running(message),
            // The RTI may not know yet that this federate has ended.
            Phase::Resigning | Phase::Ended | Phase::Failed => Ok(Event::None),
        };
        result.map_err(|error| self.fail_with(error))
    }

    /// The connection to the RTI has ended, or broken.
    ///
    /// # Errors
    /// When this federate still needed it.
    pub fn handle_disconnected(&mut self) -> Result<Disconnected, FederateError> {
        match self.phase {
            Phase::Disconnected | Phase::Authenticating | Phase::Introducing => {
                self.phase = Phase::Disconnected;
                self.outbox.clear();
                self.patience = Deadline::Never;
                Ok(Disconnected::ConnectAgain)
            }
            Phase::Synchronizing | Phase::Meeting | Phase::Starting | Phase::Running | Phase::Resigning => {
                Err(self.fail_with(FederateError::RtiLost { phase: self.phase }))
            }
            Phase::Ended | Phase::Failed => {
                self.outbox.clear();
                Ok(Disconnected::Ended)
            }
        }
    }

    /// The time that [`Federate::poll_timeout`] named has come. Harmless at any other time.
    ///
    /// # Errors
    /// When the RTI has let this federate wait too long.
    pub fn handle_timeout(&mut self, now: Instant) -> Result<Event<'static>, FederateError> {
        if self.renewal.is_due(now) {
            self.announce(now);
        }
        if self.silence.is_due(now) {
            self.silence = Deadline::Never;
            self.net.break_silence();
        }
        if self.patience.is_due(now) {
            return self.lose_patience(now).map_err(|error| self.fail_with(error));
        }
        Ok(Event::None)
    }

    /// The next message for the RTI that is due and no longer than `room` bytes; `None` when there is none, or no room.
    ///
    /// After at most seventeen calls without an event or command in between, `None` comes.
    pub fn poll_transmit(&mut self, room: usize) -> Option<Message<'a>> {
        let message = self.next_transmit().filter(|message| message.encoded_len() <= room)?;
        self.outbox.remove(&message);
        match message {
            Message::NextEventTag(_) => self.net.transmitted(),
            Message::AddressQuery { .. } if self.phase == Phase::Running => self.pace.asked(),
            Message::T3 { .. } => self.sync.t3_leaves(),
            Message::Resign => self.phase = Phase::Ended,
            _ => {}
        }
        Some(message)
    }

    /// Whether [`Federate::poll_transmit`] has a message, given room.
    pub fn has_transmit(&self) -> bool {
        self.next_transmit().is_some()
    }

    /// All that [`Federate::poll_transmit`] gave has been written to the socket; `now` is the time after that.
    pub fn handle_written(&mut self, now: Instant) {
        self.sync.written(now);
    }

    /// When [`Federate::handle_timeout`] is to be called, by this participant's own clock.
    pub fn poll_timeout(&self) -> Deadline {
        self.patience.min(self.renewal).min(self.silence)
    }

    /// This federate ends because of an error of its own: FAILED is sent instead of RESIGN.
    ///
    /// Without effect once it has ended.
    pub fn fail(&mut self) {
        if !matches!(self.phase, Phase::Ended | Phase::Failed) {
            self.end_failed(self.phase != Phase::Disconnected);
        }
    }

    fn next_transmit(&self) -> Option<Message<'a>> {
        // Once failed, a federate has nothing to promise.
        let net = if self.phase == Phase::Failed { None } else { self.net.due() };
        let message = self.outbox.next(&self.config, net);
        // Last, so that it stands behind all that it is to tell of.
        let query = || Message::AddressQuery { federate: self.config.id.0 };
        message.or_else(|| (self.phase == Phase::Running && self.pace.is_question_due()).then(query))
    }

    pub(super) fn unexpected(&self, message: &Message<'_>) -> FederateError {
        FederateError::Unexpected { message: message.name(), phase: self.phase }
    }

    /// Notes that this federate cannot go on. Gives the error back.
    fn fail_with(&mut self, error: FederateError) -> FederateError {
        // Whoever rejected this federate does not know it, and who is gone does not hear it.
        let tell = !matches!(error, FederateError::Rejected(_) | FederateError::RtiLost { .. });
        self.end_failed(tell && self.phase != Phase::Disconnected);
        if error == FederateError::RtiNotAuthentic {
            self.outbox.reject = Some(RejectCode::HmacMismatch);
        }
        error
    }

    fn end_failed(&mut self, tell: bool) {
        if self.phase == Phase::Ended {
            // The RTI has been told already that this federate has ended in order.
            return;
        }
        self.phase = Phase::Failed;
        self.patience = Deadline::Never;
        self.renewal = Deadline::Never;
        self.silence = Deadline::Never;
        self.outbox.clear();
        self.outbox.failed = tell;
    }

    /// `fail_with` for the commands of `running.rs`.
    pub(super) fn refuse<T>(&mut self, error: FederateError) -> Result<T, FederateError> {
        Err(self.fail_with(error))
    }
}
