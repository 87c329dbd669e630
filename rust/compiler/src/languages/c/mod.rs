// SPDX-License-Identifier: Apache-2.0
//! Facts about C.

mod integer;
mod shape;
mod types;
mod values;

pub(crate) use types::{INTERVAL, PROTO, TYPE_OF, literals};

use super::facts::Facts;
use crate::diagnostics::Code;

/// The facts about C.
pub(super) const FACTS: Facts = Facts {
    name_code: Code::LanguageName,
    between_child_and_port: ".",
    before_member: "self->",
    time_type: INTERVAL,
    empty_type: types::VOID,
    serializers: &["native", PROTO],
    replaces_events: false,
    deadlines_come_first: true,
    negative_times: true,
    superfluous_types: true,
    external_bodies: true,
    unknown_threads: true,
    native_bodies: true,
    preprocessor: true,
    type_text: types::text,
    type_problem: types::problem,
    type_of_literal: types::of_literal,
    literals_of: types::literals,
    is_same_type: |one, other| types::representation(one) == types::representation(other),
    value_text: values::text,
    integer: integer::value,
    unsendable: |ty, serializer, _| types::unsendable(ty, serializer).into_iter().collect(),
    not_handed_over: |ty, serializer, _| types::not_handed_over(ty, serializer).into_iter().collect(),
    shape: |ty, _| shape::shape(ty).map_err(|why| vec![why]),
    // Values are copied as bytes, and values behind pointers are counted.
    uncopyable: |_, _| None,
};
