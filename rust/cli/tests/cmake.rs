// SPDX-License-Identifier: Apache-2.0
//! Programs with files for CMake: the real CMake configures them, and its messages are reported at their places.

use std::process::Command;

use crate::support::{folder, lfz, said, text, write};

const PROGRAM: &str = r#"
target C { cmake-include: "lib/all.cmake", compile-definitions: { LIMIT: 5 }, files: "lib/extra.c" }
preamble {=
    #include <stdio.h>
    #include "fan.h"
    #include "made.h"
    int extra(int);
=}
main reactor {
    reaction(startup) {=
        printf("%d %d %d %d\n", fan_speed(3), MADE, extra(4), SEEN);
        lf_request_stop();
    =}
}
"#;

/// A package with a library in C++, a file that the build makes, variables, lists and conditions.
const CMAKE: &str = r"
find_package(Fan REQUIRED PATHS ${CMAKE_CURRENT_LIST_DIR})
list(APPEND libraries Fan::Fan)
if(DEFINED LIMIT AND LIMIT GREATER 4)
  target_compile_definitions(${LF_MAIN_TARGET} PRIVATE SEEN=${LIMIT})
endif()
unset(nothing)
add_custom_command(
  OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/made.h
  COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_CURRENT_LIST_DIR}/made.txt ${CMAKE_CURRENT_BINARY_DIR}/made.h
)
target_sources(${LF_MAIN_TARGET} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/made.h extra.c)
target_include_directories(${LF_MAIN_TARGET} PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
target_link_libraries(${LF_MAIN_TARGET} ${libraries})
";

const PACKAGE: &str = r"
add_library(fan STATIC ${CMAKE_CURRENT_LIST_DIR}/fan/fan.cpp)
target_include_directories(fan PUBLIC ${CMAKE_CURRENT_LIST_DIR}/fan)
add_library(Fan::Fan ALIAS fan)
";

const FILES: [(&str, &str); 7] = [
    ("P.lf", PROGRAM),
    ("lib/all.cmake", CMAKE),
    ("lib/FanConfig.cmake", PACKAGE),
    ("lib/made.txt", "#define MADE 42\n"),
    ("lib/extra.c", "#include \"fan.h\"\nint extra(int a) { return fan_speed(a) + 1; }\n"),
    ("lib/fan/fan.h", "int fan_speed(int);\n"),
    ("lib/fan/fan.cpp", "extern \"C\" int fan_speed(int a) { return new int(a) ? a * 7 : 0; }\n"),
];

#[test]
fn cmake_configures_programs_and_builds_their_libraries() {
    let folder = folder(&FILES);
    let output = said(&mut lfz(folder.path(), &["run"]));
    assert_eq!(text(&output.stdout), "21 42 29 5\n", "{}", text(&output.stderr));

    write(folder.path(), "lib/fan/fan.cpp", "extern \"C\" int fan_speed(int a) { return a * 8; }\n");
    let output = said(&mut lfz(folder.path(), &["run"]));
    assert_eq!(text(&output.stdout), "24 42 33 5\n", "{}", text(&output.stderr));
}

#[test]
fn what_cmake_and_compilers_say_is_at_its_places() {
    let folder = folder(&FILES);
    write(folder.path(), "lib/all.cmake", &CMAKE.replace("find_package(Fan", "\nfind_package(Fun"));
    let output = said(&mut lfz(folder.path(), &["build"]));
    let error = text(&output.stderr);
    assert!(error.contains("lib/all.cmake:3:1: error: CMake: ") && error.contains("FunConfig.cmake"), "{error}");

    write(folder.path(), "lib/all.cmake", &format!("{CMAKE}message(WARNING \"be\n  careful\")\n"));
    write(folder.path(), "lib/extra.c", "int extra(int a) { return \"x\" * a; }\n");
    let output = said(&mut lfz(folder.path(), &["build"]));
    let error = text(&output.stderr);
    assert!(error.contains("lib/extra.c:1:31: error: invalid operands"), "{error}");
    assert!(error.contains("warning: CMake: be careful"), "{error}");
}

#[test]
fn a_program_with_c_beside_its_bodies_is_configured_as_well() {
    let program = r#"
target Rust { c-headers: "fan.h", cmake-include: "fan.cmake" }
main reactor {
    reaction(startup) {= println!("{}", unsafe { c::fan_speed(3) }); =}
}
"#;
    let folder = folder(&[
        ("P.lf", program),
        ("fan.h", "int fan_speed(int);\n"),
        ("fan.c", "int fan_speed(int a) { return a * FACTOR; }\n"),
        (
            "fan.cmake",
            "set(factor 5)\nadd_library(fan OBJECT ${CMAKE_CURRENT_LIST_DIR}/fan.c)\n\
                       target_compile_definitions(fan PRIVATE FACTOR=${factor})\n\
                       target_link_libraries(${LF_MAIN_TARGET} PRIVATE fan)\n",
        ),
    ]);
    let output = said(&mut lfz(folder.path(), &["run"]));
    assert_eq!(text(&output.stdout), "15\n", "{}", text(&output.stderr));
}

#[test]
fn check_says_what_only_a_build_can_know() {
    let folder = folder(&FILES);
    let mut check = Command::new(env!("CARGO_BIN_EXE_lfz"));
    let output = said(check.current_dir(folder.path()).args(["check", "P.lf"]));
    assert_eq!(text(&output.stdout), "P.lf: no errors; lib/all.cmake will be read by CMake in a build\n");
}
