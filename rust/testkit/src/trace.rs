// SPDX-License-Identifier: Apache-2.0
//! Recordings with values, in the form that a replay reads.

use std::cell::RefCell;
use std::rc::Rc;

use lf_model::time::Instant;
use lf_runtime::trace::{Event, Record, Recorder};

/// A recorder that keeps all records in memory; its clones share them.
#[derive(Clone, Debug, Default)]
pub struct Records(Rc<RefCell<Vec<Record>>>);

impl Recorder for Records {
    fn record(&mut self, at: Instant, event: Event) {
        self.0.borrow_mut().push(Record { at, event });
    }
}

impl Records {
    /// Returns what was recorded.
    pub fn to_vec(&self) -> Vec<Record> {
        self.0.borrow().clone()
    }

    /// Returns the file of these records.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.0.borrow().iter().flat_map(|record| record.to_bytes()).collect()
    }
}

/// Returns the events of a recording, oldest first, each with the value that came with it. A value whose beginning is
/// lost is left out, with one whose end is.
pub fn with_values(records: impl IntoIterator<Item = Record>) -> Vec<(Record, Option<Vec<u8>>)> {
    let mut found: Vec<(Record, Option<Vec<u8>>)> = Vec::new();
    // The event of the parts that follow, and the parts so far.
    let mut open: Option<(usize, Vec<u8>)> = None;
    for record in records {
        match record.event {
            Event::Data(chunk) => {
                let Some((index, mut bytes)) = open.take() else { continue };
                bytes.extend(chunk.bytes());
                if chunk.is_last {
                    found[index].1 = Some(bytes);
                } else {
                    open = Some((index, bytes));
                }
            }
            // These records can stand between parts, where a file wraps around.
            Event::Clock(_) | Event::Starts(..) | Event::Lost(_) | Event::Seam => found.push((record, None)),
            _ => {
                open = Some((found.len(), Vec::new()));
                found.push((record, None));
            }
        }
    }
    found
}
