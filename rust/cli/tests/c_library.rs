// SPDX-License-Identifier: Apache-2.0
//! LF's library for C, as far as the runtime has it.

use crate::support::{folder, lfz, said, text};

const PROGRAM: &str = r#"
target C {
    files: [
        "/lib/c/reactor-c/util/deque.c", "/lib/c/reactor-c/util/deque.h", "/lib/c/reactor-c/core/utils/vector.h",
        "/lib/c/reactor-c/util/initialize_from_file.h", "/lib/c/reactor-c/util/wave_file_reader.h", "data"
    ],
    cmake-include: [
        "/lib/c/reactor-c/util/deque.cmake", "/lib/c/reactor-c/core/utils/vector.cmake",
        "/lib/c/reactor-c/util/initialize_from_file.cmake", "/lib/c/reactor-c/util/wave_file_reader.cmake",
        "bytes.cmake"
    ]
}
preamble {=
    #include <stdio.h>
    #include "deque.h"
    #include "vector.h"
    #include "initialize_from_file.h"
    #include "wave_file_reader.h"
    #include "hashset/hashset_itr.h"
    #include <string.h>
    #include "core/federated/network/net_util.h"
    #define DATA LF_TARGET_FILES_DIRECTORY "/data/"
=}
main reactor {
    reaction(startup) {=
        static int items[5000];
        deque_t deque;
        deque_initialize(&deque);
        for (int i = 0; i < 3; i++) {
            deque_push_back(&deque, &items[i]);
        }
        deque_push_front(&deque, &items[9]);
        LF_TEST(deque_size(&deque) == 4 && deque_peek_front(&deque) == &items[9], "deque");
        LF_TEST(deque_pop_back(&deque) == &items[2] && deque_pop_front(&deque) == &items[9], "deque");
        LF_TEST(deque_pop_front(&deque) == &items[0] && deque_pop_front(&deque) == &items[1], "deque");
        LF_TEST(deque_is_empty(&deque) && deque_pop_back(&deque) == NULL, "deque");

        vector_t vector = vector_new(1);
        for (int i = 0; i < 5000; i++) {
            vector_push(&vector, &items[i]);
        }
        LF_TEST(vector_size(&vector) == 5000 && *vector_at(&vector, 4999) == &items[4999], "vector");
        LF_TEST(*vector_at(&vector, 5001) == NULL && vector_size(&vector) == 5002, "vector");
        while (vector_pop(&vector) != &items[10]) { }
        for (int i = 0; i < 1000; i++) {
            vector_vote(&vector);
        }
        LF_TEST(vector_size(&vector) == 10 && vector.end - vector.start < 100, "vector");
        vector_free(&vector);

        hashset_t set = hashset_create(2);
        for (int i = 0; i < 5000; i++) {
            LF_TEST(hashset_add(set, &items[i]) == 1 && hashset_add(set, &items[i]) == 0, "hashset");
        }
        for (int i = 0; i < 5000; i += 2) {
            LF_TEST(hashset_remove(set, &items[i]) == 1 && hashset_remove(set, &items[i]) == 0, "hashset");
        }
        LF_TEST(hashset_add(set, NULL) == -1 && hashset_num_items(set) == 2500, "hashset");
        hashset_itr_t walk = hashset_iterator(set);
        int seen = 0;
        while (hashset_iterator_has_next(walk)) {
            LF_TEST(hashset_iterator_next(walk) >= 0, "hashset");
            LF_TEST(((int *)hashset_iterator_value(walk) - items) % 2 == 1, "hashset");
            seen++;
        }
        LF_TEST(seen == 2500 && !hashset_is_member(set, &items[0]) && hashset_is_member(set, &items[1]), "hashset");
        free(walk);
        hashset_destroy(set);

        double x, y;
        int a, b;
        char *first, *second;
        LF_TEST(lf_initialize_double(DATA "rows.csv", ',', 1, &x, &y, NULL) == 2 && x == 1.5 && y == -2e3, "double");
        LF_TEST(lf_initialize_int(DATA "rows.csv", ',', 2, &a, &b, NULL) == 2 && a == 7 && b == -8, "int");
        LF_TEST(lf_initialize_string(DATA "rows.csv", ',', 3, &first, &second, NULL) == 2, "string");
        printf("%s|%s\n", first, second);
        LF_TEST(lf_initialize_int(DATA "rows.csv", ',', 1, &a, NULL) == -1, "a wrong value");
        LF_TEST(lf_initialize_int(DATA "rows.csv", ',', 9, &a, NULL) == -1, "no row");
        LF_TEST(lf_initialize_int(DATA "none.csv", ',', 0, &a, NULL) == -1, "no file");

        lf_waveform_t *wave = read_wave_file(DATA "tone.wav");
        LF_TEST(wave != NULL && wave->length == 2 && wave->num_channels == 1 && wave->waveform[1] == -2, "wave");
        LF_TEST(read_wave_file(DATA "rows.csv") == NULL, "no wave");

        unsigned char bytes[12];
        encode_tag(bytes, (tag_t){.time = -2, .microstep = 0x10203});
        LF_TEST(memcmp(bytes, "\xfe\xff\xff\xff\xff\xff\xff\xff\x03\x02\x01\x00", 12) == 0, "bytes");
        LF_TEST(extract_tag(bytes).time == -2 && extract_tag(bytes).microstep == 0x10203, "tag");
        LF_TEST(extract_int64(bytes) == -2 && extract_int32(bytes + 8) == 0x10203, "numbers");
        encode_uint16(0xabcd, bytes);
        LF_TEST(extract_uint16(bytes) == 0xabcd && bytes[0] == 0xcd, "short number");
        LF_TEST(host_is_big_endian() == (swap_bytes_if_big_endian_int32(1) != 1), "order of bytes");
    =}
}
"#;

#[test]
fn programs_find_lfs_library_for_c() {
    let folder = folder(&[
        ("P.lf", PROGRAM),
        ("bytes.cmake", "target_sources(${LF_MAIN_TARGET} PRIVATE core/federated/network/net_util.c)\n"),
        ("data/rows.csv", "x,y\n1.5, -2e3\r\n7,-8\n \"one, \"\"two\"\"\" , three \n"),
    ]);
    let format = b"fmt \x10\0\0\0\x01\0\x01\0\x44\xac\0\0\x88\x58\x01\0\x02\0\x10\0";
    let tone = [&b"RIFF\x28\0\0\0WAVE"[..], format, b"data\x04\0\0\0\x05\0\xfe\xff"].concat();
    std::fs::write(folder.path().join("data/tone.wav"), tone).expect("it can be written");
    let output = said(&mut lfz(folder.path(), &["run"]));
    let all = text(&output.stdout);
    let expected = "one, \"two\"|three\n";
    assert!(output.status.success() && all.starts_with(expected), "{all}\n{}", text(&output.stderr));
    for error in ["row 1: `1.5` is no value for variable 0", "has no row 9: it ends after 4", "rows.csv is no WAV file"]
    {
        assert!(all.contains(error), "{error}: {all}");
    }
}
