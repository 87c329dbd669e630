// SPDX-License-Identifier: Apache-2.0
//! The participants' output, each line with its participant's name before it.

use std::collections::BTreeMap;
use std::io::{self, Write};

use crate::codes::with_sentences;
use crate::compile::Console;
use crate::terminal::has_colours;

/// The output stream of a participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stream {
    /// Standard output, which goes to standard output.
    Standard,
    /// Standard error, which goes to standard error.
    Error,
}

/// Colours that are distinguishable on dark and light terminals, one per participant.
const COLOURS: [u8; 6] = [36, 33, 35, 32, 34, 31];

/// The destination of lines.
pub(crate) struct Output {
    standard: Box<dyn Write>,
    error: Box<dyn Write>,
    /// Whether each of the two is a terminal, and gets colours.
    coloured: (bool, bool),
    /// The name before messages about the run itself; without it no line gets a name.
    speaker: Option<String>,
    /// The width of names, in characters.
    name_width: usize,
    /// The consoles of participants that do not name positions in the program themselves, by their names.
    consoles: BTreeMap<String, Console>,
    /// The error of the last output, until it has been handled.
    lost: Option<io::Error>,
}

impl Output {
    /// Returns the output to the standard streams of this process, with room for these names.
    pub(crate) fn of_this_process<'a>(speaker: Option<&'a str>, names: impl IntoIterator<Item = &'a str>) -> Self {
        let coloured = (has_colours(&io::stdout()), has_colours(&io::stderr()));
        Self::new(Box::new(io::stdout()), Box::new(io::stderr()), coloured, speaker, names)
    }

    /// Returns the output to any two writers.
    pub(super) fn new<'a>(
        standard: Box<dyn Write>,
        error: Box<dyn Write>,
        coloured: (bool, bool),
        speaker: Option<&'a str>,
        names: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let name_width = names.into_iter().chain(speaker).map(|name| name.chars().count()).max().unwrap_or(0);
        let speaker = speaker.map(str::to_owned);
        Self { standard, error, coloured, speaker, name_width, consoles: BTreeMap::new(), lost: None }
    }

    /// Adds the consoles of participants, by their names.
    pub(crate) fn with_consoles(self, consoles: BTreeMap<String, Console>) -> Self {
        Self { consoles, ..self }
    }

    /// Returns the error of the output, after which it is pointless to continue.
    pub(super) fn take_error(&mut self) -> Option<io::Error> {
        self.lost.take()
    }

    /// Shows a participant's output as it is.
    pub(super) fn bytes(&mut self, stream: Stream, bytes: &[u8]) {
        self.write(stream, bytes);
    }

    /// Shows one line of a participant, without its end, with sentences for codes and positions in the program for
    /// those in generated code.
    pub(super) fn line(&mut self, index: usize, name: &str, stream: Stream, line: &[u8]) {
        let colour = Some(COLOURS[index % COLOURS.len()]);
        let prefix = if self.speaker.is_none() { String::new() } else { self.prefix(name, colour, stream) };
        let mut bytes = prefix.into_bytes();
        let line = with_sentences(line);
        bytes.extend_from_slice(&match self.consoles.get(name) {
            Some(console) => console.with_lf_places(&line),
            None => line.as_ref().into(),
        });
        bytes.push(b'\n');
        self.write(stream, &bytes);
    }

    /// Prints a message in this program's own name.
    pub(super) fn note(&mut self, text: &str) {
        let prefix = self.prefix(self.speaker.as_deref().unwrap_or("lfz"), None, Stream::Error);
        self.write(Stream::Error, format!("{prefix}{text}\n").as_bytes());
    }

    /// Writes out what is buffered.
    pub(super) fn flush(&mut self) {
        if let Err(error) = self.standard.flush().and_then(|()| self.error.flush()) {
            self.lost = Some(error);
        }
    }

    fn prefix(&self, name: &str, colour: Option<u8>, stream: Stream) -> String {
        let width = self.name_width;
        let coloured = if stream == Stream::Standard { self.coloured.0 } else { self.coloured.1 };
        match colour {
            _ if !coloured => format!("{name:width$} | "),
            Some(colour) => format!("\x1b[{colour}m{name:width$} |\x1b[0m "),
            None => format!("\x1b[1m{name:width$} |\x1b[0m "),
        }
    }

    fn write(&mut self, stream: Stream, bytes: &[u8]) {
        let writer = match stream {
            Stream::Standard => &mut self.standard,
            Stream::Error => &mut self.error,
        };
        if let Err(error) = writer.write_all(bytes).and_then(|()| writer.flush()) {
            self.lost = Some(error);
        }
    }
}
