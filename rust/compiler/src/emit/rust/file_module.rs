// SPDX-License-Identifier: Apache-2.0
//! One module per LF file: its preambles, and the modules of its reactors.

use quote::quote;

use super::layout::Layout;
use crate::emit::host::{Splices, ident};
use crate::emit::view::View;
use crate::emit::{EmitError, File, FileMap};
use crate::plan::FileIndex;

/// Emits the module of an LF file; `binds` says whether the crate has the module `c`.
pub(super) fn emit(
    view: &View<'_>,
    layout: &Layout<'_>,
    file: FileIndex,
    binds: bool,
    path: String,
) -> Result<(File, FileMap), EmitError> {
    let path_of_source = &view.plan.files[file.0].path;
    let name = path_of_source.rsplit(['/', '\\']).next().unwrap_or(path_of_source);
    let about = format!(" The declarations of {name}.");
    let mut splices = Splices::new(view.plan);
    let mut preambles = Vec::new();
    for preamble in view.preambles(file) {
        preambles.push(splices.items(preamble)?);
    }
    let modules = layout.classes_of(file).map(|(_, module)| {
        let module = ident(module);
        quote!(pub mod #module;)
    });
    let siblings = layout.siblings_of(view, file).into_iter().map(|(folder, module)| {
        let (folder, module) = (ident(folder), ident(module));
        quote!(pub use crate::#folder::#module;)
    });
    let bindings = binds.then(|| {
        quote!(
            use crate::c;
        )
    });
    let tokens = quote! {
        #![doc = #about]
        #(#modules)*
        #(#siblings)*
        use ::lf::prelude::*;
        #bindings
        #(#preambles)*
    };
    splices.finish(path, tokens)
}
