// SPDX-License-Identifier: Apache-2.0
//! Separates words for the C compiler into those for compiling and those for linking: the compiler accepts both, and
//! the host needs each by itself.

use super::compilation::CompilerArguments;
use crate::emit::Job;

/// Options whose value may be the next word. All of them also accept it as a suffix.
const WITH_VALUE: [&str; 12] =
    ["-I", "-D", "-U", "-L", "-l", "-T", "-u", "-z", "-isystem", "-iquote", "-idirafter", "-include"];

/// Options whose value is a path.
const PATHS: [&str; 8] = ["-isystem", "-iquote", "-idirafter", "-I", "-L", "-T", "-Wl,-L", "-Wl,-rpath,"];

/// Options for linking only.
const LINKED: [&str; 7] = ["-l", "-L", "-T", "-u", "-z", "-Wl,", "-rdynamic"];

/// Options that make code call a library, and its name.
const LIBRARIES: [(&str, &str); 4] =
    [("-fopenmp", "gomp"), ("--coverage", "gcov"), ("-fprofile-arcs", "gcov"), ("-fprofile-generate", "gcov")];

/// Libraries of sanitizers, which replace functions of others.
const SANITIZERS: [(&str, &str); 4] =
    [("address", "asan"), ("undefined", "ubsan"), ("thread", "tsan"), ("leak", "lsan")];

/// Returns whether a word is for linking only.
fn is_linked(word: &str) -> bool {
    word == "-Xlinker" || word != "-undef" && LINKED.iter().any(|option| word.starts_with(option))
}

impl CompilerArguments<'_> {
    /// Adds words for the compiler; paths in them are relative to the folder of the file at this path.
    pub(super) fn add_words<'w>(&mut self, job: &Job<'_>, words: impl IntoIterator<Item = &'w str>, file: &str) {
        for word in words {
            // A separate value belongs to the option before it.
            let begun = [&mut self.flags, &mut self.linked]
                .into_iter()
                .find_map(|list| list.pop_if(|last| WITH_VALUE.contains(&last.as_str()) || last == "-Xlinker"));
            match begun {
                Some(option) if option == "-Xlinker" => self.linked.push(format!("-Wl,{word}")),
                Some(option) => self.add_word(job, &(option + word), file),
                None => self.add_word(job, word, file),
            }
        }
    }

    fn add_word(&mut self, job: &Job<'_>, word: &str, file: &str) {
        let around = |path: &str| match file.rsplit_once('/') {
            _ if path.starts_with(['/', '=', '$']) => path.to_owned(),
            Some((folder, _)) => job.settings.absolute(&format!("{folder}/{path}")),
            None => job.settings.absolute(path),
        };
        let given = |option: &&&str| word.strip_prefix(**option).is_some_and(|value| !value.is_empty());
        let word = match PATHS.iter().find(given) {
            Some(option) => format!("{option}{}", around(&word[option.len()..])),
            None if !word.starts_with('-') => around(word),
            None => word.to_owned(),
        };
        if let Some(asked) = word.strip_prefix("-fsanitize=") {
            let libraries = SANITIZERS.iter().filter(|(name, _)| asked.split(',').any(|one| one == *name));
            self.first_libraries.extend(libraries.map(|(_, library)| (*library).to_owned()));
        }
        let libraries = LIBRARIES.iter().filter(|(option, _)| word.starts_with(option));
        self.libraries.extend(libraries.map(|(_, library)| (*library).to_owned()));
        // A word that is no option is a file, such as an archive.
        if !word.starts_with('-') || is_linked(&word) {
            self.linked.push(word);
            return;
        }
        if word == "-pthread" {
            self.linked.push(word.clone());
        }
        self.flags.push(word);
    }

    /// Returns the first word that needs a library which images do not have.
    pub(in crate::emit) fn needs_library(&self) -> Option<&str> {
        let mut words = self.flags.iter().map(String::as_str);
        words.find(|word| {
            word.starts_with("-fsanitize=") || LIBRARIES.iter().any(|(option, _)| word.starts_with(option))
        })
    }
}
