// SPDX-License-Identifier: Apache-2.0
//! Integers that are known at compile time.

/// Returns the result of an operator; `None` on overflow, or for an operator that is none of integers.
pub(super) fn operation(operator: &str, left: i64, right: i64) -> Option<i64> {
    match operator {
        "+" => left.checked_add(right),
        "-" => left.checked_sub(right),
        "*" => left.checked_mul(right),
        "/" => left.checked_div(right),
        "%" => left.checked_rem(right),
        "<<" => left.checked_shl(u32::try_from(right).ok()?),
        ">>" => left.checked_shr(u32::try_from(right).ok()?),
        _ => None,
    }
}
