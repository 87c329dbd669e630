// SPDX-License-Identifier: Apache-2.0
//! Types of declarations: as written, or inferred from the initial value.

use super::checker::Checker;
use super::model::CheckedParameter;
use crate::diagnostics::{Code, Diagnostic, Span};
use crate::syntax::ast::{Expression, ExpressionKind, Initialiser, Literal, Name, TypeKind, TypeSyntax};

/// The type of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Resolved {
    /// The type in the target language's spelling.
    pub(super) text: String,
    pub(super) span: Span,
    pub(super) is_time: bool,
}

impl Checker<'_> {
    /// Returns the type of a port or action; the type without a value if none is written.
    pub(super) fn signal_type(&mut self, ty: Option<&TypeSyntax>, name: &Name) -> Resolved {
        match ty {
            Some(ty) => self.written(ty),
            None => Resolved { text: self.language.facts().empty_type.to_owned(), span: name.span, is_time: false },
        }
    }

    /// Returns the type of a parameter or state variable; parameters in scope can determine it.
    pub(super) fn value_type(
        &mut self,
        ty: Option<&TypeSyntax>,
        init: Option<&Initialiser>,
        name: &Name,
        scope: &[CheckedParameter<'_>],
    ) -> Resolved {
        if let Some(ty) = ty {
            return self.written(ty);
        }
        let inferred = init.and_then(|init| self.infer(&init.value, scope));
        if let Some((text, is_time)) = inferred {
            return Resolved { text, span: name.span, is_time };
        }
        let unknown_name = init.is_some_and(|init| matches!(init.value.kind, ExpressionKind::Name(_)));
        // A value that names an unknown parameter has its own diagnostic.
        if !unknown_name {
            let message = format!("`{}` needs a type", name.text);
            let integer = (self.language.facts().type_of_literal)(&Literal::Int(String::new()));
            let hint = format!("write it behind the name: `{}: {integer}`", name.text);
            self.report(Diagnostic::new(Code::MissingType, name.span, message).hint(hint));
        }
        Resolved { text: self.language.facts().empty_type.to_owned(), span: name.span, is_time: false }
    }

    fn written(&mut self, ty: &TypeSyntax) -> Resolved {
        self.check_type(ty);
        Resolved { text: (self.language.facts().type_text)(ty), span: ty.span, is_time: ty.is_time() }
    }

    fn check_type(&mut self, ty: &TypeSyntax) {
        if let TypeKind::Path { arguments, .. } = &ty.kind {
            for argument in arguments {
                self.check_type(argument);
            }
        }
        if let Some(diagnostic) = (self.language.facts().type_problem)(ty) {
            self.report(diagnostic);
        }
    }

    /// Infers the type of a value from the value alone, and whether it is a time.
    fn infer(&self, value: &Expression, scope: &[CheckedParameter<'_>]) -> Option<(String, bool)> {
        match &value.kind {
            ExpressionKind::Time(_) => Some((self.language.facts().time_type.to_owned(), true)),
            ExpressionKind::Name(name) => scope
                .iter()
                .find(|parameter| parameter.name.text == *name)
                .map(|parameter| (parameter.ty.clone(), parameter.is_time)),
            ExpressionKind::Literal(literal) => {
                Some(((self.language.facts().type_of_literal)(literal).to_owned(), false))
            }
            ExpressionKind::Code(_) | ExpressionKind::List(_) => None,
        }
    }
}
