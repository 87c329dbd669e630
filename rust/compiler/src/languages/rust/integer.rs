// SPDX-License-Identifier: Apache-2.0
//! Integers that are known at compile time.

use quote::ToTokens;
use syn::{Expr, Lit, UnOp};

use crate::languages::integer::operation;

/// Returns the value of an expression of integers and parameters; `None` for any other one.
pub(super) fn value(code: &str, parameter: &dyn Fn(&str) -> Option<i64>) -> Option<i64> {
    evaluate(&syn::parse_str(code).ok()?, parameter)
}

fn evaluate(expression: &Expr, parameter: &dyn Fn(&str) -> Option<i64>) -> Option<i64> {
    match expression {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(number) => number.base10_parse().ok(),
            _ => None,
        },
        Expr::Path(path) => parameter(&path.path.get_ident()?.to_string()),
        Expr::Paren(inner) => evaluate(&inner.expr, parameter),
        Expr::Group(inner) => evaluate(&inner.expr, parameter),
        Expr::Cast(cast) => evaluate(&cast.expr, parameter),
        Expr::Unary(unary) => match unary.op {
            UnOp::Neg(_) => evaluate(&unary.expr, parameter)?.checked_neg(),
            _ => None,
        },
        Expr::Binary(binary) => {
            let (left, right) = (evaluate(&binary.left, parameter)?, evaluate(&binary.right, parameter)?);
            operation(&binary.op.to_token_stream().to_string(), left, right)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::value;

    #[test]
    fn arithmetic_of_parameters_is_worked_out_and_nothing_else() {
        let parameter = |name: &str| (name == "n").then_some(4);
        for (code, expected) in [
            (" 3 ", Some(3)),
            ("n * 2 + 1", Some(9)),
            ("(n as usize - 1) % 2", Some(1)),
            ("1u32 << n", Some(16)),
            ("-n", Some(-4)),
            ("n / 0", None),
            ("i64::MAX", None),
            ("f(n)", None),
            ("n +", None),
            ("9223372036854775807 + n", None),
        ] {
            assert_eq!(value(code, &parameter), expected, "{code}");
        }
    }
}
