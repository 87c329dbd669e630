// SPDX-License-Identifier: Apache-2.0
//! Formatted files: how they look, and that they are the same programs.

use std::fs;
use std::path::{Path, PathBuf};

use lf_compiler::format;
use proptest::prelude::*;

/// A program that was typed in a hurry.
const TYPED: &str = r#"target   Rust{
timeout:1 s ,
      cargo-dependencies:{ heapless : "0.9"  , "libm":{version:"0.2",
   default-features:false} }
   }


import  A ,B as  C   from"other.lf"

/** A source.
  *  It counts.
 */
@label( "x" ,y=1 )  @icon("i")
reactor   Source < T , U > ( start : u32=3,step : u32 = {= 2 =} ,
        list: u32[](1,2) )   extends A , B{
    state count:u32={= start =} // how many
    state  table :  {= [u8; 4] =}( 1,2 , 3,  4)
  @capacity( 8 )
  physical   action act ( 0 , 10 ms,"drop" ):T
	timer t(0,10ms) ;
  input [ 2 ]  x:u32 ; output y : {= Vec<U> =};
reaction ( t , x )act->y , reset( Mode ){=
  if self.count > 0 {
    println!("{}", "a
      b");
  }
=}deadline( 5 ms ){= ctx.set(y, Vec::new()); =}   # late

     reaction(startup)
        x
          -> y {=
             let one = 1;
               let two = one;
         =}
   initial   mode One{
 reaction(act)->reset(Two){= =}
      }
    mode Two { }
  // the end
}
federated   reactor  at  host.example:4242   {
a=new[2]   Source < u8 , u8 >( start=4 , step = 2 )
   b  =  new Source ( )   at 10.0.0.1:15045
      a.y , b.y->
         a.x,
           b.x   after   10 ms
   ( a.y )+ ~> b.x
  'quoted
}"#;

#[test]
fn a_file_that_was_typed_in_a_hurry_is_well_formatted() {
    let typed = TYPED.replace("  'quoted\n", "");
    insta::assert_snapshot!(format("P.lf", &typed).expect("it has no errors of syntax"));
    let diagnostics = format("P.lf", TYPED).expect_err("a quote is no declaration");
    assert!(diagnostics.has_errors());
}

/// Checks that a formatted text says the same, and that the second time nothing is left to do.
fn check(path: &Path, text: &str) -> Result<(), TestCaseError> {
    let Ok(formatted) = format("P.lf", text) else { return Ok(()) };
    let words = |text: &str| text.split_whitespace().collect::<String>();
    prop_assert_eq!(words(&formatted), words(text), "{}", path.display());
    let again = format("P.lf", &formatted).map_err(|_| TestCaseError::fail("errors that were not there"))?;
    prop_assert_eq!(&again, &formatted, "{}", path.display());
    prop_assert!(!formatted.contains("\n\n\n") || text.contains("\n\n\n"), "{}", path.display());
    Ok(())
}

/// Returns the programs of this repository, those with errors too.
fn programs() -> Vec<(PathBuf, String)> {
    fn collect(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let name = entry.file_name();
            if path.is_dir() && name != "target" && name != "build" {
                collect(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "lf") {
                found.extend(fs::read_to_string(&path).ok().map(|text| (path, text)));
            }
        }
    }
    let mut found = Vec::new();
    for folder in ["applications", "tests", "rust", "scripts/tests"] {
        collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder), &mut found);
    }
    assert!(found.len() > 200, "{} programs", found.len());
    found
}

#[test]
fn formatted_programs_say_the_same_and_stay_as_they_are() {
    for (path, text) in programs() {
        check(&path, &text).unwrap_or_else(|error| panic!("{error}"));
    }
}

proptest! {
    /// Whatever blanks there are, nothing is lost, and nothing is left to do the second time.
    #[test]
    fn blanks_are_all_that_changes(cuts in prop::collection::vec((0..TYPED.len(), "[ \t\n]{1,3}"), 0..20)) {
        let mut text = TYPED.replace("  'quoted\n", "");
        for (at, blanks) in cuts {
            let at = (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
            text.insert_str(at, &blanks);
        }
        check(Path::new("typed"), &text)?;
    }
}

/// A literal of several lines would have other blanks if it moved.
#[test]
fn code_with_text_of_several_lines_stays_where_it_is() {
    for (target, text, moves) in [
        ("Rust", "let a = \"x\n  y\";", false),
        ("Rust", "let a = 1; /* x\n   y */", true),
        ("C", "int a = 1;\n   int b = 2;", true),
        ("Python", "a = \"\"\"x\n  y\"\"\"", false),
        ("Python", "a = 1", true),
        ("Rust", "let a = 1;\n\tlet b = 2;", false),
    ] {
        let source = format!("target {target}\nmain reactor {{\nreaction(startup) {{=\n{text}\n=}}\n}}\n");
        let formatted = format("P.lf", &source).expect("it has no errors of syntax");
        let is_moved = !formatted.contains(&format!("{{=\n{text}\n=}}"));
        assert_eq!(is_moved, moves, "{formatted}");
    }
}
