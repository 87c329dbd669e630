// SPDX-License-Identifier: Apache-2.0
//! The lengths of payloads. Only the C compiler knows them, so an object file has a variable as large as each type.

use lf_model::HandedOver;

use super::cpp::{as_bytes, extension};
use super::symbols::preamble_headers;
use super::text::Text;
use super::types::CType;
use crate::emit::File;
use crate::emit::host::sent_ports;
use crate::emit::view::View;
use crate::plan::{ClassIndex, Federate, Location, Port, Serializer, StateVariable};
use crate::tables::{HandedOverRow, handed_over};

/// The types that a participant sends, receives or forwards, each once.
pub(super) struct Sizes<'p> {
    view: &'p View<'p>,
    rows: Vec<(CType, Location)>,
    /// The types by port of the federate.
    ports: Vec<(String, CType)>,
    /// The types of states that are handed over.
    states: Vec<CType>,
}

impl<'p> Sizes<'p> {
    pub(super) fn new(view: &'p View<'p>, federate: Option<&Federate>, rti: bool) -> Self {
        let mut sizes = Self { view, rows: Vec::new(), ports: Vec::new(), states: Vec::new() };
        let is_own = |known: &Federate| federate.is_some_and(|own| own.id == known.id);
        let is_c = |known: &Federate| view.is_own(known.instances[0].class);
        for known in view.plan.federates.iter().filter(|known| is_own(known) || rti && is_c(known)) {
            for (port, _) in sent_ports(known) {
                let port = &known.ports[port.0];
                let ty = sizes.type_of(known, port);
                if !ty.is_nothing() && !ty.is_token() && !ty.is_text() && !sizes.rows.iter().any(|(row, _)| *row == ty)
                {
                    sizes.rows.push((ty.clone(), port.ty.at));
                }
                sizes.ports.push((port.path.clone(), ty));
            }
            for HandedOverRow { instance, state, .. } in handed_over(view.plan, known) {
                let ty = CType::new(view.class(known.instances[instance.0].class), &state.ty);
                if !sizes.rows.iter().any(|(row, _)| *row == ty) {
                    sizes.rows.push((ty.clone(), state.ty.at));
                }
                sizes.states.push(ty);
            }
        }
        sizes
    }

    fn type_of(&self, federate: &Federate, port: &Port) -> CType {
        let class = federate.declared(&port.path).map_or(self.view.plan.main, |(class, _)| class);
        CType::new(self.view.class(class), &port.ty)
    }

    /// Returns the maximum number of bytes of a port's value, as an expression of Rust.
    pub(super) fn max_len(&self, port: &Port, serializer: Option<&Serializer>) -> String {
        if let Some(length) = serializer.and_then(|serializer| serializer.max_length) {
            return length.to_string();
        }
        let ty = self.ports.iter().find(|(path, _)| *path == port.path).map(|(_, ty)| ty);
        match ty {
            Some(ty) if ty.is_nothing() => "0".to_owned(),
            Some(ty) => self.size_of(ty),
            None => "c::PAYLOAD_BYTES".to_owned(),
        }
    }

    /// Returns the number of bytes of a state that is handed over, as an expression of Rust.
    pub(super) fn state_len(&self, class: ClassIndex, state: &StateVariable) -> String {
        self.size_of(&CType::new(self.view.class(class), &state.ty))
    }

    fn size_of(&self, ty: &CType) -> String {
        let row = self.rows.iter().position(|(row, _)| row == ty);
        row.map_or_else(|| "c::PAYLOAD_BYTES".to_owned(), |row| format!("crate::sizes::LF_SIZE_{row}"))
    }

    /// Returns all lengths, as expressions of Rust, for an RTI that forwards the values.
    pub(super) fn all(&self) -> Vec<String> {
        let sizes = (0..self.rows.len()).map(|row| format!("crate::sizes::LF_SIZE_{row}"));
        let unknown = self.ports.iter().any(|(_, ty)| ty.is_token() || ty.is_text());
        let states = self.states.iter().map(|ty| format!("{} + {}", HandedOver::ID_BYTES, self.size_of(ty)));
        sizes.chain(states).chain(unknown.then(|| "lf::c::PAYLOAD_BYTES".to_owned())).collect()
    }

    /// Returns the file that the compiler measures.
    pub(super) fn file(&self, folder: &str) -> File {
        let path = format!("{folder}/c/sizes.{}", extension(self.view));
        let mut text = Text::new(self.view, path, "The sizes of payloads; this object is measured, and never linked.");
        text.line("#include <lf.h>");
        if !self.rows.is_empty() {
            for header in preamble_headers(self.view.plan) {
                text.line(format_args!("#include \"{header}.h\""));
            }
        }
        for (index, (row, at)) in self.rows.iter().enumerate() {
            text.line("typedef").typed(*at, format_args!("{};", row.declare(&format!("lf_type_{index}")))).continues();
            text.line(format_args!("char lf_size_{index}[sizeof(lf_type_{index})];"));
            if self.view.native.is_cpp {
                text.line(as_bytes(&format!("lf_type_{index}"), "values for another federate"));
            }
        }
        text.file()
    }
}
