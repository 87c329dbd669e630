// SPDX-License-Identifier: Apache-2.0
//! Compiles generated sources.

use std::collections::BTreeMap;

use lf_compiler::plan::Plan;
use lf_compiler::{Code, Style, compile};

/// Returns the plan; or whether the reason of the failure is a loop, and the messages.
pub(crate) fn compile_text(text: &str) -> Result<Plan, (bool, String)> {
    let files = BTreeMap::from([("Simulated.lf".to_owned(), text.to_owned())]);
    let compilation = compile("Simulated.lf", &files);
    compilation.plan.ok_or_else(|| {
        let is_loop = compilation.diagnostics.iter().any(|entry| entry.code == Code::CausalityLoop);
        (is_loop, compilation.diagnostics.render(Style::Plain))
    })
}
