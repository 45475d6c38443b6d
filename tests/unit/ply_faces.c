/* Faces of PLY files: the same triangles in every encoding and type, and what is refused. */
#include "proto/codec.h"
#include "proto/dump.h"
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum encoding { ASCII, LITTLE, BIG, ENCODINGS };

static const struct vor_limits keep = {.points = 1000, .header_bytes = 65536, .keep_faces = 1};

/* How a file is written. */
struct how {
    enum encoding encoding;
    enum vor_type count, index; /* of the lists */
    int faces_first;            /* before the vertices */
    int besides;                /* with properties that are no corners before and behind */
    const char *list;           /* name */
};

static void put_text(struct vt_bytes *to, const char *text)
{
    ck_assert_int_eq(vt_bytes_write(to, text, strlen(text)), 0);
}

static void put_value(struct vt_bytes *to, enum encoding encoding, enum vor_type type, double value)
{
    uint8_t bytes[8], turned[8];
    size_t size = vor_type_size(type);
    char text[32];

    switch (type) {
#define PUT_CASE(name, ctype, ply, sized)                                                          \
    case VOR_##name: {                                                                             \
        ctype as = (ctype)value;                                                                   \
        memcpy(bytes, &as, sizeof as);                                                             \
        break;                                                                                     \
    }
        VOR_TYPE_TABLE(PUT_CASE)
#undef PUT_CASE
    default:
        ck_abort();
    }
    for (size_t i = 0; i < size; i++)
        turned[i] = bytes[size - 1 - i];
    (void)snprintf(text, sizeof text, "%.9g ", value);
    if (encoding == ASCII)
        put_text(to, text);
    else
        ck_assert_int_eq(vt_bytes_write(to, encoding == BIG ? turned : bytes, size), 0);
}

static void end_row(struct vt_bytes *to, enum encoding encoding)
{
    if (encoding == ASCII)
        put_text(to, "\n");
}

/* Five vertices, a pyramid over the unit square. */
static const float corners[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};

static void put_vertices(struct vt_bytes *to, enum encoding encoding)
{
    for (int i = 0; i < 5; i++) {
        for (int c = 0; c < 3; c++)
            put_value(to, encoding, VOR_FLOAT32, (double)corners[i][c]);
        end_row(to, encoding);
    }
}

/* Lists of indices, each a count and so many: they end with a count of -1. */
static size_t put_lists(struct vt_bytes *to, const struct how *how, const int *lists)
{
    size_t rows = 0;

    for (; *lists >= 0; rows++) {
        int count = *lists++;

        if (how->besides)
            put_value(to, how->encoding, VOR_FLOAT32, 7.5);
        put_value(to, how->encoding, how->count, count);
        for (int i = 0; i < count; i++)
            put_value(to, how->encoding, how->index, *lists++);
        if (how->besides) {
            put_value(to, how->encoding, VOR_UINT8, 2);
            put_value(to, how->encoding, VOR_FLOAT64, 0.25);
            put_value(to, how->encoding, VOR_FLOAT64, 0.5);
        }
        end_row(to, how->encoding);
    }
    return rows;
}

/* A file of the five vertices and the lists as rows of `element`. */
static struct vt_bytes make(const struct how *how, const char *element, const int *lists)
{
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    static const char vertices[] =
        "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n";
    struct vt_bytes file = {0}, rows = {0};
    size_t count = put_lists(&rows, how, lists);
    char of_faces[300];

    (void)snprintf(of_faces, sizeof of_faces, "element %s %zu\n%sproperty list %s %s %s\n%s",
                   element, count, how->besides ? "property float quality\n" : "",
                   vor_type_name(how->count), vor_type_name(how->index), how->list,
                   how->besides ? "property list uchar double texcoord\n" : "");
    put_text(&file, "ply\nformat ");
    put_text(&file, formats[how->encoding]);
    put_text(&file, " 1.0\n");
    put_text(&file, how->faces_first ? of_faces : vertices);
    put_text(&file, how->faces_first ? vertices : of_faces);
    put_text(&file, "end_header\n");
    if (!how->faces_first)
        put_vertices(&file, how->encoding);
    ck_assert_int_eq(vt_bytes_write(&file, rows.data, rows.size), 0);
    if (how->faces_first)
        put_vertices(&file, how->encoding);
    free(rows.data);
    return file;
}

static const struct how plain = {ASCII, VOR_UINT8, VOR_INT32, 0, 0, "vertex_indices"};

/* A triangle, a square, a polygon of five, and lists that are no faces. */
static const int lists[] = {3, 0, 1, 4, 4, 0, 1, 2, 3, 0, 2, 1, 2, 5, 4, 3, 2, 1, 0, -1};
static const uint32_t triangles[] = {0, 1, 4, 0, 1, 2, 0, 2, 3, 4, 3, 2, 4, 2, 1, 4, 1, 0};

static void assert_triangles(const struct vor_cloud *cloud, const uint32_t *want, size_t count)
{
    ck_assert_uint_eq(cloud->n, 5);
    ck_assert_mem_eq(cloud->xyz, corners, sizeof corners);
    ck_assert_uint_eq(cloud->triangle_count, count);
    if (count > 0)
        ck_assert_mem_eq(cloud->triangles, want, count * 3 * sizeof *want);
}

static vor_status read_file(struct vor_cloud *cloud, const struct vt_bytes *file, size_t size,
                            const struct vor_limits *limits)
{
    uint8_t *copy = malloc(size + 1); /* so that a byte too many is seen */
    vor_status status;

    ck_assert_ptr_nonnull(copy);
    memcpy(copy, file->data, size);
    vor_cloud_init(cloud, &vt_memory);
    status = vor_codec_read(cloud, NULL, copy, size, limits, &vt_err);
    free(copy);
    return status;
}

/* Vector. */
static void check(const struct how *how)
{
    struct vt_bytes file = make(how, "face", lists);
    struct vor_cloud cloud;

    vt_assert_ok(read_file(&cloud, &file, file.size, &keep));
    assert_triangles(&cloud, triangles, 6);
    ck_assert_uint_eq(cloud.notes.faces, 5);
    ck_assert_uint_eq(cloud.notes.dropped_count, how->besides ? 2 : 0);
    ck_assert(!how->besides || (strcmp(cloud.notes.dropped[0].what, "face.quality") == 0 &&
                                strcmp(cloud.notes.dropped[1].what, "face.texcoord") == 0));
    vor_cloud_free(&cloud);
    free(file.data);
}

START_TEST(faces_are_the_same_triangles_in_every_encoding)
{
    static const enum vor_type types[] = {VOR_INT8,   VOR_UINT8, VOR_INT16,
                                          VOR_UINT16, VOR_INT32, VOR_UINT32};
    static const char *const names[] = {"vertex_indices", "vertex_index"};

    for (int count = 0; count < 6; count++)
        for (int index = 0; index < 6; index++)
            for (int k = 0; k < 4; k++) {
                const struct how how = {
                    (enum encoding)_i,     types[count], types[index], k % 2, k / 2,
                    names[(count + k) % 2]};

                check(&how);
            }
    vt_assert_no_leak();
}
END_TEST

/* Vector: every other triangle of a strip is turned, -1 begins anew, and so does a list. */
START_TEST(strips_are_triangles_that_face_one_way)
{
    static const int strips[] = {11, 0, 1, 2, 3, 4, -1, 4, 3, -1, 1, 2, 4, 4, 1, 0, 2, -1};
    static const uint32_t want[] = {0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 1, 0, 0, 1, 2};
    struct how how = plain;
    struct vt_bytes file;
    struct vor_cloud cloud;

    how.encoding = (enum encoding)_i;
    file = make(&how, "tristrips", strips);
    vt_assert_ok(read_file(&cloud, &file, file.size, &keep));
    assert_triangles(&cloud, want, 5);
    ck_assert_uint_eq(cloud.notes.faces, 2);
    vor_cloud_free(&cloud);
    free(file.data);
    vt_assert_no_leak();
}
END_TEST

START_TEST(faces_that_are_not_wanted_are_only_counted)
{
    struct vor_limits limits = keep;
    struct vt_bytes file = make(&plain, "face", lists);
    struct vor_cloud cloud;

    limits.keep_faces = 0;
    vt_assert_ok(read_file(&cloud, &file, file.size - 20, &limits)); /* and not looked at */
    assert_triangles(&cloud, triangles, 0);
    ck_assert_ptr_null(cloud.triangles);
    ck_assert_uint_eq(cloud.notes.faces, 5);
    ck_assert_uint_eq(cloud.notes.dropped_count, 1);
    ck_assert_str_eq(cloud.notes.dropped[0].what, "face");
    vor_cloud_free(&cloud);
    free(file.data);
}
END_TEST

/* A list as the file has it, and what is said of it. */
static const struct refusal {
    const char *element, *list;
    enum vor_type type;
    int lists[12];
    vor_status status;
    const char *said;
} refusals[] = {
    {"face",
     "vertex_indices",
     VOR_INT32,
     {3, 0, 1, 2, 3, 0, 5, 1, -1},
     VOR_E_FORMAT,
     "corner 1 of face 1 is vertex 5, want 0 to 4"},
    {"face",
     "vertex_indices",
     VOR_INT32,
     {4, 0, 1, 2, -1, -1},
     VOR_E_FORMAT,
     "corner 3 of face 0 is vertex -1, want 0 to 4"},
    {"face", "vertex_indices", VOR_UINT32, {3, 0, 1, -1, -1}, VOR_E_FORMAT, NULL},
    {"tristrips",
     "vertex_indices",
     VOR_INT16,
     {3, 0, 1, -2, -1},
     VOR_E_FORMAT,
     "corner 2 of strip 0 is vertex -2, want -1, or 0 to 4"},
    {"face",
     "vertex_indices",
     VOR_FLOAT32,
     {3, 0, 1, 2, -1},
     VOR_E_FORMAT,
     "property vertex_indices of face is a list of float, want a type of integers"},
    {"face",
     "vertex_indices",
     VOR_INT32,
     {2, 0, 1, -1},
     VOR_E_FACES,
     "sample is faces, but the input has 5 points and no faces, want faces with three corners, or "
     "sample=vertices"},
    {"edges", "vertex_indices", VOR_INT32, {3, 0, 1, 2, -1}, VOR_E_FACES, NULL},
    {"face", "corners", VOR_INT32, {3, 0, 1, 2, -1}, VOR_E_FACES, NULL},
    {"face",
     "vertex_indices",
     VOR_INT32,
     {3, 0, 1, 1, 3, 4, 4, 4, -1},
     VOR_E_FACES,
     "sample is faces, but the area of each of the input's 2 triangles is 0, want one above 0, or "
     "sample=vertices"},
};

enum { REFUSALS = sizeof refusals / sizeof refusals[0] };

START_TEST(what_is_wrong_with_faces_is_said)
{
    const struct refusal *row = &refusals[_i];

    for (int encoding = ASCII; encoding < ENCODINGS; encoding++) {
        const struct how how = {(enum encoding)encoding, VOR_UINT8, row->type, 0, 0, row->list};
        struct vt_bytes file;
        struct vor_cloud cloud;

        if (encoding != ASCII && row->type == VOR_UINT32)
            continue; /* it has no -1 */
        file = make(&how, row->element, row->lists);
        vt_assert_fails(row->status, read_file(&cloud, &file, file.size, &keep));
        ck_assert(row->said == NULL || strcmp(vt_err.message, row->said) == 0);
        if (row->status == VOR_E_FACES)
            ck_assert_str_eq(vt_err.parameter, "sample");
        else
            ck_assert(vt_err.byte_offset > 0 && vt_err.byte_offset < (int64_t)file.size);
        ck_assert(cloud.n == 0 && cloud.triangles == NULL);
        free(file.data);
    }
    vt_assert_no_leak();
}
END_TEST

/* Refusal: a file that ends anywhere inside its faces; memory that runs out at any point. */
START_TEST(faces_that_are_cut_or_do_not_fit_leave_nothing)
{
    struct how how = plain;
    struct vt_bytes file;
    struct vor_cloud cloud;
    size_t size = 0;
    vor_status status = VOR_E_NOMEM;

    how.encoding = (enum encoding)_i;
    file = make(&how, "face", lists);
    /* Without the last number a file in ascii is cut, too: its row ends early. */
    for (size_t less = _i == ASCII ? 3 : 1; less < 60; less++) {
        vt_assert_fails(VOR_E_FORMAT, read_file(&cloud, &file, file.size - less, &keep));
        ck_assert_ptr_null(cloud.triangles);
    }
    for (vt_memory.fail_at = 0; status == VOR_E_NOMEM; size++) {
        vt_memory.fail_at = atomic_load(&vt_memory.calls) + size + 1;
        status = read_file(&cloud, &file, file.size, &keep);
        ck_assert(status == VOR_OK || cloud.triangles == NULL);
    }
    vt_memory.fail_at = 0;
    vt_assert_ok(status);
    ck_assert_uint_gt(size, 1);
    vor_cloud_free(&cloud);
    free(file.data);
    vt_assert_no_leak();
}
END_TEST

/* Refusal: more triangles than the limit has room for, declared or not. */
START_TEST(triangles_beyond_the_limit_are_refused)
{
    struct vor_limits limits = keep;
    struct vor_cloud cloud;
    static const int fan[] = {14, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, -1};
    struct vt_bytes file = make(&plain, "face", fan);
    static const char many[] =
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty "
        "float y\nproperty float z\nelement face 11\nproperty list uchar "
        "int vertex_index\nend_header\n0 0 0\n0 0 1\n0 1 0\n1 0 0\n1 1 1\n";

    limits.points = 5;
    vt_assert_fails(VOR_E_LIMIT, read_file(&cloud, &file, file.size, &limits));
    ck_assert_str_eq(vt_err.message, "11 triangles or more, want at most 10");
    ck_assert(vt_err.limit == 10 && vt_err.got == 11);
    free(file.data);
    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_fails(VOR_E_LIMIT,
                    vor_ply_read(&cloud, (const uint8_t *)many, sizeof many - 1, &limits, &vt_err));
    ck_assert_str_eq(vt_err.message, "11 rows of faces, want at most 10");
    vt_assert_no_leak();
}
END_TEST

/* Vector: the apex is not finite; the square stays, under other numbers. */
START_TEST(triangles_of_points_that_are_dropped_go_with_them)
{
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 3\nproperty list uchar int vertex_index\nend_header\nnan 0 1\n"
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 1 2 3 4\n3 4 3 0\n";
    static const uint32_t want[] = {0, 1, 2, 0, 2, 3};
    struct vor_limits limits = keep;
    struct vor_cloud cloud;

    limits.drop_invalid = 1;
    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_ok(
        vor_codec_read(&cloud, NULL, (const uint8_t *)text, sizeof text - 1, &limits, &vt_err));
    ck_assert_uint_eq(cloud.n, 4);
    ck_assert_uint_eq(cloud.triangle_count, 2);
    ck_assert_mem_eq(cloud.triangles, want, sizeof want);
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

/* What a job keeps of its upload has the triangles, and is refused where they are cut or wrong. */
START_TEST(a_dump_keeps_the_triangles)
{
    struct vt_bytes file = make(&plain, "face", lists), dump = {0};
    struct vor_sink sink = {&dump, vt_bytes_write};
    struct vor_cloud cloud, back;

    vt_assert_ok(read_file(&cloud, &file, file.size, &keep));
    vt_assert_ok(vor_dump_write(&sink, &cloud, &vt_err));
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_dump_read(&back, dump.data, dump.size, &vt_err));
    assert_triangles(&back, triangles, 6);
    ck_assert_uint_eq(back.notes.faces, 5);
    vor_cloud_free(&back);
    for (size_t size = 0; size < dump.size; size++)
        vt_assert_fails(VOR_E_FORMAT, vor_dump_read(&back, dump.data, size, &vt_err));
    dump.data[dump.size - 4] = 5; /* there are five points */
    vt_assert_fails(VOR_E_FORMAT, vor_dump_read(&back, dump.data, dump.size, &vt_err));
    vor_cloud_free(&cloud);
    free(file.data);
    free(dump.data);
    vt_assert_no_leak();
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("ply_faces");

    vt_add_loop(suite, faces_are_the_same_triangles_in_every_encoding, ENCODINGS);
    vt_add_loop(suite, strips_are_triangles_that_face_one_way, ENCODINGS);
    vt_add(suite, faces_that_are_not_wanted_are_only_counted);
    vt_add_loop(suite, what_is_wrong_with_faces_is_said, REFUSALS);
    vt_add_loop(suite, faces_that_are_cut_or_do_not_fit_leave_nothing, ENCODINGS);
    vt_add(suite, triangles_beyond_the_limit_are_refused);
    vt_add(suite, triangles_of_points_that_are_dropped_go_with_them);
    vt_add(suite, a_dump_keeps_the_triangles);
    return vt_run(suite);
}
