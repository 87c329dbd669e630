// SPDX-License-Identifier: Apache-2.0
//! The outcomes of all programs: by folder, and why some did not pass.

use std::collections::BTreeMap;
use std::process::ExitCode;

/// The outcome of a program.
pub(super) enum Verdict {
    Passed,
    /// It has no main reactor, because others import it.
    Library,
    /// It needs an unsupported part of LF.
    Refused(String),
    Failed(String),
}

/// The outcomes of all programs.
#[derive(Default)]
pub(super) struct Verdicts {
    /// The numbers of passed, failed and refused programs by folder.
    folders: BTreeMap<String, [usize; 3]>,
    libraries: usize,
    /// Programs with reasons.
    failed: Vec<(String, String)>,
    /// Programs by the reason for which they were refused.
    refused: BTreeMap<String, Vec<String>>,
}

impl Verdicts {
    /// Prints the outcome of a program, and counts it.
    pub(super) fn add(&mut self, name: &str, verdict: Verdict) {
        let column = match verdict {
            Verdict::Passed => {
                println!("passed   {name}");
                0
            }
            Verdict::Library => {
                self.libraries += 1;
                return;
            }
            Verdict::Refused(reason) => {
                println!("refused  {name}: {reason}");
                self.refused.entry(reason).or_default().push(name.to_owned());
                2
            }
            Verdict::Failed(reason) => {
                println!("FAILED   {name}: {reason}");
                self.failed.push((name.to_owned(), reason));
                1
            }
        };
        let folder = name.rsplit_once('/').map_or(".", |(folder, _)| folder);
        self.folders.entry(folder.to_owned()).or_default()[column] += 1;
    }

    /// Prints the tables; succeeds if no program failed.
    pub(super) fn close(self) -> ExitCode {
        let Self { folders, libraries, failed, refused } = self;
        let mut reasons: Vec<_> = refused.into_iter().collect();
        reasons.sort_by_key(|(_, names)| std::cmp::Reverse(names.len()));
        for (reason, names) in &reasons {
            println!("refused {} times: {reason}", names.len());
            println!("    {}", names.join(", "));
        }
        for (name, reason) in &failed {
            println!("FAILED {name}: {reason}");
        }
        println!("{libraries} files without a main reactor");
        let mut sum = [0; 3];
        println!("{:40}   passed   failed  refused", "folder");
        for (folder, counts) in &folders {
            println!("{folder:40} {:8} {:8} {:8}", counts[0], counts[1], counts[2]);
            sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        println!("{} passed, {} failed, {} refused", sum[0], sum[1], sum[2]);
        if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}
