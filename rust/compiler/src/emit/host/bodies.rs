// SPDX-License-Identifier: Apache-2.0
//! The interface between the host and the bodies of a participant.
//!
//! The host writes the crate: tables, queues, `Program`, RTI, entry point and manifest. It does not know the language
//! of the bodies; an implementation per language provides the access to them. Implementations may use the host's
//! functions, and not each other's.

use proc_macro2::TokenStream;
use quote::quote;

use super::places::{Group, PlaceExpression};
use super::splice::Splices;
use super::symbols::Owner;
use crate::emit::{EmitError, File, FileMap};
use crate::plan::{Location, Port, Serializer};
use crate::tables::HandedOverRow;

/// The bodies of a participant, and all other code in their language.
pub(in crate::emit) trait Bodies {
    /// Returns the parts of the crate that C compilers process.
    fn native_parts(&self) -> NativeParts;

    /// Returns the files that configure the compilation of the bodies and of code beside them.
    ///
    /// # Errors
    /// The first element that cannot be compiled for the participant.
    fn build_files(&self) -> Result<Vec<File>, EmitError>;

    /// Adds the files with the bodies.
    ///
    /// # Errors
    /// The first element that cannot be emitted.
    fn emit(&self, output: &mut Output) -> Result<(), EmitError>;

    /// Returns the modules at the root of the crate that [`Bodies::emit`] adds.
    fn modules(&self) -> Vec<&str>;

    /// Returns the paths of the reactors' modules if code names them below `crate::reactors`, where LF's own compiler
    /// has them.
    fn reactor_modules(&self) -> Vec<String>;

    /// Returns whether the bodies use devices of this computer by the crate `lf`.
    fn uses_devices(&self) -> bool;

    /// Returns the parameters of the main reactor that a command line can set.
    fn parameters(&self) -> TokenStream;

    /// Returns the lengths of the values that an RTI in this crate forwards, as expressions.
    ///
    /// # Errors
    /// A type that the language does not have.
    fn payload_lengths(&self) -> Result<Vec<String>, EmitError>;

    /// Returns the maximum number of bytes of a port's value, as an expression; `ty` is its [`Bodies::value_type`].
    fn max_len(&self, port: &Port, ty: &str, serializer: Option<&Serializer>) -> String;

    /// Returns the number of events that an action with this required capacity holds.
    fn room(&self, capacity: usize) -> usize;

    /// Returns the path of a type of cells: ports, timers, actions and their queues.
    fn cell(&self, name: &str) -> String;

    /// Returns whether cells refer to values elsewhere by the numbers of ports and triggers, instead of having them.
    fn cells_refer(&self) -> bool;

    /// Returns the type of a serializer for values of a type; nothing where cells know it by themselves.
    fn serializer(&self, serializer: &Serializer, ty: &str) -> Option<String>;

    /// Returns the type of the values of a port or an action, as it can be named in the federate's module. It is empty
    /// where cells hold values of any type.
    ///
    /// # Errors
    /// A type that the language does not have.
    fn value_type(&self, path: &str, ty: &crate::plan::Type) -> Result<String, EmitError>;

    /// Adds the instances to the struct that owns everything.
    ///
    /// # Errors
    /// An instance that cannot be constructed.
    fn instances(&self, owner: &Owner<'_>, members: &mut Members, splices: &mut Splices<'_>) -> Result<(), EmitError>;

    /// Returns the calls that run a part of each reaction that has it, with the reaction's number.
    fn reactions(&self, owner: &Owner<'_>, part: ReactionPart) -> Vec<(usize, String)>;

    /// Returns the arms that share the reactions of a level among several threads, by level.
    fn shares(&self, owner: &Owner<'_>) -> Vec<String>;

    /// Returns the arms that reset state, by mode.
    fn resets(&self, owner: &Owner<'_>) -> Vec<String>;

    /// Returns the arms that write the values of states that are handed over, and those that set them, by state.
    fn handovers(&self, owner: &Owner<'_>) -> [Vec<String>; 2];

    /// Returns the maximum number of bytes of the value of such a state, as an expression.
    fn state_len(&self, owner: &Owner<'_>, row: &HandedOverRow<'_>) -> String;

    /// Returns further implementations for the struct that owns everything, which has this name.
    fn implementations(&self, owner: &Owner<'_>, name: &str) -> String;

    /// Returns the imports of the federate's module that the other methods need.
    fn imports(&self) -> String;
}

/// The parts of a crate that C compilers process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::emit) enum NativeParts {
    /// No parts that its build script compiles.
    None,
    /// Its bodies.
    Bodies,
    /// Files beside bodies in another language.
    Sources,
    /// Such files with headers that are bound, or headers alone.
    Headers,
}

/// A part of a reaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::emit) enum ReactionPart {
    Body,
    MissedDeadline,
    Tardy,
}

impl ReactionPart {
    /// Returns the method of `Program` that runs it.
    pub(in crate::emit) fn method(self) -> &'static str {
        match self {
            Self::Body => "react",
            Self::MissedDeadline => "miss_deadline",
            Self::Tardy => "handle_tardy",
        }
    }
}

/// Files with bodies.
#[derive(Default)]
pub(in crate::emit) struct Output {
    /// Files in which the compiler itself is given the places in the program.
    pub(in crate::emit) files: Vec<File>,
    /// Files with a map to the program.
    pub(in crate::emit) mapped: Vec<(File, FileMap)>,
}

/// Fields of the struct that owns everything, and the parts of its constructor.
#[derive(Default)]
pub(in crate::emit) struct Members {
    pub(in crate::emit) fields: TokenStream,
    pub(in crate::emit) values: TokenStream,
    pub(in crate::emit) locals: TokenStream,
}

/// An instance, a port or a queue in that struct.
pub(in crate::emit) struct Member<'p> {
    /// A word before its path in the documentation, with a space.
    pub(in crate::emit) word: &'static str,
    pub(in crate::emit) path: &'p str,
    pub(in crate::emit) at: Location,
    pub(in crate::emit) ty: String,
    pub(in crate::emit) value: TokenStream,
}

impl Members {
    /// Adds the fields of all members of one kind, by their numbers; some numbers have none.
    pub(in crate::emit) fn add(
        &mut self,
        splices: &mut Splices<'_>,
        (places, arrays): (&[PlaceExpression], &[Group]),
        members: &[Option<Member<'_>>],
    ) {
        for (number, place) in places.iter().enumerate() {
            let (Some(member), Some(field)) = (&members[number], place.begun_field()) else { continue };
            let Member { word, path, at, ty, value } = member;
            let (text, ty, value) = match arrays.iter().find(|array| array.parts[0] == number) {
                None => (format!("{word}`{path}`"), ty.clone(), value.clone()),
                Some(array) => {
                    let all: Vec<_> = array.parts.iter().filter_map(|part| members[*part].as_ref()).collect();
                    let last = all.last().map_or(*path, |member| member.path);
                    let values: Vec<_> = all.iter().map(|member| member.value.clone()).collect();
                    (format!("{word}`{path}` to `{last}`"), array.array_type(ty), array.array(&values))
                }
            };
            let (doc, ty) = (splices.doc(&text, *at), tokens(&ty));
            self.fields.extend(quote! { #doc #field: #ty, });
            let is_variable = *field == value.to_string();
            self.values.extend(if is_variable { quote!(#field,) } else { quote!(#field: #value,) });
        }
    }
}

/// Returns the tokens of a text that consists of Rust names.
pub(in crate::emit) fn tokens(text: &str) -> TokenStream {
    text.parse().unwrap_or_default()
}
