// SPDX-License-Identifier: Apache-2.0
//! Parameters of the main reactor that can be set on a program's command line.

use proc_macro2::TokenStream;
use quote::quote;

use super::class_file::ClassFile;
use super::types::CType;
use crate::emit::view::View;
use crate::languages::LiteralKind;
use crate::languages::c::{INTERVAL, literals};
use crate::plan::{Fixed, Value};

/// The kind of a value on a command line.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ArgumentKind {
    Time,
    Bool,
    Whole,
    Real,
    Text,
    /// A type without a representation on a command line.
    Other,
}

impl ArgumentKind {
    fn of(ty: &CType) -> Self {
        match ty.text() {
            INTERVAL | "instant_t" => Self::Time,
            "bool" | "_Bool" => Self::Bool,
            "float" | "double" | "long double" => Self::Real,
            "string" | "char*" | "const char*" => Self::Text,
            other if literals(other) == Some(LiteralKind::Number) => Self::Whole,
            _ => Self::Other,
        }
    }
}

/// Returns the parameters for the program's `main`.
pub(super) fn of_main(view: &View<'_>) -> TokenStream {
    let class = view.class(view.plan.main);
    let rows = class.parameters.iter().map(|parameter| {
        let (name, ty) = (&parameter.name, CType::new(class, &parameter.ty));
        let kind = match ArgumentKind::of(&ty) {
            ArgumentKind::Time => quote!(lf::ParameterKind::Time),
            ArgumentKind::Bool => quote!(lf::ParameterKind::Bool),
            ArgumentKind::Whole => quote!(lf::ParameterKind::Whole),
            ArgumentKind::Real => quote!(lf::ParameterKind::Real),
            ArgumentKind::Text => quote!(lf::ParameterKind::Text),
            ArgumentKind::Other => quote!(lf::ParameterKind::Other),
        };
        let kind = match parameter.fixed {
            Some(Fixed::Width) => quote!(lf::ParameterKind::FixedWidth),
            Some(Fixed::Time) => quote!(lf::ParameterKind::FixedTime),
            None => kind,
        };
        let default = match &parameter.default {
            Some(Value::Time { ns }) => crate::plan::Time(*ns).to_string(),
            Some(Value::Code(code)) => code.text.trim().to_owned(),
            None => String::new(),
        };
        let ty = ty.text();
        quote!(lf::Parameter { name: #name, ty: #ty, kind: #kind, default: #default })
    });
    let rows: Vec<TokenStream> = rows.collect();
    if rows.is_empty() {
        return quote!(lf::Parameters::NONE);
    }
    quote!(lf::Parameters { rows: &[#(#rows),*], give: lf::c::give_parameter })
}

impl ClassFile<'_, '_> {
    /// Emits the function that assigns values of the command line to parameters of the main reactor. It returns whether
    /// a value belongs to the parameter's type.
    pub(super) fn give(&mut self) {
        let (class, linkage) = (self.class, self.linkage());
        self.text.line(format_args!(
            "\n/* Values from the command line. */\nextern {}const void *lf_main_given[];\n\
             {linkage}bool {}_give(int lf_index, long long lf_whole, double lf_real, char *lf_text) {{\n    \
             (void)lf_whole, (void)lf_real, (void)lf_text;\n    switch (lf_index) {{",
            if linkage.is_empty() { "" } else { "\"C\" " },
            self.name
        ));
        for (index, parameter) in class.parameters.iter().enumerate().filter(|(_, one)| one.fixed.is_none()) {
            let ty = self.ty(&parameter.ty);
            let (variable, place) = (format!("lf_value_{index}"), ty.declare(&format!("lf_value_{index}")));
            let lines = match ArgumentKind::of(&ty) {
                ArgumentKind::Other => continue,
                ArgumentKind::Time | ArgumentKind::Bool => format!("{variable} = lf_whole;"),
                // The comparison detects values outside of the type's range, which change in the conversion.
                ArgumentKind::Whole => format!(
                    "{variable} = ({})lf_whole;\n        if ((long long){variable} != lf_whole || ({variable} < 0) != \
                     (lf_whole < 0)) {{\n            return false;\n        }}",
                    ty.text()
                ),
                ArgumentKind::Real => format!("{variable} = ({})lf_real;", ty.text()),
                ArgumentKind::Text => format!("{variable} = lf_text;"),
            };
            self.text.line(format_args!(
                "    case {index}: {{\n        static {place};\n        {lines}\n        \
                 lf_main_given[{index}] = &{variable};\n        return true;\n    }}"
            ));
        }
        self.text.line("    default:\n        return false;\n    }\n}");
    }
}
