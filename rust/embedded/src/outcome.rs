// SPDX-License-Identifier: Apache-2.0
//! The status of a federate or an RTI for C.

use core::ffi::c_int;
use core::fmt;

use lf_runtime::{Code, LogEvent, TEXTS};

/// Returns the status of an outcome: 0, or 1 after an error, with which it calls `report` first.
pub fn status<E>(outcome: Result<(), E>, report: impl FnOnce(&E)) -> c_int {
    c_int::from(outcome.inspect_err(report).is_err())
}

/// Calls `say` with the words for an error: its sentence, or without texts its code.
pub fn in_words<E: LogEvent>(error: &E, say: impl FnOnce(fmt::Arguments<'_>)) {
    if TEXTS { say(format_args!("{error}")) } else { say(format_args!("{}", Code::of(error))) }
}

#[cfg(test)]
mod tests {
    use std::string::{String, ToString as _};

    use lf_runtime::{ImageError, explain};

    use super::{in_words, status};

    #[test]
    fn the_status_of_an_error_is_one_and_its_words_can_be_read() {
        assert_eq!(status(Ok(()), |_: &ImageError| unreachable!("there is no error")), 0);
        let mut words = String::new();
        assert_eq!(status(Err(ImageError::Running), |error| in_words(error, |said| words = said.to_string())), 1);
        let mut sentence = words.clone();
        explain(&words, |text| String::from(text).leak(), &mut |said| sentence = said.to_string());
        assert_eq!(sentence, ImageError::Running.to_string());
    }
}
