// SPDX-License-Identifier: Apache-2.0
//! The applications of this repository as a user runs them, many times: as programs of this computer and as images on
//! `native_sim`, beside what the thesis measured.

mod boards;
mod clock;
mod grid;
mod message;
mod ping;
mod run;
mod thesis;

pub use boards::{boards, sizes};
pub use clock::drift;
pub use grid::{grid, smallest_after};
pub use message::{delay, rate};
pub use ping::answer_pings;
pub use run::{Applications, Board};
