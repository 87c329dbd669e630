// SPDX-License-Identifier: Apache-2.0
//! All.

use lf_testkit::golden::replay::replay;
use lf_testkit::rti::Recorded;

#[test]
fn all() {
    for recording in lf_testkit::golden::load_all().unwrap() {
        if !recording.name.starts_with("0.13/") { continue; }
        for piece in [usize::MAX, 1, 7] {
            let mut rti = Recorded::new(recording.rti().unwrap(), piece);
            match std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| replay(&recording, &mut rti))) {
                Ok(Ok(())) => println!("{} {piece}: OK {:?}", recording.name, rti.rig.rti.status()),
                Ok(Err(error)) => { println!("{error}"); break; }
                Err(_) => { println!("{} PANIC", recording.name); break; }
            }
        }
    }
}
