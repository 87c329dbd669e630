// SPDX-License-Identifier: Apache-2.0
//! What to do about an error of rustc, where the program tells more than the generated code does.

use super::scopes::{Kind, Scope, Thing};

/// What rustc has said, as far as it matters here.
pub(super) struct RustcError<'a> {
    /// The error's code, or nothing.
    pub(super) code: &'a str,
    pub(super) message: &'a str,
    /// What is written beside the place.
    pub(super) label: &'a str,
    /// The line of the program, and the bytes in it that are meant.
    pub(super) line: &'a str,
    pub(super) range: std::ops::Range<usize>,
    /// The setting of Kconfig without which the image does not have it.
    pub(super) left_out_without: Option<&'a str>,
    /// The body that it is in.
    pub(super) scope: Option<&'a Scope>,
}

impl RustcError<'_> {
    /// What to do; it takes the place of rustc's own notes.
    pub(super) fn hint(&self) -> Option<String> {
        if let Some(symbol) = self.left_out_without {
            return Some(format!("the image is built without this: add `{symbol}=y` to prj.conf"));
        }
        match self.code {
            "E0423" | "E0425" => self.unknown_name(),
            "E0308" => self.not_mutable(),
            "E0277" => self.not_copy(),
            "E0432" | "E0433" => self.missing_crate(),
            _ => None,
        }
    }

    fn meant(&self) -> &str {
        self.line.get(self.range.clone()).unwrap_or_default()
    }

    fn before(&self) -> &str {
        self.line.get(..self.range.start).unwrap_or_default()
    }

    /// A name that the signature of the reaction could have given the body.
    fn unknown_name(&self) -> Option<String> {
        let (scope, name) = (self.scope?, self.meant());
        if let Some(thing) = scope.thing(name) {
            return Some(declare(scope, thing, self.before()));
        }
        let behind = self.line.get(self.range.end..)?.strip_prefix('.')?;
        let port = behind.split(|sign: char| !sign.is_alphanumeric() && sign != '_').next()?;
        let written = format!("{name}.{port}");
        let mut ports = scope.ports_of_child(name).peekable();
        ports.peek()?;
        let Some(thing) = ports.find(|thing| thing.written == written) else {
            return Some(format!("`{name}` is a contained reactor, which has no port `{port}`"));
        };
        let variable = &thing.name;
        if scope.has_variable(variable) {
            return Some(format!("bodies call the port `{written}` of a contained reactor `{variable}`"));
        }
        let rest = declare(scope, thing, self.before());
        Some(format!("bodies call it `{variable}`; {rest}"))
    }

    /// What the signature gives the body only to look at.
    fn not_mutable(&self) -> Option<String> {
        if !self.label.contains("types differ in mutability") {
            return None;
        }
        let thing = self.scope?.thing(self.meant())?;
        let (written, what) = (&thing.written, thing.kind.text());
        Some(match thing.kind {
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

/// How the signature of a reaction names something.
fn declare(scope: &Scope, thing: &Thing, before: &str) -> String {
    let (written, what) = (&thing.written, thing.kind.text());
    let of = if written.contains('.') { String::new() } else { format!(" of `{}`", scope.reactor) };
    let is_written = before.contains(".set") || before.contains(".schedule");
    let how = match (thing.kind.is_trigger(), thing.kind.is_effect()) {
        (_, true) if is_written || !thing.kind.is_trigger() => format!("add `-> {written}`"),
        (true, true) => format!("add `{written}` behind the triggers to read it, `-> {written}` to schedule it"),
        _ if thing.kind == Kind::Timer => format!("add `{written}` to the triggers"),
        _ => format!("add `{written}` to the triggers, or behind them to only read it"),
    };
    format!("`{written}` is {what}{of} that the reaction's signature does not name: {how}")
}
