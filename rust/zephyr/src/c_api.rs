// SPDX-License-Identifier: Apache-2.0
//! The C API of an application. cbindgen makes `<lf/lf.h>` of this file.
#![allow(unreachable_pub, reason = "C reaches it, and cbindgen takes only what is public")]

use core::ffi::{CStr, c_char, c_int};
use core::fmt;
use core::sync::atomic::{AtomicPtr, Ordering};

use lf_embedded::{Text, in_words, status};
use lf_runtime::{ImageError, LogEvent};
use log::LevelFilter;

use crate::kconfig::LF_LINE_SIZE;
#[cfg(any(CONFIG_LF_RTI, feature = "traces"))]
use crate::recording::RecordedParticipant;
use crate::{ImagePlatform, ZephyrPlatform};

/// Called with a zero-terminated sentence when the federate or the RTI ends early, before the program stops.
#[expect(non_camel_case_types, reason = "the name is the one that C sees")]
pub type lf_fatal_hook = Option<extern "C" fn(reason: *const c_char)>;

/// The context in which the generated crate runs the federate of an image.
#[derive(Debug)]
pub struct Federate<'a> {
    status: &'a mut c_int,
}

/// The hook, as a pointer because there is no atomic function pointer.
static FATAL_HOOK: AtomicPtr<()> = AtomicPtr::new(core::ptr::null_mut());

impl Federate<'_> {
    /// Runs the federate on Zephyr, with the log level that both `logging` and Kconfig allow.
    ///
    /// The outcome becomes the status that `lf_main()` returns; an error is logged, and passed to the fatal hook.
    pub fn run(self, logging: LevelFilter, run: impl FnOnce(&mut ImagePlatform) -> Result<(), ImageError>) {
        #[cfg(CONFIG_LF_SECURITY)]
        let run = |platform: ZephyrPlatform| run(&mut crate::security::of_federate(platform));
        #[cfg(not(CONFIG_LF_SECURITY))]
        let run = |mut platform: ZephyrPlatform| run(&mut platform);
        self.run_and(logging, run, report);
    }

    /// Runs a program that is not an LF program, whose errors have no codes.
    pub fn run_other<E: fmt::Display>(
        self,
        logging: LevelFilter,
        run: impl FnOnce(&mut ZephyrPlatform) -> Result<(), E>,
    ) {
        self.run_and(logging, |mut platform| run(&mut platform), |error| report_words(format_args!("{error}")));
    }

    fn run_and<E>(
        self,
        logging: LevelFilter,
        run: impl FnOnce(ZephyrPlatform) -> Result<(), E>,
        report_error: impl FnOnce(&E),
    ) {
        crate::logger::install(logging);
        *self.status = match ZephyrPlatform::new() {
            Ok(platform) => status(run(platform), report_error),
            Err(_) => status(Err(ImageError::Descriptor), report),
        };
    }
}

/// Accepts federates at the RTI of the image. Returns 0 if it can, else 1; the log then has the reason.
///
/// Call it once, before `lf_rti_main()`.
#[cfg(CONFIG_LF_RTI)]
#[unsafe(no_mangle)]
pub extern "C" fn lf_rti_listen() -> c_int {
    let (rti, description) = rti_of_image();
    crate::logger::install(description.logging);
    status(crate::rti::listen(rti, description), report)
}

/// Runs the RTI until all federates have left. Returns 0 if the federation ended in order, else 1; the log then has the
/// reason.
///
/// Call it once, from a thread whose stack the event loop can use.
#[cfg(CONFIG_LF_RTI)]
#[unsafe(no_mangle)]
pub extern "C" fn lf_rti_main() -> c_int {
    let (rti, description) = rti_of_image();
    let status = status(rti.run(description, RecordedParticipant::Rti.recording()), report);
    #[cfg(feature = "traces")]
    crate::trace::print(RecordedParticipant::Rti);
    // SAFETY: it has no precondition.
    unsafe { crate::raw::lf_watchdog_end() };
    status
}

#[cfg(CONFIG_LF_RTI)]
fn rti_of_image() -> crate::rti::Image {
    // SAFETY: the symbol is defined by `rti!` in the crate that is linked, with this signature.
    unsafe { lf_rti_of_image() }
}

/// Runs the federate until it ends. Returns 0 if it ended in order, else 1; the log then has the reason.
///
/// Call it once, from a thread whose stack the event loop and the reactions can use.
#[cfg(CONFIG_LF_FEDERATE)]
#[unsafe(no_mangle)]
pub extern "C" fn lf_main() -> c_int {
    let mut status = 1;
    // SAFETY: the symbol is defined by `main!` in the crate that is linked, with this signature.
    unsafe { lf_federate_of_image(Federate { status: &mut status }) };
    #[cfg(feature = "traces")]
    crate::trace::print(RecordedParticipant::Federate);
    // SAFETY: it has no precondition.
    unsafe { crate::raw::lf_watchdog_end() };
    status
}

/// Returns the version of the runtime, zero-terminated and static.
#[unsafe(no_mangle)]
pub extern "C" fn lf_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"unknown",
    };
    VERSION.as_ptr()
}

/// Prints the recordings of all participants; for code that ends the system otherwise.
#[cfg(feature = "traces")]
#[unsafe(no_mangle)]
pub extern "C" fn lf_trace_print() {
    crate::trace::print_all();
}

/// Sets the hook that is called when the federate ends early, by an error or a panic; null for none.
#[unsafe(no_mangle)]
pub extern "C" fn lf_set_fatal_hook(hook: lf_fatal_hook) {
    let pointer = hook.map_or(core::ptr::null_mut(), |hook| hook as *mut ());
    FATAL_HOOK.store(pointer, Ordering::Release);
}

unsafe extern "Rust" {
    #[cfg(CONFIG_LF_FEDERATE)]
    fn lf_federate_of_image(federate: Federate<'_>);
    #[cfg(CONFIG_LF_RTI)]
    fn lf_rti_of_image() -> crate::rti::Image;
}

/// Logs why the federate or the RTI ends early, and calls the hook.
fn report<E: LogEvent>(reason: &E) {
    in_words(reason, report_words);
}

fn report_words(reason: fmt::Arguments<'_>) {
    if cfg!(CONFIG_LOG) {
        log::error!("{reason}");
    } else {
        crate::console::print_line(format_args!("lf: {reason}"));
    }
    call_fatal_hook(reason);
}

/// Calls the hook with the reason why the program ends.
pub(crate) fn call_fatal_hook(reason: fmt::Arguments<'_>) {
    let pointer = FATAL_HOOK.load(Ordering::Acquire);
    if pointer.is_null() {
        return;
    }
    // SAFETY: only `lf_set_fatal_hook` stores here, and it stores null or a function of this type.
    let hook = unsafe { core::mem::transmute::<*mut (), extern "C" fn(*const c_char)>(pointer) };
    let mut text = Text::<LF_LINE_SIZE>::new();
    text.append(reason);
    hook(text.terminated().as_ptr());
}
