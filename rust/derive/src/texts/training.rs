// SPDX-License-Identifier: Apache-2.0
//! Finds the pairs that make the sentences of this repository shortest.

use std::collections::BTreeMap;
use std::path::Path;
use std::{env, fs};

use proc_macro2::{TokenStream, TokenTree};
use syn::LitStr;

use super::pack::{FIRST, PAIRS_MAX, VALUE, of_pair, pack, pairs, replace};
use super::{Sentence, split};

/// The crates that have sentences of images.
const CRATES: [&str; 4] = ["model", "wire", "coordination", "runtime"];

#[test]
fn sentences_take_half_of_their_bytes_at_most() {
    let sentences = sentences();
    assert!(sentences.len() > 100, "there are sentences");
    if env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        write(&train(sentences));
        return;
    }
    let length = |sentences: &[Vec<u8>]| sentences.iter().map(Vec::len).sum::<usize>();
    let packed: Vec<Vec<u8>> = sentences.iter().map(|sentence| pack(sentence)).collect();
    let (before, after) = (length(&sentences), length(&packed));
    println!("{} sentences: {before} bytes, packed {after}", sentences.len());
    assert!(after * 2 <= before, "{before} bytes, packed {after}: `cargo xtask bless` finds better pairs");
}

#[test]
fn each_sentence_is_the_same_when_it_is_unpacked() {
    fn unpack(bytes: &[u8], to: &mut Vec<u8>) {
        for byte in bytes {
            match pairs().get(usize::from(byte.wrapping_sub(FIRST))) {
                Some(pair) => unpack(pair, to),
                None => to.push(*byte),
            }
        }
    }
    for sentence in sentences() {
        let mut unpacked = Vec::new();
        unpack(&pack(&sentence), &mut unpacked);
        assert_eq!(unpacked, sentence);
    }
}

/// Returns the pairs, each the most frequent one when those before it are replaced.
fn train(mut sentences: Vec<Vec<u8>>) -> Vec<[String; 2]> {
    let mut texts: BTreeMap<u8, String> = (b' '..=b'~').map(|byte| (byte, char::from(byte).to_string())).collect();
    texts.insert(VALUE, "{}".to_owned());
    let mut pairs = Vec::new();
    for index in 0..PAIRS_MAX {
        let mut counts = BTreeMap::<[u8; 2], usize>::new();
        for pair in sentences.iter().flat_map(|sentence| sentence.windows(2)) {
            *counts.entry([pair[0], pair[1]]).or_default() += 1;
        }
        // Two different pairs can make the same text, and a list of texts has to name each once.
        let known = |pair: &[u8; 2]| {
            let text = format!("{}{}", texts[&pair[0]], texts[&pair[1]]);
            texts.values().any(|known| *known == text)
        };
        let best = counts.into_iter().filter(|(pair, _)| !known(pair)).max_by_key(|(_, count)| *count);
        let Some((pair, _)) = best else { break };
        let parts = pair.map(|byte| texts[&byte].clone());
        texts.insert(of_pair(index), parts.concat());
        pairs.push(parts);
        for sentence in &mut sentences {
            replace(sentence, pair, of_pair(index));
        }
    }
    pairs
}

fn write(pairs: &[[String; 2]]) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/texts/pairs.rs");
    let text = fs::read_to_string(&file).expect("the list can be read");
    let (head, _) = text.split_once("= &[").expect("the list begins so");
    let line = |[first, second]: &[String; 2]| format!("    [{first:?}, {second:?}],\n");
    let lines: Vec<String> = pairs.iter().map(line).collect();
    fs::write(&file, format!("{head}= &[\n{}];\n", lines.concat())).expect("the list can be written");
}

/// Returns all sentences in the sources of [`CRATES`].
fn sentences() -> Vec<Vec<u8>> {
    let mut sentences = Vec::new();
    for name in CRATES {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src");
        for_each_file(&folder, &mut |text| {
            find(text.parse().expect("the crate compiles"), &mut sentences);
        });
    }
    sentences
}

fn for_each_file(folder: &Path, each: &mut dyn FnMut(&str)) {
    let mut paths: Vec<_> =
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            for_each_file(&path, each);
        } else {
            each(&fs::read_to_string(&path).expect("a source file"));
        }
    }
}

/// Finds `say!(f, "…")` and `text!("…")`.
fn find(tokens: TokenStream, sentences: &mut Vec<Vec<u8>>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    for (index, token) in tokens.iter().enumerate() {
        let TokenTree::Group(group) = token else { continue };
        let name = match index.checked_sub(2).map(|start| &tokens[start..index]) {
            Some([TokenTree::Ident(name), TokenTree::Punct(mark)]) if mark.as_char() == '!' => name.to_string(),
            _ => String::new(),
        };
        let parts = split(group.stream());
        let literal = |part: &TokenStream| syn::parse2::<LitStr>(part.clone()).expect("a sentence");
        match (name.as_str(), parts.as_slice()) {
            ("text", [text]) => sentences.push(literal(text).value().into_bytes()),
            ("say", [_, text, ..]) => {
                sentences.push(Sentence::read(&literal(text)).expect("the crate compiles").bytes);
            }
            _ => find(group.stream(), sentences),
        }
    }
}
