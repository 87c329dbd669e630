// SPDX-License-Identifier: Apache-2.0
//! Properties whose values are words or options of their own: the platform of a program, its logging, its coordination.
#![allow(
    clippy::redundant_closure_for_method_calls,
    reason = "a method of a type with a lifetime is no function for every lifetime"
)]

use super::reader::{Read, TargetReader, text_of};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::plan;
use crate::syntax::ast::{Name, PropertyKind, PropertyValue, TimeValue};

const PLATFORM: &[(&str, Read)] = &[
    ("name", |reader, key, value| reader.platform_name(key, value)),
    ("board", |reader, key, value| match text_of(value) {
        Some(text) => reader.target.board = Some(text),
        None => reader.bad(key, value, "the name of a board"),
    }),
    ("user-threads", |reader, key, value| {
        if let Some(threads) = reader.number(key, value, 64) {
            reader.target.user_threads = u16::try_from(threads).unwrap_or(u16::MAX);
        }
    }),
];

const CLOCK_SYNC: &[(&str, Read)] = &[
    ("trials", |reader, key, value| {
        reader.target.clock_sync_trials = reader.count(key, value).unwrap_or(reader.target.clock_sync_trials);
    }),
    ("period", |reader, key, value| reader.clock_sync_period(key, value)),
    ("attenuation", |reader, key, value| {
        let attenuation = reader.count(key, value);
        reader.target.clock_sync_attenuation = attenuation.unwrap_or(reader.target.clock_sync_attenuation);
    }),
    ("local-federates-on", |reader, key, value| {
        reader.target.clock_sync_local = reader.boolean(key, value).unwrap_or_default();
    }),
    ("test-offset", |reader, key, value| {
        if is_forever(value) {
            reader.bad(key, value, "a time by which the clocks are wrong");
        } else {
            reader.target.clock_sync_test_offset_ns = reader.time(key, value).unwrap_or(0);
        }
    }),
    ("collect-stats", |reader, key, value| {
        if reader.boolean(key, value) == Some(false) {
            reader.idle(key, "what is collected costs next to nothing, and is told at the end in any case");
        }
    }),
];

const COORDINATION: &[(&str, Read)] = &[
    ("advance-message-interval", |reader, key, value| {
        if is_forever(value) {
            return reader.bad(key, value, "a time after which progress is told again");
        }
        match reader.time(key, value) {
            Some(0) => reader.bad(key, value, "a time longer than 0"),
            Some(ns) => reader.target.advance_interval_ns = ns,
            None => {}
        }
    }),
    ("log-waits", |reader, key, value| match reader.time(key, value) {
        Some(ns) if ns > 0 => reader.target.log_waits_ns = Some(ns),
        Some(_) => reader.bad(key, value, "a time longer than 0"),
        None => {}
    }),
];

/// Options of a platform in LF for flashing it.
const FLASHING: &[(&str, &str)] = &[
    ("port", "remove it, and pass options for flashing to west"),
    ("baud-rate", "remove it, and pass options for flashing to west"),
    ("flash", "remove it, and pass options for flashing to west"),
];

/// The longest federation id, in bytes; the wire has no room for a longer one.
const FEDERATION_ID_MAX: usize = 255;

const JOINT_RTI: &[(&str, Read)] = &[
    ("federation-id", |reader, key, value| match text_of(value) {
        Some(id) if (1..=FEDERATION_ID_MAX).contains(&id.len()) => reader.target.federation_id = Some(id),
        _ => reader.bad(key, value, "a text of up to 255 bytes"),
    }),
    ("port", |reader, key, value| reader.target.rti_port = reader.count(key, value)),
];

/// Alternatives to SST.
const INSTEAD_OF_SST: &str = "remove it, and write `security: noise`, or `comm-type: TLS` for programs of Linux alone";

fn is_forever(value: &PropertyValue) -> bool {
    matches!(value.kind, PropertyKind::Time(TimeValue::Forever))
}

impl TargetReader<'_> {
    pub(super) fn platform(&mut self, key: &Name, value: &PropertyValue) {
        match &value.kind {
            PropertyKind::Map(_) => self.options(key, value, PLATFORM, FLASHING),
            _ => self.platform_name(key, value),
        }
    }

    pub(super) fn clock_sync_options(&mut self, key: &Name, value: &PropertyValue) {
        self.options(key, value, CLOCK_SYNC, &[]);
    }

    pub(super) fn coordination_options(&mut self, key: &Name, value: &PropertyValue) {
        self.options(key, value, COORDINATION, &[]);
    }

    pub(super) fn joint_rti_options(&mut self, key: &Name, value: &PropertyValue) {
        self.options(key, value, JOINT_RTI, &[]);
    }

    pub(super) fn comm_type(&mut self, key: &Name, value: &PropertyValue) {
        match text_of(value).map(|text| text.to_uppercase()).as_deref() {
            Some("TCP") => {}
            Some("TLS") => self.target.security = plan::Security::Tls,
            Some("SST") => self.refuse_value(key, value, INSTEAD_OF_SST),
            _ => self.bad(key, value, "TCP or TLS"),
        }
    }

    /// Reads `security`, after `comm-type`.
    pub(super) fn security(&mut self, key: &Name, value: &PropertyValue) {
        use plan::Security::{Noise, None as Plain, Tls, UnverifiedTls};
        let Some(word) = self.word(key, value, &["none", "noise", "unverified"]) else { return };
        self.target.security = match (word, self.target.security) {
            ("none", Plain) => Plain,
            ("unverified", Tls) => UnverifiedTls,
            ("noise", Plain) => Noise,
            ("unverified", _) => {
                let message = "`security: unverified` is about TLS, and the program has no `comm-type: TLS`";
                let hint = "write `security: noise`, or both to talk with programs of LF's own compiler";
                return self.found.push(Diagnostic::new(Code::BadPropertyValue, value.span, message).hint(hint));
            }
            _ => {
                let message = format!("`security: {word}` contradicts `comm-type: TLS`, which encrypts connections");
                return self
                    .found
                    .push(Diagnostic::new(Code::BadPropertyValue, value.span, message).hint("remove one"));
            }
        };
    }

    pub(super) fn logging(&mut self, key: &Name, value: &PropertyValue) {
        use plan::Logging::{Debug, Error, Info, Log, Warn};
        let levels =
            [("error", Error), ("warn", Warn), ("warning", Warn), ("info", Info), ("log", Log), ("debug", Debug)];
        let text = text_of(value).map(|text| text.to_lowercase());
        match levels.iter().find(|(name, _)| text.as_deref() == Some(*name)) {
            Some((_, level)) => self.target.logging = *level,
            None => self.bad(key, value, "one of error, warn, info, log and debug"),
        }
    }

    fn platform_name(&mut self, key: &Name, value: &PropertyValue) {
        const SUPPORTED: [&str; 3] = ["Zephyr", "Native", "Linux"];
        const OTHERS: [&str; 11] =
            ["Arduino", "nRF52", "RP2040", "Pico", "FlexPRET", "Patmos", "FreeRTOS", "RIOT", "Mac", "Windows", "Auto"];
        let Some(text) = text_of(value) else { return self.bad(key, value, "the name of a platform") };
        let text = if text.eq_ignore_ascii_case("POSIX") { "Native".to_owned() } else { text };
        let same = |name: &&&str| name.eq_ignore_ascii_case(&text);
        if let Some(name) = SUPPORTED.iter().find(same) {
            self.target.platform = Some((*name).to_owned());
        } else if OTHERS.iter().any(|name| same(&name)) {
            self.refuse_value(key, value, "use `Zephyr`, `Linux` or `Native`");
        } else {
            let message = format!("there is no platform `{text}`");
            // Names of boards have digits, hyphens and slashes; those of platforms have none.
            let is_board = text.contains(|one: char| !one.is_ascii_alphabetic());
            let hint = match did_you_mean(&text, SUPPORTED) {
                Some(hint) => hint,
                None if is_board => format!("a board is named so: `platform: {{ name: Zephyr, board: \"{text}\" }}`"),
                None => "platforms are `Zephyr`, `Linux` and `Native`; a board is named so: \
                         `platform: { name: Zephyr, board: \"qemu_cortex_m3\" }`"
                    .to_owned(),
            };
            self.found.push(Diagnostic::new(Code::BadPropertyValue, value.span, message).hint(hint));
        }
    }

    fn clock_sync_period(&mut self, key: &Name, value: &PropertyValue) {
        const LEAST_NS: i64 = 1_000_000;
        const MOST_NS: i64 = 3_600_000_000_000;
        let forever = is_forever(value);
        match self.time(key, value) {
            Some(ns) if (LEAST_NS..=MOST_NS).contains(&ns) => self.target.clock_sync_period_ns = ns,
            None if !forever => {}
            _ => self.bad(key, value, "a time from 1 ms to 1 h"),
        }
    }
}
