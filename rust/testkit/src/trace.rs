// SPDX-License-Identifier: Apache-2.0
//! Recordings with values, as those read them who want to know what a participant was given.

use std::cell::RefCell;
use std::rc::Rc;

use lf_model::time::Instant;
use lf_runtime::trace::{Event, Record, Recorder};

/// Keeps all records in memory; its copies have the same.
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
    // Where the parts belong that follow, and those that have come.
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
            // These can stand between parts, where a file goes on at its beginning.
            Event::Clock(_) | Event::Starts(..) | Event::Lost(_) | Event::Seam => found.push((record, None)),
            _ => {
                open = Some((found.len(), Vec::new()));
                found.push((record, None));
            }
        }
    }
    found
}
