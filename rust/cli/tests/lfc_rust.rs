// SPDX-License-Identifier: Apache-2.0
//! Programs for the Rust target of LF's own compiler: the paths and names that its generated crates have.

use crate::support::{folder, lfz, said, text};

const PROGRAM: &str = "target Rust { timeout: 1 ms }
import SomeRunner from \"lib/Runner.lf\"
main reactor {
  preamble {=
    use crate::{print_twice, reactors::some_runner::{answer, Kept}};
  =}
  runner = new SomeRunner()
  reaction(startup) {=
    print_twice!(\"value\", answer(&Kept { value: 21 }));
  =}
}
";

const RUNNER: &str = "target Rust
reactor SomeRunner {
  preamble {=
    pub struct Kept { pub value: u32 }
    pub fn answer(kept: &Kept) -> u32 { 2 * kept.value }
    #[macro_export]
    macro_rules! print_twice {
      ($name:expr, $value:expr) => { println!(\"{} {}\", $name, $value); };
    }
  =}
  state began: {= reactor_rt::Instant =} = {= Instant::now() =}
  state times: {= Vec<reactor_rt::Duration> =}
  reaction(startup) {=
    self.times.push(ctx.get_physical_time().duration_since(self.began));
    println!(\"{}\", self.times[0] < Duration::from_secs(60) && !log_enabled!(log::Level::Trace));
  =}
}
";

#[test]
fn code_finds_reactors_and_the_runtime_where_lfs_compiler_has_them() {
    let folder = folder(&[("P.lf", PROGRAM), ("lib/Runner.lf", RUNNER)]);
    let output = said(&mut lfz(folder.path(), &["run"]));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("value 42") && said.contains("true"), "{said}");
}
