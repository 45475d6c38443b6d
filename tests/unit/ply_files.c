/* Vectors: scans and meshes as they are in the world, where ../shared/data has them. Counts and
 * boxes were taken from the files by another program. */
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct vor_limits limits = VOR_LIMITS_DEFAULT;

static const struct scan {
    const char *name;
    size_t n;
    enum vor_type type;
    const char *attributes; /* name:type:components, as vor_type_name has it */
    double low[3], high[3];
} scans[] = {
    {"armadillo_mesh.ply",
     43243,
     VOR_FLOAT32,
     "",
     {-0.43527498841285706, -0.5734019875526428, -0.3794809877872467},
     {0.40334200859069824, 0.4265489876270294, 0.38332998752593994}},
    {"autzen.ply",
     110000,
     VOR_FLOAT64,
     "color:uchar:3",
     {636001.76, 848935.2000000001, 406.26},
     {637179.22, 849497.9, 520.51}},
    {"bun_zipper.ply",
     35947,
     VOR_FLOAT32,
     "confidence:float:1 intensity:float:1",
     {-0.09468989819288254, 0.03298740088939667, -0.061873599886894226},
     {0.06100910156965256, 0.1873210072517395, 0.05879969894886017}},
    {"bunny.ply",
     35947,
     VOR_FLOAT32,
     "",
     {-0.09468989819288254, 0.03298740088939667, -0.061873599886894226},
     {0.06100910156965256, 0.1873210072517395, 0.05879969894886017}},
    {"cow_mesh.ply",
     2903,
     VOR_FLOAT32,
     "",
     {-4.445835113525391, -3.637036085128784, -1.7014050483703613},
     {5.9980878829956055, 2.7597200870513916, 1.7014050483703613}},
    {"fandisk_mesh.ply",
     6475,
     VOR_FLOAT32,
     "",
     {0.0, 12.605500221252441, -2.680259943008423},
     {4.827899932861328, 17.850000381469727, 0.0}},
    {"igea_mesh.ply",
     134345,
     VOR_FLOAT32,
     "",
     {-0.03455600142478943, -0.04966900125145912, -0.04953800141811371},
     {0.03455600142478943, 0.04966900125145912, 0.04953800141811371}},
    {"igea_tristrips.ply",
     134345,
     VOR_FLOAT32,
     "",
     {-0.03455600142478943, -0.04966900125145912, -0.04953800141811371},
     {0.03455600142478943, 0.04966900125145912, 0.04953800141811371}},
    {"kitti_000008.ply",
     17238,
     VOR_FLOAT32,
     "intensity:float:1",
     {2.8889999389648438, -26.420000076293945, -3.6070001125335693},
     {76.83499908447266, 10.277999877929688, 2.865999937057495}},
    {"office1.ply",
     254456,
     VOR_FLOAT32,
     "color:uchar:3",
     {-2.6454761028289795, -2.1964290142059326, 1.8329999446868896},
     {1.5043599605560303, 1.581246018409729, 5.363999843597412}},
    {"scannet.ply",
     40684,
     VOR_FLOAT32,
     "color:uchar:3",
     {-0.014288811013102531, -0.0016582333482801914, -0.0003987468662671745},
     {8.406188011169434, 8.734845161437988, 3.0226428508758545}},
};

enum { AUTZEN = 1, SCANS = sizeof scans / sizeof scans[0] };

/* False where the file is not there. */
static int open_scan(struct vor_cloud *cloud, const char *name)
{
    const char *path = vt_data_or_skip(name);
    size_t size;
    uint8_t *bytes;

    if (path == NULL)
        return 0;
    bytes = vt_slurp(path, &size);
    ck_assert_ptr_nonnull(bytes);
    vor_cloud_init(cloud, &vt_memory);
    vt_assert_ok(vor_ply_read(cloud, bytes, size, &limits, &vt_err));
    free(bytes);
    return 1;
}

static void box(const struct vor_cloud *cloud, double low[3], double high[3])
{
    for (int c = 0; c < 3; c++) {
        low[c] = INFINITY;
        high[c] = -INFINITY;
    }
    for (size_t i = 0; i < cloud->n; i++) {
        double at[3];

        vor_cloud_position(cloud, i, at);
        for (int c = 0; c < 3; c++) {
            low[c] = fmin(low[c], at[c]);
            high[c] = fmax(high[c], at[c]);
        }
    }
}

static void list_attributes(const struct vor_cloud *cloud, char *out, size_t size)
{
    size_t at = 0;

    out[0] = '\0';
    for (size_t i = 0; i < cloud->attribute_count; i++)
        at += (size_t)snprintf(out + at, size - at, "%s%s:%s:%u", i > 0 ? " " : "",
                               cloud->attributes[i].name, vor_type_name(cloud->attributes[i].type),
                               cloud->attributes[i].components);
}

START_TEST(a_scan_has_its_points_box_and_attributes)
{
    const struct scan *scan = &scans[_i];
    struct vor_cloud cloud;
    char attributes[256];
    double low[3], high[3];

    if (!open_scan(&cloud, scan->name))
        return;
    ck_assert_uint_eq(cloud.n, scan->n);
    ck_assert_int_eq(cloud.position_type, scan->type);
    list_attributes(&cloud, attributes, sizeof attributes);
    ck_assert_str_eq(attributes, scan->attributes);
    box(&cloud, low, high);
    for (int c = 0; c < 3; c++) {
        double extent = scan->high[c] - scan->low[c];
        double tolerance = scan->type == VOR_FLOAT64 ? ldexp(extent, -20) : 0;

        ck_assert_double_le(fabs(low[c] - scan->low[c]), tolerance);
        ck_assert_double_le(fabs(high[c] - scan->high[c]), tolerance);
    }
    vor_cloud_free(&cloud);
    vt_assert_no_leak();
}
END_TEST

START_TEST(a_scan_survives_being_written_and_read)
{
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};
    struct vor_cloud cloud, back;

    if (!open_scan(&cloud, scans[_i].name))
        return;
    vt_assert_ok(vor_ply_write(&sink, &cloud, NULL, &vt_err));
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_ply_read(&back, bytes.data, bytes.size, &limits, &vt_err));
    ck_assert_uint_eq(back.n, cloud.n);
    ck_assert_mem_eq(back.origin, cloud.origin, sizeof back.origin);
    ck_assert_mem_eq(back.xyz, cloud.xyz, cloud.n * 12);
    ck_assert_uint_eq(back.attribute_count, cloud.attribute_count);
    for (size_t a = 0; a < cloud.attribute_count; a++)
        ck_assert_mem_eq(back.attributes[a].data, cloud.attributes[a].data,
                         cloud.n * cloud.attributes[a].components *
                             vor_type_size(cloud.attributes[a].type));
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(bytes.data);
    vt_assert_no_leak();
}
END_TEST

/* The ascii scan is the binary one as it was distributed. */
START_TEST(ascii_and_binary_bunny_are_the_same_points)
{
    struct vor_cloud ascii, binary;

    if (!open_scan(&ascii, "bun_zipper.ply"))
        return;
    if (open_scan(&binary, "bunny.ply")) {
        ck_assert_uint_eq(ascii.n, binary.n);
        ck_assert_mem_eq(ascii.xyz, binary.xyz, ascii.n * 12);
        vor_cloud_free(&binary);
    }
    vor_cloud_free(&ascii);
}
END_TEST

/* The contract of vor_cloud_set_double on survey coordinates: half a cell of extent / 2^24. */
START_TEST(survey_coordinates_keep_their_last_digit)
{
    const char *path = vt_data("autzen.ply");
    struct vor_cloud cloud;
    size_t size;
    uint8_t *bytes, *row;
    double extent = 0;

    if (!open_scan(&cloud, "autzen.ply"))
        return;
    bytes = vt_slurp(path, &size);
    ck_assert_ptr_nonnull(bytes);
    for (int c = 0; c < 3; c++)
        extent = fmax(extent, scans[AUTZEN].high[c] - scans[AUTZEN].low[c]);
    row = bytes + size - cloud.n * 27; /* nothing follows the vertices */
    for (size_t i = 0; i < cloud.n; i++, row += 27) {
        double want[3], got[3];

        memcpy(want, row, sizeof want);
        vor_cloud_position(&cloud, i, got);
        for (int c = 0; c < 3; c++)
            ck_assert_double_le(fabs(got[c] - want[c]), ldexp(extent, -24));
    }
    vor_cloud_free(&cloud);
    free(bytes);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("ply_files");

    vt_add_loop(suite, a_scan_has_its_points_box_and_attributes, SCANS);
    vt_add_loop(suite, a_scan_survives_being_written_and_read, SCANS);
    vt_add(suite, ascii_and_binary_bunny_are_the_same_points);
    vt_add(suite, survey_coordinates_keep_their_last_digit);
    return vt_run(suite);
}
