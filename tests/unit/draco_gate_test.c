#include "proto/draco/draco_gate.h"
#include "proto/draco/draco_meter.h"
#include "tests/unit/draco_files.h"

#include <stdio.h>
#include <unistd.h>

/* Files that the cases below change a few bytes of. */
enum base {
    LOSSLESS, /* 4 points, sequential: count at 11, attribute table at 16, values from 23 */
    TREE,     /* 4 points, kd-tree: as LOSSLESS, then level at 22, bits at 23, points at 27 */
    OLD_TREE, /* 200 points, bitstream 2.1, kd-tree of floats: method at 22, points at 24 and 41 */
    OLD_INTS, /* 200 points, bitstream 2.1, kd-tree of integers: points at 24 and 32 */
    ORIGIN,   /* LOSSLESS with metadata from 11: no attributes, 2 entries, the first at 13 */
    BREAKER,  /* a mesh, bitstream 2.2: traversal at 11, then vertices, faces, tables, symbols */
    BASES
};

static struct vt_bytes bases[BASES];

static void append(struct vt_bytes *out, const void *bytes, size_t size)
{
    ck_assert_int_eq(vt_bytes_write(out, bytes, size), 0);
}

#define APPEND(out, literal) append(out, literal, sizeof(literal) - 1)

static void make_old_trees(void)
{
    static const char head[] = "DRACO\2\1\0\1\0\0\xc8\0\0\0\1\1\0\x09\3\0\0";

    APPEND(&bases[OLD_TREE], head);
    APPEND(&bases[OLD_TREE], "\0\6\xc8\0\0\0\3\0\0\0\1\x0a\0\0\0\0\0\x80\x3f\xc8\0\0\0\6\0\0\0");
    APPEND(&bases[OLD_INTS], head);
    APPEND(&bases[OLD_INTS], "\1\6\xc8\0\0\0\x0a\0\0\0\xc8\0\0\0");
}

static void make_bases(void)
{
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 4);
    vt_assert_ok(draco_encode(&bases[LOSSLESS], &cloud, 0, 1));
    vt_assert_ok(draco_encode(&bases[TREE], &cloud, 8, 0));
    cloud.origin[0] = 1e6;
    vt_assert_ok(draco_encode(&bases[ORIGIN], &cloud, 0, 1));
    vor_cloud_free(&cloud);
    make_old_trees();
    bases[BREAKER].data =
        vt_slurp("tests/fuzz/corpus/draco/mesh-edgebreaker.drc", &bases[BREAKER].size);
    ck_assert_ptr_nonnull(bases[BREAKER].data);
}

static void free_bases(void)
{
    for (int i = 0; i < BASES; i++)
        free(bases[i].data);
    memset(bases, 0, sizeof bases);
}

enum {
    LIBRARY = -1, /* the gate lets it pass, the library refuses: nobody knows where */
    END = -2      /* where the file ends */
};

static const struct {
    const char *what;
    enum base base;
    size_t at;
    const char *bytes;
    size_t count;
    vor_status want;
    int64_t offset;
} cases[] = {
    {"another magic", LOSSLESS, 0, "d", 1, VOR_E_FORMAT, 0},
    {"magic cut short by a zero", LOSSLESS, 4, "\0", 1, VOR_E_FORMAT, 0},
    {"bitstream 0.3", LOSSLESS, 5, "\0", 1, VOR_E_FORMAT, 5},
    {"bitstream 3.0", LOSSLESS, 5, "\3\0", 2, VOR_E_FORMAT, 5},
    {"bitstream 255.255", LOSSLESS, 5, "\377\377", 2, VOR_E_FORMAT, 5},
    {"bitstream 2.4", LOSSLESS, 6, "\4", 1, VOR_E_FORMAT, 5},
    {"bitstream 1.4", LOSSLESS, 5, "\1\4", 2, VOR_E_FORMAT, 5},
    {"a mesh of bitstream 2.3", BREAKER, 6, "\3", 1, VOR_E_FORMAT, 5},
    {"geometry 2", LOSSLESS, 7, "\2", 1, VOR_E_FORMAT, 7},
    {"geometry 255", LOSSLESS, 7, "\377", 1, VOR_E_FORMAT, 7},
    {"method 2", LOSSLESS, 8, "\2", 1, VOR_E_FORMAT, 8},
    {"method 255 of a mesh", BREAKER, 8, "\377", 1, VOR_E_FORMAT, 8},
    {"no points", LOSSLESS, 11, "\0", 1, VOR_E_EMPTY, 11},
    {"no points in a kd-tree", TREE, 11, "\0", 1, VOR_E_EMPTY, 11},
    {"2^31 - 1 points", LOSSLESS, 11, "\377\377\377\177", 4, VOR_E_LIMIT, 11},
    {"2^31 points", LOSSLESS, 11, "\0\0\0\200", 4, VOR_E_FORMAT, 11},
    {"2^32 - 1 points in a kd-tree", TREE, 11, "\377\377\377\377", 4, VOR_E_FORMAT, 11},
    {"100,000,000 points", TREE, 11, "\0\341\365\5", 4, VOR_E_LIMIT, 11},
    {"one point more than there is", LOSSLESS, 11, "\5", 1, VOR_E_FORMAT, LIBRARY},
    {"no attribute decoder", LOSSLESS, 15, "\0", 1, VOR_E_FORMAT, 15},
    {"two attribute decoders in a kd-tree", TREE, 15, "\2", 1, VOR_E_FORMAT, 15},
    {"two attribute decoders", LOSSLESS, 15, "\2", 1, VOR_E_FORMAT, LIBRARY},
    {"no attributes", LOSSLESS, 16, "\0", 1, VOR_E_FORMAT, 16},
    {"66 attributes", LOSSLESS, 16, "\102", 1, VOR_E_LIMIT, 16},
    {"2^32 - 1 attributes", LOSSLESS, 16, "\377\377\377\377\17", 5, VOR_E_LIMIT, 16},
    {"a number of attributes that never ends", LOSSLESS, 16, "\377\377\377\377\377", 5,
     VOR_E_FORMAT, 16},
    {"a number of attributes beyond 32 bits", LOSSLESS, 16, "\377\377\377\377\37", 5, VOR_E_FORMAT,
     16},
    {"no position", LOSSLESS, 17, "\1", 1, VOR_E_FORMAT, LIBRARY},
    {"an attribute of kind 5", LOSSLESS, 17, "\5", 1, VOR_E_FORMAT, 17},
    {"scalar type 0", LOSSLESS, 18, "\0", 1, VOR_E_FORMAT, 18},
    {"scalar type 12", LOSSLESS, 18, "\14", 1, VOR_E_FORMAT, 18},
    {"no components", LOSSLESS, 19, "\0", 1, VOR_E_FORMAT, 19},
    {"positions of 2 components", LOSSLESS, 19, "\2", 1, VOR_E_FORMAT, 55},
    {"17 components", LOSSLESS, 19, "\21", 1, VOR_E_FORMAT, 19},
    {"255 components", TREE, 19, "\377", 1, VOR_E_FORMAT, 19},
    {"an unknown decoder of values", LOSSLESS, 22, "\11", 1, VOR_E_FORMAT, LIBRARY},
    {"a NaN", LOSSLESS, 23, "\0\0\300\177", 4, VOR_E_NONFINITE, LIBRARY},
    {"kd-tree of level 7", TREE, 22, "\7", 1, VOR_E_FORMAT, 22},
    {"kd-tree of 33 bits", TREE, 23, "\41", 1, VOR_E_FORMAT, 23},
    {"kd-tree of 2^32 - 1 bits", TREE, 23, "\377\377\377\377", 4, VOR_E_FORMAT, 23},
    {"kd-tree that counts 2^32 - 1 points", TREE, 27, "\377\377\377\377", 4, VOR_E_FORMAT, 27},
    {"kd-tree that counts no points", TREE, 27, "\0", 1, VOR_E_FORMAT, 27},
    {"old kd-tree by method 2", OLD_TREE, 22, "\2", 1, VOR_E_FORMAT, 22},
    {"old kd-tree of level 7", OLD_TREE, 23, "\7", 1, VOR_E_FORMAT, 23},
    {"old kd-tree of 262,144,000 points", OLD_TREE, 24, "\0\0\240\17", 4, VOR_E_FORMAT, 24},
    {"old kd-tree, version 4", OLD_TREE, 28, "\4", 1, VOR_E_FORMAT, 28},
    {"old kd-tree, inner method 2", OLD_TREE, 32, "\2", 1, VOR_E_FORMAT, 32},
    {"old kd-tree of 32 bits", OLD_TREE, 33, "\40", 1, VOR_E_FORMAT, 33},
    {"old kd-tree, 262,144,000 points inside", OLD_TREE, 41, "\0\0\240\17", 4, VOR_E_FORMAT, 41},
    {"old kd-tree, inner level 7", OLD_TREE, 45, "\7", 1, VOR_E_FORMAT, 45},
    {"old kd-tree without data", OLD_TREE, 0, "D", 1, VOR_E_FORMAT, LIBRARY},
    {"old integers of 262,144,000 points", OLD_INTS, 24, "\0\0\240\17", 4, VOR_E_FORMAT, 24},
    {"old integers of 33 bits", OLD_INTS, 28, "\41", 1, VOR_E_FORMAT, 28},
    {"old integers, 2^32 - 1 points inside", OLD_INTS, 32, "\377\377\377\377", 4, VOR_E_FORMAT, 32},
    {"old integers without data", OLD_INTS, 0, "D", 1, VOR_E_FORMAT, LIBRARY},
    {"metadata of 127 attributes", ORIGIN, 11, "\177", 1, VOR_E_FORMAT, END},
    {"metadata of 127 entries", ORIGIN, 12, "\177", 1, VOR_E_FORMAT, END},
    {"a name of 255 bytes", ORIGIN, 13, "\377", 1, VOR_E_FORMAT, END},
    {"an entry of 4 GB", ORIGIN, 29, "\377\377\377\377\17", 5, VOR_E_FORMAT, END},
    {"traversal 3", BREAKER, 11, "\3", 1, VOR_E_FORMAT, 11},
    {"no vertices", BREAKER, 12, "\0", 1, VOR_E_EMPTY, 12},
    {"2^32 - 1 vertices", BREAKER, 12, "\377\377\377\377\17", 5, VOR_E_LIMIT, 12},
    {"no faces", BREAKER, 13, "\0", 1, VOR_E_FORMAT, 13},
    {"2^32 - 1 faces", BREAKER, 13, "\377\377\377\377\17", 5, VOR_E_LIMIT, 13},
    {"more symbols than faces", BREAKER, 15, "\41", 1, VOR_E_FORMAT, 15},
    {"more splits than symbols", BREAKER, 16, "\41", 1, VOR_E_FORMAT, 16},
};

/* Refusal: one lie each, the exact status and the exact byte. */
START_TEST(every_lie_gets_its_own_status_and_place)
{
    make_bases();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct vt_bytes *base = &bases[cases[k].base];
        struct vt_bytes bytes = {.data = malloc(base->size), .size = base->size};
        struct vor_cloud cloud;
        int64_t offset = cases[k].offset == END ? (int64_t)base->size : cases[k].offset;
        vor_status status;

        ck_assert_ptr_nonnull(bytes.data);
        ck_assert_uint_le(cases[k].at + cases[k].count, base->size);
        memcpy(bytes.data, base->data, base->size);
        memcpy(bytes.data + cases[k].at, cases[k].bytes, cases[k].count);
        status = draco_decode(&cloud, &bytes);
        ck_assert_msg(status == cases[k].want, "%s: %s: %s", cases[k].what, vor_status_slug(status),
                      vt_err.message);
        ck_assert_msg(vt_err.byte_offset == offset, "%s: byte %ld: %s", cases[k].what,
                      (long)vt_err.byte_offset, vt_err.message);
        ck_assert_uint_gt(strlen(vt_err.message), 0);
        ck_assert_msg(status != VOR_E_LIMIT || vt_err.got > vt_err.limit, "%s: limit %lu, got %lu",
                      cases[k].what, (unsigned long)vt_err.limit, (unsigned long)vt_err.got);
        ck_assert(cloud.n == 0 && cloud.xyz == NULL && cloud.attribute_count == 0);
        free(bytes.data);
    }
    free_bases();
    vt_assert_no_leak();
}
END_TEST

/* Refusal: files end anywhere. From where the gate has seen enough, the library decides; values
 * that are not entropy-coded must all be there. */
START_TEST(no_beginning_of_a_file_is_taken_for_the_file)
{
    struct vor_cloud cloud;

    make_bases();
    for (int base = 0; base < BASES; base++) {
        size_t counted = base == BREAKER ? 17 : base == ORIGIN || base == LOSSLESS ? SIZE_MAX : 31;

        for (size_t size = 0; size < bases[base].size && size < counted; size++) {
            struct vt_bytes cut = {.data = malloc(size + 1), .size = size};
            vor_status status;

            memcpy(cut.data, bases[base].data, size);
            cut.data = realloc(cut.data, size > 0 ? size : 1);
            status = draco_decode(&cloud, &cut);
            ck_assert_msg(status == VOR_E_FORMAT, "%zu bytes of base %d: %s", size, base,
                          vor_status_slug(status));
            ck_assert(size < 5 ? vt_err.byte_offset == 0 : 1);
            free(cut.data);
        }
    }
    free_bases();
    vt_assert_no_leak();
}
END_TEST

/* Property: any byte of any base may be anything; what comes is a cloud or a refusal. */
START_TEST(any_changed_byte_ends_in_a_cloud_or_a_refusal)
{
    make_bases();
    for (int base = 0; base < BASES; base++) {
        for (size_t k = 0; k < 600; k++) {
            struct vt_bytes bytes = {.data = malloc(bases[base].size), .size = bases[base].size};
            size_t at = (size_t)(vt_unit(base, 3 * k) * (double)bytes.size);
            struct vor_cloud cloud;
            vor_status status;

            memcpy(bytes.data, bases[base].data, bytes.size);
            bytes.data[at] = (uint8_t)(256 * vt_unit(base, 3 * k + 1));
            at = (size_t)(vt_unit(base, 3 * k + 2) * (double)bytes.size);
            bytes.data[at] ^= (uint8_t)(1 << (k % 8));
            status = draco_decode(&cloud, &bytes);
            ck_assert_msg(status == VOR_OK ? cloud.n > 0 : cloud.n == 0 && vt_err.message[0] != 0,
                          "base %d, change %zu: %s", base, k, vor_status_slug(status));
            vor_cloud_free(&cloud);
            free(bytes.data);
        }
    }
    free_bases();
    vt_assert_no_leak();
}
END_TEST

START_TEST(the_limit_of_points_is_what_the_caller_says)
{
    struct vor_limits limits = {.points = 3, .header_bytes = 65536};
    struct vor_cloud cloud;

    make_bases();
    vor_cloud_init(&cloud, &vt_memory);
    for (int base = 0; base < BASES; base++) {
        vt_assert_fails(VOR_E_LIMIT, vor_draco_read(&cloud, bases[base].data, bases[base].size,
                                                    &limits, &vt_err));
        ck_assert_uint_eq(vt_err.limit, 3);
        ck_assert_uint_gt(vt_err.got, 3);
    }
    limits.points = 4;
    vt_assert_ok(vor_draco_read(&cloud, bases[TREE].data, bases[TREE].size, &limits, &vt_err));
    vor_cloud_free(&cloud);
    free_bases();
}
END_TEST

/* Regression: 58 bytes that decode to 100,000,000 points. A byte may stand for 64. */
START_TEST(points_must_be_in_proportion_to_bytes)
{
    uint8_t bytes[58] = "DRACO\2\3\0\1\0\0\0\341\365\5\1\1\0\11\3\0\0\0\12\0\0\0\0\341\365\5";
    struct vor_cloud cloud;

    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_fails(VOR_E_LIMIT,
                    vor_draco_read(&cloud, bytes, sizeof bytes, &draco_limits, &vt_err));
    ck_assert_uint_eq(vt_err.limit, 58 * 64 + 100000);
    ck_assert_uint_eq(vt_err.got, 100000000);
}
END_TEST

/* Refusal: of 64 scalars a point, a kd-tree may hold a 21st of the points; they take it 441 times
 * as long. */
START_TEST(scalars_in_a_kd_tree_must_be_in_proportion_to_bytes)
{
    uint8_t bytes[128] = "DRACO\2\3\0\1\0\0\0\0\1\0\1\5\0\11\3\0\0";
    static const uint8_t extra[] = {4, 6, 16, 0, 1, 4, 6, 16, 0, 2, 4, 6, 16, 0, 3, 4, 6, 13, 0, 4};
    struct vor_cloud cloud;

    memcpy(bytes + 22, extra, sizeof extra);
    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_fails(VOR_E_LIMIT,
                    vor_draco_read(&cloud, bytes, sizeof bytes, &draco_limits, &vt_err));
    ck_assert_uint_eq(vt_err.limit, 3 * (128 * 64 + 100000));
    ck_assert_uint_eq(vt_err.got, 65536 * 64);
    bytes[39] = 14;
    vt_assert_fails(VOR_E_LIMIT,
                    vor_draco_read(&cloud, bytes, sizeof bytes, &draco_limits, &vt_err));
    ck_assert_uint_eq(vt_err.limit, VOR_DRACO_KD_SCALARS);
    ck_assert_uint_eq(vt_err.got, 65);
}
END_TEST

static void nest(struct vt_bytes *out, int levels)
{
    APPEND(out, "DRACO\2\3\0\0\0\x80\0");
    for (int i = 0; i < levels; i++)
        APPEND(out, "\0\1\1x");
    APPEND(out, "\0\0");
}

/* Regression: the library frees nested metadata by recursion, so depth is stack. */
/* Reads a base with `count` bytes of that value behind it. */
static vor_status read_with_rest(enum base base, uint8_t value, size_t count)
{
    struct vt_bytes bytes = {0};
    struct vor_cloud cloud;
    vor_status status;

    append(&bytes, bases[base].data, bases[base].size);
    for (size_t i = 0; i < count; i++)
        append(&bytes, &value, 1);
    status = draco_decode(&cloud, &bytes);
    vor_cloud_free(&cloud);
    free(bytes.data);
    return status;
}

START_TEST(bytes_behind_the_stream_are_refused_but_for_padding)
{
    static const enum base whole[] = {LOSSLESS, TREE, ORIGIN, BREAKER};
    enum { MANY = 5000 };

    make_bases();
    for (size_t i = 0; i < sizeof whole / sizeof whole[0]; i++) {
        int64_t size = (int64_t)bases[whole[i]].size;

        vt_assert_ok(read_with_rest(whole[i], 0, 0));
        vt_assert_ok(read_with_rest(whole[i], 0, VOR_DRACO_PADDING_MAX));
        vt_assert_fails(VOR_E_FORMAT, read_with_rest(whole[i], 0, VOR_DRACO_PADDING_MAX + 1));
        ck_assert_int_eq(vt_err.byte_offset, size);
        vt_assert_fails(VOR_E_FORMAT, read_with_rest(whole[i], 1, 1));
        ck_assert_int_eq(vt_err.byte_offset, size);
        vt_assert_fails(VOR_E_FORMAT, read_with_rest(whole[i], 0, MANY));
        ck_assert_int_ge(vt_err.byte_offset, size);
        ck_assert_int_lt(vt_err.byte_offset, size + 64);
        ck_assert_ptr_nonnull(strstr(vt_err.message, "want at most 7 more"));
    }
    free_bases();
    vt_assert_no_leak();
}
END_TEST

/* 1 MB behind the four coders of a kd-tree would let it declare 64 million points. */
START_TEST(a_kd_tree_with_bytes_behind_it_is_refused_before_it_is_decoded)
{
    struct vt_bytes bytes = {0};

    make_bases();
    append(&bytes, bases[TREE].data, bases[TREE].size);
    for (size_t i = 0; i < 1 << 20; i++)
        append(&bytes, "", 1);
    vt_assert_fails(VOR_E_FORMAT, vor_draco_gate(bytes.data, bytes.size, &draco_limits, &vt_err));
    free(bytes.data);
    free_bases();
}
END_TEST

/* ORIGIN with an entry of 60,000 bytes more in its metadata, and a count of 200,000 points. */
START_TEST(metadata_stands_for_no_points)
{
    enum { ENTRY = 60000, POINTS = 200000 };
    static const uint8_t flags_on[] = "DRACO\2\3\0\0\0\200\0\1\1x\340\324\3";
    struct vt_bytes bytes = {0};
    uint32_t points = POINTS;

    append(&bytes, flags_on, sizeof flags_on - 1);
    for (size_t i = 0; i < ENTRY; i++)
        append(&bytes, "", 1);
    APPEND(&bytes, "\0");
    append(&bytes, &points, sizeof points);
    APPEND(&bytes, "\1\1\0\11\3\0\0\1");
    vt_assert_fails(VOR_E_LIMIT, vor_draco_gate(bytes.data, bytes.size, &draco_limits, &vt_err));
    ck_assert_uint_eq(vt_err.got, POINTS);
    ck_assert_uint_lt(vt_err.limit, VOR_DRACO_POINTS_FREE + 100 * VOR_DRACO_POINTS_PER_BYTE);
    free(bytes.data);
}
END_TEST

START_TEST(a_strict_gate_takes_point_clouds_of_bitstream_2_3_without_metadata_alone)
{
    static const struct {
        enum base base;
        int64_t offset; /* -1: it is taken */
    } strict[] = {{LOSSLESS, -1}, {TREE, -1}, {OLD_TREE, 5}, {ORIGIN, 9}, {BREAKER, 7}};
    struct vor_limits limits = draco_limits;

    limits.strict_draco = 1;
    make_bases();
    for (size_t i = 0; i < sizeof strict / sizeof strict[0]; i++) {
        const struct vt_bytes *base = &bases[strict[i].base];
        vor_status status = vor_draco_gate(base->data, base->size, &limits, &vt_err);

        ck_assert_int_eq(status, strict[i].offset < 0 ? VOR_OK : VOR_E_FORMAT);
        if (strict[i].offset >= 0)
            ck_assert_int_eq(vt_err.byte_offset, strict[i].offset);
    }
    free_bases();
}
END_TEST

START_TEST(metadata_nests_as_deep_as_the_gate_allows_and_no_deeper)
{
    struct vor_cloud cloud;

    make_bases();
    for (int k = 0; k < 3; k++) {
        struct vt_bytes bytes = {0};

        nest(&bytes, k == 0 ? 15 : k == 1 ? 16 : 500000);
        append(&bytes, bases[LOSSLESS].data + 11, bases[LOSSLESS].size - 11);
        if (k == 0)
            vt_assert_ok(draco_decode(&cloud, &bytes));
        else
            vt_assert_fails(VOR_E_FORMAT, draco_decode(&cloud, &bytes));
        vor_cloud_free(&cloud);
        free(bytes.data);
    }
    free_bases();
}
END_TEST

/* Regression: 43 bytes that declare 200 points made the library ask for 3 GB. The gate refuses
 * them; this goes round the gate. */
START_TEST(the_meter_alone_stops_what_the_gate_would_have_stopped)
{
    static const struct {
        enum base base;
        size_t at;
    } bombs[] = {{OLD_TREE, 24}, {OLD_INTS, 24}, {LOSSLESS, 11}, {BREAKER, 12}, {BREAKER, 13}};

    make_bases();
    for (size_t k = 0; k < sizeof bombs / sizeof *bombs; k++) {
        const struct vt_bytes *base = &bases[bombs[k].base];
        struct vor_memory memory;
        struct vor_draco_purse purse = {.memory = &memory, .most = (size_t)64 << 20};
        struct vor_draco_meter meter = vor_draco_purse_meter(&purse);
        struct vor_draco_decoded *decoded;
        enum vor_draco_result result;
        size_t size = base->size;
        char message[96];

        vor_memory_init(&memory, SIZE_MAX);
        memcpy(base->data + bombs[k].at, "\377\377\377\377\17", bombs[k].base == BREAKER ? 5 : 4);
        base->data[bombs[k].at + 3] &= bombs[k].base == BREAKER ? 0xff : 0x0f;
        result = vor_draco_decode(&decoded, &meter, base->data, &size, message);
        ck_assert_msg(result == VOR_DRACO_NO_MEMORY || result == VOR_DRACO_REFUSED, "bomb %zu", k);
        ck_assert_msg(bombs[k].base == BREAKER || result == VOR_DRACO_NO_MEMORY,
                      "bomb %zu was no bomb: %s", k, message);
        ck_assert_ptr_null(decoded);
        ck_assert_uint_le(atomic_load(&memory.peak), purse.most);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
    free_bases();
}
END_TEST

/* 63 attributes of 16 equal integers: 800 MB out of a few kilobytes, all of it declared honestly.
 */
START_TEST(a_small_file_that_unpacks_to_a_large_cloud_meets_its_budget)
{
    struct vor_cloud cloud, back;
    struct vor_memory memory;
    struct vt_bytes bytes;

    vt_cloud_cube(&cloud, 1, 20000);
    for (int i = 0; i < 63; i++)
        (void)draco_add(&cloud, "zero", VOR_GENERIC, VOR_INT32, 16);
    vt_assert_ok(draco_encode(&bytes, &cloud, 1, 1));
    vor_cloud_free(&cloud);
    ck_assert_uint_lt(bytes.size, 20000);
    vor_memory_init(&memory, (size_t)1 << 40);
    vor_cloud_init(&back, &memory);
    vt_assert_fails(VOR_E_NOMEM,
                    vor_draco_read(&back, bytes.data, bytes.size, &draco_limits, &vt_err));
    ck_assert_uint_le(atomic_load(&memory.peak), (64 << 20) + 40 * (100000 + 64 * bytes.size));
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    free(bytes.data);
}
END_TEST

/* Property: wherever the cap lies, the call succeeds or says so, and nothing stays booked. */
START_TEST(any_cap_on_memory_ends_cleanly)
{
    make_bases();
    for (int base = 0; base < BASES; base++) {
        int ended = 0;

        for (size_t cap = 0; !ended && cap < 40000; cap += 61) {
            struct vor_memory memory;
            struct vor_cloud cloud;
            vor_status status;

            vor_memory_init(&memory, cap);
            vor_cloud_init(&cloud, &memory);
            status =
                vor_draco_read(&cloud, bases[base].data, bases[base].size, &draco_limits, &vt_err);
            ended = status != VOR_E_NOMEM;
            ck_assert_uint_le(atomic_load(&memory.peak), cap);
            vor_cloud_free(&cloud);
            ck_assert_uint_eq(atomic_load(&memory.used), 0);
        }
        ck_assert_msg(ended, "base %d does not fit into 40,000 bytes", base);
    }
    free_bases();
}
END_TEST

/* Property: the same for the writer, which hands nothing to the sink unless all is well. */
START_TEST(any_cap_on_the_writer_ends_cleanly)
{
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 200);
    for (int k = 0; k < 2; k++) {
        size_t before = atomic_load(&vt_memory.used), failures = 0;
        vor_status status = VOR_E_NOMEM;

        for (size_t more = 0; status == VOR_E_NOMEM && more < 1 << 20; more += 211) {
            struct vt_bytes bytes;

            vt_memory.cap = before + more;
            status = draco_encode(&bytes, &cloud, -1, k);
            ck_assert(status == VOR_OK ? bytes.size > 0 : bytes.data == NULL);
            ck_assert_uint_eq(atomic_load(&vt_memory.used), before);
            failures += status == VOR_E_NOMEM;
            free(bytes.data);
        }
        vt_memory.cap = SIZE_MAX;
        ck_assert_int_eq(status, VOR_OK);
        ck_assert_uint_gt(failures, 20);
    }
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

/* Property: the N-th allocation of ours fails. */
START_TEST(any_allocation_may_fail)
{
    struct vor_cloud cloud, back;

    for (int keep_order = 0; keep_order < 2; keep_order++) {
        struct vt_bytes bytes;
        size_t failures = 0;
        vor_status status = VOR_E_NOMEM;

        vt_cloud_cube(&cloud, 1, 100);
        (void)draco_add(&cloud, "color", VOR_COLOR, VOR_UINT8, 3);
        ((int32_t *)draco_add(&cloud, "wide", VOR_GENERIC, VOR_INT32, 1))[3] = INT32_MIN;
        for (size_t i = 1; status == VOR_E_NOMEM; i++) {
            vt_memory.fail_at = atomic_load(&vt_memory.calls) + i;
            status = draco_encode(&bytes, &cloud, -1, keep_order);
            failures += status == VOR_E_NOMEM;
            ck_assert(status == VOR_OK || bytes.data == NULL);
        }
        ck_assert_int_eq(status, VOR_OK);
        ck_assert_uint_ge(failures, 2);
        status = VOR_E_NOMEM;
        failures = 0;
        for (size_t i = 1; status == VOR_E_NOMEM; i++) {
            vt_memory.fail_at = atomic_load(&vt_memory.calls) + i;
            status = draco_decode(&back, &bytes);
            failures += status == VOR_E_NOMEM;
        }
        vt_memory.fail_at = 0;
        ck_assert_int_eq(status, VOR_OK);
        ck_assert_uint_ge(failures, 3);
        vor_cloud_free(&back);
        vor_cloud_free(&cloud);
        free(bytes.data);
    }
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("draco_gate");

    vt_add(suite, every_lie_gets_its_own_status_and_place);
    vt_add(suite, no_beginning_of_a_file_is_taken_for_the_file);
    vt_add(suite, any_changed_byte_ends_in_a_cloud_or_a_refusal);
    vt_add(suite, the_limit_of_points_is_what_the_caller_says);
    vt_add(suite, points_must_be_in_proportion_to_bytes);
    vt_add(suite, scalars_in_a_kd_tree_must_be_in_proportion_to_bytes);
    vt_add(suite, bytes_behind_the_stream_are_refused_but_for_padding);
    vt_add(suite, a_kd_tree_with_bytes_behind_it_is_refused_before_it_is_decoded);
    vt_add(suite, metadata_stands_for_no_points);
    vt_add(suite, a_strict_gate_takes_point_clouds_of_bitstream_2_3_without_metadata_alone);
    vt_add(suite, metadata_nests_as_deep_as_the_gate_allows_and_no_deeper);
    vt_add(suite, the_meter_alone_stops_what_the_gate_would_have_stopped);
    vt_add(suite, a_small_file_that_unpacks_to_a_large_cloud_meets_its_budget);
    vt_add(suite, any_cap_on_memory_ends_cleanly);
    vt_add(suite, any_cap_on_the_writer_ends_cleanly);
    vt_add(suite, any_allocation_may_fail);
    return vt_run(suite);
}
