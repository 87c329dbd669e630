// SPDX-License-Identifier: Apache-2.0
//! LF programs as the compiler generates them, for tests that run them in virtual time; the sources are in `programs`.

// The name by which generated code knows its platform.
extern crate lf_linux as lf;

include!(concat!(env!("OUT_DIR"), "/programs.rs"));
