// SPDX-License-Identifier: Apache-2.0
//! The folder that the results are written to.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lf_bench::results::{FORMAT, Results};
use lf_bench::{Result, page};

/// A folder that can be written to.
pub(super) struct Folder(PathBuf);

impl Folder {
    /// Makes it if it is not there; tells now if it cannot be written to, and not after an hour.
    pub(super) fn new(path: &Path) -> Result<Self> {
        let refuse = |error: std::io::Error| {
            format!("--report {}: {error}; name a folder that you may write to", path.display())
        };
        fs::create_dir_all(path).map_err(refuse)?;
        let probe = path.join(".lf-bench");
        fs::write(&probe, "").and_then(|()| fs::remove_file(&probe)).map_err(refuse)?;
        Ok(Self(path.to_owned()))
    }

    pub(super) fn page(&self) -> PathBuf {
        self.0.join("report.html")
    }

    /// Writes the results, and the page that is made of them.
    pub(super) fn write(&self, results: &Results) -> Result<()> {
        self.put("results.json", &(serde_json::to_string_pretty(results)? + "\n"))?;
        self.put("report.html", &page::render(results)?)
    }

    /// Replaces a file as a whole: whoever is stopped in between leaves the one before.
    fn put(&self, name: &str, text: &str) -> Result<()> {
        let file = self.0.join(name);
        let new = file.with_extension("new");
        fs::write(&new, text)
            .and_then(|()| fs::rename(&new, &file))
            .map_err(|error| format!("{}: {error}", file.display()).into())
    }
}

/// Results that were written before.
pub(super) fn read(file: &Path) -> Result<Results> {
    #[derive(serde::Deserialize)]
    struct Head {
        format: u32,
    }
    let wrong = |what: String| format!("--from {}: {what}", file.display());
    let text = fs::read_to_string(file).map_err(|error| wrong(error.to_string()))?;
    let no_results = |error| wrong(format!("{error}; give a results.json that --report has written"));
    let head: Head = serde_json::from_str(&text).map_err(no_results)?;
    if head.format != FORMAT {
        return Err(wrong(format!("it has format {}, and this program reads {FORMAT}", head.format)).into());
    }
    Ok(serde_json::from_str(&text).map_err(no_results)?)
}

/// The time in UTC; nothing where the system cannot tell.
pub(super) fn now() -> String {
    let output = Command::new("date").args(["-u", "+%Y-%m-%d %H:%M UTC"]).output();
    output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default()
}
