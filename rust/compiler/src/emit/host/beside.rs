// SPDX-License-Identifier: Apache-2.0
//! C beside bodies in another language: files that are compiled with a participant, and headers that are bound for it.

use std::collections::BTreeSet;

use super::compilation::{CompilerArguments, concerns};
use crate::emit::{File, Job};
use crate::plan::Location;

/// The C code that a participant has beside its bodies.
pub(in crate::emit) struct Beside<'p>(CompilerArguments<'p>);

impl<'p> Beside<'p> {
    /// Returns the C code named in those files that are in the crate: it would not see the types of the others. An RTI
    /// alone, which runs no reactions, has the headers only.
    pub(in crate::emit) fn new(job: &Job<'p>, has_file: impl Fn(Location) -> bool) -> Self {
        let (native, mut all) = (&job.view.native, CompilerArguments::default());
        let runs = |at: Location| job.federate.is_some() && concerns(job, at);
        let sources = native.sources.iter().filter(|file| runs(file.at));
        all.sources.extend(sources.map(|file| job.settings.absolute(&file.path)));
        let headers = native.headers.iter().filter(|file| has_file(file.at));
        let first = headers.clone().next().map(|file| (job.plan().path(file.at), file.at));
        all.place = first.map(|(path, at)| format!("{path}:{}:{}", at.line, at.column));
        all.headers.extend(headers.clone().map(|file| job.settings.absolute(&file.path)));
        for list in [&mut all.sources, &mut all.headers] {
            let mut seen = BTreeSet::new();
            list.retain(|path| seen.insert(path.clone()));
        }
        // C names files from the folder of the LF file, or by their own names if a header is there.
        let named = native.sources.iter().chain(&native.headers).chain(&native.folders);
        for file in named.filter(|file| has_file(file.at)) {
            all.add_folder_around(job, job.plan().path(file.at));
        }
        for header in headers {
            all.add_folder_around(job, &header.path);
        }
        for folder in native.folders.iter().filter(|folder| has_file(folder.at)) {
            all.add_folder(job.settings.absolute(&folder.path));
        }
        all.add_definitions(job, &has_file);
        all.cmake.extend(native.cmake.iter().filter(|cmake| runs(cmake.at)));
        Self(all)
    }

    /// Returns whether there is any.
    pub(in crate::emit) fn is_any(&self) -> bool {
        self.has_headers() || !self.0.sources.is_empty() || !self.0.cmake.is_empty()
    }

    /// Returns whether the crate has the module `c`.
    pub(in crate::emit) fn has_headers(&self) -> bool {
        !self.0.headers.is_empty()
    }

    /// Returns the files that configure its compilation: for this computer the build script, which also binds headers;
    /// for an image `c.cmake` beside it.
    pub(in crate::emit) fn files(&self, job: &Job<'_>) -> Vec<File> {
        let (folder, binds, mut files) = (job.folder, self.has_headers(), Vec::new());
        if !self.is_any() {
            return files;
        }
        let mut all = self.0.clone();
        if job.is_image {
            let bindings = if binds { "set(bindings TRUE)\n" } else { "" };
            let text = all.cmake(job, std::iter::empty()) + bindings;
            files.push(File { path: format!("{folder}/c.cmake"), text });
            // CMake gets include folders in another way, with those that files for CMake add.
            let CompilerArguments { flags, headers, place, .. } = all;
            all = CompilerArguments { flags, headers, place, ..CompilerArguments::default() };
        }
        if binds || !job.is_image {
            files.push(File { path: format!("{folder}/build.rs"), text: all.build_script(job, "beside") });
        }
        files
    }
}
