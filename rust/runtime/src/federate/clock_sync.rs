// SPDX-License-Identifier: Apache-2.0
//! Clock synchronization of a federate over UDP. Before the start it is among the messages of the session.

use core::mem::replace;

use lf_coordination::clock_sync::{ClockCorrection, ClockFault};
use lf_coordination::federate::{ClockSync, Federate, Needs};

use crate::datagram::{DatagramPort, send};
use crate::log_event::{FederateEvent, report};
use crate::platform::{NetError, Platform};
use crate::trace::{Event, RTI, Recording};
use log::Level;

/// The port for datagrams of the RTI.
#[derive(Debug, Default)]
pub(super) struct ClockSyncPort {
    pub(super) port: DatagramPort,
    /// Whether strangers have been logged.
    stranger: bool,
    /// The kinds of clock fault that have been logged, by their bits.
    faults: u8,
}

impl ClockSyncPort {
    /// Opens a port, if a federate takes part in rounds over UDP; returns its number.
    pub(super) fn open<P: Platform>(platform: &mut P, clock_sync: ClockSync) -> Result<(Self, Option<u16>), NetError> {
        let ClockSync::On { .. } = clock_sync else { return Ok((Self::default(), None)) };
        if !P::DATAGRAMS {
            report(Level::Warn, &FederateEvent::NoDatagrams);
            return Ok((Self::default(), None));
        }
        let socket = platform.bind(0)?;
        let number = platform.local_port(socket)?;
        Ok((Self { port: DatagramPort::new(platform, Some(socket)), ..Self::default() }, Some(number)))
    }

    /// Reads the datagrams that have come, a bounded number of them, and answers them.
    pub(super) fn synchronize<P: Platform>(
        &mut self,
        platform: &mut P,
        recording: &mut Recording<'_>,
        machine: &mut Federate<'_, impl Needs>,
    ) {
        if !P::DATAGRAMS {
            return;
        }
        let Self { port, stranger, faults } = self;
        port.receive(platform, |platform, socket, now, from, datagram| {
            let heard = machine.handle_datagram(now, from, datagram);
            if let Some(answer) = heard.answer {
                let now = platform.now();
                machine.answer_leaves(now);
                send(platform, socket, from, &answer);
            }
            // Only now, because the times of these messages count.
            if recording.is_on() {
                recording.note_bytes(now, datagram, RTI);
                if let Some(answer) = heard.answer {
                    recording.note_sent(platform, &answer, RTI);
                }
            }
            if heard.corrected {
                set_correction(platform, recording, machine.clock());
            }
            if heard.stranger && !replace(stranger, true) {
                report(Level::Warn, &FederateEvent::Stranger(from));
            }
            if let Some(fault) = heard.fault {
                let kind = match fault {
                    ClockFault::Drift(_) => 1,
                    ClockFault::Unsteady(_) => 2,
                    ClockFault::OtherPort { .. } => 4,
                    ClockFault::FarOff(_) => 8,
                };
                let told = *faults;
                if replace(faults, told | kind) & kind == 0 {
                    report(Level::Warn, &FederateEvent::ClockFault(fault));
                }
            }
        });
    }

    /// Ends clock synchronization, and logs its results.
    pub(super) fn end<P: Platform>(&mut self, platform: &mut P, machine: &Federate<'_, impl Needs>) {
        if !P::DATAGRAMS {
            return;
        }
        self.port.close(platform);
        if let Some(results) = machine.clock_sync_report() {
            report(Level::Info, &FederateEvent::ClockSync(results));
        }
    }
}

/// Sets the correction of the platform's clock, and records what it shows from now on.
pub(super) fn set_correction(platform: &mut impl Platform, recording: &mut Recording<'_>, correction: ClockCorrection) {
    platform.set_correction(correction);
    if recording.is_on() {
        let now = platform.now();
        recording.note_at(now, Event::Clock(correction.physical(now)));
    }
}
