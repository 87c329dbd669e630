// SPDX-License-Identifier: Apache-2.0
//! Rust: a crate per participant, with bodies as methods of a struct per reactor.

mod code_block;
mod code_syntax;
pub(in crate::languages) mod crates;
mod declared;
pub(in crate::languages) mod federate;
mod integer;
mod items;
mod layout;
pub(in crate::languages) mod manifest;
mod names;
mod nesting;
mod print;
mod reactor;
pub(in crate::languages) mod rti;
mod scope;
mod sendable;
pub(in crate::languages) mod sending;
mod shape;
mod splice;
mod types;
mod values;

use super::language::{BlockEnd, CodeKind, CodeProblem, Language, LiteralKind, Preambles, Unsendable};
use super::lexical;
use crate::diagnostics::{Code, Diagnostic};
use crate::emit::{EmitError, File, Job, SourceMap};
use crate::plan::{Plan, Serializer, Shape};
use crate::syntax::ast::{Expression, Literal, TypeSyntax};

/// `target Rust`
#[derive(Debug)]
pub(crate) struct Rust;

impl Language for Rust {
    fn name(&self) -> &'static str {
        "Rust"
    }

    fn aliases(&self) -> &'static [&'static str] {
        &[]
    }

    fn block_end(&self, text: &str) -> BlockEnd {
        lexical::block_end(text, code_block::skip)
    }

    fn code_problem(&self, text: &str, kind: CodeKind) -> Option<CodeProblem> {
        code_syntax::problem(text, kind)
    }

    fn name_problem(&self, name: &str, in_bodies: bool, _: &str) -> Option<&'static str> {
        names::problem(name, in_bodies)
    }

    fn name_code(&self) -> Code {
        Code::RustName
    }

    fn port_of_child(&self, child: &str, port: &str) -> String {
        format!("{child}__{port}")
    }

    fn member_of_self(&self, name: &str) -> String {
        format!("self.{name}")
    }

    fn type_text(&self, ty: &TypeSyntax) -> String {
        types::text(ty)
    }

    fn type_problem(&self, ty: &TypeSyntax) -> Option<Diagnostic> {
        types::problem(ty)
    }

    fn time_type(&self) -> &'static str {
        types::DURATION
    }

    fn empty_type(&self) -> &'static str {
        "()"
    }

    fn type_of_literal(&self, literal: &Literal) -> &'static str {
        types::of_literal(literal)
    }

    fn literals_of(&self, ty: &str) -> Option<LiteralKind> {
        types::literals(ty)
    }

    fn serializers(&self) -> &'static [&'static str] {
        sending::SERIALIZERS
    }

    fn unsendable(&self, ty: &str, serializer: Option<&Serializer>, preambles: Preambles<'_>) -> Vec<Unsendable> {
        sendable::unsendable(ty, serializer, preambles)
    }

    fn shape(&self, ty: &str, preambles: Preambles<'_>) -> Result<Shape, Vec<Unsendable>> {
        shape::shape(ty, preambles)
    }

    fn uncopyable(&self, ty: &str, preambles: Preambles<'_>) -> Option<Unsendable> {
        sendable::uncopyable(ty, preambles)
    }

    fn is_same_type(&self, one: &str, other: &str) -> bool {
        types::last_names(one) == types::last_names(other)
    }

    fn value_text(&self, value: &Expression, ty: &str) -> String {
        values::text(value, ty)
    }

    fn integer(&self, code: &str, parameter: &dyn Fn(&str) -> Option<i64>) -> Option<i64> {
        integer::value(code, parameter)
    }

    fn replaces_events(&self) -> bool {
        true
    }

    fn deadlines_come_first(&self) -> bool {
        false
    }

    fn has_negative_times(&self) -> bool {
        false
    }

    fn allows_superfluous_types(&self) -> bool {
        false
    }

    fn has_workers(&self) -> bool {
        true
    }

    fn has_external_bodies(&self) -> bool {
        false
    }

    fn emit(&self, job: &Job<'_>, files: &mut Vec<File>, map: &mut SourceMap) -> Result<(), EmitError> {
        crates::emit(job, files, map)
    }

    fn workspace(&self, plan: &Plan, folders: &[String]) -> File {
        manifest::of_workspace(plan, folders)
    }
}
