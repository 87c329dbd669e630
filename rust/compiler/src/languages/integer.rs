// SPDX-License-Identifier: Apache-2.0
//! Integers that can be worked out when the program is compiled.

/// What an operator makes of two values; nothing where it does not fit, or for an operator that is none of integers.
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
