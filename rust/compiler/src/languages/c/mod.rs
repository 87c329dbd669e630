// SPDX-License-Identifier: Apache-2.0
//! C: bodies as functions of C, which the same crate calls that a program in Rust is.

mod code_block;
pub(in crate::languages) mod emit;
mod integer;
mod names;
mod shape;
mod types;
mod values;

pub(in crate::languages) use emit::{Beside, Sizes};

use super::language::{BlockEnd, CodeKind, CodeProblem, Language, LiteralKind, Preambles, Unsendable};
use super::lexical;
use crate::diagnostics::{Code, Diagnostic};
use crate::emit::{EmitError, File, Job, SourceMap};
use crate::plan::{Plan, Serializer, Shape};
use crate::syntax::ast::{Expression, Literal, TypeSyntax};

/// Its name in the target declaration.
pub(in crate::languages) const NAME: &str = "C";

/// The name by which bodies are compiled as C++.
const CPP: &str = "CCpp";

/// `target C`, and `target CCpp`, whose bodies are compiled as C++
#[derive(Debug)]
pub(crate) struct C;

impl Language for C {
    fn name(&self) -> &'static str {
        NAME
    }

    fn aliases(&self) -> &'static [&'static str] {
        &[CPP]
    }

    fn block_end(&self, text: &str) -> BlockEnd {
        lexical::block_end(text, code_block::skip)
    }

    fn code_problem(&self, text: &str, kind: CodeKind) -> Option<CodeProblem> {
        code_block::problem(text, kind)
    }

    fn name_problem(&self, name: &str, in_bodies: bool, target: &str) -> Option<&'static str> {
        names::problem(name, in_bodies, target.eq_ignore_ascii_case(CPP))
    }

    fn name_code(&self) -> Code {
        Code::LanguageName
    }

    fn port_of_child(&self, child: &str, port: &str) -> String {
        format!("{child}.{port}")
    }

    fn member_of_self(&self, name: &str) -> String {
        format!("self->{name}")
    }

    fn type_text(&self, ty: &TypeSyntax) -> String {
        types::text(ty)
    }

    fn type_problem(&self, ty: &TypeSyntax) -> Option<Diagnostic> {
        types::problem(ty)
    }

    fn time_type(&self) -> &'static str {
        types::INTERVAL
    }

    fn empty_type(&self) -> &'static str {
        types::VOID
    }

    fn type_of_literal(&self, literal: &Literal) -> &'static str {
        types::of_literal(literal)
    }

    fn literals_of(&self, ty: &str) -> Option<LiteralKind> {
        types::literals(ty)
    }

    fn serializers(&self) -> &'static [&'static str] {
        &["native"]
    }

    fn unsendable(&self, ty: &str, _: Option<&Serializer>, _: Preambles<'_>) -> Vec<Unsendable> {
        types::unsendable(ty).into_iter().collect()
    }

    fn shape(&self, ty: &str, _: Preambles<'_>) -> Result<Shape, Vec<Unsendable>> {
        shape::shape(ty).map_err(|why| vec![why])
    }

    // Values are copied as they lie, and those behind pointers are counted.
    fn uncopyable(&self, _: &str, _: Preambles<'_>) -> Option<Unsendable> {
        None
    }

    fn is_same_type(&self, one: &str, other: &str) -> bool {
        types::spelled(one) == types::spelled(other)
    }

    fn value_text(&self, value: &Expression, ty: &str) -> String {
        values::text(value, ty)
    }

    fn integer(&self, code: &str, parameter: &dyn Fn(&str) -> Option<i64>) -> Option<i64> {
        integer::value(code, parameter)
    }

    fn replaces_events(&self) -> bool {
        false
    }

    fn deadlines_come_first(&self) -> bool {
        true
    }

    fn has_negative_times(&self) -> bool {
        true
    }

    fn allows_superfluous_types(&self) -> bool {
        true
    }

    fn has_workers(&self) -> bool {
        false
    }

    fn has_external_bodies(&self) -> bool {
        true
    }

    fn emit(&self, job: &Job<'_>, files: &mut Vec<File>, map: &mut SourceMap) -> Result<(), EmitError> {
        emit::emit(job, files, map)
    }

    fn workspace(&self, plan: &Plan, folders: &[String]) -> File {
        emit::workspace(plan, folders)
    }
}
