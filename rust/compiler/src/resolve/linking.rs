// SPDX-License-Identifier: Apache-2.0
//! Words for the C compiler that a program cannot have, because lfz and rustc decide these settings.

/// Sanitizers whose libraries programs can be linked with.
const SANITIZERS: [&str; 4] = ["address", "undefined", "thread", "leak"];

/// Returns the alternative to this word, if a program cannot have it.
pub(super) fn refusal(word: &str) -> Option<String> {
    let text = match word {
        "-framework" => "remove it: frameworks are for macOS",
        "-static" | "-static-pie" => {
            "remove it, and have rustc link statically: `RUSTFLAGS=\"-C target-feature=+crt-static\"`"
        }
        "-shared" | "-r" | "-nostdlib" | "-nostartfiles" | "-nodefaultlibs" => {
            "remove it: rustc links the program, as it does those in Rust"
        }
        "-c" | "-S" | "-E" | "-M" | "-MM" | "-MD" | "-MMD" => "remove it: lfz says what becomes of the files",
        _ if word.starts_with("-flto") => {
            "remove it: the linker of programs for this computer does not read such objects; for images there is \
             `CONFIG_LTO=y`"
        }
        _ if word.starts_with("-o") => "remove it: lfz says where the results go",
        _ if word.starts_with("-x") => "remove it: a file's language is that of its name",
        _ => {
            let asked = word.strip_prefix("-fsanitize=")?;
            let unknown = asked.split(',').find(|one| !SANITIZERS.contains(one))?;
            return Some(format!("`{unknown}` is not linked; those that are: {}", SANITIZERS.join(", ")));
        }
    };
    Some(text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::refusal;

    #[test]
    fn words_that_would_make_something_else_of_the_program_are_refused() {
        for word in
            ["-c", "-static", "-framework", "-shared", "-ofile", "-xc", "-flto=auto", "-fsanitize=address,memory"]
        {
            assert!(refusal(word).is_some(), "{word}");
        }
        for word in ["-O2", "-Lx", "-lm", "-Wl,-z,now", "-fsanitize=address,undefined", "lib/a.a", "-pthread"] {
            assert_eq!(refusal(word), None, "{word}");
        }
    }
}
