// SPDX-License-Identifier: Apache-2.0
//! The recordings of an image's participants, in rings of `CONFIG_LF_TRACE_RECORDS` records in static memory.
//!
//! The image prints a ring to the console when its participant has ended, for any reason: a line for the header and
//! each record, `lf-trace WHO` and 64 hexadecimal digits, and at last `lf-trace WHO end`. `lfz trace` finds them in
//! logs.

use core::cell::RefCell;
use core::fmt;

use critical_section::Mutex;
use lf_model::Outside;
use lf_model::time::Instant;
use lf_runtime::trace::{Event, Header, RECORD_BYTES, Record, Recorder, Ring, Role};

use crate::kconfig::LF_TRACE_RECORDS;
use crate::outside::ZephyrOutside;
use crate::recording::RecordedParticipant;
use crate::{clock, console};

struct Trace {
    header: Option<Header>,
    ring: Ring<LF_TRACE_RECORDS>,
}

type TraceCell = Mutex<RefCell<Trace>>;

static FEDERATE: TraceCell = Mutex::new(RefCell::new(Trace { header: None, ring: Ring::new() }));
#[cfg(CONFIG_LF_RTI)]
static RTI: TraceCell = Mutex::new(RefCell::new(Trace { header: None, ring: Ring::new() }));

/// Calls `then` with the trace of a participant, in a critical section.
fn with<T>(participant: RecordedParticipant, then: impl FnOnce(&mut Trace) -> T) -> T {
    let place = match participant {
        #[cfg(CONFIG_LF_RTI)]
        RecordedParticipant::Rti => &RTI,
        _ => &FEDERATE,
    };
    critical_section::with(|section| then(&mut place.borrow_ref_mut(section)))
}

impl Recorder for RecordedParticipant {
    fn record(&mut self, at: Instant, event: Event) {
        with(*self, |trace| match event {
            Event::Begins(header) => trace.header = Some(header),
            event => trace.ring.push(at, event),
        });
    }
}

/// Prints the recording of a participant, once.
pub(crate) fn print(participant: RecordedParticipant) {
    let Some(header) = with(participant, |trace| trace.header.take()) else { return };
    let role = RoleName(header.role);
    let line = |bytes: [u8; RECORD_BYTES]| console::print_line(format_args!("lf-trace {role} {}", Hexadecimal(bytes)));
    line(header.to_bytes());
    // The last correction of the clock may be lost. It applies to all records before the first kept correction.
    let (at, time) = (clock::now(), ZephyrOutside::of_program().physical_time());
    let mut clock = Some(Record { at, event: Event::Clock(time) });
    let mut index = 0;
    // One record at a time, so that interrupts stay enabled while a line is printed.
    while let Some(record) = with(participant, |trace| trace.ring.records().nth(index)).or_else(|| clock.take()) {
        line(record.to_bytes());
        index += 1;
    }
    console::print_line(format_args!("lf-trace {role} end"));
}

/// Prints the recordings of all participants.
pub(crate) fn print_all() {
    print(RecordedParticipant::Federate);
    #[cfg(CONFIG_LF_RTI)]
    print(RecordedParticipant::Rti);
}

/// The name of a participant in a line.
struct RoleName(Role);

impl fmt::Display for RoleName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Role::Federate(id) => write!(f, "{id}"),
            Role::Rti => f.write_str("rti"),
            Role::Program => f.write_str("program"),
        }
    }
}

/// Bytes as hexadecimal digits.
struct Hexadecimal([u8; RECORD_BYTES]);

impl fmt::Display for Hexadecimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}
