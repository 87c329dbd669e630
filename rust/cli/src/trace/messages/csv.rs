// SPDX-License-Identifier: Apache-2.0
//! A trace as comma-separated values: all messages, including those without a number in LF's format.
//!
//! | column | content |
//! |---|---|
//! | `physical_ns` | the RTI's clock in nanoseconds after the start of the federation; negative before it |
//! | `direction` | `received` or `sent`, by the RTI |
//! | `federate` | the federate at the other end; empty while it has not said who it is |
//! | `message` | the name of the message in the protocol |
//! | `tag_ns`, `microstep` | the message's tag, if it has one: nanoseconds after the start, or `NEVER`, `FOREVER` |
//! | `to` | the federate for which a message is |
//! | `bytes` | its length on the wire |
//!
//! If the federation never starts, the first line has the time zero.

use std::io::{self, Write};

use lf_linux::model::time::{Instant, Tag};

use super::line::{Direction, Format, MessageLine};

const COLUMNS: &str = "physical_ns,direction,federate,message,tag_ns,microstep,to,bytes";

/// The format of comma-separated values.
pub(super) struct Csv;

impl Format for Csv {
    fn begin(&mut self, file: &mut dyn Write, _: i64) -> io::Result<()> {
        writeln!(file, "{COLUMNS}")
    }

    fn line(&mut self, file: &mut dyn Write, line: &MessageLine, start: i64) -> io::Result<()> {
        let direction = match line.direction {
            Direction::Received => "received",
            Direction::Sent => "sent",
        };
        let number = |number: Option<u16>| number.map_or_else(String::new, |number| number.to_string());
        let (tag, microstep) = match line.tag {
            None => (String::new(), String::new()),
            Some(Tag::NEVER) => ("NEVER".to_owned(), String::new()),
            Some(Tag::FOREVER) => ("FOREVER".to_owned(), String::new()),
            Some(Tag { time: Instant::NEVER, microstep }) => ("NEVER".to_owned(), microstep.0.to_string()),
            Some(Tag { time, microstep }) => {
                (time.as_nanos().saturating_sub(start).to_string(), microstep.0.to_string())
            }
        };
        let physical = line.now.as_nanos().saturating_sub(start);
        let (federate, to, MessageLine { kind, bytes, .. }) = (number(line.federate), number(line.to), line);
        writeln!(file, "{physical},{direction},{federate},{kind},{tag},{microstep},{to},{bytes}")
    }

    fn end(&mut self, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }
}
