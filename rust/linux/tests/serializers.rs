// SPDX-License-Identifier: Apache-2.0
//! Values by serializers: they come back as they went, within their bound, and no bytes make a decoder panic.
#![allow(missing_docs, unreachable_pub, clippy::unwrap_used, reason = "a test program has no users")]
use std::collections::BTreeMap;

use lf_linux::MaxLength;
use lf_linux::model::{Bounded, PayloadError, Postcard, Serializer};
use postcard::experimental::max_size::MaxSize;
use proptest::prelude::*;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, MaxSize)]
enum Command {
    Stop,
    Move { steps: u128, back: bool },
    Color([u8; 3], Option<char>),
}

type Names = BTreeMap<String, (usize, Vec<Command>)>;

fn round_trip<T, S: Serializer<T>>(value: &T) -> Result<T, PayloadError> {
    let mut bytes = vec![0xAA; S::MAX_LEN];
    let len = S::encode(value, &mut bytes)?;
    S::decode(&bytes[..len])
}

fn any_command() -> impl Strategy<Value = Command> {
    prop_oneof![
        Just(Command::Stop),
        any::<(u128, bool)>().prop_map(|(steps, back)| Command::Move { steps, back }),
        any::<([u8; 3], Option<char>)>().prop_map(|(color, letter)| Command::Color(color, letter)),
    ]
}

fn any_names() -> impl Strategy<Value = Names> {
    let commands = prop::collection::vec(any_command(), 0..3);
    prop::collection::btree_map("[a-z]{0,5}", (any::<usize>(), commands), 0..4)
}

proptest! {
    #[test]
    fn values_come_back(
        command in any_command(),
        names in any_names(),
        text in "[^\0]{0,9}",
        list in prop::collection::vec(any::<Option<i32>>(), 0..=9),
    ) {
        prop_assert_eq!(&round_trip::<_, Postcard<{ <Command as Bounded>::BYTES }>>(&command), &Ok(command));
        prop_assert_eq!(&round_trip::<Names, Postcard<999>>(&names), &Ok(names));
        prop_assert_eq!(&round_trip::<String, MaxLength<36>>(&text), &Ok(text));
        prop_assert_eq!(&round_trip::<Vec<Option<i32>>, MaxLength<9>>(&list), &Ok(list));
    }

    #[test]
    fn no_bytes_make_a_decoder_panic(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
        let _ = <Postcard<80> as Serializer<Command>>::decode(&bytes);
        let _ = <Postcard<80> as Serializer<Names>>::decode(&bytes);
        let _ = <MaxLength<9> as Serializer<String>>::decode(&bytes);
        let _ = <MaxLength<9> as Serializer<Vec<Option<char>>>>::decode(&bytes);
    }
}

#[test]
fn bytes_that_are_too_long_or_no_value_are_refused_with_the_reason() {
    let command = Command::Move { steps: u128::MAX, back: false };
    let mut bytes = [0; 40];
    assert_eq!(Postcard::<5>::encode(&command, &mut bytes), Err(PayloadError::LongerThan(5)));
    let no_room = PayloadError::NoRoom { needed: 30, available: 5 };
    assert_eq!(Postcard::<30>::encode(&command, &mut bytes[..5]), Err(no_room));
    let len = Postcard::<30>::encode(&command, &mut bytes).unwrap();
    for wrong in [&bytes[..len - 1], &bytes[..=len], &[], &[9]] {
        let found: Result<Command, _> = Postcard::<30>::decode(wrong);
        assert_eq!(found, Err(PayloadError::NotDeserialized));
    }
}
