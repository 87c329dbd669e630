// SPDX-License-Identifier: Apache-2.0
//! What is generated of a plan whose bodies are C.

use crate::emit::{EmitError, File, Job, SourceMap};
use crate::plan::Plan;

/// Adds the files of a participant's program.
///
/// # Errors
/// Always: nothing is generated yet.
pub(super) fn emit(job: &Job<'_>, _files: &mut Vec<File>, _map: &mut SourceMap) -> Result<(), EmitError> {
    let at = job.plan.classes[job.plan.main.0].at;
    Err(EmitError::new(job.plan, at, "bodies in C are not generated yet".to_owned()))
}

/// The file by which programs for this computer are built together.
pub(super) fn workspace(_plan: &Plan, _folders: &[String]) -> File {
    File { path: "Cargo.toml".to_owned(), text: String::new() }
}
