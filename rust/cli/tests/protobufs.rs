// SPDX-License-Identifier: Apache-2.0
//! Messages of Protocol Buffers in C, with the real protobuf-c.

use crate::support::{folder, lfz, said, text, write};

const PROGRAM: &str = r#"
target C { protobufs: ["my messages/Route.proto", "Place.proto"], timeout: 20 ms }
preamble {= #include <stdio.h> =}
reactor Sender {
    output out: Tour__RouteOf*
    timer t(0, 10 ms)
    state count: int = 0
    reaction(t) -> out {=
        Tour__RouteOf* route = (Tour__RouteOf*)malloc(sizeof(Tour__RouteOf));
        static Place first = PLACE__INIT;
        static Place* stops[] = { &first };
        tour__route_of__init(route);
        first.name = "Delphi";
        first.level = self->count++;
        route->n_stops = 1;
        route->stops = stops;
        lf_set(out, route);
    =}
}
reactor Keeper {
    mutable input x: Tour__RouteOf*
    reaction(x) {= x->value->stops[0]->level += 100; =}
}
reactor Receiver {
    input in: Tour__RouteOf*
    keeper = new Keeper()
    in -> keeper.x
    reaction(in) {= printf("%s %d\n", in->value->stops[0]->name, in->value->stops[0]->level); =}
}
federated reactor {
    sender = new Sender()
    receiver = new Receiver()
    sender.out -> receiver.in after 1 ms serializer "proto"
}
"#;

const ROUTE: &str = "syntax = \"proto3\";\npackage tour;\nimport \"Place.proto\";\n\
                     message RouteOf {\n  repeated Place stops = 1;\n}\n";

const PLACE: &str = "syntax = \"proto3\";\nmessage Place {\n  string name = 1;\n  int32 level = 2;\n}\n";

fn program() -> tempfile::TempDir {
    folder(&[("P.lf", PROGRAM), ("my messages/Route.proto", ROUTE), ("Place.proto", PLACE)])
}

#[test]
fn messages_go_to_another_federate_with_what_they_point_to() {
    let folder = program();
    let output = said(&mut lfz(folder.path(), &["run"]));
    let out = text(&output.stdout);
    let lines: Vec<_> = out.lines().filter(|line| line.starts_with("receiver")).collect();
    assert_eq!(lines, ["receiver | Delphi 0", "receiver | Delphi 1"], "{out}{}", text(&output.stderr));
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn mistakes_in_messages_and_types_are_at_their_places() {
    let folder = program();
    write(folder.path(), "my messages/Route.proto", &ROUTE.replace("repeated Place", "repeated Town"));
    let error = text(&said(&mut lfz(folder.path(), &["build"])).stderr);
    assert!(error.contains("my messages/Route.proto:5:12: error: \"Town\" is not defined."), "{error}");

    let number = r#"
target C { protobufs: "Place.proto" }
reactor Sender { output y: int  reaction(startup) -> y {= lf_set(y, 3); =} }
reactor Receiver { input x: int  reaction(x) {= =} }
federated reactor {
    sender = new Sender()
    receiver = new Receiver()
    sender.y -> receiver.x serializer "proto"
}
"#;
    write(folder.path(), "P.lf", number);
    let error = text(&said(&mut lfz(folder.path(), &["build"])).stderr);
    assert!(error.contains("`int` is no pointer to a message"), "{error}");

    write(folder.path(), "P.lf", &PROGRAM.replace("Place.proto", "Plaza.proto"));
    let error = text(&said(&mut lfz(folder.path(), &["build"])).stderr);
    assert!(error.contains("Plaza.proto") && error.contains("P.lf:2:"), "{error}");
}
