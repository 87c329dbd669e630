// SPDX-License-Identifier: Apache-2.0
//! Loads the recorded runs of `tests/golden`, for the tests of other crates. The README there describes the format.
//!
//! Nothing is skipped: a key that is unknown, or that does not belong to its step, is an error, and so is a masked byte
//! for which the file does not say how the tester has to fill it. The loader knows no messages, only bytes.

mod error;
mod file;
mod hmac;
mod mask;
mod recording;
pub mod replay;

pub use self::hmac::hmac;
pub use error::GoldenError;
pub use file::{directory, load, load_all, parse};
pub use mask::{FillError, Mask, MaskError};
pub use recording::{Coordination, FederateSetup, Fill, Frame, Recording, RelativeTag, Role, RtiSetup, Step};

/// Expands to a test for each recording: `recordings! { play; handshake: "01-handshake", }` makes the test `handshake`,
/// which calls `play("01-handshake")`.
#[macro_export]
macro_rules! recordings {
    ($play:ident; $($test:ident: $name:literal,)*) => {
        $(
            #[test]
            fn $test() {
                $play($name);
            }
        )*
    };
}
