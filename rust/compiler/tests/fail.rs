// SPDX-License-Identifier: Apache-2.0
//! Programs that must not compile; the file beside each has its messages.
//!
//! `cargo xtask bless -p lf-compiler fail::` rewrites the expected output.

use std::fs;
use std::path::{Path, PathBuf};

use lf_compiler::{SourceProvider, Style, compile};

struct Folder(PathBuf);

impl SourceProvider for Folder {
    fn read(&self, path: &str) -> Result<String, String> {
        fs::read_to_string(self.0.join(path)).map_err(|_| "it does not exist".to_owned())
    }
}

#[test]
fn every_wrong_program_is_refused_with_its_known_words() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fail");
    let mut names: Vec<String> = fs::read_dir(&folder)
        .expect("the folder is part of the repository")
        .map(|entry| entry.expect("the folder can be listed").file_name().to_string_lossy().into_owned())
        .filter_map(|name| name.strip_suffix(".lf").map(str::to_owned))
        .collect();
    names.sort();
    assert!(names.len() >= 25, "only {} programs were found", names.len());
    let provider = Folder(folder);
    for name in names {
        let compilation = compile(&format!("{name}.lf"), &provider);
        assert!(compilation.plan.is_none(), "{name} has a plan");
        assert!(compilation.diagnostics.has_errors(), "{name} has no error");
        insta::with_settings!({
            snapshot_path => "../../../tests/fail",
            prepend_module_to_snapshot => false,
            omit_expression => true,
        }, {
            insta::assert_snapshot!(name, compilation.diagnostics.render(Style::Plain));
        });
    }
}
