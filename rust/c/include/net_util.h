/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers and tags as bytes, the least significant one first, as LF's programs send them. */
#ifndef LF_NET_UTIL_H_
#define LF_NET_UTIL_H_

#include <lf_time.h>

#ifdef __cplusplus
extern "C" {
#endif

static inline void lf_write_bytes(uint64_t value, int count, unsigned char *buffer)
{
	for (int i = 0; i < count; i++) {
		buffer[i] = (unsigned char)(value >> (8 * i));
	}
}

static inline uint64_t lf_read_bytes(const unsigned char *bytes, int count)
{
	uint64_t value = 0;

	for (int i = count - 1; i >= 0; i--) {
		value = value << 8 | bytes[i];
	}
	return value;
}

static inline int host_is_big_endian(void)
{
	const uint16_t one = 1;

	return *(const unsigned char *)&one == 0;
}

static inline void encode_int64(int64_t data, unsigned char *buffer)
{
	lf_write_bytes((uint64_t)data, 8, buffer);
}

static inline void encode_int32(int32_t data, unsigned char *buffer)
{
	lf_write_bytes((uint32_t)data, 4, buffer);
}

static inline void encode_uint32(uint32_t data, unsigned char *buffer)
{
	lf_write_bytes(data, 4, buffer);
}

static inline void encode_uint16(uint16_t data, unsigned char *buffer)
{
	lf_write_bytes(data, 2, buffer);
}

/* 12 bytes: time and microstep. */
static inline void encode_tag(unsigned char *buffer, tag_t tag)
{
	encode_int64(tag.time, buffer);
	encode_uint32(tag.microstep, buffer + 8);
}

static inline int64_t extract_int64(const unsigned char *bytes)
{
	return (int64_t)lf_read_bytes(bytes, 8);
}

static inline int32_t extract_int32(const unsigned char *bytes)
{
	return (int32_t)lf_read_bytes(bytes, 4);
}

static inline uint16_t extract_uint16(const unsigned char *bytes)
{
	return (uint16_t)lf_read_bytes(bytes, 2);
}

static inline tag_t extract_tag(const unsigned char *buffer)
{
	tag_t tag = {extract_int64(buffer), (microstep_t)lf_read_bytes(buffer + 8, 4)};

	return tag;
}

/* These return a number whose bytes in memory are those of the argument with the least significant one first. */
static inline int64_t swap_bytes_if_big_endian_int64(int64_t src)
{
	return extract_int64((const unsigned char *)&src);
}

static inline int32_t swap_bytes_if_big_endian_int32(int32_t src)
{
	return extract_int32((const unsigned char *)&src);
}

static inline uint16_t swap_bytes_if_big_endian_uint16(uint16_t src)
{
	return extract_uint16((const unsigned char *)&src);
}

#ifdef __cplusplus
}
#endif

#endif
