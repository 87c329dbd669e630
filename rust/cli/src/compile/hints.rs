// SPDX-License-Identifier: Apache-2.0
//! Advice about an error of rustc, if the program shows more than the generated code does.

use super::scopes::{Kind, Scope, SignatureName};

/// Calls that take an action.
const SCHEDULING: [&str; 3] = [".schedule(", ".schedule_with_v(", ".schedule_physical("];

/// Functions that bodies in C call, and their counterparts in Rust.
const FUNCTIONS_OF_C: [(&str, &str); 17] = [
    ("SET", "ctx.set(PORT, VALUE)"),
    ("lf_set", "ctx.set(PORT, VALUE)"),
    ("lf_set_array", "ctx.set(PORT, VALUE)"),
    ("lf_set_token", "ctx.set(PORT, VALUE)"),
    ("lf_set_mode", "ctx.set_mode(MODE)"),
    ("lf_schedule", "ctx.schedule(ACTION, After(DELAY))"),
    ("lf_schedule_int", "ctx.schedule_with_v(ACTION, Some(VALUE), After(DELAY))"),
    ("lf_schedule_copy", "ctx.schedule_with_v(ACTION, Some(VALUE), After(DELAY))"),
    ("lf_schedule_value", "ctx.schedule_with_v(ACTION, Some(VALUE), After(DELAY))"),
    ("lf_request_stop", "ctx.request_stop(Asap)"),
    ("lf_tag", "ctx.get_tag()"),
    ("lf_time_logical", "ctx.get_logical_time()"),
    ("lf_time_logical_elapsed", "ctx.get_elapsed_logical_time()"),
    ("lf_time_physical", "ctx.get_physical_time()"),
    ("lf_time_physical_elapsed", "ctx.get_elapsed_physical_time()"),
    ("lf_time_start", "ctx.get_start_time()"),
    ("lf_print", "info!(TEXT)"),
];

/// Names of LF's API for C before LF 0.3, and what to write now.
const OLDER_API_OF_C: [(&str, &str); 28] = [
    ("SET", "lf_set"),
    ("SET_ARRAY", "lf_set_array"),
    ("SET_MODE", "lf_set_mode"),
    ("SET_NEW_ARRAY", "lf_set_array(PORT, calloc(LENGTH, sizeof(TYPE)), LENGTH)"),
    ("SET_PRESENT", "lf_set_present"),
    ("SET_TOKEN", "lf_set_token"),
    ("compare_tags", "lf_tag_compare"),
    ("error_print", "lf_print_error"),
    ("error_print_and_exit", "lf_print_error_and_exit"),
    ("get_current_tag", "lf_tag"),
    ("get_elapsed_logical_time", "lf_time_logical_elapsed"),
    ("get_elapsed_physical_time", "lf_time_physical_elapsed"),
    ("get_logical_time", "lf_time_logical"),
    ("get_microstep", "lf_tag().microstep"),
    ("get_physical_time", "lf_time_physical"),
    ("get_start_time", "lf_time_start"),
    ("info_print", "lf_print"),
    ("request_stop", "lf_request_stop"),
    ("schedule", "lf_schedule"),
    ("schedule_copy", "lf_schedule_copy"),
    ("schedule_int", "lf_schedule_int"),
    ("schedule_token", "lf_schedule_token"),
    ("schedule_value", "lf_schedule_value"),
    ("set_new_array", "lf_set_array(PORT, calloc(LENGTH, sizeof(TYPE)), LENGTH)"),
    ("start_time", "lf_time_start()"),
    ("tag_compare", "lf_tag_compare"),
    ("warning_print", "lf_print_warning"),
    ("writable_copy", "lf_writable_copy"),
];

/// Words of C compilers about a name that they do not know, in English.
const UNKNOWN_IN_C: [&str; 4] = ["implicit declaration of", "undeclared", "was not declared", "unknown type name"];

/// Fields of ports and actions in C, and their counterparts in Rust.
const MEMBERS_OF_C: [(&str, &str); 5] = [
    ("value", "ctx.get(@)"),
    ("is_present", "ctx.is_present(@)"),
    ("has_value", "ctx.is_present(@)"),
    ("width", "@.len()"),
    ("intended_tag", "ctx.get_intended_tag(@)"),
];

/// Words of rustc about code that editions before 2024 take. Programs for LF's own Rust target are such code.
const OF_EDITION_2024: [&str; 6] = [
    "reserved keyword `gen`",
    "extern blocks must be unsafe",
    "unsafe attribute used without unsafe",
    "reference to mutable static",
    "call to unsafe function `std::env::set_var`",
    "call to unsafe function `std::env::remove_var`",
];

/// Devices of images, and the options that include them.
const DEVICES: [(&str, &str); 8] = [
    ("I2c", "I2C"),
    ("Spi", "SPI"),
    ("Adc", "ADC"),
    ("Pwm", "PWM"),
    ("Uart", "SERIAL"),
    ("Pin", "GPIO"),
    ("Input", "GPIO"),
    ("Output", "GPIO"),
];

/// The relevant parts of an error of rustc.
pub(super) struct RustcError<'a> {
    /// The error's code, or nothing.
    pub(super) code: &'a str,
    pub(super) message: &'a str,
    /// The label at the position.
    pub(super) label: &'a str,
    /// The line of the program, and the bytes in it that are concerned.
    pub(super) line: &'a str,
    pub(super) range: std::ops::Range<usize>,
    /// The setting of Kconfig without which the image does not have it.
    pub(super) left_out_without: Option<&'a str>,
    /// The body that it is in.
    pub(super) scope: Option<&'a Scope>,
}

impl RustcError<'_> {
    /// Returns the advice; it replaces rustc's own notes.
    pub(super) fn hint(&self) -> Option<String> {
        if let Some(symbol) = self.left_out_without {
            return Some(format!("the image is built without this: add `{symbol}=y` to prj.conf"));
        }
        let of_all_codes = self.timer_scheduled().or_else(|| self.context_elsewhere()).or_else(|| self.older_edition());
        of_all_codes.or_else(|| match self.code {
            "E0616" | "E0609" | "E0615" | "E0599" | "E0608" => self.port_as_in_c(),
            "E0423" | "E0425" => self.unknown_name(),
            "E0308" => self.not_mutable(),
            "E0277" => self.not_copy(),
            "E0432" | "E0433" => self.missing_device().or_else(|| self.missing_crate()),
            "" => self.older_api_of_c(),
            _ => None,
        })
    }

    /// Advises about a timer: only actions are scheduled, and a timer has no list of effects that it could be added to.
    fn timer_scheduled(&self) -> Option<String> {
        let is_scheduled =
            SCHEDULING.iter().any(|call| self.before().trim_end().trim_end_matches("&mut").ends_with(call));
        let signature_name = self.scope?.signature_name(self.meant())?;
        (is_scheduled && signature_name.kind == Kind::Timer).then(|| {
            let name = &signature_name.name;
            format!("`{name}` is a timer, which has its own times: schedule a logical action in its place")
        })
    }

    /// Advises about parameters of a body, which live until the reaction has ended, and in its thread.
    fn context_elsewhere(&self) -> Option<String> {
        let is_sent = self.message.contains("cannot be sent between threads safely")
            || self.message.contains("cannot be shared between threads safely");
        let escapes = self.code == "E0521" || self.code == "E0373" || self.code == "E0597";
        let is_of_body = ["dyn Env", "dyn lf_model::", "ReactionContext", "dyn Outside", "`ctx`"]
            .iter()
            .any(|name| self.message.contains(name) || self.label.contains(name));
        let is_spawned = self.line.contains("spawn") || self.line.contains("thread");
        (is_of_body && (is_sent || (escapes && is_spawned))).then(|| {
            "a thread cannot have `ctx`: start it by `ctx.spawn_physical_thread(|link| …)`, which gives it a link to \
             schedule physical actions by"
                .to_owned()
        })
    }

    /// Advises about code of an older edition.
    fn older_edition(&self) -> Option<String> {
        let is_older = OF_EDITION_2024.iter().any(|words| self.message.contains(words));
        is_older.then(|| {
            "editions of Rust before 2024 take this: write `edition: \"2021\"` into the target declaration".to_owned()
        })
    }

    /// Advises about a name that LF's API for C had once. C compilers may take it for a misspelled one.
    fn older_api_of_c(&self) -> Option<String> {
        UNKNOWN_IN_C.iter().find(|words| self.message.contains(*words))?;
        let name = self.message.split(['\u{2018}', '\u{2019}', '\'']).nth(1)?;
        let (_, now) = OLDER_API_OF_C.iter().find(|(older, _)| *older == name)?;
        Some(format!("LF 0.3 has renamed it: write `{now}`"))
    }

    /// Advises about fields and methods that ports have in C.
    fn port_as_in_c(&self) -> Option<String> {
        let member = self.meant().trim_matches(['.', '(', ')', ' ']);
        let (_, call) = MEMBERS_OF_C.iter().find(|(name, _)| *name == member)?;
        let owner = self.before().trim_end_matches(['.', '>', '-']);
        let start = owner.rfind(|sign: char| !sign.is_alphanumeric() && sign != '_').map_or(0, |at| at + 1);
        let name = &owner[start..];
        let is_variable = self.scope?.has_variable(name);
        is_variable.then(|| format!("write `{}`", call.replace('@', name)))
    }

    /// Advises about a module of devices that images have when their configuration includes it.
    fn missing_device(&self) -> Option<String> {
        let is_device =
            self.message.contains("devices") || self.line.contains("devices::") || self.label.contains("devices");
        let meant = self.meant();
        let (_, option) =
            DEVICES.iter().find(|(name, _)| meant.ends_with(name) || self.label.contains(&format!("`{name}`")))?;
        is_device.then(|| format!("images have it with `CONFIG_{option}=y` in their `prj.conf`"))
    }

    fn meant(&self) -> &str {
        self.line.get(self.range.clone()).unwrap_or_default()
    }

    fn before(&self) -> &str {
        self.line.get(..self.range.start).unwrap_or_default()
    }

    /// Advises about a name that the signature of the reaction could have declared for the body.
    fn unknown_name(&self) -> Option<String> {
        let (scope, name) = (self.scope?, self.meant());
        if let Some((_, call)) = FUNCTIONS_OF_C.iter().find(|(function, _)| *function == name) {
            return Some(format!("`{name}` is a function of bodies in C; here write `{call}`"));
        }
        if let Some(signature_name) = scope.signature_name(name) {
            return Some(declare(scope, signature_name, self.before()));
        }
        let behind = self.line.get(self.range.end..)?.strip_prefix('.')?;
        let port = behind.split(|sign: char| !sign.is_alphanumeric() && sign != '_').next()?;
        let written = format!("{name}.{port}");
        let mut ports = scope.ports_of_child(name).peekable();
        ports.peek()?;
        let Some(signature_name) = ports.find(|signature_name| signature_name.written == written) else {
            return Some(format!("`{name}` is a contained reactor, which has no port `{port}`"));
        };
        let variable = &signature_name.name;
        if scope.has_variable(variable) {
            return Some(format!("bodies call the port `{written}` of a contained reactor `{variable}`"));
        }
        let rest = declare(scope, signature_name, self.before());
        Some(format!("bodies call it `{variable}`; {rest}"))
    }

    /// Advises about a parameter that the body can only read.
    fn not_mutable(&self) -> Option<String> {
        if !self.label.contains("types differ in mutability") {
            return None;
        }
        let signature_name = self.scope?.signature_name(self.meant())?;
        let (written, what) = (&signature_name.written, signature_name.kind.text());
        Some(match signature_name.kind {
            Kind::Input => format!(
                "`{written}` is {what} of `{}`: a reaction can set outputs, and inputs of contained reactors",
                self.scope?.reactor
            ),
            Kind::ChildOutput => format!("`{written}` is {what}, which only that reactor can set"),
            _ => format!("`{written}` is none of the reaction's effects: add `-> {written}` to its signature"),
        })
    }

    fn not_copy(&self) -> Option<String> {
        let is_get = self.before().trim_end().ends_with(".get(");
        let hint = format!("`ctx.get` copies values; `ctx.get_ref({})` gives a reference to any", self.meant());
        (is_get && self.message.ends_with(": Copy` is not satisfied")).then_some(hint)
    }

    fn missing_crate(&self) -> Option<String> {
        let (_, rest) = self.label.split_once("unresolved module or unlinked crate `")?;
        let name = rest.split('`').next()?;
        Some(match name {
            "std" | "alloc" => format!("there is no `{name}` in images: use `core`, and `heapless` for containers"),
            _ => format!("name the crate in the target declaration: `cargo-dependencies: {{ {name}: \"VERSION\" }}`"),
        })
    }
}

/// Returns the declaration of an element in the signature of a reaction.
fn declare(scope: &Scope, signature_name: &SignatureName, before: &str) -> String {
    let (written, what) = (&signature_name.written, signature_name.kind.text());
    let of = if written.contains('.') { String::new() } else { format!(" of `{}`", scope.reactor) };
    let is_written = before.contains(".set") || before.contains(".schedule");
    let how = match (signature_name.kind.is_trigger(), signature_name.kind.is_effect()) {
        (_, true) if is_written || !signature_name.kind.is_trigger() => format!("add `-> {written}`"),
        (true, true) => format!("add `{written}` behind the triggers to read it, `-> {written}` to schedule it"),
        _ if signature_name.kind == Kind::Timer => format!("add `{written}` to the triggers"),
        _ => format!("add `{written}` to the triggers, or behind them to only read it"),
    };
    format!("`{written}` is {what}{of} that the reaction's signature does not name: {how}")
}
