// SPDX-License-Identifier: Apache-2.0
//! Programs in Rust with C beside them: errors in the C code are reported at their places, and changed files are
//! compiled.

use crate::support::{folder, lfz, said, text, write};

const PROGRAM: &str = r#"
target Rust {
    c-sources: "driver/fan.c",
    c-headers: ["driver/fan.h"],
    compile-definitions: { STEP: 5 },
}

preamble {=
    use core::ffi::{CStr, c_void};
    use core::sync::atomic::{AtomicU32, Ordering};

    static CHANGES: AtomicU32 = AtomicU32::new(0);

    extern "C" fn changed(fan: *const c::fan, data: *mut c_void) {
        // SAFETY: it is called with what exists, from `fan_set`.
        let (fan, changes) = unsafe { (&*fan, &*data.cast::<AtomicU32>()) };
        changes.fetch_add(fan.speed, Ordering::Relaxed);
    }
=}

main reactor {
    state fan: c::fan

    reaction(startup) {=
        let name: &CStr = c::FAN_NAME;
        // SAFETY: the fan is borrowed, and the counter is static.
        let is_on = unsafe {
            c::fan_on_change(Some(changed), (&raw const CHANGES).cast_mut().cast());
            c::fan_set(&mut self.fan, 33);
            c::fan_is_on(&self.fan)
        };
        println!("{name:?} {} {is_on} {}", self.fan.speed, self.fan.mode == c::fan_mode::FAN_ON);
        println!("{}", CHANGES.load(Ordering::Relaxed));
    =}
}
"#;

const HEADER: &str = r#"
#include <stdbool.h>
#include "private.h"
#define FAN_NAME "a fan"
enum fan_mode { FAN_OFF, FAN_ON };
struct fan { uint8_t number; enum fan_mode mode; uint32_t speed; };
typedef void (*fan_callback)(const struct fan *fan, void *data);
void fan_set(struct fan *fan, uint32_t speed);
void fan_on_change(fan_callback callback, void *data);
static inline bool fan_is_on(const struct fan *fan) { return fan->mode == FAN_ON; }
"#;

const SOURCE: &str = r#"
#include "fan.h"
static fan_callback on_change;
static void *its_data;
void fan_set(struct fan *fan, uint32_t speed) {
    fan->speed = speed / STEP * STEP + MORE;
    fan->mode = speed > 0 ? FAN_ON : FAN_OFF;
    on_change(fan, its_data);
}
void fan_on_change(fan_callback callback, void *data) { on_change = callback; its_data = data; }
"#;

const FILES: [(&str, &str); 4] = [
    ("P.lf", PROGRAM),
    ("driver/fan.h", HEADER),
    ("driver/fan.c", SOURCE),
    ("driver/private.h", "#include <stdint.h>\n#define MORE 0\n"),
];

#[test]
fn bodies_call_c_which_calls_back_and_is_compiled_again_when_a_header_changes() {
    let folder = folder(&FILES);
    let output = said(&mut lfz(folder.path(), &["run"]));
    assert_eq!(text(&output.stdout), "\"a fan\" 30 true true\n30\n", "{}", text(&output.stderr));

    write(folder.path(), "driver/private.h", "#include <stdint.h>\n#define MORE 1\n");
    let output = said(&mut lfz(folder.path(), &["run"]));
    assert_eq!(text(&output.stdout), "\"a fan\" 31 true true\n31\n", "{}", text(&output.stderr));
}

#[test]
fn errors_in_c_are_at_their_places_in_it() {
    let folder = folder(&FILES);
    write(folder.path(), "driver/fan.c", &SOURCE.replace("speed / STEP", "sped / STEP"));
    let errors = text(&said(&mut lfz(folder.path(), &["build"])).stderr);
    assert!(errors.contains("\ndriver/fan.c:6:18: error: "), "{errors}");
    assert!(errors.contains("6 |     fan->speed = sped / STEP"), "{errors}");

    write(folder.path(), "driver/fan.h", &HEADER.replace("uint8_t", "uint9_t"));
    let errors = text(&said(&mut lfz(folder.path(), &["build"])).stderr);
    assert!(errors.contains("\ndriver/fan.h:6:14: error: unknown type name 'uint9_t'"), "{errors}");
}

#[test]
fn a_missing_libclang_is_reported_with_where_to_get_it() {
    let folder = folder(&FILES);
    let output = said(lfz(folder.path(), &["build"]).env("LIBCLANG_PATH", "/dev/null"));
    let errors = text(&output.stderr);
    assert!(!output.status.success());
    assert!(errors.contains("P.lf:4:17: error: libclang, which reads headers, cannot be loaded: "), "{errors}");
    assert!(errors.contains("install it, on Debian and Ubuntu as libclang-dev"), "{errors}");
}
