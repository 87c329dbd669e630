// SPDX-License-Identifier: Apache-2.0
//! Facts about Rust.

mod declared;
mod integer;
mod sendable;
mod shape;
mod types;
mod values;

pub(crate) use sendable::{Growing, growing};
pub(crate) use types::{DURATION, is_copy};

use super::facts::Facts;
use crate::diagnostics::Code;

/// The facts about Rust.
pub(super) const FACTS: Facts = Facts {
    name_code: Code::RustName,
    between_child_and_port: "__",
    before_member: "self.",
    time_type: DURATION,
    empty_type: "()",
    // The first one is the layout of the type itself.
    serializers: &["native", "postcard"],
    replaces_events: true,
    deadlines_come_first: false,
    negative_times: false,
    superfluous_types: false,
    external_bodies: false,
    unknown_threads: false,
    native_bodies: false,
    preprocessor: false,
    type_text: types::text,
    type_problem: types::problem,
    type_of_literal: types::of_literal,
    literals_of: types::literals,
    is_same_type: |one, other| types::last_names(one) == types::last_names(other),
    value_text: values::text,
    integer: integer::value,
    unsendable: sendable::unsendable,
    not_handed_over: sendable::unsendable,
    shape: shape::shape,
    uncopyable: sendable::uncopyable,
};
