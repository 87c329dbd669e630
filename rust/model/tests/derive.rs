// SPDX-License-Identifier: Apache-2.0
//! `#[derive(Payload)]`: structs and enums come back as they went, lie as in C, and no bytes make a decoder panic.
use std::fmt::Debug;
use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use lf_model::prelude::*;
use lf_model::{PayloadError, layout::Field};
use proptest::prelude::*;

type Name = heapless::String<5>;

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
#[payload(crate = lf_model)]
enum Level {
    Low = -1,
    Middle,
    High = 7,
}

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
#[payload(crate = lf_model)]
#[repr(u8)]
enum Small {
    First = 3,
    Second,
}

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
#[payload(crate = lf_model)]
struct Pair<T>(T, u16);

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
#[payload(crate = lf_model)]
struct Nothing;

/// Names that the derive uses, too.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
#[payload(crate = lf_model)]
struct Layout(u8);
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
#[payload(crate = lf_model)]
struct Fields {
    bytes: Layout,
    fields: Option<Layout>,
}

/// Variants of all three kinds, one of which needs more alignment than the number before it.
#[derive(Clone, Debug, PartialEq, Payload)]
#[payload(crate = lf_model)]
#[repr(u8)]
enum Event {
    Idle,
    Moved { by: i16, precise: f64 } = 4,
    Named(Name, Small),
}

#[derive(Clone, Debug, PartialEq, Payload)]
#[payload(crate = lf_model)]
struct Whole {
    level: Level,
    small: Small,
    letter: char,
    maybe: Option<u32>,
    tuple: (u8, Duration, bool),
    pair: Pair<Pair<i64>>,
    list: heapless::Vec<Pair<u8>, 3>,
    names: [Name; 2],
    event: Event,
    events: heapless::Vec<Event, 2>,
    nothing: Nothing,
}

fn bytes_of<T: Payload>(value: &T) -> Vec<u8> {
    let mut bytes = vec![0xAA; T::MAX_LEN];
    let len = value.encode(&mut bytes).unwrap();
    bytes.truncate(len);
    bytes
}

fn comes_back<T: Payload + PartialEq + Debug>(value: &T) {
    assert_eq!(&T::decode(&bytes_of(value)).unwrap(), value);
}

fn any_name() -> impl Strategy<Value = Name> {
    // A text in a struct may have a NUL in it.
    "[a-z\0]{0,5}".prop_map(|text| Name::try_from(text.as_str()).unwrap())
}

fn any_event() -> impl Strategy<Value = Event> {
    prop_oneof![
        Just(Event::Idle),
        (any::<i16>(), -1e9..1e9).prop_map(|(by, precise)| Event::Moved { by, precise }),
        (any_name(), any_small()).prop_map(|(name, small)| Event::Named(name, small)),
    ]
}

fn any_small() -> impl Strategy<Value = Small> {
    prop_oneof![Just(Small::First), Just(Small::Second)]
}

fn any_whole() -> impl Strategy<Value = Whole> {
    let level = prop_oneof![Just(Level::Low), Just(Level::Middle), Just(Level::High)];
    let tuple = (any::<u8>(), (0..i64::MAX).prop_map(|ns| Duration::from_nanos(ns.unsigned_abs())), any::<bool>());
    let numbers = (any::<char>(), any::<Option<u32>>(), tuple, any::<(i64, u16, u16)>());
    let list = prop::collection::vec((any::<u8>(), any::<u16>()), 0..=3);
    let events = prop::collection::vec(any_event(), 0..=2);
    (level, any_small(), numbers, list, [any_name(), any_name()], any_event(), events).prop_map(
        |(level, small, (letter, maybe, tuple, (x, y, z)), list, names, event, events)| Whole {
            level,
            small,
            letter,
            maybe,
            tuple,
            pair: Pair(Pair(x, y), z),
            list: list.into_iter().map(|(x, y)| Pair(x, y)).collect(),
            names,
            event,
            events: events.into_iter().collect(),
            nothing: Nothing,
        },
    )
}

proptest! {
    #[test]
    fn values_survive_encoding_and_decoding(whole in any_whole(), list in prop::collection::vec(any_whole(), 0..=2)) {
        comes_back(&whole);
        comes_back(&Some((whole.names.clone(), whole.level)));
        comes_back(&Option::<Whole>::None);
        comes_back(&Fields { bytes: Layout(whole.tuple.0), fields: Some(Layout(1)) });
        comes_back(&list.into_iter().collect::<heapless::Vec<Whole, 2>>());
        comes_back(&whole.events);
        comes_back(&whole.names.into_iter().collect::<heapless::Vec<Name, 2>>());
    }

    /// Whatever a peer sends: a value or an error; and what was read is written as bytes that are read the same.
    #[test]
    fn no_bytes_make_a_decoder_panic(mut bytes in prop::collection::vec(any::<u8>(), Whole::MAX_LEN), small: bool) {
        if small {
            // Mostly small numbers, so that more of them are lengths and variants that there are.
            for byte in &mut bytes {
                *byte = if *byte < 240 { 0 } else { *byte % 9 };
            }
        }
        for len in [Event::MAX_LEN, Whole::MAX_LEN] {
            let _ = Option::<Name>::decode(&bytes[..len]);
            let _ = heapless::Vec::<Event, 9>::decode(&bytes[..len]);
            let _ = Event::decode(&bytes[..len]).map(|value| comes_back(&value));
            let _ = Whole::decode(&bytes[..len]).map(|value| comes_back(&value));
        }
    }
}

#[test]
fn bytes_that_no_value_has_are_refused_with_the_reason() {
    assert_eq!(Level::decode(&1i32.to_le_bytes()), Err(PayloadError::NotVariant(1)));
    assert_eq!(Small::decode(&[5]), Err(PayloadError::NotVariant(5)));
    assert_eq!(char::decode(&0xD800u32.to_le_bytes()), Err(PayloadError::NotChar(0xD800)));
    assert_eq!(Option::<u8>::decode(&[2, 0]), Err(PayloadError::NotBool(2)));
    let mut named = bytes_of(&Event::Named(Name::new(), Small::First));
    named[8] = 6;
    assert_eq!(Event::decode(&named), Err(PayloadError::TooLong { capacity: 5, found: 6 }));
    named[8..13].copy_from_slice(&[1, 0, 0, 0, 0xFF]);
    assert_eq!(Event::decode(&named), Err(PayloadError::NotUtf8));
}

/// The values of [`golden`] in C.
const C: &str = r#"
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
enum level { LOW = -1, MIDDLE, HIGH = 7 };
struct pair_u8 { uint8_t first; uint16_t second; };
struct pair_i64 { int64_t first; uint16_t second; };
struct pair_pair { struct pair_i64 first; uint16_t second; };
struct name { uint32_t length; char text[5]; };
struct event {
  uint8_t number;
  union {
    struct { int16_t by; double precise; } moved;
    struct { struct name name; uint8_t small; } named;
  } is;
};
struct whole {
  enum level level;
  uint8_t small;
  uint32_t letter;
  struct { bool is_some; uint32_t value; } maybe;
  struct { uint8_t first; int64_t second; bool third; } tuple;
  struct pair_pair pair;
  struct { uint32_t length; struct pair_u8 elements[3]; } list;
  struct name names[2];
  struct event event;
  struct { uint32_t length; struct event elements[2]; } events;
};
int main(void) {
  struct whole whole;
  memset(&whole, 0, sizeof whole);
  whole.level = LOW;
  whole.small = 4;
  whole.letter = 0x20AC;
  whole.maybe.is_some = true;
  whole.maybe.value = 0x01020304;
  whole.tuple.first = 9;
  whole.tuple.second = 1000000000;
  whole.tuple.third = true;
  whole.pair.first.first = -2;
  whole.pair.first.second = 3;
  whole.pair.second = 4;
  whole.list.length = 2;
  whole.list.elements[0].first = 1;
  whole.list.elements[1].second = 0x0203;
  whole.names[1].length = 3;
  memcpy(whole.names[1].text, "abc", 3);
  whole.event.number = 4;
  whole.event.is.moved.by = -1;
  whole.event.is.moved.precise = 0.5;
  whole.events.length = 1;
  whole.events.elements[0].number = 5;
  whole.events.elements[0].is.named.name.length = 1;
  whole.events.elements[0].is.named.name.text[0] = 'x';
  whole.events.elements[0].is.named.small = 3;
  for (size_t at = 0; at < sizeof whole; at++) printf("%02x", ((unsigned char *)&whole)[at]);
  return 0;
}
"#;

fn golden() -> Whole {
    let name = |text: &str| Name::try_from(text).unwrap();
    Whole {
        level: Level::Low,
        small: Small::Second,
        letter: '€',
        maybe: Some(0x0102_0304),
        tuple: (9, Duration::from_secs(1), true),
        pair: Pair(Pair(-2, 3), 4),
        list: [Pair(1, 0), Pair(0, 0x0203)].into_iter().collect(),
        names: [name(""), name("abc")],
        event: Event::Moved { by: -1, precise: 0.5 },
        events: [Event::Named(name("x"), Small::First)].into_iter().collect(),
        nothing: Nothing,
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[test]
fn the_bytes_are_those_of_c() {
    let found = hex(&bytes_of(&golden()));
    let expected = concat!(
        "ffffffff04000000ac20000001000000",
        "04030201000000000900000000000000",
        "00ca9a3b000000000100000000000000",
        "feffffffffffffff0300000000000000",
        "04000000000000000200000001000000",
        "00000302000000000000000000000000",
        "00000000030000006162630000000000",
        "0400000000000000ffff000000000000",
        "000000000000e03f0100000000000000",
        "05000000000000000100000078000000",
        "00000000030000000000000000000000",
        "00000000000000000000000000000000",
    );
    assert_eq!(found, expected);
    assert_eq!(Level::LAYOUT.size(), 4);
    assert_eq!(Nothing::LAYOUT.size(), 0);
    let folder = std::env::temp_dir().join(format!("lf-derive-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let (source, program) = (folder.join("golden.c"), folder.join("golden"));
    fs::write(&source, C).unwrap();
    // Where there is no C compiler, the bytes above are what it once made.
    if Command::new("cc").arg(&source).arg("-o").arg(&program).status().is_ok_and(|status| status.success()) {
        let output = Command::new(&program).output().unwrap();
        assert_eq!(found, String::from_utf8(output.stdout).unwrap());
    }
    fs::remove_dir_all(&folder).unwrap();
}
