#include "tests/unit/draco_files.h"

#include <pthread.h>
#include <stdio.h>

/* False, with a line that names it, when a file is not there: prints a TAP comment. */
static int slurp(struct vt_bytes *out, const char *path, const char *name)
{
    out->data = path != NULL ? vt_slurp(path, &out->size) : NULL;
    if (out->data == NULL)
        printf("# skipped: %s is not there\n", name);
    return out->data != NULL;
}

static int read_data(struct vor_cloud *out, const char *name)
{
    struct vt_bytes bytes = {0};

    const char *path = vt_data_or_skip(name);

    if (path == NULL || !slurp(&bytes, path, name))
        return 0;
    vt_assert_ok(draco_decode(out, &bytes));
    free(bytes.data);
    return 1;
}

static int by_color(const void *a, const void *b)
{
    return memcmp(a, b, 3);
}

/* Vector: the Draco project's own point clouds, one object in both encodings and two bitstreams
 * (2.2 sequential, 2.3 kd-tree): the order differs, the colours are the same. */
VT_TEST(both_encodings_of_one_cloud_hold_the_same_points)
{
    struct vor_cloud clouds[2];
    double extent;

    if (!read_data(&clouds[0], "pc_color.drc"))
        return;
    ck_assert(read_data(&clouds[1], "pc_kd_color.drc"));
    for (int k = 0; k < 2; k++) {
        const struct vor_attribute *color = vor_cloud_find(&clouds[k], VOR_COLOR);

        ck_assert_uint_eq(clouds[k].n, 7733);
        ck_assert_uint_eq(clouds[k].attribute_count, 1);
        ck_assert_int_eq(clouds[k].position_type, VOR_FLOAT32);
        ck_assert(color != NULL && color->type == VOR_UINT8 && color->components == 3);
        ck_assert_str_eq(color->name, "color");
        qsort(color->data, clouds[k].n, 3, by_color);
    }
    ck_assert_mem_eq(clouds[0].attributes[0].data, clouds[1].attributes[0].data, (size_t)7733 * 3);
    extent = draco_extent(&clouds[0]);
    must_be_near(draco_extent(&clouds[1]), extent, 1e-3 * extent);
    vor_cloud_free(&clouds[0]);
    vor_cloud_free(&clouds[1]);
}

VT_TEST(redrocks_has_all_its_points_and_colours)
{
    struct vor_cloud cloud;

    if (!read_data(&cloud, "redrocks.drc"))
        return;
    ck_assert_uint_eq(cloud.n, 43041);
    ck_assert_ptr_nonnull(vor_cloud_find(&cloud, VOR_COLOR));
    vor_cloud_free(&cloud);
}

/* The surface of the three meshes in the corpus: 5 x 5 vertices at (x, y, sin(x + 2 y)), coloured
 * (50 x, 50 y, c) where c is 0 in the left half and 200 in the right: a seam at x = 2. */
static void check_sheet(const struct vor_cloud *cloud, size_t n)
{
    const struct vor_attribute *color = vor_cloud_find(cloud, VOR_COLOR);
    int seen[5][5] = {{0}};

    ck_assert_uint_eq(cloud->n, n);
    ck_assert(color != NULL && color->components == 3 && color->type == VOR_UINT8);
    ck_assert_ptr_nonnull(vor_cloud_find_name(cloud, "tex_coord"));
    ck_assert_uint_eq(cloud->attribute_count, 2);
    for (size_t i = 0; i < n; i++) {
        const float *p = cloud->xyz + 3 * i;
        const uint8_t *rgb = (const uint8_t *)color->data + 3 * i;
        int x = (int)lrintf(p[0]), y = (int)lrintf(p[1]);

        ck_assert(x >= 0 && x <= 4 && y >= 0 && y <= 4);
        must_be_near(p[0], x, 2e-3);
        must_be_near(p[1], y, 2e-3);
        must_be_near(p[2], sin(x + 2 * y), 2e-3);
        ck_assert_int_eq(rgb[0], 50 * x);
        ck_assert_int_eq(rgb[1], 50 * y);
        ck_assert(x == 2 ? rgb[2] == 0 || rgb[2] == 200 : rgb[2] == (x < 2 ? 0 : 200));
        seen[x][y]++;
    }
    for (int x = 0; x < 5; x++)
        for (int y = 0; y < 5; y++)
            ck_assert_msg(seen[x][y] == 1 || (n > 25 && x == 2 && seen[x][y] == 2),
                          "vertex %d %d comes %d times", x, y, seen[x][y]);
}

/* The 32 triangles cover 4 x 4 of the plane, and none reaches across the seam. */
static void check_faces(const struct vor_cloud *cloud)
{
    const uint8_t *rgb = vor_cloud_find(cloud, VOR_COLOR)->data;
    double area = 0;

    ck_assert_uint_eq(cloud->triangle_count, 32);
    for (size_t t = 0; t < 32; t++) {
        const uint32_t *corner = &cloud->triangles[3 * t];
        const float *p[3];

        for (int k = 0; k < 3; k++) {
            ck_assert_uint_lt(corner[k], cloud->n);
            p[k] = &cloud->xyz[3 * (size_t)corner[k]];
            ck_assert_uint_eq(rgb[3 * (size_t)corner[k] + 2], rgb[3 * (size_t)corner[0] + 2]);
        }
        area += fabs((double)((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                              (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]))) /
                2;
    }
    must_be_near(area, 16, 1e-2);
}

/* Vector: the seam makes 30 points of 25 vertices, as each belongs to one side, in a file that
 * shares positions between points as in those that store them twice. A sheet of 5 x 5 vertices has
 * 32 triangles, which are given or named. */
VT_TEST_LOOP(meshes_give_their_points_and_where_wanted_their_faces, 3)
{
    static const char *const paths[] = {"tests/fuzz/corpus/draco/mesh-edgebreaker.drc",
                                        "tests/fuzz/corpus/draco/mesh-edgebreaker-fast.drc",
                                        "tests/fuzz/corpus/draco/mesh-sequential.drc"};
    struct vor_limits limits = draco_limits;
    struct vt_bytes bytes = {0};
    struct vor_cloud cloud;

    ck_assert(slurp(&bytes, paths[_i], paths[_i]));
    for (limits.keep_faces = 0; limits.keep_faces < 2; limits.keep_faces++) {
        vor_cloud_init(&cloud, &vt_memory);
        vt_assert_ok(vor_draco_read(&cloud, bytes.data, bytes.size, &limits, &vt_err));
        check_sheet(&cloud, 30);
        if (limits.keep_faces) {
            check_faces(&cloud);
            ck_assert_uint_eq(cloud.notes.faces, 32);
            ck_assert_uint_eq(cloud.notes.dropped_count, 0);
        } else {
            ck_assert_uint_eq(cloud.notes.dropped_count, 1);
            ck_assert_str_eq(cloud.notes.dropped[0].what, "face");
            ck_assert_uint_eq(cloud.notes.dropped[0].count, 32);
        }
        vor_cloud_free(&cloud);
    }
    free(bytes.data);
}

static void put(struct vt_bytes *out, const void *bytes, size_t size)
{
    ck_assert_int_eq(vt_bytes_write(out, bytes, size), 0);
}

static void put_head(struct vt_bytes *out, const char version[2], uint32_t n, int kd_tree)
{
    uint8_t head[11] = "DRACO";

    memcpy(head + 5, version, 2);
    head[8] = (uint8_t)kd_tree;
    put(out, head, sizeof head);
    put(out, &n, sizeof n);
    put(out, "\1", 1);
}

/* Vector: our kd-tree in the dress of bitstream 2.2, which stored the integers themselves: the
 * positions come out as cells, and integer positions go through double. */
VT_TEST(a_kd_tree_of_an_older_bitstream_holds_the_same_cells)
{
    struct vor_cloud cloud, back, old;
    struct vt_bytes bytes, dressed = {0};
    double low[3] = {INFINITY, INFINITY, INFINITY}, cell;
    uint32_t n = 500;

    vt_cloud_cube(&cloud, 3, n);
    vt_assert_ok(draco_encode(&bytes, &cloud, 10, 0));
    vt_assert_ok(draco_decode(&back, &bytes));
    put_head(&dressed, "\2\2", n, 1);
    put(&dressed, "\1\0\6\3\0\0\1\6", 8); /* one attribute: position, UINT32; integers, level 6 */
    put(&dressed, &n, sizeof n);
    put(&dressed, bytes.data + 23, bytes.size - 23 - 17); /* without the quantisation at its end */
    vt_assert_ok(draco_decode(&old, &dressed));
    ck_assert_uint_eq(old.n, n);
    ck_assert_int_eq(old.position_type, VOR_FLOAT64);
    for (size_t i = 0; i < 3 * n; i++)
        low[i % 3] = fmin(low[i % 3], (double)cloud.xyz[i]);
    cell = draco_extent(&cloud) / 1023;
    for (size_t i = 0; i < n; i++) {
        double cells[3];

        vor_cloud_position(&old, i, cells);
        for (size_t c = 0; c < 3; c++) {
            must_be_near(cells[c], rint(cells[c]), 1e-9);
            must_be_near(low[c] + cell * cells[c], (double)back.xyz[3 * i + c], 1e-6);
        }
    }
    vor_cloud_free(&old);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    free(bytes.data);
    free(dressed.data);
}

VT_TEST(what_the_library_held_is_in_the_peak_and_given_back)
{
    struct vor_cloud cloud, back;
    struct vor_memory memory;
    struct vt_bytes bytes;

    vt_cloud_sphere(&cloud, 1, 50000);
    vt_assert_ok(draco_encode(&bytes, &cloud, 12, 0));
    vor_memory_init(&memory, SIZE_MAX);
    vor_cloud_init(&back, &memory);
    vt_assert_ok(vor_draco_read(&back, bytes.data, bytes.size, &draco_limits, &vt_err));
    ck_assert_uint_ge(atomic_load(&memory.peak), (size_t)2 * 12 * 50000);
    ck_assert_uint_lt(atomic_load(&memory.used), (size_t)12 * 50000 + 256);
    vor_cloud_free(&back);
    ck_assert_uint_eq(atomic_load(&memory.used), 0);
    vor_cloud_free(&cloud);
    free(bytes.data);
}

/* One thread's share: its own allocator, capped on every other turn. */
static void *trips(void *ctx)
{
    const struct vt_bytes *bytes = ctx;
    size_t wrong = 0;

    for (int k = 0; k < 40; k++) {
        size_t cap = k % 2 == 0 ? SIZE_MAX : 30000;
        struct vor_memory memory;
        struct vor_cloud cloud;
        struct vor_error err;
        vor_status status;

        vor_memory_init(&memory, cap);
        vor_cloud_init(&cloud, &memory);
        status = vor_draco_read(&cloud, bytes->data, bytes->size, &draco_limits, &err);
        wrong += status != (k % 2 == 0 ? VOR_OK : VOR_E_NOMEM);
        vor_cloud_free(&cloud);
        wrong += atomic_load(&memory.used) != 0;
    }
    return wrong == 0 ? ctx : NULL;
}

/* Property: the meter of one call never sees the allocations of another. */
VT_TEST(calls_on_several_threads_share_nothing)
{
    pthread_t threads[4];
    struct vor_cloud cloud;
    struct vt_bytes bytes;
    void *answer;

    vt_cloud_sphere(&cloud, 1, 2000);
    vt_assert_ok(draco_encode(&bytes, &cloud, 12, 0));
    for (int i = 0; i < 4; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, trips, &bytes), 0);
    for (int i = 0; i < 4; i++) {
        ck_assert_int_eq(pthread_join(threads[i], &answer), 0);
        ck_assert_ptr_nonnull(answer);
    }
    free(bytes.data);
    vor_cloud_free(&cloud);
}
