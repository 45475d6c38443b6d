/* Vectors: scans and meshes as they are in the world (tests/data/scans.txt), where ../shared/data
 * has them. */
#include "proto/ply/ply.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct vor_limits limits = VOR_LIMITS_DEFAULT;

static struct scan {
    char name[40], type[16], attributes[80]; /* name:type:components, as vor_type_name has it */
    size_t n;
    double low[3], high[3];
} scans[20];

static int read_scans(void)
{
    FILE *table = fopen("tests/data/scans.txt", "r");
    char line[400];
    int count = 0;

    while (table != NULL && fgets(line, sizeof line, table) != NULL) {
        struct scan *scan = &scans[count];

        count += line[0] != '#' &&
                 sscanf(line, "%39s %zu %15s %lf %lf %lf %lf %lf %lf %79[^\n]", scan->name,
                        &scan->n, scan->type, &scan->low[0], &scan->low[1], &scan->low[2],
                        &scan->high[0], &scan->high[1], &scan->high[2], scan->attributes) >= 9;
    }
    if (table == NULL || fclose(table) != 0 || count < 11)
        exit(1);
    return count;
}

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

static int count; /* of scans */

VT_TEST_LOOP(a_scan_has_its_points_box_and_attributes, count)
{
    const struct scan *scan = &scans[_i];
    struct vor_cloud cloud;
    char attributes[256];
    double low[3], high[3];

    if (!open_scan(&cloud, scan->name))
        return;
    ck_assert_uint_eq(cloud.n, scan->n);
    ck_assert_str_eq(vor_type_name_sized(cloud.position_type), scan->type);
    list_attributes(&cloud, attributes, sizeof attributes);
    ck_assert_str_eq(attributes, scan->attributes);
    box(&cloud, low, high);
    for (int c = 0; c < 3; c++) {
        double extent = scan->high[c] - scan->low[c];
        double tolerance = cloud.position_type == VOR_FLOAT64 ? ldexp(extent, -20) : 0;

        ck_assert_double_le(fabs(low[c] - scan->low[c]), tolerance);
        ck_assert_double_le(fabs(high[c] - scan->high[c]), tolerance);
    }
    vor_cloud_free(&cloud);
}

VT_TEST_LOOP(a_scan_survives_being_written_and_read, count)
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
}

/* The ascii scan is the binary one as it was distributed. */
VT_TEST(ascii_and_binary_bunny_are_the_same_points)
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

/* The contract of vor_cloud_set_double on survey coordinates: half a cell of extent / 2^24. */
VT_TEST(survey_coordinates_keep_their_last_digit)
{
    const char *path = vt_data("autzen.ply");
    struct vor_cloud cloud;
    size_t size;
    uint8_t *bytes, *row;
    double extent = 0, low[3], high[3];

    if (!open_scan(&cloud, "autzen.ply"))
        return;
    bytes = vt_slurp(path, &size);
    ck_assert_ptr_nonnull(bytes);
    box(&cloud, low, high);
    for (int c = 0; c < 3; c++)
        extent = fmax(extent, high[c] - low[c]);
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

void vt_suite(Suite *suite VOR_UNUSED)
{
    count = read_scans();
}
