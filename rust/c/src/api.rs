// SPDX-License-Identifier: Apache-2.0
//! The functions of the bodies' API that are not in C itself. `include/lf.h` documents them.
use core::ffi::{c_char, c_int, c_void};
use core::time::Duration;

use lf_model::{Instant, Interval, ModeId, Offset, PhysicalActionRef, PhysicalLink, PortId, Transition, TriggerId};

use crate::ffi::{
    RawModeChange, RawTag, RawToken, lf_c_port_has_type, lf_c_trigger_has_type, lf_miss_deadline, lf_print_error,
    lf_print_warning,
};
use crate::running::{
    Program, change_deadline, deadline_of, federation_id, first_tag, is_late, last_tag, mark_present, physical_time,
    program, with_running,
};
use crate::token::Token;

// --- Times and tags ---

#[unsafe(no_mangle)]
extern "C" fn lf_c_tag() -> RawTag {
    with_running(|running| running.ctx.current_tag()).unwrap_or_else(last_tag).into()
}

#[unsafe(no_mangle)]
extern "C" fn lf_time_start() -> i64 {
    program().map_or(Instant::NEVER, |program| program.start).as_nanos()
}

#[unsafe(no_mangle)]
extern "C" fn lf_time_physical() -> i64 {
    physical_time().as_nanos()
}

#[unsafe(no_mangle)]
extern "C" fn lf_tag_start_effective() -> RawTag {
    first_tag().into()
}

#[unsafe(no_mangle)]
extern "C" fn lf_get_federation_id() -> *const c_char {
    federation_id().as_ptr()
}

// --- Ports, modes, deadlines, the end ---

#[unsafe(no_mangle)]
extern "C" fn lf_c_mark_present(running: *mut c_void, port: u16) -> RawTag {
    // SAFETY: C passes what it has now for this thread.
    let tag = unsafe { mark_present(running, PortId(port)) }.unwrap_or_else(|| {
        error(c"a port can be set in reactions only, and not in other threads");
        last_tag()
    });
    tag.into()
}

#[unsafe(no_mangle)]
extern "C" fn lf_set_mode(change: RawModeChange) {
    let mode = ModeId(change.mode);
    let transition = if change.history { Transition::history(mode) } else { Transition::reset(mode) };
    if with_running(|running| running.ctx.set_mode(transition)).is_none() {
        error(c"lf_set_mode: a mode can be set in reactions only, and not in other threads");
    }
}

#[unsafe(no_mangle)]
extern "C" fn lf_c_check_deadline(handle: bool) -> bool {
    let late = with_running(|running| {
        let deadline = deadline_of(running.reaction, running.ctx)?;
        is_late(running.ctx, deadline).then_some(running.reaction)
    });
    let Some(reaction) = late.flatten() else { return false };
    if handle {
        lf_miss_deadline(reaction.0);
    }
    true
}

#[unsafe(no_mangle)]
extern "C" fn lf_c_update_deadline(deadline: i64) {
    let changed = with_running(|running| {
        let has_one = deadline_of(running.reaction, running.ctx).is_some();
        has_one.then(|| change_deadline(running.reaction, Interval::from_nanos(deadline)))
    });
    match changed.flatten() {
        Some(Ok(())) => {}
        Some(Err(most)) => {
            // SAFETY: the format has a size_t.
            unsafe {
                lf_print_error(c"lf_update_deadline: %zu reactions have changed theirs, which is all".as_ptr(), most);
            }
        }
        None => error(c"lf_update_deadline: there is no reaction here that has a deadline"),
    }
}

#[unsafe(no_mangle)]
extern "C" fn lf_get_fed_maxwait() -> i64 {
    with_running(|running| running.ctx.max_wait()).unwrap_or_default().as_nanos()
}

#[unsafe(no_mangle)]
extern "C" fn lf_set_fed_maxwait(max_wait: i64) {
    if with_running(|running| running.ctx.set_max_wait(Interval::from_nanos(max_wait))).is_none() {
        error(c"lf_set_fed_maxwait: it can be set in reactions only, and not in other threads");
    }
}

#[unsafe(no_mangle)]
extern "C" fn lf_request_stop() {
    request_stop(Offset::Asap);
}

#[unsafe(no_mangle)]
extern "C" fn lf_c_request_stop_after(offset: i64) {
    request_stop(match u64::try_from(offset) {
        Ok(ns) if ns > 0 => Offset::After(Duration::from_nanos(ns)),
        _ => Offset::Asap,
    });
}

#[unsafe(no_mangle)]
extern "C" fn lf_stop() {
    if with_running(|running| running.ctx.stop()).is_none() {
        error(c"lf_stop: a program can be stopped alone in reactions only, and not in other threads");
    }
}

fn request_stop(offset: Offset) {
    if with_running(|running| running.ctx.request_stop(offset)).is_some() {
        return;
    }
    match program() {
        Some(program) => link(&program).request_stop(offset),
        None => error(c"lf_request_stop: the program has not started"),
    }
}

// --- Watchdogs ---

#[unsafe(no_mangle)]
extern "C" fn lf_c_watchdog_start(trigger: u16, additional: i64) {
    let additional = Interval::from_nanos(additional).to_duration();
    let started = with_running(|running| {
        let watchdog = running.program.watchdog(TriggerId(trigger))?;
        running.ctx.start_watchdog(watchdog, additional);
        Some(())
    });
    if started.flatten().is_none() {
        error(c"lf_watchdog_start: a watchdog can be started in reactions only, and not in other threads");
    }
}

#[unsafe(no_mangle)]
extern "C" fn lf_c_watchdog_stop(trigger: u16) {
    let stopped = with_running(|running| {
        let watchdog = running.program.watchdog(TriggerId(trigger))?;
        running.ctx.stop_watchdog(watchdog);
        Some(())
    });
    if stopped.flatten().is_none() {
        error(c"lf_watchdog_stop: a watchdog can be stopped in reactions only, and not in other threads");
    }
}

// --- Actions ---

/// The handle of an event, and the value for an error.
const SCHEDULED: c_int = 1;
const NOT_SCHEDULED: c_int = -1;

#[unsafe(no_mangle)]
unsafe extern "C" fn lf_c_schedule(trigger: u16, offset: i64, token: *mut RawToken) -> c_int {
    // SAFETY: C passes on its share, or null.
    let mut value = unsafe { Token::from_raw(token) };
    if offset < 0 {
        // SAFETY: the format has no arguments.
        unsafe { lf_print_warning(c"lf_schedule: an offset cannot be negative, so it is 0".as_ptr()) };
    }
    let (id, offset) = (TriggerId(trigger), Offset::After(Interval::from_nanos(offset).to_duration()));
    let scheduled = with_running(|running| {
        let action = running.program.action(id)?;
        running.ctx.schedule_with_v(action, value.take(), offset);
        Some(SCHEDULED)
    });
    match scheduled {
        Some(scheduled) => scheduled.unwrap_or(NOT_SCHEDULED),
        None => post(id, value, offset),
    }
}

/// Schedules a physical action outside of a reaction.
fn post(id: TriggerId, value: Option<Token>, offset: Offset) -> c_int {
    let Some(program) = program() else {
        error(c"lf_schedule: an action can be scheduled from the first reaction on");
        return NOT_SCHEDULED;
    };
    let Some(inbox) = (program.inbox)(id) else {
        error(c"lf_schedule: a logical action can be scheduled in reactions only; other threads need a physical one");
        return NOT_SCHEDULED;
    };
    let action = PhysicalActionRef::new(inbox);
    let Err(full) = link(&program).schedule_physical_with_v(&action, value, offset) else { return SCHEDULED };
    let name = program.tables.triggers[usize::from(id.0)].name;
    let format =
        c"lf_schedule: %zu events of %.*s wait already, which is all it has room for: write @capacity(n) with \
                   a larger n before its declaration, or schedule it less often";
    let length = c_int::try_from(name.len()).unwrap_or(0);
    // SAFETY: the format has a size_t, and a text with its length.
    unsafe { lf_print_error(format.as_ptr(), full.capacity, length, name.as_ptr()) };
    NOT_SCHEDULED
}

/// Returns the link of a thread to the program. It is dropped at once, because the end of a C thread is unknown.
fn link(program: &Program) -> PhysicalLink {
    PhysicalLink::new(program.outside, program.start)
}

// --- Errors ---

#[unsafe(no_mangle)]
unsafe extern "C" fn lf_c_name(token_type: *const c_void, name: *mut *const c_char) -> usize {
    let Some(Program { tables, .. }) = program() else { return 0 };
    let mut ports = (0..).zip(tables.ports).filter(|(id, _)| lf_c_port_has_type(*id, token_type));
    let mut triggers = (0..).zip(tables.triggers).filter(|(id, _)| lf_c_trigger_has_type(*id, token_type));
    let found = ports.next().map(|(_, port)| port.name).or_else(|| triggers.next().map(|(_, trigger)| trigger.name));
    let found = found.unwrap_or("");
    // SAFETY: C passes the address of a pointer.
    unsafe { name.write(found.as_ptr().cast()) };
    found.len()
}

/// Prints an error.
fn error(text: &core::ffi::CStr) {
    // SAFETY: the texts of this file have no conversions.
    unsafe { lf_print_error(text.as_ptr()) };
}
