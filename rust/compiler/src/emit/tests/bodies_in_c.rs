// SPDX-License-Identifier: Apache-2.0
//! What is emitted of a program whose bodies are C.

use std::collections::BTreeMap;

use super::{emit_on, listing};
use crate::compile;
use crate::deployment::Deployment;

const TEXT: &str = r#"target C { timeout: 1 sec }
preamble {=
    typedef struct { int a; double b; } pair_t;
=}
reactor Source(n: int = 3, list: int[] = {1, 2, 3}) {
  output y: pair_t
  output[2] m: int
  timer t(0, 100 msec)
  logical action a(10 msec): int
  state array: int[2] = {= { n, 2 } =}
  method plus(k: int): int {= return k + self->n; =}
  reaction(t) -> y, a, m {=
    lf_set(m[m_width - 1], plus(1));
  =}
  reaction(a) {= lf_print("%d", a->value); =} deadline(1 msec) {= lf_print("late"); =}
}
reactor Sink(weight: float = 0.5) {
  input x: int
  input w: int
  physical action p: char*
  reaction(x, w) -> p {= lf_schedule(p, 0); =}
}
reactor Last { input z: pair_t  reaction(z) {= =} }
federated reactor (first: int = 4) {
  s = new Source(n = first)
  l = new Last()
  s.y -> l.z
}
reactor Inside {
  s = new Source()
  k = new[2] Sink(weight = {= 0.1f * bank_index =})
  s.m -> k.x after 5 msec
  reaction(s.y) -> k.w {= lf_set(k[1].w, s.y->value.a); =}
}
"#;

fn emitted(text: &str) -> String {
    let plan = compile("P.lf", &BTreeMap::from([("P.lf".to_owned(), text.to_owned())])).plan.expect("it is right");
    listing(&emit_on(&plan, &Deployment::default()))
}

#[test]
fn c_of_a_federation() {
    insta::assert_snapshot!(emitted(TEXT));
}

#[test]
fn c_of_banks_and_delays() {
    let (head, _) = TEXT.split_once("federated reactor").expect("it is there");
    let (_, inside) = TEXT.split_once("reactor Inside").expect("it is there");
    insta::assert_snapshot!(emitted(&format!("{head}main reactor{inside}")));
}
