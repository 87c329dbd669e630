// SPDX-License-Identifier: Apache-2.0
//! `lfz keys`, and what participants get of a federation's keys.

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::Path;
use std::process::{Command, Output};

use crate::support::{folder, said, text, write};

fn program(properties: &str) -> String {
    format!(
        "target Rust {{ {properties} }}\nreactor A {{ output y: u8 }}\nreactor B {{ input x: u8 }}\n\
         federated reactor {{ a = new A() b = new B() a.y -> b.x }}\n"
    )
}

fn lfz(folder: &Path, arguments: &[&str]) -> Output {
    said(Command::new(env!("CARGO_BIN_EXE_lfz")).current_dir(folder).args(arguments).env_remove("RUST_LOG"))
}

/// Runs a command that has to succeed; returns what it prints.
fn right(folder: &Path, arguments: &[&str]) -> String {
    let output = lfz(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs a command that has to fail; returns its reason.
fn wrong(folder: &Path, arguments: &[&str]) -> String {
    let output = lfz(folder, arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", text(&output.stdout));
    text(&output.stderr)
}

fn mode(path: &Path) -> u32 {
    fs::metadata(path).expect("it is there").permissions().mode() & 0o777
}

fn set_mode(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("it is ours");
}

/// Returns a project with a name that shells would split, in which `Pair.lf` asks for encryption.
fn project(properties: &str) -> tempfile::TempDir {
    folder(&[("my project/src/Pair.lf", &program(properties))])
}

#[test]
fn keys_are_made_once_and_only_this_user_can_read_them() {
    let folder = project("security: noise");
    let project = folder.path().join("my project");
    let shown = right(&project, &["keys", "new", "src/Pair.lf"]);
    let lines: Vec<&str> = shown.lines().collect();
    assert_eq!(lines.len(), 3, "{shown}");
    for (line, name) in lines.iter().zip(["rti", "a", "b"]) {
        assert!(line.starts_with(name) && line.ends_with("its secret key is here"), "{line}");
    }
    let keys = project.join("keys/Pair");
    assert_eq!(mode(&keys), 0o700);
    for file in ["rti.key", "a.key", "b.key", "federation.secret"] {
        assert_eq!(mode(&keys.join(file)), 0o600, "{file}");
    }
    let ignored = fs::read_to_string(keys.join(".gitignore")).expect("it is there");
    assert!(ignored.lines().any(|line| line == "*"));
    let before = fs::read(keys.join("a.key")).expect("it is there");
    assert_eq!(right(&project, &["keys", "new", "src/Pair.lf"]), shown);
    assert_eq!(fs::read(keys.join("a.key")).expect("it is there"), before);
    assert_eq!(right(&project, &["keys", "show", "src/Pair.lf"]), shown);
    // Each is another one.
    let fingerprints: Vec<_> = lines.iter().map(|line| line.split_whitespace().nth(1)).collect();
    assert!(fingerprints[0] != fingerprints[1] && fingerprints[1] != fingerprints[2], "{shown}");
}

#[test]
fn git_does_not_take_keys() {
    let folder = project("security: noise");
    let project = folder.path().join("my project");
    right(&project, &["keys", "new", "src/Pair.lf"]);
    let git = |arguments: &[&str]| text(&said(Command::new("git").current_dir(&project).args(arguments)).stdout);
    git(&["init", "--quiet"]);
    git(&["add", "--all"]);
    assert_eq!(git(&["ls-files"]), "src/Pair.lf\n");
}

/// A key that was made elsewhere is accepted by its public part; the secret stays there.
#[test]
fn keys_of_other_computers_are_trusted_and_distrusted() {
    let folder = folder(&[("here/P.lf", &program("security: noise")), ("there/P.lf", &program("security: noise"))]);
    let (here, there) = (folder.path().join("here"), folder.path().join("there"));
    right(&here, &["keys", "new", "P.lf", "rti", "b"]);
    right(&there, &["keys", "new", "P.lf", "a"]);
    let shown = right(&here, &["keys", "show", "P.lf"]);
    assert!(shown.contains("a    no key: nobody trusts it"), "{shown}");
    let public = "../there/keys/P/a.pub";
    let trusted = right(&here, &["keys", "trust", "P.lf", "a", public]);
    let fingerprint = trusted.trim_end().rsplit(' ').next().expect("it is the last word").to_owned();
    assert!(right(&there, &["keys", "show", "P.lf"]).contains(&fingerprint));
    assert!(right(&here, &["keys", "show", "P.lf"]).contains(&format!("a    {fingerprint}\n")));
    assert_eq!(right(&here, &["keys", "trust", "P.lf", "a", public]), trusted, "it is known already");
    // It is no other participant's, and nobody's place is taken unnoticed.
    for (name, key, reason) in [
        ("b", public, "b has another key already"),
        ("a", "../there/keys/P/a.key", "hand nobody secret keys"),
        ("a", "../there/P.lf", "is not complete, or is no public key"),
        ("a", "nowhere.pub", "there is no file nowhere.pub"),
        ("c", public, "P has no participant `c`; it has rti, a, b"),
    ] {
        let error = wrong(&here, &["keys", "trust", "P.lf", name, key]);
        assert!(error.contains(reason), "{name} {key}: {error}");
    }
    right(&here, &["keys", "distrust", "P.lf", "b"]);
    let error = wrong(&here, &["keys", "trust", "P.lf", "b", public]);
    assert!(error.contains("is the key of a, and no two participants have one key"), "{error}");
    assert!(wrong(&here, &["keys", "distrust", "P.lf", "b"]).contains("b has no key, so nobody trusts it"));
    assert!(right(&here, &["keys", "show", "P.lf"]).contains("b    no key: nobody trusts it"));
}

/// The participants' folders are in the build folder, and `a` cannot be taken for another one with what it gets.
#[test]
fn each_participant_gets_its_own_secret_and_no_other() {
    let folder = project("security: noise");
    let project = folder.path().join("my project");
    let deployment = "federates:\n  a: { platform: some_board, ip: 10.0.0.2 }\nrti: { ip: 10.0.0.1 }\n\
                      security: { keys: \"secret things\" }\n";
    write(&project, "deployment.yaml", deployment);
    let of = ["src/Pair.lf", "--deployment", "deployment.yaml"];
    let build = [&["build"], &of[..], &["-f", "a", "--out", "out", "--json"]].concat();
    assert!(wrong(&project, &build).contains("Pair has no keys, which would be in secret things: make them with"));
    right(&project, &[&["keys", "new"], &of[..]].concat());
    assert!(project.join("secret things/a.key").is_file());
    right(&project, &build);
    let files = |name: &str| {
        let entries = fs::read_dir(project.join("out/keys").join(name)).expect("it is there");
        let mut names: Vec<_> =
            entries.map(|entry| entry.expect("it").file_name().into_string().expect("text")).collect();
        names.sort();
        names
    };
    // With centralized coordination only the RTI speaks with both.
    assert_eq!(files("a"), ["federation.secret", "keys.h", "own.key", "rti.pub"]);
    assert_eq!(files("rti"), ["0.pub", "1.pub", "federation.secret", "own.key"]);
    let header = fs::read_to_string(project.join("out/keys/a/keys.h")).expect("it is there");
    let defined: Vec<_> = header.lines().filter_map(|line| line.strip_prefix("#define ")?.split(' ').next()).collect();
    assert_eq!(defined, ["LF_KEY_OWN", "LF_KEY_RTI", "LF_KEY_FEDERATION"]);
    let kconfig = fs::read_to_string(project.join("out/a/a.conf")).expect("it is there");
    assert!(kconfig.contains("CONFIG_LF_SECURITY=y\nCONFIG_LF_SECURITY_KEYS=\""), "{kconfig}");
    for name in ["a", "rti"] {
        let out = project.join("out/keys").join(name);
        assert_eq!(mode(&out), 0o700);
        assert!(fs::read_dir(&out).expect("it is there").all(|file| mode(&file.expect("it").path()) == 0o600));
    }
    assert!(!project.join("out/keys/b").exists());
    // A lost board is shut out by the RTI, and no other participant is built again for that.
    right(&project, &[&["keys", "distrust"], &of[..], &["b"]].concat());
    let warned = lfz(&project, &build);
    assert!(text(&warned.stderr).contains("warning: nobody trusts b, which has no key"), "{}", text(&warned.stderr));
    assert_eq!(files("rti"), ["0.pub", "federation.secret", "own.key"]);
}

#[test]
fn wrong_files_are_refused_with_the_reason() {
    let folder = project("security: noise");
    let project = folder.path().join("my project");
    right(&project, &["keys", "new", "src/Pair.lf"]);
    let keys = project.join("keys/Pair");
    // rustc does not have to run for it.
    let build = || wrong(&project, &["build", "src/Pair.lf", "--platform", "zephyr", "--out", "out"]);
    let a = fs::read_to_string(keys.join("a.key")).expect("it is there");
    let b = fs::read_to_string(keys.join("b.key")).expect("it is there");
    let rewrite = |name: &str, text: &str| fs::write(keys.join(name), text).expect("it is ours");

    set_mode(&keys.join("a.key"), 0o644);
    assert!(build().contains("a.key is a secret, and other users may read it (mode 0644)"));
    set_mode(&keys.join("a.key"), 0o600);
    rewrite("a.key", &b);
    assert!(build().contains("do not belong together"));
    rewrite("a.key", &a[..a.len() / 2]);
    assert!(build().contains("a.key is not complete"));
    rewrite("a.key", &fs::read_to_string(keys.join("a.pub")).expect("it is there"));
    assert!(build().contains("a.key has a public key, and a secret one is expected there"));
    rewrite("a.key", &a);

    // A link leads to a file with permissions of its own, and none is written through.
    let elsewhere = project.join("elsewhere");
    fs::write(&elsewhere, &a).expect("it can be written");
    set_mode(&elsewhere, 0o640);
    fs::remove_file(keys.join("a.key")).expect("it is there");
    symlink(&elsewhere, keys.join("a.key")).expect("it can be made");
    assert!(build().contains("other users may read it (mode 0640)"));
    right(&project, &["keys", "distrust", "src/Pair.lf", "a"]);
    assert_eq!(fs::read_to_string(&elsewhere).expect("it is there"), a, "the link is gone, and not the file");
    symlink(project.join("nowhere"), keys.join("a.key")).expect("it can be made");
    right(&project, &["keys", "new", "src/Pair.lf", "a"]);
    assert!(!project.join("nowhere").exists());
    fs::remove_file(keys.join("a.key")).expect("it is there");
    right(&project, &["keys", "new", "src/Pair.lf", "a"]);

    fs::remove_file(keys.join("a.key")).expect("it is there");
    assert!(build().contains("the secret key of a is not in "));
    set_mode(&keys, 0o770);
    assert!(wrong(&project, &["keys", "show", "src/Pair.lf"]).contains("(mode 0770), and with it whom"));
    set_mode(&keys, 0o700);
}

#[test]
fn programs_that_ask_for_no_encryption_have_no_keys() {
    let folder = folder(&[
        ("P.lf", &program("")),
        ("Alone.lf", "target Rust { security: noise }\nmain reactor { }\n"),
        ("Tls.lf", &program("comm-type: TLS")),
    ]);
    let error = wrong(folder.path(), &["keys", "new", "P.lf"]);
    assert!(error.contains("P does not ask for encryption: write `security: noise`"), "{error}");
    let error = wrong(folder.path(), &["keys", "new", "Alone.lf"]);
    assert!(error.contains("Alone is not federated"), "{error}");
    assert!(wrong(folder.path(), &["keys", "show", "Tls.lf"]).contains("Tls has no keys"));
    write(folder.path(), "P.lf", &program("security: noise"));
    right(folder.path(), &["keys", "new", "P.lf"]);
    write(folder.path(), "P.lf", &program("comm-type: TLS"));
    let error = wrong(folder.path(), &["keys", "show", "P.lf"]);
    assert!(error.contains("rti.pub is a key for programs with `security: noise`, and not for this one"), "{error}");
}

#[test]
fn programs_with_tls_have_certificates() {
    let folder = project("comm-type: TLS");
    let project = folder.path().join("my project");
    right(&project, &["keys", "new", "src/Pair.lf"]);
    let keys = project.join("keys/Pair");
    for name in ["rti", "a", "b"] {
        let certificate = fs::read_to_string(keys.join(format!("{name}.crt"))).expect("it is there");
        assert!(certificate.starts_with("-----BEGIN CERTIFICATE-----"), "{certificate}");
        assert_eq!(mode(&keys.join(format!("{name}.key"))), 0o600);
    }
    assert!(!keys.join("federation.secret").exists());
    let error = wrong(&project, &["build", "src/Pair.lf", "--platform", "zephyr", "--out", "out"]);
    assert!(error.contains("a is on a board, which has no TLS: write `security: noise`"), "{error}");
}
