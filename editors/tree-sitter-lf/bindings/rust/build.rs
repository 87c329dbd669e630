// SPDX-License-Identifier: Apache-2.0
//! Generates the parser from `grammar.js`, and compiles it.

#[cfg(not(feature = "parser"))]
fn main() {}

#[cfg(feature = "parser")]
fn main() -> Result<(), String> {
    generated::make().map_err(|error| format!("cannot generate the parser, which needs Node.js: {error}"))
}

#[cfg(feature = "parser")]
mod generated {
    use std::env;
    use std::error::Error;
    use std::path::PathBuf;

    use tree_sitter_generate::{OptLevel, generate_parser_in_directory};

    /// The version of the interface to editors: the highest one that every Neovim since 0.9 knows.
    const ABI: usize = 14;

    pub(crate) fn make() -> Result<(), Box<dyn Error>> {
        let folder = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
        let out = PathBuf::from(env::var("OUT_DIR")?);
        let grammar = folder.join("grammar.js");
        let scanner = folder.join("src/scanner.c");
        for file in [&grammar, &scanner] {
            println!("cargo:rerun-if-changed={}", file.display());
        }
        let (to, from, runtime) = (Some(&out), Some(&grammar), Some("node"));
        generate_parser_in_directory(&folder, to, from, ABI, None, runtime, true, OptLevel::default())?;
        cc::Build::new()
            .std("c11")
            .include(&out)
            .file(out.join("parser.c"))
            .file(&scanner)
            .try_compile("tree-sitter-lf")?;
        Ok(())
    }
}
