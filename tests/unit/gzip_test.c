/* What came as gzip: inflated as it was, or refused with nothing more than allowed written. */
#include "proto/gzip.h"
#include "tests/support/vt.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* Appends a member that holds size bytes. */
static void add_member(struct vt_bytes *to, const void *bytes, size_t size, int level)
{
    static uint8_t block[1 << 16];
    z_stream z = {.next_in = (Bytef *)(uintptr_t)bytes, .avail_in = (uInt)size};
    int code;

    ck_assert_int_eq(deflateInit2(&z, level, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY),
                     Z_OK);
    do {
        z.next_out = block;
        z.avail_out = sizeof block;
        code = deflate(&z, Z_FINISH);
        ck_assert_int_eq(vt_bytes_write(to, block, sizeof block - z.avail_out), 0);
    } while (code == Z_OK);
    ck_assert_int_eq(code, Z_STREAM_END);
    deflateEnd(&z);
}

static vor_status inflate_all(struct vt_bytes *out, const struct vt_bytes *in, uint64_t most)
{
    const struct vor_sink sink = {out, vt_bytes_write};

    out->size = 0;
    return vor_gzip_inflate(&sink, in->data, in->size, most, &vt_err);
}

/* Bytes that deflate by about two. */
static uint8_t *make_bytes(int seed, size_t size)
{
    uint8_t *bytes = malloc(size + 1);

    ck_assert_ptr_nonnull(bytes);
    for (size_t i = 0; i < size; i++)
        bytes[i] = (uint8_t)vor_rng_below((uint64_t)seed, 1, i, 16);
    return bytes;
}

VT_TEST_LOOP(what_was_compressed_comes_back, 80)
{
    static const size_t sizes[] = {0, 1, 100, 32767, 32768, 32769, 65536, 300000};
    size_t size = sizes[_i % 8];
    uint8_t *bytes = make_bytes(_i, size);
    struct vt_bytes in = {0}, out = {0};

    add_member(&in, bytes, size, _i / 8);
    vt_assert_ok(inflate_all(&out, &in, size)); /* as many as may come */
    ck_assert_uint_eq(out.size, size);
    ck_assert(size == 0 || memcmp(out.data, bytes, size) == 0);
    if (size > 0)
        vt_assert_fails(VOR_E_BYTES, inflate_all(&out, &in, size - 1));
    ck_assert_uint_lt(out.size, size + 1);
    free(bytes);
    free(in.data);
    free(out.data);
}

VT_TEST(members_one_behind_the_other_are_one_body)
{
    struct vt_bytes in = {0}, out = {0};

    add_member(&in, "one ", 4, 6);
    add_member(&in, "", 0, 6);
    add_member(&in, "two", 3, 0);
    vt_assert_ok(inflate_all(&out, &in, 100));
    ck_assert_uint_eq(out.size, 7);
    ck_assert_mem_eq(out.data, "one two", 7);
    free(in.data);
    free(out.data);
}

/* Refusal: cut after any byte. */
VT_TEST(what_is_cut_short_is_refused)
{
    struct vt_bytes in = {0}, out = {0};
    uint8_t *bytes = make_bytes(1, 500);
    size_t whole;

    add_member(&in, bytes, 500, 6);
    whole = in.size;
    for (in.size = 1; in.size < whole; in.size++) {
        vt_assert_fails(VOR_E_REQUEST, inflate_all(&out, &in, 1000));
        ck_assert_int_eq(vt_err.byte_offset, (int64_t)in.size);
        ck_assert_ptr_nonnull(strstr(vt_err.message, "is cut short"));
    }
    in.size = 0;
    vt_assert_fails(VOR_E_EMPTY, inflate_all(&out, &in, 1000));
    free(bytes);
    free(in.data);
    free(out.data);
}

VT_TEST_LOOP(what_follows_a_body_is_refused, 5)
{
    static const char *const tails[] = {"x", "\x1f", "\x1fx", "\x1f\x8b", "garbage that goes on"};
    static const char *const words[] = {"has data after its end", "has data after its end",
                                        "has data after its end", "is cut short",
                                        "has data after its end"};
    struct vt_bytes in = {0}, out = {0};
    size_t size;

    add_member(&in, "one", 3, 6);
    size = in.size;
    ck_assert_int_eq(vt_bytes_write(&in, tails[_i], strlen(tails[_i])), 0);
    vt_assert_fails(VOR_E_REQUEST, inflate_all(&out, &in, 1000));
    ck_assert_ptr_nonnull(strstr(vt_err.message, words[_i]));
    ck_assert_int_ge(vt_err.byte_offset, (int64_t)size);
    free(in.data);
    free(out.data);
}

/* Refusal: any byte but those of a header's time, system and level is checked. */
VT_TEST(a_changed_byte_is_refused_or_changes_nothing)
{
    struct vt_bytes in = {0}, out = {0};
    uint8_t *bytes = make_bytes(2, 500);
    int refused = 0;

    add_member(&in, bytes, 500, 6);
    for (size_t i = 0; i < in.size; i++) {
        in.data[i] ^= (uint8_t)(1u << (i % 8));
        if (inflate_all(&out, &in, 1000) == VOR_OK) {
            ck_assert_uint_eq(out.size, 500);
            ck_assert_mem_eq(out.data, bytes, 500);
        } else {
            ck_assert(vt_err.status == VOR_E_REQUEST || vt_err.status == VOR_E_BYTES);
            refused++;
        }
        in.data[i] ^= (uint8_t)(1u << (i % 8));
    }
    ck_assert_int_ge(refused, (int)in.size - 8);
    free(bytes);
    free(in.data);
    free(out.data);
}

/* Refusal: a bomb writes no more than its ratio allows, and less than 1 MiB is free. */
VT_TEST(a_bomb_stops_at_its_ratio)
{
    static uint8_t zeros[16 << 20];
    struct vt_bytes in = {0}, out = {0};

    add_member(&in, zeros, sizeof zeros, 9);
    ck_assert_uint_lt(in.size, sizeof zeros / 900);
    vt_assert_fails(VOR_E_BYTES, inflate_all(&out, &in, (uint64_t)1 << 40));
    ck_assert_uint_le(out.size, in.size * VOR_GZIP_RATIO_MAX);
    ck_assert_uint_eq(vt_err.limit, in.size * VOR_GZIP_RATIO_MAX);
    ck_assert_ptr_nonnull(strstr(vt_err.message, "100 times"));
    in.size = 0;
    add_member(&in, zeros, VOR_GZIP_FREE, 9);
    vt_assert_ok(inflate_all(&out, &in, (uint64_t)1 << 40));
    in.size = 0;
    add_member(&in, zeros, VOR_GZIP_FREE + 1, 9);
    vt_assert_fails(VOR_E_BYTES, inflate_all(&out, &in, (uint64_t)1 << 40));
    ck_assert_uint_le(out.size, VOR_GZIP_FREE);
    free(in.data);
    free(out.data);
}

VT_TEST_LOOP(other_codings_are_no_gzip, 5)
{
    static const char *const bytes[] = {"ply\nformat ascii 1.0\n", "x\x9c\x03\x00\x00\x00\x00\x01",
                                        "\x1f\x8b\x07\x01", "\x28\xb5\x2f\xfd", "\x1f\x9d"};
    struct vt_bytes in = {.data = (uint8_t *)(uintptr_t)bytes[_i], .size = strlen(bytes[_i])};
    struct vt_bytes out = {0};

    if (_i == 1)
        in.size = 8;
    vt_assert_fails(VOR_E_REQUEST, inflate_all(&out, &in, 1000));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "is not gzip"));
    ck_assert_uint_eq(out.size, 0);
    free(out.data);
}

static int refuse_all(void *ctx, const void *bytes, size_t size)
{
    (void)ctx, (void)bytes, (void)size;
    return -1;
}

VT_TEST(a_sink_that_refuses_is_said)
{
    const struct vor_sink sink = {NULL, refuse_all};
    struct vt_bytes in = {0};

    add_member(&in, "one", 3, 6);
    vt_assert_fails(VOR_E_IO, vor_gzip_inflate(&sink, in.data, in.size, 100, &vt_err));
    free(in.data);
}
