// SPDX-License-Identifier: Apache-2.0
//! The C compiler's diagnostics of bodies are shown once, at the line of the program; code that newer compilers refuse
//! is refused by all.

use crate::support::{folder, lfz, said, text, write};

const HEAD: &str = "target C { files: \"helpers.h\" }\npreamble {=\n#include \"helpers.h\"\n=}\nreactor R {\n  \
                    output y: int\n  \
                    reaction(startup) -> y {=\n";

fn program(body: &str) -> String {
    format!("{HEAD}    {body}\n  =}}\n}}\nmain reactor {{ r = new R() }}\n")
}

#[test]
fn each_warning_is_shown_once_and_in_each_build() {
    let body = program("int x = 1 / 0; lf_set(y, 2 / 0);");
    let folder = folder(&[("P.lf", &body), ("helpers.h", "static inline int half(void) { return 1 / 0; }\n")]);
    for _ in 0..2 {
        let output = said(lfz(folder.path(), &["build"]).env("LC_ALL", "C"));
        let errors = text(&output.stderr);
        assert!(output.status.success(), "{errors}");
        assert_eq!(errors.matches("P.lf:8:15: warning: division by zero").count(), 1, "{errors}");
        assert_eq!(errors.matches("helpers.h:1:41: warning: division by zero").count(), 1, "{errors}");
    }
}

#[test]
fn code_that_newer_compilers_refuse_is_an_error_at_its_place() {
    let folder = folder(&[("P.lf", ""), ("helpers.h", "")]);
    for (body, message) in [
        ("lf_set(y, \"abc\");", "P.lf:8:5: error: assignment to 'int' from 'char *'"),
        ("lf_sett(y, 1);", "P.lf:8:5: error: implicit declaration of function 'lf_sett'"),
        ("int x = \"a\";", "P.lf:8:13: error: initialization of 'int' from 'char *'"),
        ("double *d = 0; int *p = d;", "P.lf:8:29: error: initialization of 'int *' from incompatible pointer type"),
        ("static x;", "P.lf:8:12: error: type defaults to 'int'"),
    ] {
        write(folder.path(), "P.lf", &program(body));
        let output = said(lfz(folder.path(), &["build"]).env("LC_ALL", "C").env("CC", "gcc"));
        let errors = text(&output.stderr);
        assert!(!output.status.success() && errors.contains(message), "{body}: {errors}");
        assert!(errors.ends_with("P.lf: 1 error\n"), "{body}: {errors}");
    }
}

#[test]
fn names_that_lf_had_once_have_a_hint() {
    let folder = folder(&[("P.lf", ""), ("helpers.h", "")]);
    for (body, hint) in [
        ("SET(y, 1);", "write `lf_set`"),
        ("request_stop();", "write `lf_request_stop`"),
        ("instant_t t = start_time; lf_set(y, t > 0);", "write `lf_time_start()`"),
    ] {
        for target in ["C", "CCpp"] {
            write(folder.path(), "P.lf", &program(body).replacen("target C ", &format!("target {target} "), 1));
            let output = said(lfz(folder.path(), &["build"]).env("CC", "gcc"));
            let errors = text(&output.stderr);
            assert!(!output.status.success() && errors.contains(hint), "{body}: {errors}");
        }
    }
}

#[test]
fn a_name_that_is_a_macro_is_an_error_where_it_is_declared() {
    let program = |name: &str| {
        format!(
            "target C {{ files: \"board.h\" }}\npreamble {{=\n#include \"board.h\"\n=}}\nreactor R {{\n  \
             output {name}: int\n  reaction(startup) -> {name} {{= lf_set({name}, 1); =}}\n}}\n\
             reactor S {{\n  r = new R()\n  reaction(r.{name}) {{= printf(\"%d\\n\", r.{name}->value); =}}\n}}\n\
             main reactor {{ s = new S() }}\n"
        )
    };
    let header = "#define LIMIT 3\n#define NOTHING\n#define PAIR 1, 2\n#define BIT(n) (1 << (n))\n#define OWN OWN\n";
    let folder = folder(&[("P.lf", ""), ("board.h", header)]);
    for name in ["LIMIT", "NOTHING", "PAIR", "BUFSIZ", "FOREVER", "errno"] {
        write(folder.path(), "P.lf", &program(name));
        let output = said(lfz(folder.path(), &["build"]).env("LC_ALL", "C"));
        let errors = text(&output.stderr);
        let message = format!("`{name}` is a macro of a header here: choose another name");
        assert!(!output.status.success() && errors.contains("P.lf:6:"), "{name}: {errors}");
        assert!(errors.contains(&message), "{name}: {errors}");
    }
    // These are no macros, or replace nothing where no bracket follows.
    for name in ["limit", "BIT", "OWN", "stdin"] {
        write(folder.path(), "P.lf", &program(name));
        let output = said(&mut lfz(folder.path(), &["run"]));
        assert_eq!(text(&output.stdout), "1\n", "{name}: {}", text(&output.stderr));
    }
}

#[test]
fn an_unknown_type_is_an_error_once_and_where_the_program_has_it() {
    let program = "target C\nreactor S(\n  p: parameter_t = 1) {\n  output y: port_t\n  state s: state_t\n  \
                   logical action a: action_t\n  reaction(startup) -> y {= =}\n}\n\
                   reactor R {\n  input x: port_t\n  reaction(x) {= =}\n}\n\
                   federated reactor {\n  s = new S()\n  r = new R()\n  s.y -> r.x\n}\n";
    let folder = folder(&[("P.lf", program)]);
    let output = said(lfz(folder.path(), &["build"]).env("LC_ALL", "C").env("CC", "gcc"));
    let errors = text(&output.stderr);
    let places = ["P.lf:3:6", "P.lf:4:13", "P.lf:5:12", "P.lf:6:21", "P.lf:10:12"];
    for (place, name) in places.iter().zip(["parameter_t", "port_t", "state_t", "action_t", "port_t"]) {
        let message = format!("{place}: error: unknown type name '{name}'");
        assert_eq!(errors.matches(&message).count(), 1, "{message}: {errors}");
    }
    assert!(errors.ends_with("P.lf: 5 errors\n"), "{errors}");
}

#[test]
fn a_library_of_the_programs_own_is_linked_by_each_way_of_naming_it() {
    let text_of = |flags: &str| {
        format!(
            "target C {{ compiler-flags: {flags} }}\npreamble {{= int own(int); =}}\nmain reactor {{\n  \
             reaction(startup) {{= printf(\"%d\\n\", own(1)); =}}\n}}\n"
        )
    };
    let folder = folder(&[("P.lf", ""), ("own.c", "int own(int x) { return x + 41; }\n")]);
    let script = "gcc -c own.c && ar rcs libown.a own.o";
    let made = std::process::Command::new("sh").current_dir(folder.path()).args(["-c", script]).status();
    assert!(made.expect("there is a shell").success());
    for flags in
        ["[\"-L.\", \"-lown\"]", "\"libown.a\"", "\"-L . -l own -fsanitize=address\"", "\"own.o -rdynamic -pthread\""]
    {
        write(folder.path(), "P.lf", &text_of(flags));
        let output = said(&mut lfz(folder.path(), &["run"]));
        assert_eq!(text(&output.stdout), "42\n", "{flags}: {}", text(&output.stderr));
    }
}
