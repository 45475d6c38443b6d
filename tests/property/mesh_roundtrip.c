/* Faces of a result go into both formats and come back over the same points, on many random meshes:
 * surfaces, closed and open, that the Draco library can walk along, and soups that it cannot. */
#include "proto/codec.h"
#include "tests/unit/draco_files.h"

#include <stdio.h>

enum { DRACO_KIND = 7, DRACO_METHOD = 8, MESH = 1, SEQUENTIAL = 0, EDGEBREAKER = 1 };

static int formats(int loop)
{
    return loop % 2 == 0 ? VOR_FORMAT_PLY : VOR_FORMAT_DRC;
}

static void allocate(struct vor_mesh *mesh, size_t count)
{
    vor_mesh_init(mesh, &vt_memory);
    mesh->count = count;
    mesh->triangle = vor_malloc(&vt_memory, count, 3 * sizeof *mesh->triangle);
    ck_assert_ptr_nonnull(mesh->triangle);
}

/* A point of a torus of wide x high, or of a bent sheet. */
static void place(float out[3], size_t i, size_t wide, size_t high, int closed)
{
    double u = 6.283185307 * (double)(i % wide) / (double)wide;
    double v = 6.283185307 * (double)(i / wide) / (double)high;

    out[0] = (float)(closed ? (3 + cos(v)) * cos(u) : u);
    out[1] = (float)(closed ? (3 + cos(v)) * sin(u) : v);
    out[2] = (float)(closed ? sin(v) : sin(u));
}

/* Squares of a grid, two triangles each; closed, it is a torus. One in forty is larger than what a
 * writer writes at a time. */
static void surface_mesh(struct vor_cloud *cloud, struct vor_mesh *mesh, uint64_t seed, int closed)
{
    double most = seed % 40 == 0 ? 120 : 20;
    size_t wide = 3 + (size_t)(most * vt_unit(seed, 1));
    size_t high = 3 + (size_t)(most * vt_unit(seed, 2));
    size_t columns = closed ? wide : wide - 1, rows = closed ? high : high - 1;
    uint32_t *at;

    vt_cloud_cube(cloud, seed, wide * high);
    for (size_t i = 0; i < cloud->n; i++)
        place(cloud->xyz + 3 * i, i, wide, high, closed);
    allocate(mesh, 2 * columns * rows);
    at = mesh->triangle;
    for (size_t r = 0; r < rows; r++)
        for (size_t c = 0; c < columns; c++, at += 6) {
            uint32_t a = (uint32_t)(r * wide + c), b = (uint32_t)(r * wide + (c + 1) % wide);
            uint32_t d = (uint32_t)((r + 1) % high * wide + c);
            uint32_t e = (uint32_t)((r + 1) % high * wide + (c + 1) % wide);

            memcpy(at, (uint32_t[6]){a, b, e, a, e, d}, 6 * sizeof *at);
        }
}

/* Any points, but not one alone: edges of many faces, faces of one point twice, points of no face.
 */
static void soup_mesh(struct vor_cloud *cloud, struct vor_mesh *mesh, uint64_t seed)
{
    size_t n = 3 + (size_t)(300 * vt_unit(seed, 1));

    vt_cloud_cube(cloud, seed, n);
    allocate(mesh, 1 + (size_t)(400 * vt_unit(seed, 2)));
    for (size_t k = 0; k < 3 * mesh->count; k++)
        mesh->triangle[k] = (uint32_t)((double)n * vt_unit(seed, 10 + k));
    for (uint32_t *at = mesh->triangle; at < mesh->triangle + 3 * mesh->count; at += 3)
        if (at[0] == at[1] && at[0] == at[2])
            at[2] = (at[2] + 1) % (uint32_t)n;
}

static void make(struct vor_cloud *cloud, struct vor_mesh *mesh, uint64_t seed)
{
    if (seed % 4 == 3)
        soup_mesh(cloud, mesh, seed);
    else
        surface_mesh(cloud, mesh, seed, seed % 2 == 0);
}

/* A value of every kind that writers treat in a way of its own, and the number of each point. */
static void add_attributes(struct vor_cloud *cloud, uint64_t seed)
{
    float *normal = draco_add(cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3);
    uint8_t *color = draco_add(cloud, "color", VOR_COLOR, VOR_UINT8, 4);
    int32_t *near = draco_add(cloud, "near", VOR_GENERIC, VOR_INT32, 1);
    uint32_t *far = draco_add(cloud, "far", VOR_GENERIC, VOR_UINT32, 1);
    double *wide = draco_add(cloud, "wide", VOR_GENERIC, VOR_FLOAT64, 1);

    for (size_t i = 0; i < cloud->n; i++) {
        normal[3 * i + i % 3] = i % 2 == 0 ? 1 : -1;
        for (size_t c = 0; c < 4; c++)
            color[4 * i + c] = (uint8_t)(256 * vt_unit(seed, 4 * i + c));
        near[i] = (int32_t)(1000 * vt_unit(seed, 7 * i)) - 500;
        far[i] = (uint32_t)(4294967295.0 * vt_unit(seed, 9 * i));
        wide[i] = vt_unit(seed, 11 * i) / 3;
    }
    draco_number(cloud);
}

static void encode(struct vt_bytes *out, unsigned format, const struct vor_cloud *cloud,
                   const struct vor_write_options *options)
{
    struct vor_sink sink = {.ctx = out, .write = vt_bytes_write};

    memset(out, 0, sizeof *out);
    vt_assert_ok(vor_format(format)->write(&sink, cloud, options, &vt_err));
}

static vor_status decode(struct vor_cloud *cloud, struct vor_mesh *mesh,
                         const struct vt_bytes *bytes)
{
    struct vor_limits limits = draco_limits;
    vor_status status;

    limits.keep_faces = VOR_FACES_KEPT;
    vor_cloud_init(cloud, &vt_memory);
    status = vor_codec_read(cloud, NULL, bytes->data, bytes->size, &limits, &vt_err);
    *mesh = (struct vor_mesh){&vt_memory, cloud->triangles, cloud->triangle_count, cloud->polygons};
    cloud->triangles = NULL;
    cloud->triangle_count = 0;
    return status;
}

static int by_corners(const void *a, const void *b)
{
    const uint32_t *p = a, *q = b;

    for (int c = 0; c < 3; c++)
        if (p[c] != q[c])
            return p[c] < q[c] ? -1 : 1;
    return 0;
}

/* The triangles in an order of their own, each from its smallest corner on, over the points that
 * numbers (NULL: themselves) tell. The caller frees it. */
static uint32_t *ordered(const struct vor_mesh *mesh, const uint32_t *numbers)
{
    uint32_t *out = malloc(mesh->count * 3 * sizeof *out);

    ck_assert_ptr_nonnull(out);
    for (size_t i = 0; i < mesh->count; i++) {
        uint32_t corner[3], *at = out + 3 * i;
        unsigned least = 0;

        for (unsigned c = 0; c < 3; c++) {
            corner[c] = mesh->triangle[3 * i + c];
            if (numbers != NULL)
                corner[c] = numbers[corner[c]];
            if (corner[c] < corner[least])
                least = c;
        }
        if (corner[0] == corner[2] && least == 0) /* of two that are the least, the later one */
            least = 2;
        for (unsigned c = 0; c < 3; c++)
            at[c] = corner[(least + c) % 3];
    }
    qsort(out, mesh->count, 3 * sizeof *out, by_corners);
    return out;
}

static void assert_same_faces(const struct vor_mesh *got, const uint32_t *numbers,
                              const struct vor_mesh *want)
{
    uint32_t *a, *b;

    ck_assert_uint_eq(got->count, want->count);
    a = ordered(got, numbers);
    b = ordered(want, NULL);
    ck_assert_mem_eq(a, b, 3 * want->count * sizeof *a);
    free(a);
    free(b);
}

/* A cloud with its mesh, a file of both, and what is read from it. */
struct trip {
    struct vor_write_options options;
    struct vor_cloud cloud, back;
    struct vor_mesh mesh, faces;
    struct vt_bytes bytes;
    uint32_t *numbers; /* of each point of `back`, in `cloud` */
};

/* Writes and reads a numbered cloud; its triangles come back. */
static void go(struct trip *trip, unsigned format)
{
    trip->options.mesh = &trip->mesh;
    encode(&trip->bytes, format, &trip->cloud, &trip->options);
    vt_assert_ok(decode(&trip->back, &trip->faces, &trip->bytes));
    trip->numbers = draco_numbers(&trip->back);
    assert_same_faces(&trip->faces, trip->numbers, &trip->mesh);
}

static void forget(struct trip *trip)
{
    free(trip->numbers);
    free(trip->bytes.data);
    vor_mesh_free(&trip->faces);
    vor_cloud_free(&trip->back);
}

static void end(struct trip *trip)
{
    forget(trip);
    vor_mesh_free(&trip->mesh);
    vor_cloud_free(&trip->cloud);
}

/* Property: PLY keeps every face where it is, and the points as they would be without faces. */
VT_TEST_LOOP(ply_keeps_every_face_and_every_bit_of_the_points, 40)
{
    uint64_t seed = 100 + (uint64_t)_i;
    struct trip trip = {.options = {.quantization_bits = 0}};

    make(&trip.cloud, &trip.mesh, seed);
    add_attributes(&trip.cloud, seed);
    go(&trip, VOR_FORMAT_PLY);
    ck_assert_mem_eq(trip.faces.triangle, trip.mesh.triangle,
                     3 * trip.mesh.count * sizeof *trip.mesh.triangle);
    ck_assert_uint_eq(trip.back.n, trip.cloud.n);
    ck_assert_mem_eq(trip.back.xyz, trip.cloud.xyz, 3 * trip.cloud.n * sizeof *trip.cloud.xyz);
    for (size_t i = 0; i < trip.cloud.attribute_count; i++)
        draco_assert_same(&trip.back, &trip.cloud, trip.cloud.attributes[i].name, NULL);
    end(&trip);
}

/* The bits of loop i: lossless, auto, or so many. */
static int bits_of(int i)
{
    return i % 3 == 0 ? 0 : i % 3 == 1 ? -1 : 8 + i % 23;
}

/* What quantised positions may be off: half a cell, and what float32 rounds off. */
static double tolerance(const struct vor_cloud *cloud, int bits)
{
    double extent = draco_extent(cloud), cells = bits > 0 ? ldexp(1, bits) - 1 : 200;

    return bits == 0 ? 0 : extent / cells / 2 + 8 * extent * 0x1p-24;
}

/* Property: whatever the options, a Draco mesh has the same triangles over the same points, with
 * the same values; surfaces are written by edgebreaker. */
VT_TEST_LOOP(draco_keeps_every_face_over_its_points, 132)
{
    uint64_t seed = 200 + (uint64_t)_i;
    int bits = bits_of(_i);
    struct trip trip = {
        .options = {.quantization_bits = bits, .compression = _i % 11, .keep_order = _i % 5 == 4}};

    make(&trip.cloud, &trip.mesh, seed);
    add_attributes(&trip.cloud, seed);
    go(&trip, VOR_FORMAT_DRC);
    ck_assert_int_eq(trip.bytes.data[DRACO_KIND], MESH);
    ck_assert_int_eq(trip.bytes.data[DRACO_METHOD],
                     seed % 4 == 3 || trip.options.keep_order ? SEQUENTIAL : EDGEBREAKER);
    ck_assert_uint_eq(trip.back.n, trip.cloud.n);
    for (size_t i = 0; i < 3 * trip.back.n; i++)
        must_be_near(trip.back.xyz[i], trip.cloud.xyz[3 * trip.numbers[i / 3] + i % 3],
                     tolerance(&trip.cloud, bits));
    for (size_t i = 0; i < trip.cloud.attribute_count; i++)
        draco_assert_same(&trip.back, &trip.cloud, trip.cloud.attributes[i].name, trip.numbers);
    for (size_t i = 0; trip.options.keep_order && i < trip.back.n; i++)
        ck_assert_uint_eq(trip.numbers[i], i);
    end(&trip);
}

/* Two squares that share one corner only, and a point of no face: edgebreaker would make two points
 * of the one and none of the other. */
VT_TEST_LOOP(no_point_is_split_or_lost_where_surfaces_touch, 2)
{
    static const uint32_t corners[] = {0, 1, 2, 0, 2, 3, 2, 4, 5, 2, 5, 6};
    struct trip trip = {.options = {.quantization_bits = 10}};

    allocate(&trip.mesh, _i == 1 ? 2 : 4);
    memcpy(trip.mesh.triangle, corners, 3 * trip.mesh.count * sizeof *corners);
    vt_cloud_cube(&trip.cloud, 5, 7);
    draco_number(&trip.cloud);
    go(&trip, VOR_FORMAT_DRC);
    ck_assert_int_eq(trip.bytes.data[DRACO_METHOD], SEQUENTIAL);
    ck_assert_uint_eq(trip.back.n, 7);
    end(&trip);
}

/* Polygons of 3 to 12 corners, one of all that a byte counts, each with points of its own. Returns
 * how many there are. */
static size_t polygon_mesh(struct vor_cloud *cloud, struct vor_mesh *mesh, uint64_t seed)
{
    size_t polygons = 2 + (size_t)(400 * vt_unit(seed, 1)), corners = 0;
    unsigned sides[402];
    uint32_t *at;

    for (size_t p = 0; p < polygons; p++) {
        sides[p] = p == polygons / 2 ? UINT8_MAX : 3 + (unsigned)(10 * vt_unit(seed, 10 + p));
        corners += sides[p];
    }
    vt_cloud_cube(cloud, seed, corners);
    allocate(mesh, corners - 2 * polygons);
    mesh->polygons = 1;
    at = mesh->triangle;
    corners = 0;
    for (size_t p = 0; p < polygons; p++) {
        for (unsigned c = 2; c < sides[p]; c++, at += 3)
            memcpy(at,
                   ((uint32_t[3]){(uint32_t)corners, (uint32_t)corners + c - 1,
                                  (uint32_t)corners + c}),
                   3 * sizeof *at);
        corners += sides[p];
    }
    return polygons;
}

/* Property: PLY holds polygons as they are, and Draco their triangles. */
VT_TEST_LOOP(polygons_come_back_whole_or_as_triangles, 20)
{
    struct trip trip = {.options = {.quantization_bits = 0}};
    char line[40], head[400];
    size_t polygons = polygon_mesh(&trip.cloud, &trip.mesh, (uint64_t)_i);

    ck_assert_uint_eq(vor_mesh_faces(&trip.mesh), polygons);
    draco_number(&trip.cloud);
    go(&trip, VOR_FORMAT_PLY);
    (void)snprintf(line, sizeof line, "element face %zu\n", polygons);
    (void)snprintf(head, sizeof head, "%.*s", (int)sizeof head - 1, (const char *)trip.bytes.data);
    ck_assert_ptr_nonnull(strstr(head, line));
    ck_assert_mem_eq(trip.faces.triangle, trip.mesh.triangle,
                     3 * trip.mesh.count * sizeof *trip.mesh.triangle);
    ck_assert_uint_eq(vor_mesh_faces(&trip.faces), polygons);
    forget(&trip);
    go(&trip, VOR_FORMAT_DRC);
    end(&trip);
}

/* Metres of UTM with millimetres behind them: the origin goes along, and comes back. */
VT_TEST_LOOP(coordinates_of_doubles_survive_beside_faces, 2)
{
    struct trip trip = {.options = {.quantization_bits = 16}};

    surface_mesh(&trip.cloud, &trip.mesh, 8, 1);
    trip.cloud.origin[0] = 637000.123;
    trip.cloud.origin[1] = 5849000.987;
    trip.cloud.position_type = VOR_FLOAT64;
    draco_number(&trip.cloud);
    go(&trip, (unsigned)formats(_i));
    ck_assert_int_eq(trip.back.position_type, VOR_FLOAT64);
    for (size_t i = 0; i < trip.back.n; i++) {
        double got[3], want[3];

        vor_cloud_position(&trip.back, i, got);
        vor_cloud_position(&trip.cloud, trip.numbers[i], want);
        for (int c = 0; c < 3; c++)
            must_be_near(got[c], want[c], 8.0 / 65535 / 2 + 1e-6);
    }
    end(&trip);
}

/* Who asks for points alone gets them, and is told how many faces there are besides. */
VT_TEST_LOOP(points_are_read_without_faces_which_are_noted, 2)
{
    struct vor_write_options options = {.quantization_bits = 12};
    struct vor_cloud cloud, back;
    struct vor_mesh mesh;
    struct vt_bytes bytes;

    surface_mesh(&cloud, &mesh, 6, 1);
    options.mesh = &mesh;
    encode(&bytes, (unsigned)formats(_i), &cloud, &options);
    vor_cloud_init(&back, &vt_memory);
    vt_assert_ok(vor_codec_read(&back, NULL, bytes.data, bytes.size, &draco_limits, &vt_err));
    ck_assert_uint_eq(back.n, cloud.n);
    ck_assert_uint_eq(back.notes.dropped_count, 1);
    ck_assert_str_eq(back.notes.dropped[0].what, "face");
    ck_assert_uint_eq(back.notes.dropped[0].count, mesh.count);
    free(bytes.data);
    vor_cloud_free(&back);
    vor_mesh_free(&mesh);
    vor_cloud_free(&cloud);
}

/* A file without faces is read as one that has none. */
VT_TEST_LOOP(a_cloud_is_a_mesh_of_no_faces, 2)
{
    struct vor_write_options options = {.quantization_bits = 12};
    struct vor_mesh none = {.memory = &vt_memory}, faces;
    struct vor_cloud cloud, back;
    struct vt_bytes bytes, plain;

    vt_cloud_sphere(&cloud, 3, 200);
    encode(&plain, (unsigned)formats(_i), &cloud, &options);
    options.mesh = &none;
    encode(&bytes, (unsigned)formats(_i), &cloud, &options);
    ck_assert_uint_eq(bytes.size, plain.size);
    ck_assert_mem_eq(bytes.data, plain.data, plain.size);
    vt_assert_ok(decode(&back, &faces, &bytes));
    ck_assert_uint_eq(back.n, 200);
    ck_assert_uint_eq(faces.count, 0);
    ck_assert_ptr_null(faces.triangle);
    free(bytes.data);
    free(plain.data);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
}

/* --- damage ----------------------------------------------------------------------------------- */

/* Cut anywhere, or with any byte changed, a file is read as something or refused; never is a corner
 * no point, and nothing is left behind. */
VT_TEST_LOOP(a_damaged_file_has_no_corner_that_is_no_point, 4)
{
    struct vor_write_options options = {.quantization_bits = 8, .keep_order = _i / 2};
    struct vor_cloud cloud, back;
    struct vor_mesh mesh, faces;
    struct vt_bytes bytes;
    size_t refused = 0;

    surface_mesh(&cloud, &mesh, 12, 0);
    options.mesh = &mesh;
    encode(&bytes, (unsigned)formats(_i), &cloud, &options);
    for (uint64_t k = 0; k < 400; k++) {
        size_t at = (size_t)((double)bytes.size * vt_unit(77, k));
        uint8_t was = bytes.data[at];
        struct vt_bytes cut = {.data = bytes.data, .size = k % 2 == 0 ? at : bytes.size};

        bytes.data[at] = (uint8_t)(was ^ (1 + (unsigned)(255 * vt_unit(78, k))));
        if (decode(&back, &faces, &cut) == VOR_OK)
            for (size_t c = 0; c < 3 * faces.count; c++)
                ck_assert_uint_lt(faces.triangle[c], back.n);
        else
            refused++;
        bytes.data[at] = was;
        vor_mesh_free(&faces);
        vor_cloud_free(&back);
    }
    ck_assert_uint_ge(refused, 200); /* all that are cut */
    free(bytes.data);
    vor_mesh_free(&mesh);
    vor_cloud_free(&cloud);
}

VT_TEST(more_corners_than_the_library_counts_are_refused)
{
    struct vor_mesh mesh = {.memory = &vt_memory, .count = INT32_MAX / 3 + 1};
    struct vor_write_options options = {.mesh = &mesh};
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {&bytes, vt_bytes_write};
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 3);
    vt_assert_fails(VOR_E_LIMIT, vor_draco_write(&sink, &cloud, &options, &vt_err));
    ck_assert_str_eq(vt_err.message,
                     "the result has 715827883 faces, but a Draco file can have at most 715827882");
    ck_assert_uint_eq(vt_err.limit, INT32_MAX / 3);
    ck_assert_uint_eq(bytes.size, 0);
    vor_cloud_free(&cloud);
}

/* Whichever allocation fails first, writing and reading say so and leave nothing. */
VT_TEST_LOOP(writing_and_reading_survive_the_failure_of_any_allocation, 2)
{
    struct vor_write_options options = {.quantization_bits = 8};
    struct vt_bytes bytes = {0}, lost = {0};
    struct vor_sink sink = {&lost, vt_bytes_write};
    struct vor_cloud cloud, back;
    struct vor_mesh mesh, faces;
    vor_status status;
    uint32_t *numbers;
    size_t used;

    surface_mesh(&cloud, &mesh, 14, 1);
    add_attributes(&cloud, 14);
    options.mesh = &mesh;
    encode(&bytes, (unsigned)formats(_i), &cloud, &options);
    used = atomic_load(&vt_memory.used);
    for (int reads = 0; reads < 2; reads++)
        for (size_t k = 1;; k++) {
            vt_memory.fail_at = atomic_load(&vt_memory.calls) + k;
            if (reads)
                status = decode(&back, &faces, &bytes);
            else
                status = vor_format((unsigned)formats(_i))->write(&sink, &cloud, &options, &vt_err);
            vt_memory.fail_at = 0;
            if (status == VOR_OK)
                break;
            ck_assert_int_eq(status, VOR_E_NOMEM);
            ck_assert_uint_eq(atomic_load(&vt_memory.used), used);
        }
    numbers = draco_numbers(&back);
    assert_same_faces(&faces, numbers, &mesh);
    free(numbers);
    free(bytes.data);
    free(lost.data);
    vor_mesh_free(&faces);
    vor_cloud_free(&back);
    vor_mesh_free(&mesh);
    vor_cloud_free(&cloud);
}
