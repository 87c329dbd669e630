// SPDX-License-Identifier: Apache-2.0
//! The reaction that runs, and the state of the program outside of reactions.
use core::cell::RefCell;
use core::ffi::{CStr, c_void};
use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use critical_section::Mutex;
use heapless::Vec;
use lf_model as model;
#[cfg(feature = "transients")]
use lf_model::PayloadError;
use lf_model::{
    Inbox, Instant, Interval, ModeId, Outside, Part, PortId, ReactionContext, ReactionId, Schedulable, SharedTag,
    Tables, Tag, TriggerId,
};

use crate::ffi;
use crate::token::Token;

/// The program's interface for the C API; generated code has one `match` per method.
pub trait Bodies {
    /// Returns an action, to schedule it.
    fn action(&mut self, _action: TriggerId) -> Option<&mut dyn Schedulable<Value = Token>> {
        None
    }

    /// Returns a watchdog, to start and to stop it.
    fn watchdog(&mut self, _watchdog: TriggerId) -> Option<&mut model::Watchdog> {
        None
    }

    /// Returns the inbox of a physical action, for other threads.
    fn inbox(_action: TriggerId) -> Option<&'static dyn Inbox<Token>>
    where
        Self: Sized,
    {
        None
    }
}

/// Sets the parameters and the initial state of all reactors. Call it when the owner of the program is made.
pub fn construct() {
    critical_section::with(|cs| *KNOWN.borrow_ref_mut(cs) = Known::NOTHING);
    LAST_TAG.set(Tag::NEVER);
    CHANGED_DEADLINES.store(false, Ordering::Relaxed);
    ffi::lf_c_begin();
    ffi::lf_construct();
}

/// Sets a parameter of the main reactor, by its position, before [`construct`], to the one of the three values that is
/// of its kind. Returns whether its type has such a value.
// Inline, so that a program without a command line need not have the function in C.
#[inline]
pub fn give_parameter(parameter: u16, whole: i64, real: f64, text: &'static CStr) -> bool {
    // SAFETY: C only reads the text, which lives as long as the program; the rest are numbers.
    unsafe { ffi::lf_give_parameter(parameter, whole, real, text.as_ptr().cast_mut()) }
}

/// Runs the body of a reaction: for [`model::Program::react`].
pub fn react<B: Bodies>(program: &mut B, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
    run::<B>(program, Part::Body, reaction, ctx);
}

/// Runs the handler of a missed deadline: for [`model::Program::miss_deadline`].
pub fn miss_deadline<B: Bodies>(program: &mut B, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
    run::<B>(program, Part::MissedDeadline, reaction, ctx);
}

/// Runs the handler of a tardy input: for [`model::Program::handle_tardy`].
pub fn handle_tardy<B: Bodies>(program: &mut B, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
    run::<B>(program, Part::Tardy, reaction, ctx);
}

/// The actions and watchdogs of one reactor of a program, for the job of a worker: other jobs run meanwhile.
#[cfg(feature = "workers")]
pub struct ReactorCells<'a, 'c> {
    actions: &'a mut [(TriggerId, &'c mut dyn Schedulable<Value = Token>)],
    watchdogs: &'a mut [(TriggerId, &'c mut model::Watchdog)],
}

#[cfg(feature = "workers")]
impl<'a, 'c> ReactorCells<'a, 'c> {
    /// Returns these actions and watchdogs, with their numbers in the program.
    pub fn new(
        actions: &'a mut [(TriggerId, &'c mut dyn Schedulable<Value = Token>)],
        watchdogs: &'a mut [(TriggerId, &'c mut model::Watchdog)],
    ) -> Self {
        Self { actions, watchdogs }
    }

    /// Runs a part of a reaction of this reactor, which is one of the program `B`: for [`model::Job`].
    pub fn run<B: Bodies>(&mut self, part: Part, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        run::<B>(self, part, reaction, ctx);
    }
}

#[cfg(feature = "workers")]
impl core::fmt::Debug for ReactorCells<'_, '_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("ReactorCells").field("watchdogs", &self.watchdogs).finish_non_exhaustive()
    }
}

#[cfg(feature = "workers")]
impl Bodies for ReactorCells<'_, '_> {
    fn action(&mut self, action: TriggerId) -> Option<&mut dyn Schedulable<Value = Token>> {
        for (id, cell) in &mut *self.actions {
            if *id == action {
                return Some(&mut **cell);
            }
        }
        None
    }

    fn watchdog(&mut self, watchdog: TriggerId) -> Option<&mut model::Watchdog> {
        self.watchdogs.iter_mut().find(|(id, _)| *id == watchdog).map(|(_, cell)| &mut **cell)
    }
}

/// Resets the `reset` state variables in a mode to their initial values: for [`model::ModeCells::reset_mode`].
pub fn reset_mode(mode: ModeId) {
    ffi::lf_reset_mode(mode.0);
}

/// Calls `action` with the memory of a state that is handed over; of none, if there is no such state.
#[cfg(feature = "transients")]
fn with_state<R>(state: u16, action: impl FnOnce(&mut [u8]) -> R) -> R {
    let mut size = 0;
    // SAFETY: C writes the size, and returns null or the place of a variable of the program, which is that large.
    let place = unsafe { ffi::lf_handed_over(state, &raw mut size) };
    if place.is_null() {
        return action(&mut []);
    }
    // SAFETY: the variable is initialised, as all of the program's are. The event loop, which calls this, runs no body
    // meanwhile, and bodies run nowhere else.
    action(unsafe { core::slice::from_raw_parts_mut(place.cast(), size) })
}

/// Writes the value of a state as it lies in memory: for [`model::Program::hand_over`].
///
/// # Errors
/// When it does not fit.
#[cfg(feature = "transients")]
pub fn hand_over(state: u16, bytes: &mut [u8]) -> Result<usize, PayloadError> {
    let available = bytes.len();
    with_state(state, |value| {
        let room = bytes.get_mut(..value.len()).ok_or(PayloadError::NoRoom { needed: value.len(), available })?;
        room.copy_from_slice(value);
        Ok(value.len())
    })
}

/// Sets a state to a value of another instance: for [`model::Program::take_over`].
///
/// # Errors
/// When it has another size.
#[cfg(feature = "transients")]
pub fn take_over(state: u16, bytes: &[u8]) -> Result<(), PayloadError> {
    with_state(state, |value| {
        if value.len() != bytes.len() {
            return Err(PayloadError::Length { expected: value.len(), found: bytes.len() });
        }
        value.copy_from_slice(bytes);
        Ok(())
    })
}

/// The reaction that runs, for the functions that its body calls.
pub(crate) struct Running<'a, 'c> {
    pub(crate) program: &'a mut dyn Bodies,
    pub(crate) ctx: &'a mut ReactionContext<'c>,
    pub(crate) reaction: ReactionId,
}

/// Runs a part of a reaction of the program `B`. A deadline that a body has changed decides between the body and its
/// handler.
#[inline]
fn run<B: Bodies>(program: &mut dyn Bodies, part: Part, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
    let is_late = begin::<B>(reaction, ctx).unwrap_or(part == Part::MissedDeadline);
    let body = match part {
        Part::Tardy => ffi::lf_handle_tardy,
        _ if is_late => ffi::lf_miss_deadline,
        _ => ffi::lf_react,
    };
    let mut running = Running { program, ctx, reaction };
    // SAFETY: C removes its copy of the pointer after the body, before its target ends; C does not read the target. The
    // body is one of the program's, which has one for each reaction of its tables.
    unsafe { ffi::lf_c_run(body, reaction.0, (&raw mut running).cast()) };
}

/// Calls `action` with the reaction that this thread runs; returns `None` in other threads and outside of reactions.
pub(crate) fn with_running<R>(action: impl FnOnce(&mut Running<'_, '_>) -> R) -> Option<R> {
    let running = ffi::lf_c_running();
    if running.is_null() {
        return None;
    }
    // SAFETY: `run` of this thread has passed it to C, and does not use it before it has removed it. There is no other
    // user meanwhile: it is removed from C here, so that a destructor that `action` leads to finds nothing.
    let result = unsafe {
        ffi::lf_c_set_running(ptr::null_mut());
        action(&mut *running.cast::<Running<'_, '_>>())
    };
    // SAFETY: it goes back to where it was.
    unsafe { ffi::lf_c_set_running(running) };
    Some(result)
}

/// Marks a port as present for a reaction. Returns its tag; `None` if the reaction is null.
///
/// # Safety
/// The reaction is what C has now as the running one of this thread, or null.
pub(crate) unsafe fn mark_present(running: *mut c_void, port: PortId) -> Option<Tag> {
    // SAFETY: `run` of this thread has passed it to C, and does not use it before C has removed it. There is no other
    // user meanwhile, because nothing here leads back to C.
    let running = unsafe { running.cast::<Running<'_, '_>>().as_mut() }?;
    running.ctx.mark_present(port);
    Some(running.ctx.current_tag())
}

/// The program as threads and interrupts see it, from its first reaction on.
#[derive(Clone, Copy)]
pub(crate) struct Program {
    pub(crate) outside: &'static dyn Outside,
    pub(crate) tables: &'static Tables,
    pub(crate) inbox: fn(TriggerId) -> Option<&'static dyn Inbox<Token>>,
    pub(crate) start: Instant,
    #[cfg(feature = "transients")]
    pub(crate) first: Tag,
}

/// The number of reactions whose deadline a body can change.
const DEADLINES: usize = 8;

struct Known {
    program: Option<Program>,
    /// The deadlines that bodies have changed.
    deadlines: Vec<(ReactionId, Interval), DEADLINES>,
}

impl Known {
    const NOTHING: Self = Self { program: None, deadlines: Vec::new() };
}

static KNOWN: Mutex<RefCell<Known>> = Mutex::new(RefCell::new(Known::NOTHING));

/// The tag of the reaction that ran last, and whether [`KNOWN`] has changed deadlines: the event loop looks here before
/// each reaction, because a critical section costs more than most bodies.
static LAST_TAG: SharedTag = SharedTag::new();
static CHANGED_DEADLINES: AtomicBool = AtomicBool::new(false);

/// Returns the tag of the reaction that ran last, for other threads; NEVER before the first one.
pub(crate) fn last_tag() -> Tag {
    LAST_TAG.get()
}

/// Returns the program, from its first reaction on.
pub(crate) fn program() -> Option<Program> {
    critical_section::with(|cs| KNOWN.borrow_ref(cs).program)
}

/// Returns the first tag of the program; NEVER before the first reaction.
pub(crate) fn first_tag() -> Tag {
    #[cfg(feature = "transients")]
    let first = |program: Program| program.first;
    #[cfg(not(feature = "transients"))]
    let first = |program: Program| Tag::at(program.start);
    program().map_or(Tag::NEVER, first)
}

/// Returns the id of the federation; empty where the program is not federated, and before the first reaction.
pub(crate) fn federation_id() -> &'static CStr {
    #[cfg(feature = "transients")]
    let id = program().map_or(c"", |program| program.outside.federation_id());
    #[cfg(not(feature = "transients"))]
    let id = c"";
    id
}

/// Returns physical time; before the first reaction that of the system.
pub(crate) fn physical_time() -> Instant {
    program().map_or_else(|| Instant::from_nanos(ffi::lf_c_clock()), |program| program.outside.physical_time())
}

/// Stores the tag, and the program at its first reaction. Returns whether the reaction is late for a deadline that a
/// body has changed.
#[inline]
fn begin<B: Bodies>(reaction: ReactionId, ctx: &ReactionContext<'_>) -> Option<bool> {
    if !LAST_TAG.is(ctx.current_tag()) {
        begin_tag::<B>(ctx);
    }
    Some(is_late(ctx, changed_deadline(reaction)?))
}

// Not a part of the code above, which runs before each reaction.
#[inline(never)]
fn begin_tag<B: Bodies>(ctx: &ReactionContext<'_>) {
    let begin = || {
        if LAST_TAG.is(Tag::NEVER) {
            know::<B>(ctx);
        }
        LAST_TAG.set(ctx.current_tag());
    };
    #[cfg(not(feature = "workers"))]
    begin();
    // One thread at a time stores the tag, and none runs a body before the program is known.
    #[cfg(feature = "workers")]
    critical_section::with(|_| {
        if !LAST_TAG.is(ctx.current_tag()) {
            begin();
        }
    });
}

/// Stores the program.
fn know<B: Bodies>(ctx: &ReactionContext<'_>) {
    let (outside, tables, start) = (ctx.outside(), ctx.tables(), ctx.get_start_time());
    let program = Program {
        outside,
        tables,
        inbox: B::inbox,
        start,
        #[cfg(feature = "transients")]
        first: ctx.first_tag(),
    };
    critical_section::with(|cs| KNOWN.borrow_ref_mut(cs).program = Some(program));
}

/// Returns the current deadline of a reaction.
pub(crate) fn deadline_of(reaction: ReactionId, ctx: &ReactionContext<'_>) -> Option<Interval> {
    changed_deadline(reaction).or(ctx.tables().reactions[usize::from(reaction.0)].deadline)
}

/// Returns the deadline that a body has given to a reaction.
#[inline]
fn changed_deadline(reaction: ReactionId) -> Option<Interval> {
    if CHANGED_DEADLINES.load(Ordering::Relaxed) { known_deadline(reaction) } else { None }
}

#[cold]
fn known_deadline(reaction: ReactionId) -> Option<Interval> {
    critical_section::with(|cs| {
        let known = KNOWN.borrow_ref(cs);
        known.deadlines.iter().find(|changed| changed.0 == reaction).map(|changed| changed.1)
    })
}

/// Changes the deadline of a reaction.
///
/// # Errors
/// The maximum number, when as many have been changed.
pub(crate) fn change_deadline(reaction: ReactionId, deadline: Interval) -> Result<(), usize> {
    CHANGED_DEADLINES.store(true, Ordering::Relaxed);
    critical_section::with(|cs| {
        let mut known = KNOWN.borrow_ref_mut(cs);
        if let Some(changed) = known.deadlines.iter_mut().find(|changed| changed.0 == reaction) {
            changed.1 = deadline;
            return Ok(());
        }
        known.deadlines.push((reaction, deadline)).map_err(|_| DEADLINES)
    })
}

/// Returns whether more time than the deadline has passed since the tag's time; as in the C runtime, always for a
/// deadline of zero.
pub(crate) fn is_late(ctx: &ReactionContext<'_>, deadline: Interval) -> bool {
    deadline <= Interval::ZERO || ctx.get_physical_time() > ctx.get_logical_time() + deadline
}
