/** Helpers of the Draco tests: clouds to bytes and back. */
#ifndef DRACO_FILES_H
#define DRACO_FILES_H

#include "proto/draco/draco.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/** Asserts that `got` is `want` within a tolerance, which may be met exactly. */
#define must_be_near(got, want, tolerance)                                                         \
    ck_assert_msg(fabs((double)(got) - (double)(want)) <= (tolerance),                             \
                  "%s is %.9g, want %.9g within %g", #got, (double)(got), (double)(want),          \
                  (double)(tolerance))

static const struct vor_limits draco_limits = VOR_LIMITS_DEFAULT;

static inline vor_status draco_encode(struct vt_bytes *out, const struct vor_cloud *cloud, int bits,
                                      int keep_order)
{
    struct vor_write_options options = {
        .quantization_bits = bits, .compression = 7, .keep_order = keep_order};
    struct vor_sink sink = {.ctx = out, .write = vt_bytes_write};

    memset(out, 0, sizeof *out);
    return vor_draco_write(&sink, cloud, &options, &vt_err);
}

static inline vor_status draco_decode(struct vor_cloud *out, const struct vt_bytes *bytes)
{
    vor_cloud_init(out, &vt_memory);
    return vor_draco_read(out, bytes->data, bytes->size, &draco_limits, &vt_err);
}

/** Writes a cloud and reads it back. */
static inline void draco_trip(struct vor_cloud *out, const struct vor_cloud *cloud, int bits,
                              int keep_order)
{
    struct vt_bytes bytes;

    vt_assert_ok(draco_encode(&bytes, cloud, bits, keep_order));
    vt_assert_ok(draco_decode(out, &bytes));
    ck_assert_uint_eq(out->n, cloud->n);
    free(bytes.data);
}

/** Adds an attribute and returns its values, to be filled in. */
static inline void *draco_add(struct vor_cloud *cloud, const char *name, enum vor_semantic semantic,
                              enum vor_type type, unsigned components)
{
    struct vor_attribute *attribute;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, name, semantic, type, components, &attribute, &vt_err));
    memset(attribute->data, 0, cloud->n * components * vor_type_size(type));
    return attribute->data;
}

/** Numbers the points, so that they can be told apart after the kd-tree has shuffled them. */
static inline void draco_number(struct vor_cloud *cloud)
{
    uint32_t *id = draco_add(cloud, "id", VOR_GENERIC, VOR_UINT32, 1);

    for (size_t i = 0; i < cloud->n; i++)
        id[i] = (uint32_t)i;
}

/** Which point of the source each point of the result was: a permutation, or the test fails. The
 *  caller frees it. */
static inline uint32_t *draco_numbers(const struct vor_cloud *cloud)
{
    const struct vor_attribute *id = vor_cloud_find_name(cloud, "id");
    unsigned char *seen = calloc(cloud->n, 1);
    uint32_t *out = malloc(cloud->n * sizeof *out);

    ck_assert_ptr_nonnull(id);
    ck_assert_ptr_nonnull(seen);
    ck_assert_ptr_nonnull(out);
    ck_assert_int_eq(id->type, VOR_UINT32);
    memcpy(out, id->data, cloud->n * sizeof *out);
    for (size_t i = 0; i < cloud->n; i++) {
        ck_assert_msg(out[i] < cloud->n, "point %u of %zu", out[i], cloud->n);
        ck_assert_msg(!seen[out[i]], "point %u comes twice", out[i]);
        seen[out[i]] = 1;
    }
    free(seen);
    return out;
}

/** What a component of a normal that was quantised may be off by: nothing, but where Debian's
 *  libdraco multiplies and adds in one step, as on arm64. */
#ifdef __FP_FAST_FMAF
#define DRACO_NORMAL_OFF 0x1p-22
#else
#define DRACO_NORMAL_OFF 0.0
#endif

/** Whether values of an attribute are the same bytes, or of a normal as good as the same. */
static inline int draco_is_same(const struct vor_attribute *a, const struct vor_attribute *b,
                                size_t i, size_t j)
{
    size_t width = a->components * vor_type_size(a->type);
    const float *x = a->data, *y = b->data;
    int same = 1;

    if (a->semantic != VOR_NORMAL || a->type != VOR_FLOAT32)
        return memcmp((const char *)a->data + i * width, (const char *)b->data + j * width,
                      width) == 0;
    for (unsigned c = 0; c < a->components; c++)
        same = same && fabs((double)x[a->components * i + c] - (double)y[a->components * j + c]) <=
                           DRACO_NORMAL_OFF;
    return same;
}

/** The values of attribute `name` are the same in both clouds, point by point of `numbers` (NULL:
 *  in order), and so are type, components and meaning. */
static inline void draco_assert_same(const struct vor_cloud *got, const struct vor_cloud *want,
                                     const char *name, const uint32_t *numbers)
{
    const struct vor_attribute *a = vor_cloud_find_name(got, name);
    const struct vor_attribute *b = vor_cloud_find_name(want, name);

    ck_assert_msg(a != NULL && b != NULL, "attribute %s is missing", name);
    ck_assert_int_eq(a->type, b->type);
    ck_assert_int_eq(a->semantic, b->semantic);
    ck_assert_uint_eq(a->components, b->components);
    for (size_t i = 0; i < got->n; i++) {
        size_t j = numbers != NULL ? numbers[i] : i;

        ck_assert_msg(draco_is_same(a, b, i, j), "attribute %s of point %zu differs", name, j);
    }
}

/** Largest extent of the positions along an axis. */
static inline double draco_extent(const struct vor_cloud *cloud)
{
    double extent = 0;

    for (size_t c = 0; c < 3; c++) {
        double low = INFINITY, high = -INFINITY;

        for (size_t i = 0; i < cloud->n; i++) { /* fmax in this loop crashes gcc 12 for arm64 */
            double x = (double)cloud->xyz[3 * i + c];

            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        extent = fmax(extent, high - low);
    }
    return extent;
}

#endif
