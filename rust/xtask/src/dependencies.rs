// SPDX-License-Identifier: Apache-2.0
//! The licences and the sources of all that the workspace depends on.

use std::path::Path;

use serde_json::Value;
use spdx::{Expression, ParseMode};

use crate::process;
use crate::report::Report;

/// The licences that a dependency may have. One whose licence is a choice has one of them among its choices.
const LICENCES: [&str; 6] = ["Apache-2.0", "BSD-3-Clause", "ISC", "MIT", "Unicode-3.0", "Zlib"];
/// The source of dependencies in cargo's form.
const CRATES_IO: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Checks that each dependency has an allowed licence, and comes from crates.io.
pub(crate) fn check(repository: &Path, report: &mut Report) {
    let metadata = process::captured(process::cargo(repository).args(["metadata", "--format-version", "1", "--quiet"]));
    let Some(metadata) = metadata.and_then(|text| serde_json::from_str::<Value>(&text).ok()) else {
        report.fail("dependencies", "`cargo metadata` does not list the dependencies");
        return;
    };
    let packages = metadata["packages"].as_array().into_iter().flatten();
    let findings: Vec<String> = packages.filter_map(finding).collect();
    for finding in &findings {
        eprintln!("error: {finding}");
    }
    report.check("dependencies", findings.is_empty());
}

/// Returns the problem of a package in cargo's metadata.
fn finding(package: &Value) -> Option<String> {
    let [name, version] = ["name", "version"].map(|key| package[key].as_str().unwrap_or_default());
    let source = package["source"].as_str();
    if let Some(source) = source.filter(|source| *source != CRATES_IO) {
        return Some(format!("{name} {version} comes from {source}, not from crates.io"));
    }
    let licence = package["license"].as_str().unwrap_or_default();
    // Many crates still have `/` for `OR`.
    let expression = Expression::parse_mode(licence, ParseMode::LAX).ok();
    let allowed = expression.is_some_and(|expression| {
        expression.evaluate(|wanted| wanted.license.id().is_some_and(|id| LICENCES.contains(&id.name)))
    });
    (!allowed).then(|| format!("{name} {version} has the licence `{licence}`: allowed are {}", LICENCES.join(", ")))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn found(licence: &str, source: Option<&str>) -> Option<String> {
        finding(&json!({ "name": "a", "version": "1.0.0", "license": licence, "source": source }))
    }

    #[test]
    fn a_dependency_needs_an_allowed_licence_and_comes_from_crates_io() {
        for licence in ["MIT", "MIT/Apache-2.0", "GPL-2.0-only OR MIT", "(MIT OR Apache-2.0) AND Unicode-3.0"] {
            assert_eq!(found(licence, Some(CRATES_IO)), None);
        }
        for licence in ["", "GPL-3.0-only", "MIT AND GPL-3.0-only", "own"] {
            assert!(found(licence, Some(CRATES_IO)).is_some_and(|text| text.contains(&format!("`{licence}`"))));
        }
        assert_eq!(found("MIT", None), None);
        assert!(found("MIT", Some("git+https://example.org/a")).is_some_and(|text| text.contains("example.org")));
    }
}
