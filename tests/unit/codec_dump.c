/* The dump of a decoded cloud: exact, and refused where a byte of its tables is wrong. */
#include "proto/codec.h"
#include "proto/dump.h"
#include "tests/support/vt.h"

#include <stdlib.h>
#include <string.h>

enum { HEAD = 56, ROW = 80 };

static void random_cloud(struct vor_cloud *cloud, uint64_t seed)
{
    vt_cloud_cube(cloud, seed, 1 + seed * seed * 3);
    for (int c = 0; c < 3; c++)
        cloud->origin[c] = seed % 2 == 0 ? 0 : 1e7 * vt_unit(seed, (uint64_t)c);
    cloud->position_type = seed % 2 == 0 ? VOR_FLOAT32 : VOR_FLOAT64;
    for (uint64_t i = 0; i < seed; i++) {
        struct vor_attribute *attribute;
        enum vor_type type = (enum vor_type)((seed + i) % VOR_TYPE_COUNT);
        unsigned components = 1 + (unsigned)((seed * i) % 16);
        uint8_t *bytes;

        /* The name is longer than what a new attribute may have, as a suffix makes it. */
        vt_assert_ok(vor_cloud_add_attribute(
            cloud, "a_name_of_more_than_forty_eight_characters_that_is_cut",
            (enum vor_semantic)(i % 3), type, components, &attribute, &vt_err));
        bytes = attribute->data;
        for (size_t k = 0; k < cloud->n * components * vor_type_size(type); k++)
            bytes[k] = (uint8_t)vor_rng_bits(seed, i, k);
    }
}

static struct vt_bytes dumped(const struct vor_cloud *cloud)
{
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};

    vt_assert_ok(vor_dump_write(&sink, cloud, &vt_err));
    return bytes;
}

/* Property. */
VT_TEST_LOOP(a_dump_comes_back_exactly, 40)
{
    struct vor_cloud cloud, back;
    struct vt_bytes bytes;
    size_t points;

    random_cloud(&cloud, (uint64_t)_i);
    bytes = dumped(&cloud);
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_dump_check(&points, bytes.data, bytes.size, &vt_err));
    ck_assert_uint_eq(points, cloud.n);
    vt_assert_ok(vor_dump_read(&back, bytes.data, bytes.size, &vt_err));
    vt_assert_same(&cloud, &back);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(bytes.data);
}

static void assert_refused(const uint8_t *bytes, size_t size, vor_status want, const char *what)
{
    uint8_t *copy = malloc(size > 0 ? size : 1);
    struct vor_cloud cloud;
    vor_status status;
    size_t points;

    ck_assert_ptr_nonnull(copy);
    memcpy(copy, bytes, size);
    vor_cloud_init(&cloud, &vt_memory);
    status = vor_dump_read(&cloud, copy, size, &vt_err);
    ck_assert_msg(status == want, "%s: %s (%s)", what, vor_status_slug(status), vt_err.message);
    ck_assert_ptr_null(cloud.xyz);
    ck_assert_uint_eq(cloud.attribute_count, 0);
    status = vor_dump_check(&points, copy, size, &vt_err);
    ck_assert_msg(status == want, "%s checked: %s (%s)", what, vor_status_slug(status),
                  vt_err.message);
    free(copy);
}

VT_TEST(a_dump_of_another_length_is_refused)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;
    size_t used;

    random_cloud(&cloud, 3);
    bytes = dumped(&cloud);
    used = atomic_load(&vt_memory.used);
    for (size_t size = 0; size < bytes.size; size++)
        assert_refused(bytes.data, size, VOR_E_FORMAT, "cut");
    ck_assert_int_eq(vt_bytes_write(&bytes, "", 1), 0);
    assert_refused(bytes.data, bytes.size, VOR_E_FORMAT, "one byte more");
    ck_assert_uint_eq(atomic_load(&vt_memory.used), used);
    vor_cloud_free(&cloud);
    free(bytes.data);
}

static const struct damage {
    const char *what;
    size_t at, size;
    uint64_t value;
    vor_status status;
} damages[] = {
    {"magic", 0, 1, 'V', VOR_E_FORMAT},
    {"version", 8, 4, 2, VOR_E_FORMAT},
    {"byte order", 12, 4, 0x04030201, VOR_E_FORMAT},
    {"no points", 16, 8, 0, VOR_E_FORMAT},
    {"one point more", 16, 8, 29, VOR_E_FORMAT},
    {"2^31 points", 16, 8, UINT64_C(1) << 31, VOR_E_FORMAT},
    {"2^64 - 1 points", 16, 8, UINT64_MAX, VOR_E_FORMAT},
    {"positions of integers", 24, 4, VOR_INT32, VOR_E_FORMAT},
    {"positions of no type", 24, 4, UINT32_MAX, VOR_E_FORMAT},
    {"one attribute more", 28, 4, 4, VOR_E_FORMAT},
    {"65 attributes", 28, 4, 65, VOR_E_FORMAT},
    {"2^32 - 1 attributes", 28, 4, UINT32_MAX, VOR_E_FORMAT},
    {"an origin that is infinite", 32, 8, UINT64_C(0x7ff0000000000000), VOR_E_NONFINITE},
    {"an origin that is nan", 48, 8, UINT64_C(0x7ff8000000000000), VOR_E_NONFINITE},
    {"a semantic that is none", HEAD + 64, 4, VOR_TEX_COORD + 1, VOR_E_FORMAT},
    {"a type that is none", HEAD + 68, 4, VOR_TYPE_COUNT, VOR_E_FORMAT},
    {"another type", HEAD + 68, 4, VOR_FLOAT64, VOR_E_FORMAT},
    {"no components", HEAD + ROW + 72, 4, 0, VOR_E_FORMAT},
    {"17 components", HEAD + ROW + 72, 4, 17, VOR_E_FORMAT},
    {"2^32 - 1 components", HEAD + ROW + 72, 4, UINT32_MAX, VOR_E_FORMAT},
    {"a coordinate that is nan", HEAD + 3 * ROW, 4, 0x7fc00000, VOR_E_NONFINITE},
};

enum { DAMAGES = sizeof damages / sizeof damages[0] };

VT_TEST_LOOP(a_damaged_table_is_refused, DAMAGES)
{
    const struct damage *damage = &damages[_i];
    struct vor_cloud cloud;
    struct vt_bytes bytes;

    random_cloud(&cloud, 3); /* 28 points, three attributes */
    bytes = dumped(&cloud);
    vor_cloud_free(&cloud);
    memcpy(bytes.data + damage->at, &damage->value, damage->size);
    assert_refused(bytes.data, bytes.size, damage->status, damage->what);
    free(bytes.data);
}

VT_TEST(a_name_without_an_end_is_refused)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;

    random_cloud(&cloud, 1);
    bytes = dumped(&cloud);
    vor_cloud_free(&cloud);
    memset(bytes.data + HEAD, 'a', 64);
    assert_refused(bytes.data, bytes.size, VOR_E_FORMAT, "name");
    free(bytes.data);
}

VT_TEST(reading_a_dump_survives_the_failure_of_any_allocation)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;
    vor_status status = VOR_E_NOMEM;

    random_cloud(&cloud, 5);
    bytes = dumped(&cloud);
    vor_cloud_free(&cloud);
    for (size_t k = 1; status == VOR_E_NOMEM; k++) {
        struct vor_memory memory;

        vor_memory_init(&memory, SIZE_MAX);
        memory.fail_at = k;
        vor_cloud_init(&cloud, &memory);
        status = vor_dump_read(&cloud, bytes.data, bytes.size, &vt_err);
        ck_assert(status == VOR_OK ? k == 7 : k < 7); /* positions and five attributes */
        vor_cloud_free(&cloud);
        ck_assert_uint_eq(atomic_load(&memory.used), 0);
    }
    vt_assert_ok(status);
    free(bytes.data);
}

static int refuse(void *ctx, const void *data, size_t size)
{
    size_t *left = ctx;

    (void)data;
    if (size > *left)
        return -1;
    *left -= size;
    return 0;
}

VT_TEST(a_sink_that_refuses_ends_the_dump)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;

    random_cloud(&cloud, 3);
    bytes = dumped(&cloud);
    for (size_t left = 0; left < bytes.size; left += 17) {
        size_t room = left;
        struct vor_sink sink = {&room, refuse};

        vt_assert_fails(VOR_E_IO, vor_dump_write(&sink, &cloud, &vt_err));
    }
    vor_cloud_free(&cloud);
    free(bytes.data);
}
