// SPDX-License-Identifier: Apache-2.0
//! Values as bytes: they come back as they went, they are the memory of the C type, and wrong bytes are refused.
use std::fmt::Debug;

use lf_model::layout::Layout;
use lf_model::prelude::*;
use lf_model::{DeliverError, Interval, PayloadError, Postcard, Serializer, Tag, text_to};
use proptest::prelude::*;

payload! {
    /// Fields that need padding, between and after them.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    #[repr(C)]
    struct Sample {
        unit: u8,
        volts: f64,
        phase: u16,
        history: [i32; 3],
        closed: bool,
    }
}

payload! {
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Report {
        pub(crate) first: bool,
        sample: Sample,
        at: Duration,
    }
}

payload! {
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Nothing {}
}

/// Returns the value's bytes; asserts that they decode to the value, and that no other number of bytes is accepted.
fn round_trip<T: Payload + PartialEq + Debug>(value: &T) -> Vec<u8> {
    let mut bytes = vec![0xAA; T::MAX_LEN];
    let len = value.encode(&mut bytes).unwrap();
    bytes.truncate(len);
    assert_eq!(&T::decode(&bytes).unwrap(), value);
    for short in 0..len {
        assert_eq!(
            value.encode(&mut bytes.clone()[..short]),
            Err(PayloadError::NoRoom { needed: len, available: short })
        );
    }
    bytes
}

/// Asserts that a value of a fixed size is not read from fewer or more bytes.
fn refuses_other_lengths<T: FixedPayload + Debug>(_: &T, bytes: &[u8]) {
    let mut longer = bytes.to_vec();
    longer.push(0);
    for wrong in (0..bytes.len()).map(|len| &bytes[..len]).chain([&longer[..]]) {
        let error = T::decode(wrong).unwrap_err();
        assert_eq!(error, PayloadError::Length { expected: T::SIZE, found: wrong.len() });
    }
}

proptest! {
    #[test]
    fn values_come_back_and_other_lengths_are_refused(
        integers: (u8, i8, u16, i16, u32, i32, u64, i64),
        floats: (f32, f64),
        flag: bool,
        array: [i16; 5],
        ns in 0..=i64::MAX,
    ) {
        let (u8_, i8_, u16_, i16_, u32_, i32_, u64_, i64_) = integers;
        macro_rules! check {
            ($($value:expr),+) => {$({
                let value = $value;
                refuses_other_lengths(&value, &round_trip(&value));
            })+};
        }
        check!(u8_, i8_, u16_, i16_, u32_, i32_, u64_, i64_, flag, array, [array, array], ());
        check!(Interval::from_nanos(ns), Instant::from_nanos(i64_), Interval::from_nanos(ns).to_duration());
        prop_assert_eq!(u32_.to_le_bytes().to_vec(), round_trip(&u32_));
        let sample = Sample { unit: u8_, volts: 0.5, phase: u16_, history: [i32_, 1, -1], closed: flag };
        check!(sample, Report { first: flag, sample, at: Interval::from_nanos(ns).to_duration() }, Nothing {});
        // Floats by their bits, because NaN is not equal to itself.
        let mut bytes = [0; 8];
        floats.0.encode(&mut bytes).unwrap();
        prop_assert_eq!(&bytes[..4], floats.0.to_le_bytes());
        floats.1.encode(&mut bytes).unwrap();
        prop_assert_eq!(f64::decode(&bytes).unwrap().to_bits(), floats.1.to_bits());
    }

    #[test]
    fn lists_and_texts_take_as_many_bytes_as_they_hold(
        list in prop::collection::vec(any::<u16>(), 0..=6),
        text in "[^\0]{0,6}",
    ) {
        let list: heapless::Vec<u16, 6> = list.into_iter().collect();
        prop_assert_eq!(round_trip(&list).len(), 2 * list.len());
        let text: heapless::String<24> = text.as_str().try_into().unwrap();
        prop_assert_eq!(round_trip(&text), [text.as_bytes(), &[0]].concat());
    }

    #[test]
    fn no_bytes_make_a_decoder_panic(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
        let _ = Report::decode(&bytes);
        let _ = bool::decode(&bytes);
        let _ = heapless::Vec::<Sample, 2>::decode(&bytes);
        let _ = heapless::String::<8>::decode(&bytes);
        let _ = <[bool; 4]>::decode(&bytes);
        let _ = Duration::decode(&bytes);
    }
}

#[test]
fn structs_are_laid_out_as_c_lays_them_out() {
    assert_eq!(Sample::MAX_LEN, size_of::<Sample>());
    assert_eq!(<Sample as FixedPayload>::ALIGN, align_of::<Sample>());
    let bytes = round_trip(&Sample { unit: 1, volts: -2.0, phase: 0x0304, history: [5, 6, -1], closed: true });
    let at = |offset: usize, len: usize| &bytes[offset..offset + len];
    assert_eq!(at(std::mem::offset_of!(Sample, unit), 1), [1]);
    assert_eq!(at(std::mem::offset_of!(Sample, volts), 8), (-2.0f64).to_le_bytes());
    assert_eq!(at(std::mem::offset_of!(Sample, phase), 2), [4, 3]);
    assert_eq!(at(std::mem::offset_of!(Sample, history), 12), [5, 0, 0, 0, 6, 0, 0, 0, 255, 255, 255, 255]);
    assert_eq!(at(std::mem::offset_of!(Sample, closed), 1), [1]);
    assert_eq!(at(1, 7), [0; 7], "padding is zero, and tells nothing of the memory");
    assert_eq!(Nothing::MAX_LEN, 0);
}

/// Serde's types, with a bound for all values of the type.
#[test]
fn values_in_postcards_form_stay_within_their_bound() {
    type Bounded = Postcard<4>;
    type List = heapless::Vec<u8, 8>;
    let list = |len: u8| (1..=len).collect::<List>();
    let mut room = [0; 9];
    assert_eq!(Bounded::encode(&list(3), &mut room), Ok(4));
    assert_eq!(room, [3, 1, 2, 3, 0, 0, 0, 0, 0]);
    assert_eq!(Bounded::encode(&list(4), &mut room), Err(PayloadError::LongerThan(4)), "although there is room");
    assert_eq!(Bounded::encode(&list(4), &mut room[..4]), Err(PayloadError::LongerThan(4)));
    let too_small = PayloadError::NoRoom { needed: 4, available: 3 };
    assert_eq!(Bounded::encode(&list(3), &mut room[..3]), Err(too_small));
    let decode = |bytes: &[u8]| <Bounded as Serializer<List>>::decode(bytes);
    assert_eq!(decode(&[2, 8, 9]), Ok(List::from_slice(&[8, 9]).unwrap()));
    for wrong in [&[2, 8][..], &[2, 8, 9, 0], &[9, 1, 2, 3, 4, 5, 6, 7, 8, 9]] {
        assert_eq!(decode(wrong), Err(PayloadError::NotDeserialized), "{wrong:?}");
    }
}

/// Runs the functions of layouts, which programs evaluate while they compile.
#[test]
fn layouts_are_those_of_c() {
    let (byte, word) = (Layout::new(1, 1), Layout::new(4, 4));
    let sizes = |layout: Layout| (layout.size(), layout.align());
    assert_eq!(sizes(Layout::EMPTY.with(byte).with(word)), (8, 4));
    assert_eq!(sizes(Layout::EMPTY.with(word).with(byte).with(byte)), (8, 4));
    assert_eq!([sizes(byte.times(5)), sizes(word.times(3))], [(5, 1), (12, 4)]);
    assert_eq!(sizes(byte.times(5).or(word)), (8, 4));
    assert_eq!(sizes(word.or(byte.times(3))), (4, 4));
}

#[test]
fn each_refusal_has_a_sentence_of_its_own() {
    use PayloadError::{Absent, NotDeserialized, NotSerialized, NotUtf8, Nul};
    let numbers = [
        (PayloadError::NoRoom { needed: 71, available: 72 }, "71 72"),
        (PayloadError::Length { expected: 71, found: 72 }, "71 72"),
        (PayloadError::Remainder { element: 71, found: 72 }, "71 72"),
        (PayloadError::TooLong { capacity: 71, found: 72 }, "71 72"),
        (PayloadError::NotBool(71), "0 1 71"),
        (PayloadError::NotChar(0x71), "0x71"),
        (PayloadError::NotVariant(71), "71"),
        (PayloadError::LongerThan(71), "71"),
    ];
    let is_number = |word: &&str| word.starts_with(|first: char| first.is_ascii_digit());
    for (error, expected) in numbers {
        let sentence = error.to_string();
        let words = sentence.split([' ', ',']).filter(is_number).collect::<Vec<_>>();
        assert_eq!(words.join(" "), expected, "{sentence}");
    }
    let sentences = [Absent, NotDeserialized, NotSerialized, NotUtf8, Nul].map(|error| error.to_string());
    assert_eq!(std::collections::BTreeSet::from(sentences).len(), 5);
    let late = DeliverError::Late { input: "a.in", tag: Tag::at(Instant::from_nanos(7)), current: Tag::FOREVER };
    assert!(
        late.to_string().starts_with("a message for a.in came with tag (7 ns, 0), but this federate is at FOREVER")
    );
}

#[test]
fn bytes_that_are_no_value_are_refused_with_the_reason() {
    type Text = heapless::String<4>;
    type List = heapless::Vec<u16, 2>;
    assert_eq!(bool::decode(&[2]), Err(PayloadError::NotBool(2)));
    assert_eq!(<[bool; 2]>::decode(&[1, 7]), Err(PayloadError::NotBool(7)));
    assert_eq!(Text::decode(b""), Err(PayloadError::Nul));
    assert_eq!(Text::decode(b"abc"), Err(PayloadError::Nul));
    assert_eq!(Text::decode(b"a\0c\0"), Err(PayloadError::Nul));
    assert_eq!(Text::decode(b"\xFF\0"), Err(PayloadError::NotUtf8));
    assert_eq!(Text::decode(b"abcde\0"), Err(PayloadError::TooLong { capacity: 4, found: 5 }));
    assert_eq!(text_to("abcd", 4, &mut [0; 5]), Ok(5));
    assert_eq!(text_to("abcde", 4, &mut [0; 6]), Err(PayloadError::TooLong { capacity: 4, found: 5 }));
    assert_eq!(List::decode(&[0; 3]), Err(PayloadError::Remainder { element: 2, found: 3 }));
    assert_eq!(List::decode(&[0; 6]), Err(PayloadError::TooLong { capacity: 2, found: 3 }));
    let mut room = [0; 8];
    assert_eq!(Text::try_from("a\0b").unwrap().encode(&mut room), Err(PayloadError::Nul));
    assert_eq!(Duration::decode(&(-5i64).to_le_bytes()), Ok(Duration::ZERO), "LF's time may be negative, ours not");
}
