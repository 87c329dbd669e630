// SPDX-License-Identifier: Apache-2.0
//! The reaction that runs, and what is known of the program outside of reactions.
use core::cell::RefCell;
use core::ffi::CStr;
use core::ptr;

use critical_section::Mutex;
use heapless::Vec;
use lf_model as model;
use lf_model::{
    Inbox, Instant, Interval, ModeId, Outside, ReactionContext, ReactionId, Schedulable, Tables, Tag, TriggerId,
};

use crate::ffi;
use crate::token::Token;

/// What the C API needs of a program; generated code has one `match` per method.
pub trait Bodies {
    /// An action, to schedule it.
    fn action(&mut self, _action: TriggerId) -> Option<&mut dyn Schedulable<Value = Token>> {
        None
    }

    /// A watchdog, to start and to stop it.
    fn watchdog(&mut self, _watchdog: TriggerId) -> Option<&mut model::Watchdog> {
        None
    }

    /// The inbox of a physical action, for other threads.
    fn inbox(_action: TriggerId) -> Option<&'static dyn Inbox<Token>>
    where
        Self: Sized,
    {
        None
    }
}

/// Gives all reactors their parameters and initial state; to be called when the owner of the program is made.
pub fn construct() {
    critical_section::with(|cs| *KNOWN.borrow_ref_mut(cs) = Known::NOTHING);
    ffi::lf_c_begin();
    ffi::lf_construct();
}

/// Gives a parameter of the main reactor, by its position, a value before [`construct`]: that of the three which is
/// of its kind. Says whether its type has such a value.
// Inline, so that a program without a command line need not have the function in C.
#[inline]
pub fn give_parameter(parameter: u16, whole: i64, real: f64, text: &'static CStr) -> bool {
    // SAFETY: C reads the text only, which lives as long as the program; all else are numbers.
    unsafe { ffi::lf_give_parameter(parameter, whole, real, text.as_ptr().cast_mut()) }
}

/// Runs the body of a reaction: for [`model::Program::react`].
pub fn react<B: Bodies>(program: &mut B, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
    let is_late = begin::<B>(reaction, ctx).unwrap_or(false);
    run(program, reaction, ctx, if is_late { ffi::lf_miss_deadline } else { ffi::lf_react });
}

/// Runs the handler of a missed deadline: for [`model::Program::miss_deadline`].
pub fn miss_deadline<B: Bodies>(program: &mut B, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
    let is_late = begin::<B>(reaction, ctx).unwrap_or(true);
    run(program, reaction, ctx, if is_late { ffi::lf_miss_deadline } else { ffi::lf_react });
}

/// Runs the handler of a tardy input: for [`model::Program::handle_tardy`].
pub fn handle_tardy<B: Bodies>(program: &mut B, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
    begin::<B>(reaction, ctx);
    run(program, reaction, ctx, ffi::lf_handle_tardy);
}

/// Gives the `reset` state variables in a mode their initial values: for [`model::ModeCells::reset_mode`].
pub fn reset_mode(mode: ModeId) {
    ffi::lf_reset_mode(mode.0);
}

/// The reaction that runs, for the functions that its body calls.
pub(crate) struct Running<'a, 'c> {
    pub(crate) program: &'a mut dyn Bodies,
    pub(crate) ctx: &'a mut ReactionContext<'c>,
    pub(crate) reaction: ReactionId,
}

fn run(program: &mut dyn Bodies, reaction: ReactionId, ctx: &mut ReactionContext<'_>, body: unsafe extern "C" fn(u16)) {
    let mut running = Running { program, ctx, reaction };
    // SAFETY: what C is given lies here until it is taken back below; C does not look into it. The body is one of the
    // program's, which has one for each reaction of its tables.
    unsafe {
        ffi::lf_c_set_running((&raw mut running).cast());
        body(reaction.0);
        ffi::lf_c_set_running(ptr::null_mut());
    }
    ffi::lf_c_reaction_done();
}

/// Calls `action` with the reaction that this thread runs; `None` in other threads and outside of reactions.
pub(crate) fn with_running<R>(action: impl FnOnce(&mut Running<'_, '_>) -> R) -> Option<R> {
    let running = ffi::lf_c_running();
    if running.is_null() {
        return None;
    }
    // SAFETY: it is what `run` of this thread has given to C, and `run` does not touch it before it has taken it back.
    // Nobody else has it meanwhile: it is taken from C here, so that a destructor that `action` leads to finds nothing.
    let result = unsafe {
        ffi::lf_c_set_running(ptr::null_mut());
        action(&mut *running.cast::<Running<'_, '_>>())
    };
    // SAFETY: it goes back to where it was.
    unsafe { ffi::lf_c_set_running(running) };
    Some(result)
}

/// What threads and interrupts know of the program, from its first reaction on.
#[derive(Clone, Copy)]
pub(crate) struct Program {
    pub(crate) outside: &'static dyn Outside,
    pub(crate) tables: &'static Tables,
    pub(crate) inbox: fn(TriggerId) -> Option<&'static dyn Inbox<Token>>,
    pub(crate) start: Instant,
    /// The tag of the reaction that ran last.
    pub(crate) tag: Tag,
}

/// How many reactions can have another deadline than the program says.
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

/// The program, from its first reaction on.
pub(crate) fn program() -> Option<Program> {
    critical_section::with(|cs| KNOWN.borrow_ref(cs).program)
}

/// Physical time; before the first reaction that of the system.
pub(crate) fn physical_time() -> Instant {
    program().map_or_else(|| Instant::from_nanos(ffi::lf_c_clock()), |program| program.outside.physical_time())
}

/// Remembers what is known now. Gives whether the reaction is late for a deadline that a body has changed.
fn begin<B: Bodies>(reaction: ReactionId, ctx: &ReactionContext<'_>) -> Option<bool> {
    let program = Program {
        outside: ctx.outside(),
        tables: ctx.tables(),
        inbox: B::inbox,
        start: ctx.get_start_time(),
        tag: ctx.current_tag(),
    };
    let deadline = critical_section::with(|cs| {
        let mut known = KNOWN.borrow_ref_mut(cs);
        known.program = Some(program);
        known.deadlines.iter().find(|changed| changed.0 == reaction).map(|changed| changed.1)
    })?;
    Some(is_late(ctx, deadline))
}

/// The deadline of a reaction, as it is now.
pub(crate) fn deadline_of(reaction: ReactionId, ctx: &ReactionContext<'_>) -> Option<Interval> {
    let changed = critical_section::with(|cs| {
        let known = KNOWN.borrow_ref(cs);
        known.deadlines.iter().find(|changed| changed.0 == reaction).map(|changed| changed.1)
    });
    changed.or(ctx.tables().reactions[usize::from(reaction.0)].deadline)
}

/// Changes the deadline of a reaction.
///
/// # Errors
/// How many can be changed, when so many have been.
pub(crate) fn change_deadline(reaction: ReactionId, deadline: Interval) -> Result<(), usize> {
    critical_section::with(|cs| {
        let mut known = KNOWN.borrow_ref_mut(cs);
        if let Some(changed) = known.deadlines.iter_mut().find(|changed| changed.0 == reaction) {
            changed.1 = deadline;
            return Ok(());
        }
        known.deadlines.push((reaction, deadline)).map_err(|_| DEADLINES)
    })
}

/// Whether more time than that has passed since the tag's time; as in the C runtime, of no time it always has.
pub(crate) fn is_late(ctx: &ReactionContext<'_>, deadline: Interval) -> bool {
    deadline <= Interval::ZERO || ctx.get_physical_time() > ctx.get_logical_time() + deadline
}
