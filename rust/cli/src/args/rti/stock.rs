// SPDX-License-Identifier: Apache-2.0
//! Command lines of `lfc`'s launch scripts for the stock RTI, converted to words that clap can parse.

use std::ffi::{OsStr, OsString};
use std::path::Path;

/// The name under which launch scripts call the RTI: a program of this name is `lfz rti`.
const NAME: &str = "RTI";

/// The stock RTI has options of several letters behind a single dash, which clap would take for several options.
const LETTERS: [(&str, &str); 3] = [("-nt", "--number_of_transient_federates"), ("-sst", "--sst"), ("-tls", "--tls")];

/// Returns whether a program that was called by this path is the RTI.
pub(in crate::args) fn is_rti(path: &OsStr) -> bool {
    Path::new(path).file_name().is_some_and(|name| name == NAME)
}

/// Returns the same words for clap: without those that only end the scripts, and with options that clap knows.
pub(in crate::args) fn readable(words: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut words = words.into_iter().peekable();
    let mut readable = Vec::new();
    while let Some(word) = words.next() {
        let long = LETTERS.iter().find(|(letters, _)| word == *letters).map(|(_, long)| OsString::from(long));
        let is_id = word == "-i" || word == "--id";
        // An id may look like anything but the option that follows a missing id.
        if is_id && let Some(id) = words.next_if(|id| !is_option(id)) {
            let mut joined = OsString::from("--id=");
            joined.push(id);
            readable.push(joined);
        } else if !is_end(&word) {
            readable.push(long.unwrap_or(word));
        }
    }
    readable
}

/// Returns whether a word is only an artifact of the backslash and the blank at the end of the scripts: `&` follows or,
/// if the RTI is on another computer, `2>&1`, from which shells join the 2 to the blank.
fn is_end(word: &OsStr) -> bool {
    word == " " || word == " 2"
}

fn is_option(word: &OsStr) -> bool {
    let options = ["-a", "-c", "-d", "-i", "-m", "-n", "-nt", "-p", "-sst", "-t", "-tls", "-v"];
    options.iter().any(|option| word == *option)
}
