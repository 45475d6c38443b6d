/* Properties: a cloud survives being written by us, and by others in every encoding. */
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SEEDS = 72, FACES = 20 };

static const struct vor_limits limits = {
    .points = 50000000, .header_bytes = 65536, .keep_faces = 1};

static uint64_t below(uint64_t seed, uint64_t stream, uint64_t index, uint64_t bound)
{
    return vor_rng_below(seed, stream, index, bound);
}

/* Random bits, but no nan: its bits do not survive ascii. */
static void fill(struct vor_attribute *attribute, size_t n, uint64_t seed, uint64_t stream)
{
    size_t size = vor_type_size(attribute->type);
    uint8_t *at = attribute->data;

    for (size_t i = 0; i < n * attribute->components; i++) {
        uint64_t bits = vor_rng_bits(seed, stream, i);
        float single;
        double wide;

        if (attribute->type == VOR_FLOAT32) {
            single = (float)ldexp(vt_unit(seed, bits) - 0.5, (int)(bits % 200) - 100);
            memcpy(at + i * size, &single, size);
        } else if (attribute->type == VOR_FLOAT64) {
            wide = ldexp(vt_unit(seed, bits) - 0.5, (int)(bits % 1200) - 600);
            memcpy(at + i * size, &wide, size);
        } else {
            memcpy(at + i * size, &bits, size);
        }
    }
}

static void add(struct vor_cloud *cloud, uint64_t seed, const char *name,
                enum vor_semantic semantic, enum vor_type type, unsigned components)
{
    struct vor_attribute *attribute;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, name, semantic, type, components, &attribute, &vt_err));
    fill(attribute, cloud->n, seed, 100 + cloud->attribute_count);
}

static enum vor_type random_type(uint64_t seed, uint64_t index)
{
    return (enum vor_type)below(seed, 1, index, VOR_FLOAT64 + 1);
}

static void add_attributes(struct vor_cloud *cloud, uint64_t seed)
{
    uint64_t generics = below(seed, 2, 0, 6);
    char name[32];

    if (below(seed, 2, 1, 2) == 0)
        add(cloud, seed, "normal", VOR_NORMAL, random_type(seed, 1), 3);
    for (uint64_t i = 0; i < generics; i++) {
        (void)snprintf(name, sizeof name, "scalar_%c%u", (char)('a' + i), (unsigned)seed);
        add(cloud, seed, name, VOR_GENERIC, random_type(seed, 10 + i), 1);
    }
    if (below(seed, 2, 2, 2) == 0)
        add(cloud, seed, "color", VOR_COLOR, random_type(seed, 2), 3 + (unsigned)(seed % 2));
}

/* Positions of any magnitude, either bit for bit or from doubles far from the origin. */
static void random_cloud(struct vor_cloud *cloud, uint64_t seed, double **wide)
{
    size_t n = seed % 10 == 9 ? 5000 : 1 + (size_t)below(seed, 3, 0, 200);

    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_cloud_resize(cloud, n, &vt_err));
    *wide = malloc(3 * n * sizeof **wide);
    ck_assert_ptr_nonnull(*wide);
    for (size_t i = 0; i < 3 * n; i++) {
        (*wide)[i] = 1e6 * (vt_unit(seed, i) - 0.2) + (seed % 3 == 0 ? 6.1e6 : 0);
        cloud->xyz[i] = (float)ldexp(vt_unit(seed, i) - 0.5, (int)(i % 100) - 50);
    }
    if (seed % 2 == 0)
        vt_assert_ok(vor_cloud_set_double(cloud, *wide, &vt_err));
    add_attributes(cloud, seed);
}

VT_TEST_LOOP(what_we_write_comes_back_bit_for_bit, SEEDS)
{
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};
    struct vor_cloud cloud, back;
    double *wide;

    random_cloud(&cloud, (uint64_t)_i, &wide);
    vt_assert_ok(vor_ply_write(&sink, &cloud, NULL, &vt_err));
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_ply_read(&back, bytes.data, bytes.size, &limits, &vt_err));
    vt_assert_same(&cloud, &back);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(wide);
    free(bytes.data);
}

/* Another program's way to write a cloud: the columns in another order, elements and lists in
 * between. */
struct column {
    char name[80];
    enum vor_type type;
    const uint8_t *from; /* NULL: a list */
    size_t stride;
};

struct foreign {
    struct vt_bytes bytes;
    int ascii, big, sized;
    uint64_t seed;
    unsigned count;
    struct column columns[32];
    size_t triangle_count;
    uint32_t triangles[4 * FACES][3];
};

static void text(struct foreign *file, const char *words)
{
    ck_assert_int_eq(vt_bytes_write(&file->bytes, words, strlen(words)), 0);
}

static void column(struct foreign *file, const char *name, enum vor_type type, const void *from,
                   size_t stride)
{
    struct column *to = &file->columns[file->count++];

    ck_assert_uint_le(file->count, 32);
    (void)snprintf(to->name, sizeof to->name, "%s", name);
    to->type = type;
    to->from = from;
    to->stride = stride;
}

static void attribute_columns(struct foreign *file, const struct vor_attribute *attribute)
{
    static const char *const parts[3][4] = {
        {""}, {"nx", "ny", "nz", ""}, {"red", "green", "blue", "alpha"}};
    size_t size = vor_type_size(attribute->type);

    for (unsigned k = 0; k < attribute->components; k++)
        column(file,
               attribute->semantic == VOR_GENERIC ? attribute->name : parts[attribute->semantic][k],
               attribute->type, (const uint8_t *)attribute->data + k * size,
               size * attribute->components);
}

/* Coordinates in between the attributes, so that no column has its usual place. */
static void all_columns(struct foreign *file, const struct vor_cloud *cloud, const double *wide)
{
    size_t next = 0;

    for (unsigned c = 0; c < 3; c++) {
        const char name[2] = {"zxy"[c], 0};
        unsigned k = (c + 2) % 3;

        if (next < cloud->attribute_count && (file->seed + c) % 2 == 0)
            attribute_columns(file, &cloud->attributes[next++]);
        if (cloud->position_type == VOR_FLOAT64)
            column(file, name, VOR_FLOAT64, wide + k, 24);
        else
            column(file, name, VOR_FLOAT32, cloud->xyz + k, 12);
    }
    if (file->seed % 5 == 1)
        column(file, "a_list", VOR_INT16, NULL, 0);
    while (next < cloud->attribute_count)
        attribute_columns(file, &cloud->attributes[next++]);
}

static void binary_scalar(struct foreign *file, const void *from, size_t size)
{
    uint8_t turned[8];

    for (size_t i = 0; i < size; i++)
        turned[i] = ((const uint8_t *)from)[file->big ? size - 1 - i : i];
    ck_assert_int_eq(vt_bytes_write(&file->bytes, turned, size), 0);
}

static void ascii_scalar(struct foreign *file, const void *from, enum vor_type type)
{
    const struct vor_attribute one = {.type = type, .data = (void *)(uintptr_t)from};
    char word[64];

    (void)snprintf(word, sizeof word, "%.*g ", type == VOR_FLOAT32 ? 9 : 17,
                   vor_attribute_scalar(&one, 0));
    text(file, word);
}

static void scalar(struct foreign *file, const void *from, enum vor_type type)
{
    uint8_t copy[8] = {0};

    memcpy(copy, from, vor_type_size(type));
    if (file->ascii)
        ascii_scalar(file, copy, type);
    else
        binary_scalar(file, copy, vor_type_size(type));
}

static void list(struct foreign *file, size_t row)
{
    uint8_t count = (uint8_t)below(file->seed, 7, row, 4);

    scalar(file, &count, VOR_UINT8);
    for (int16_t i = 0; i < count; i++)
        scalar(file, &i, VOR_INT16);
}

/* Every pair of a type of count and a type of corner, before the vertices or behind. */
static enum vor_type count_type(const struct foreign *file)
{
    return (enum vor_type)(VOR_INT8 + file->seed % 6);
}

static enum vor_type corner_type(const struct foreign *file)
{
    return (enum vor_type)(VOR_INT8 + file->seed / 6 % 6);
}

/* Polygons of three to six corners; a row that is none has fewer. What they are in triangles goes
 * into file->triangles. */
static void face_rows(struct foreign *file, size_t n)
{
    for (size_t i = 0; i < FACES; i++) {
        int32_t count = (int32_t)below(file->seed, 8, i, 7), corner[6];

        scalar(file, &count, count_type(file)); /* little-endian: the low bytes are the number */
        for (int32_t k = 0; k < count; k++) {
            corner[k] = (int32_t)below(file->seed, 9, 6 * i + (size_t)k, n < 128 ? n : 128);
            scalar(file, &corner[k], corner_type(file));
            if (k >= 2)
                memcpy(file->triangles[file->triangle_count++],
                       (int32_t[]){corner[0], corner[k - 1], corner[k]}, 3 * sizeof *corner);
        }
        if (file->ascii)
            text(file, "\n");
    }
}

static void header_of_faces(struct foreign *file)
{
    char line[160];

    (void)snprintf(line, sizeof line, "element face %d\nproperty list %s %s %s\n", FACES,
                   vor_type_name(count_type(file)), vor_type_name(corner_type(file)),
                   file->seed % 3 == 0 ? "vertex_index" : "vertex_indices");
    text(file, line);
}

static void header(struct foreign *file, size_t n)
{
    char line[160];

    text(file, "ply\ncomment by another program\n");
    text(file, file->ascii ? "format ascii 1.0\n"
               : file->big ? "format binary_big_endian 1.0\n"
                           : "format binary_little_endian 1.0\n");
    text(file, "element before 7\nproperty list uchar short values\nproperty double w\n");
    if (file->seed / 2 % 2 == 0)
        header_of_faces(file);
    (void)snprintf(line, sizeof line, "element vertex %zu\n", n);
    text(file, line);
    for (unsigned k = 0; k < file->count; k++) {
        const struct column *c = &file->columns[k];
        const char *type = file->sized ? vor_type_name_sized(c->type) : vor_type_name(c->type);

        (void)snprintf(line, sizeof line, "property %s%s %s\n",
                       c->from == NULL ? "list uchar " : "", type, c->name);
        text(file, line);
    }
    if (file->seed / 2 % 2 == 1)
        header_of_faces(file);
    text(file, "end_header\n");
}

static void foreign_file(struct foreign *file, const struct vor_cloud *cloud, const double *wide)
{
    double w = 0.5;

    all_columns(file, cloud, wide);
    header(file, cloud->n);
    for (size_t i = 0; i < 7; i++) {
        list(file, 1000000 + i);
        scalar(file, &w, VOR_FLOAT64);
        if (file->ascii)
            text(file, "\n");
    }
    if (file->seed / 2 % 2 == 0)
        face_rows(file, cloud->n);
    for (size_t i = 0; i < cloud->n; i++) {
        for (unsigned k = 0; k < file->count; k++) {
            const struct column *c = &file->columns[k];

            if (c->from == NULL)
                list(file, i);
            else
                scalar(file, c->from + i * c->stride, c->type);
        }
        if (file->ascii)
            text(file, i % 2 == 0 ? "\r\n" : "\n");
    }
    if (file->seed / 2 % 2 == 1)
        face_rows(file, cloud->n);
}

/* _i is seed * 3 + encoding. */
VT_TEST_LOOP(what_others_write_is_read_in_every_encoding, 3 * SEEDS)
{
    struct foreign file = {.seed = (uint64_t)_i / 3, .ascii = _i % 3 == 0, .big = _i % 3 == 1};
    struct vor_cloud cloud, back;
    double *wide;

    file.sized = (int)(file.seed / 2 % 2);
    random_cloud(&cloud, file.seed, &wide);
    foreign_file(&file, &cloud, wide);
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_ply_read(&back, file.bytes.data, file.bytes.size, &limits, &vt_err));
    vt_assert_same(&cloud, &back);
    ck_assert_uint_eq(back.triangle_count, file.triangle_count);
    ck_assert_mem_eq(back.triangles, file.triangles, 12 * file.triangle_count);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(wide);
    free(file.bytes.data);
}

VT_TEST_LOOP(writing_survives_the_failure_of_any_allocation, 8)
{
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};
    struct vor_cloud cloud;
    double *wide;
    size_t used, before;

    random_cloud(&cloud, (uint64_t)_i, &wide);
    used = atomic_load(&vt_memory.used);
    before = atomic_load(&vt_memory.calls);
    for (size_t k = 1;; k++) {
        vt_memory.fail_at = before + k;
        if (vor_ply_write(&sink, &cloud, NULL, &vt_err) == VOR_OK)
            break;
        ck_assert_int_eq(vt_err.status, VOR_E_NOMEM);
        ck_assert_uint_eq(bytes.size, 0);
        ck_assert_uint_eq(atomic_load(&vt_memory.used), used);
        before = atomic_load(&vt_memory.calls);
    }
    vt_memory.fail_at = 0;
    ck_assert_uint_eq(atomic_load(&vt_memory.used), used);
    vor_cloud_free(&cloud);
    free(wide);
    free(bytes.data);
}
