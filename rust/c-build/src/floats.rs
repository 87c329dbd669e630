// SPDX-License-Identifier: Apache-2.0
//! Finds functions of bindings that cannot be called where Rust and C pass floating-point numbers in different
//! registers.

use std::collections::BTreeMap;

use syn::punctuated::Punctuated;
use syn::token::Comma;
use syn::visit::{self, Visit};
use syn::{FnArg, ForeignItemFn, ItemStruct, ItemType, ItemUnion, ReturnType, Type, TypePath, TypePtr};

/// Types of numbers that such registers hold.
const NUMBERS: [&str; 4] = ["f32", "f64", "c_float", "c_double"];

/// Returns the functions that have such numbers as parameters or results by value, or functions that do.
pub(crate) fn functions(bindings: &str) -> Vec<String> {
    let file = syn::parse_file(bindings).expect("bindgen writes Rust");
    let mut types = Types::default();
    types.visit_file(&file);
    types
        .functions
        .iter()
        .filter(|(_, signature)| types.has_number(signature, 0))
        .map(|(name, _)| name.clone())
        .collect()
}

/// The components of types, and the signatures of functions.
#[derive(Default)]
struct Types {
    parts: BTreeMap<String, Vec<Type>>,
    functions: Vec<(String, Vec<Type>)>,
}

impl<'ast> Visit<'ast> for Types {
    fn visit_item_struct(&mut self, item: &'ast ItemStruct) {
        self.parts.insert(item.ident.to_string(), item.fields.iter().map(|field| field.ty.clone()).collect());
    }

    fn visit_item_union(&mut self, item: &'ast ItemUnion) {
        let fields = item.fields.named.iter().map(|field| field.ty.clone());
        self.parts.insert(item.ident.to_string(), fields.collect());
    }

    fn visit_item_type(&mut self, item: &'ast ItemType) {
        self.parts.insert(item.ident.to_string(), vec![(*item.ty).clone()]);
    }

    fn visit_foreign_item_fn(&mut self, item: &'ast ForeignItemFn) {
        self.functions.push((item.sig.ident.to_string(), signature(&item.sig.inputs, &item.sig.output)));
    }
}

fn signature(inputs: &Punctuated<FnArg, Comma>, output: &ReturnType) -> Vec<Type> {
    let inputs = inputs.iter().filter_map(|input| match input {
        FnArg::Typed(input) => Some((*input.ty).clone()),
        FnArg::Receiver(_) => None,
    });
    let output = match output {
        ReturnType::Type(_, ty) => Some((**ty).clone()),
        ReturnType::Default => None,
    };
    inputs.chain(output).collect()
}

/// The maximum nesting of types: deeper ones form a circle, through functions.
const DEPTH_MAX: usize = 16;

impl Types {
    fn has_number(&self, types: &[Type], depth: usize) -> bool {
        let mut finder = FloatFinder { types: self, depth, found: false };
        for ty in types {
            finder.visit_type(ty);
        }
        finder.found
    }
}

/// Visits the components of a type, not through pointers, but through function types.
struct FloatFinder<'t> {
    types: &'t Types,
    depth: usize,
    found: bool,
}

impl<'ast> Visit<'ast> for FloatFinder<'_> {
    fn visit_type_ptr(&mut self, _: &'ast TypePtr) {}

    fn visit_type_path(&mut self, path: &'ast TypePath) {
        let name = path.path.segments.last().map(|segment| segment.ident.to_string()).unwrap_or_default();
        self.found |= NUMBERS.contains(&name.as_str());
        if let Some(parts) = self.types.parts.get(&name).filter(|_| self.depth < DEPTH_MAX) {
            self.found |= self.types.has_number(parts, self.depth + 1);
        }
        visit::visit_type_path(self, path);
    }
}

#[cfg(test)]
mod tests {
    use super::functions;

    #[test]
    fn numbers_are_found_in_structs_and_in_functions_but_not_behind_pointers() {
        let bindings = "
            pub type celsius = f32;
            pub struct reading { pub number: u32, pub value: celsius }
            pub type handler = ::core::option::Option<unsafe extern \"C\" fn(value: ::core::ffi::c_double)>;
            unsafe extern \"C\" {
                pub fn takes(value: f64);
                pub fn gives() -> reading;
                pub fn calls(handler: handler);
                pub fn points(to: *mut reading) -> u32;
            }";
        assert_eq!(functions(bindings), ["takes", "gives", "calls"]);
    }
}
