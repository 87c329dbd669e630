// SPDX-License-Identifier: Apache-2.0
//! A federate's observations of its tags and messages, as lines of a file that `lfz run --measure` reads.
//!
//! | line | event |
//! |---|---|
//! | `begins TIME MICROSTEP DUE AT` | a tag that could begin at DUE begins |
//! | `sends FEDERATE PORT TIME MICROSTEP AT` | a message for this tag goes out to a federate's input |
//! | `receives PORT TIME MICROSTEP AT` | a message for this tag has come at an input |
//!
//! All times are nanoseconds of the federation's physical time.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use lf_model::Outside;
use lf_model::time::{Instant, Tag};
use lf_runtime::platform::Observation;

use crate::outside::HostOutside;

/// The file, until it cannot be written.
#[derive(Debug)]
pub(crate) struct Observations {
    file: Option<BufWriter<File>>,
}

impl Observations {
    /// Creates a file.
    ///
    /// # Errors
    /// When it cannot be created.
    pub(crate) fn create(path: &Path) -> std::io::Result<Self> {
        Ok(Self { file: Some(BufWriter::new(File::create(path)?)) })
    }

    /// Writes an observation.
    pub(crate) fn note(&mut self, observation: Observation) {
        let now = HostOutside::of_program().physical_time();
        let Some(file) = &mut self.file else { return };
        if let Err(error) = writeln!(file, "{}", line(observation, now)) {
            log::error!("cannot write what is observed: {error}");
            self.file = None;
        }
    }
}

fn line(observation: Observation, now: Instant) -> String {
    let (at, tag) = (now.as_nanos(), |tag: Tag| format!("{} {}", tag.time.as_nanos(), tag.microstep.0));
    match observation {
        Observation::Begins { tag: begun, due } => format!("begins {} {} {at}", tag(begun), due.as_nanos()),
        Observation::Sends { federate, port, tag: sent } => format!("sends {federate} {port} {} {at}", tag(sent)),
        Observation::Receives { port, tag: received } => format!("receives {port} {} {at}", tag(received)),
    }
}

#[cfg(test)]
mod tests {
    use lf_model::time::Microstep;

    use super::*;

    #[test]
    fn each_observation_is_a_line_of_words() {
        let tag = Tag { time: Instant::from_nanos(100), microstep: Microstep(2) };
        let said = |observation| line(observation, Instant::from_nanos(130));
        assert_eq!(said(Observation::Begins { tag, due: Instant::from_nanos(120) }), "begins 100 2 120 130");
        assert_eq!(said(Observation::Sends { federate: 1, port: 3, tag }), "sends 1 3 100 2 130");
        assert_eq!(said(Observation::Receives { port: 3, tag }), "receives 3 100 2 130");
    }
}
