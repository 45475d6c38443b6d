/* What a cloud has beside its points: points that are not finite, remarks, and lists of what was
 * left out; through readers, dumps and writers. */
#include "core/cloud/sift.h"
#include "proto/codec.h"
#include "proto/dump.h"
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* n points of which about one in four is not finite, each with its number for an attribute. */
static void sick_cloud(struct vor_cloud *cloud, uint64_t seed, size_t n, size_t *sick)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    struct vor_attribute *number;

    vt_cloud_cube(cloud, seed, n);
    vt_assert_ok(
        vor_cloud_add_attribute(cloud, "number", VOR_GENERIC, VOR_UINT32, 1, &number, &vt_err));
    *sick = 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t at = (uint32_t)i;

        memcpy((char *)number->data + 4 * i, &at, sizeof at);
        if (vt_unit(seed + 1000, i) > 0.25)
            continue;
        cloud->xyz[3 * i + vor_rng_bits(seed, 7, i) % 3] = bad[i % 3];
        ++*sick;
    }
}

/* Property: the others stay, in their order, each with its own values. */
VT_TEST_LOOP(points_that_are_dropped_take_nothing_else_along, 20)
{
    uint64_t seed = (uint64_t)_i;
    size_t n = 5 + seed * 17, sick, kept = 0;
    struct vor_cloud cloud, before;

    sick_cloud(&cloud, seed, n, &sick);
    vor_cloud_init(&before, &vt_memory);
    vt_assert_ok(vor_cloud_copy(&before, &cloud, &vt_err));
    if (sick == n)
        cloud.xyz[0] = cloud.xyz[1] = cloud.xyz[2] = 0;
    vt_assert_ok(vor_cloud_sift(&cloud, NULL, 1, &vt_err));
    for (size_t i = 0; i < n; i++) {
        const float *x = &before.xyz[3 * i];

        if (!isfinite(x[0]) || !isfinite(x[1]) || !isfinite(x[2]))
            continue;
        ck_assert_mem_eq(&cloud.xyz[3 * kept], x, 12);
        ck_assert_double_eq(vor_attribute_scalar(&cloud.attributes[0], kept), (double)i);
        kept++;
    }
    ck_assert_uint_eq(cloud.n, kept);
    ck_assert_uint_eq(cloud.notes.invalid, n - kept);
    vor_cloud_free(&before);
    vor_cloud_free(&cloud);
}

VT_TEST(coordinates_that_are_still_doubles_close_up_in_their_place)
{
    double wide[] = {1, 2, 3, NAN, 0, 0, 4, 5, 6, 0, 0, INFINITY};
    static const double left[] = {1, 2, 3, 4, 5, 6};
    struct vor_cloud cloud;

    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_ok(vor_cloud_resize(&cloud, 4, &vt_err));
    vt_assert_ok(vor_cloud_sift(&cloud, wide, 1, &vt_err));
    ck_assert_uint_eq(cloud.n, 2);
    ck_assert_mem_eq(wide, left, sizeof left);
    vor_cloud_free(&cloud);
}

VT_TEST(a_refusal_counts_the_points_and_names_the_way_out)
{
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 9);
    cloud.xyz[3 * 4 + 2] = -INFINITY;
    cloud.xyz[3 * 7] = NAN;
    vt_assert_fails(VOR_E_NONFINITE, vor_cloud_sift(&cloud, NULL, 0, &vt_err));
    ck_assert_str_eq(
        vt_err.message,
        "2 of 9 points have a coordinate that is not finite. The first is point 4: its z "
        "is -inf. invalid=drop leaves such points out");
    ck_assert_str_eq(vt_err.parameter, "invalid");
    ck_assert_uint_eq(cloud.n, 9);
    for (size_t i = 0; i < 9; i++)
        cloud.xyz[3 * i] = NAN;
    vt_assert_fails(VOR_E_EMPTY, vor_cloud_sift(&cloud, NULL, 1, &vt_err));
    ck_assert_uint_eq(cloud.n, 9);
    vor_cloud_free(&cloud);
}

static vor_status read_text(struct vor_cloud *out, const char *text, size_t size, int drop)
{
    struct vor_limits limits = VOR_LIMITS_DEFAULT;

    limits.drop_invalid = drop;
    vor_cloud_init(out, &vt_memory);
    return vor_codec_read(out, NULL, (const uint8_t *)text, size, &limits, &vt_err);
}

#define XYZ "property float x\nproperty float y\nproperty float z\n"

/* Vector: what is in the header and not in the cloud. */
VT_TEST(a_ply_file_tells_what_is_left_out_of_it)
{
    static const char text[] =
        "ply\nformat ascii 1.0\ncomment one\nelement camera 1\nproperty int id\nelement vertex "
        "2\n" XYZ "property list uchar int rings\ncomment written by voronoid\nelement face 3\n"
        "property list uchar int vertex_indices\nelement tri\351 0\nproperty int a\nobj_info two\n"
        "end_header\n7\n0 0 0 0\nnan 0 0 1 5\n";
    struct vor_cloud cloud;

    vt_assert_ok(read_text(&cloud, text, sizeof text - 1, 1));
    ck_assert_uint_eq(cloud.n, 1);
    ck_assert_uint_eq(cloud.notes.invalid, 1);
    ck_assert_uint_eq(cloud.notes.format, VOR_FORMAT_PLY);
    ck_assert_uint_eq(cloud.notes.dropped_count, 3);
    ck_assert_str_eq(cloud.notes.dropped[0].what, "camera");
    ck_assert_uint_eq(cloud.notes.dropped[0].count, 1);
    ck_assert_str_eq(cloud.notes.dropped[1].what, "face");
    ck_assert_uint_eq(cloud.notes.dropped[1].count, 3);
    ck_assert_str_eq(cloud.notes.dropped[2].what, "vertex.rings");
    ck_assert_uint_eq(cloud.notes.dropped[2].count, 2);
    ck_assert_uint_eq(cloud.notes.remarks_size, strlen("comment one\nobj_info two\n"));
    ck_assert_mem_eq(cloud.notes.remarks, "comment one\nobj_info two\n", cloud.notes.remarks_size);
    ck_assert_uint_eq(vor_notes_remarks(&cloud.notes, "comment"), 1);
    ck_assert_uint_eq(vor_notes_remarks(&cloud.notes, "obj_info"), 1);
    vor_cloud_free(&cloud);
    vt_assert_fails(VOR_E_NONFINITE, read_text(&cloud, text, sizeof text - 1, 0));
    ck_assert_int_eq(vt_err.byte_offset, (int64_t)(strstr(text, "nan") - text));
}

/* Refusal: in a file of the old Macintosh a line may hold what ends a line elsewhere. */
VT_TEST(a_remark_cannot_become_another_line_of_the_header)
{
    static const char text[] = "ply\rformat ascii 1.0\rcomment a\nelement vertex 9\n\001b\r"
                               "element vertex 1\rproperty float x\rproperty float y\r"
                               "property float z\rend_header\r1 2 3\r";
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};
    struct vor_cloud cloud, back;

    vt_assert_ok(read_text(&cloud, text, sizeof text - 1, 0));
    vt_assert_ok(vor_ply_write(&sink, &cloud, NULL, &vt_err));
    vt_assert_ok(read_text(&back, (const char *)bytes.data, bytes.size, 0));
    ck_assert_uint_eq(back.n, 1);
    ck_assert_uint_eq(back.notes.remarks_size, cloud.notes.remarks_size);
    ck_assert_mem_eq(back.notes.remarks, "comment a?element vertex 9??b\n",
                     back.notes.remarks_size);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(bytes.data);
}

/* Else we would refuse what we wrote. */
VT_TEST(remarks_never_fill_a_header_beyond_what_is_read)
{
    struct vt_bytes file = {0}, bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};
    static const char head[] = "ply\nformat ascii 1.0\n";
    static const char tail[] = "element vertex 1\n" XYZ "end_header\n1 2 3\n";
    struct vor_cloud cloud, back;
    char line[1000];
    int lines = 65;

    (void)vt_bytes_write(&file, head, sizeof head - 1);
    for (int i = 0; i < lines; i++) {
        (void)snprintf(line, sizeof line, "comment %0991d", i);
        line[sizeof line - 1] = '\n';
        (void)vt_bytes_write(&file, line, sizeof line);
    }
    (void)vt_bytes_write(&file, tail, sizeof tail - 1);
    vt_assert_ok(read_text(&cloud, (const char *)file.data, file.size, 0));
    ck_assert_uint_eq(cloud.notes.remarks_size, 49 * sizeof line);
    ck_assert_uint_eq(cloud.notes.dropped_count, 1);
    ck_assert_str_eq(cloud.notes.dropped[0].what, "comment");
    ck_assert_uint_eq(cloud.notes.dropped[0].count, (uint64_t)lines - 49);
    vt_assert_ok(vor_ply_write(&sink, &cloud, NULL, &vt_err));
    vt_assert_ok(read_text(&back, (const char *)bytes.data, bytes.size, 0));
    ck_assert_uint_eq(back.notes.remarks_size, cloud.notes.remarks_size);
    ck_assert_mem_eq(back.notes.remarks, file.data + sizeof head - 1, back.notes.remarks_size);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(bytes.data);
    free(file.data);
}

VT_TEST(a_list_of_what_was_left_out_never_grows_beyond_its_end)
{
    struct vor_notes notes = {.format = 0};
    uint64_t sum = 0;
    char what[16];

    for (unsigned i = 0; i < 100; i++) {
        (void)snprintf(what, sizeof what, "kind %u", i);
        vor_dropped_add(notes.dropped, &notes.dropped_count, what, i);
    }
    vor_dropped_add(notes.dropped, &notes.dropped_count, "kind 1", UINT64_MAX);
    ck_assert_uint_eq(notes.dropped_count, VOR_DROPPED_MAX);
    ck_assert_str_eq(notes.dropped[0].what, "kind 1"); /* of kind 0 there were none */
    ck_assert_uint_eq(notes.dropped[0].count, UINT64_MAX);
    for (unsigned i = VOR_DROPPED_MAX; i < 100; i++)
        sum += i;
    ck_assert_str_eq(notes.dropped[VOR_DROPPED_MAX - 1].what, "others");
    ck_assert_uint_eq(notes.dropped[VOR_DROPPED_MAX - 1].count, sum);
}

/* Vector: 2^53 + 1 is the least whole number that is no double. */
VT_TEST(integers_that_a_format_rounds_are_counted)
{
    static const int64_t values[] = {
        1, -((INT64_C(1) << 53) + 1), INT64_C(1) << 60, INT64_MIN, INT64_MAX, 0};
    struct vor_report report = {.dropped_count = 0};
    struct vor_attribute *attribute;
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 6);
    vt_assert_ok(
        vor_cloud_add_attribute(&cloud, "id", VOR_GENERIC, VOR_INT64, 1, &attribute, &vt_err));
    memcpy(attribute->data, values, sizeof values);
    vor_codec_report_dropped(&report, &cloud, NULL, vor_format(VOR_FORMAT_DRC));
    ck_assert_uint_eq(report.dropped_count, 0);
    vor_codec_report_dropped(&report, &cloud, NULL, vor_format(VOR_FORMAT_PLY));
    ck_assert_uint_eq(report.dropped_count, 1);
    ck_assert_str_eq(report.dropped[0].what, "digits of id");
    ck_assert_uint_eq(report.dropped[0].count, 2);
    vor_cloud_free(&cloud);
}

static void noted_cloud(struct vor_cloud *cloud)
{
    static const char remarks[] = "comment a\nobj_info b\n";

    vt_cloud_cube(cloud, 3, 50);
    cloud->notes.format = VOR_FORMAT_DRC;
    cloud->notes.invalid = 7;
    vor_dropped_add(cloud->notes.dropped, &cloud->notes.dropped_count, "face", 12);
    vor_dropped_add(cloud->notes.dropped, &cloud->notes.dropped_count, "seam", 1);
    cloud->notes.remarks = vor_malloc(&vt_memory, sizeof remarks - 1, 1);
    ck_assert_ptr_nonnull(cloud->notes.remarks);
    memcpy(cloud->notes.remarks, remarks, sizeof remarks - 1);
    cloud->notes.remarks_size = sizeof remarks - 1;
}

VT_TEST(a_dump_keeps_the_notes_and_is_refused_where_they_are_cut)
{
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};
    struct vor_cloud cloud, back;

    noted_cloud(&cloud);
    vt_assert_ok(vor_dump_write(&sink, &cloud, &vt_err));
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_dump_read(&back, bytes.data, bytes.size, &vt_err));
    ck_assert_uint_eq(back.notes.format, VOR_FORMAT_DRC);
    ck_assert_uint_eq(back.notes.invalid, 7);
    ck_assert_uint_eq(back.notes.dropped_count, 2);
    ck_assert_mem_eq(back.notes.dropped, cloud.notes.dropped, 2 * sizeof *back.notes.dropped);
    ck_assert_uint_eq(back.notes.remarks_size, cloud.notes.remarks_size);
    ck_assert_mem_eq(back.notes.remarks, cloud.notes.remarks, back.notes.remarks_size);
    vor_cloud_free(&back);
    for (size_t size = 0; size < bytes.size; size++) {
        uint8_t *copy = malloc(size + 1); /* so that a byte too many is seen */

        memcpy(copy, bytes.data, size);
        vt_assert_fails(VOR_E_FORMAT, vor_dump_read(&back, copy, size, &vt_err));
        free(copy);
    }
    vor_cloud_free(&cloud);
    free(bytes.data);
}
