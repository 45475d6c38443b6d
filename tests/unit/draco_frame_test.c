/* Which frame the positions of a Draco file stand in: written, read, and read from files of before.
 */
#include "tests/unit/draco_files.h"

#include "proto/draco/draco_shim.h"

enum { N = 300 };

static const double utm[3] = {637000, 5849000, 80};

static int holds(const struct vt_bytes *bytes, const char *text)
{
    size_t length = strlen(text);

    for (size_t i = 0; i + length <= bytes->size; i++)
        if (memcmp(bytes->data + i, text, length) == 0)
            return 1;
    return 0;
}

static void encode_at(struct vt_bytes *out, const struct vor_cloud *cloud, int bits,
                      const double origin[3])
{
    struct vor_write_options options = {
        .quantization_bits = bits, .compression = 7, .keep_order = 1};
    struct vor_sink sink = {.ctx = out, .write = vt_bytes_write};

    memset(out, 0, sizeof *out);
    options.has_origin = 1;
    memcpy(options.origin, origin, sizeof options.origin);
    vt_assert_ok(vor_draco_write(&sink, cloud, &options, &vt_err));
}

VT_TEST(an_origin_is_written_as_single_doubles)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;

    vt_cloud_cube(&cloud, 1, N);
    encode_at(&bytes, &cloud, 0, utm);
    ck_assert(holds(&bytes, "\x11voronoid.origin.x\x08"));
    ck_assert(holds(&bytes, "\x11voronoid.origin.y\x08"));
    ck_assert(holds(&bytes, "\x11voronoid.origin.z\x08"));
    ck_assert(!holds(&bytes, "\x0fvoronoid.origin"));
    free(bytes.data);
    vor_cloud_free(&cloud);
}

/* Property: in whatever frame, positions are those of the cloud within half a cell and a step of
 * float32, and the origin is the one asked for. */
VT_TEST_LOOP(positions_survive_a_change_of_frame, 12)
{
    static const double origins[][3] = {
        {637000, 5849000, 80}, {637100.125, 5849000.5, 80}, {0, 0, 0}};
    const double *origin = origins[_i % 3];
    int bits = _i % 2 == 0 ? 0 : 16;
    struct vor_cloud cloud, back;
    struct vt_bytes bytes;
    double step = _i % 3 == 2 ? 0.5 : 0x1p-17, cell = bits > 0 ? 101 / 65535.0 : 0;

    vt_cloud_cube(&cloud, (uint64_t)_i, N);
    for (int i = 0; i < 3 * N; i++)
        cloud.xyz[i] *= 100;
    memcpy(cloud.origin, utm, sizeof utm);
    cloud.origin[0] += 0.123;
    cloud.position_type = VOR_FLOAT64;
    encode_at(&bytes, &cloud, bits, origin);
    vt_assert_ok(draco_decode(&back, &bytes));
    ck_assert_mem_eq(back.origin, origin, sizeof back.origin);
    ck_assert_int_eq(back.position_type, VOR_FLOAT64);
    for (size_t i = 0; i < N; i++) {
        double x[3], y[3];

        vor_cloud_position(&cloud, i, x);
        vor_cloud_position(&back, i, y);
        for (int c = 0; c < 3; c++)
            must_be_near(y[c], x[c], cell / 2 + step);
    }
    free(bytes.data);
    vt_free_last(&back, &cloud);
}

/* A float cloud with origin 0 in absolute coordinates is what it always was. */
VT_TEST(a_frame_that_does_not_change_costs_no_bit)
{
    static const double zero[3] = {0, 0, 0};
    struct vt_bytes plain, framed;
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 4, N);
    cloud.xyz[0] = -0.0F;
    for (int bits = 0; bits < 20; bits += 19) {
        vt_assert_ok(draco_encode(&plain, &cloud, bits, 1));
        encode_at(&framed, &cloud, bits, zero);
        ck_assert_uint_eq(framed.size, plain.size);
        ck_assert_mem_eq(framed.data, plain.data, plain.size);
        ck_assert(!holds(&framed, "voronoid"));
        free(plain.data);
        free(framed.data);
    }
    vor_cloud_free(&cloud);
}

/* Of coordinates that float32 tells apart only in the frame, as many stay apart as it can. */
VT_TEST(points_that_the_frame_merges_do_not_cost_more_bits)
{
    static const double zero[3] = {0, 0, 0};
    struct vor_cloud cloud, back;
    struct vt_bytes bytes;

    vt_cloud_square(&cloud, 5, N);
    cloud.origin[0] = 1 << 24; /* steps of 2 */
    encode_at(&bytes, &cloud, -1, zero);
    vt_assert_ok(draco_decode(&back, &bytes));
    for (size_t i = 0; i < N; i++)
        must_be_near(back.xyz[3 * i], 1 << 24, 2);
    free(bytes.data);
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
}

/* Writes all, or nothing. */
static vor_status try_write(void *ctx)
{
    struct vor_write_options options = {.compression = 7, .has_origin = 1, .origin = {1, 2, 3}};
    struct vt_bytes bytes = {0};
    struct vor_sink sink = {.ctx = &bytes, .write = vt_bytes_write};
    vor_status status = vor_draco_write(&sink, ctx, &options, &vt_err);

    ck_assert_int_eq(bytes.size > 0, status == VOR_OK);
    free(bytes.data);
    return status;
}

VT_TEST(a_frame_that_does_not_fit_into_memory_is_an_error)
{
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 6, N);
    vt_fail_each(try_write, &cloud);
    vor_cloud_free(&cloud);
}

static int no_charge(void *ctx, size_t bytes)
{
    (void)ctx, (void)bytes;
    return 1;
}

static void no_release(void *ctx, size_t bytes)
{
    (void)ctx, (void)bytes;
}

/* Positions in double with an origin, as a stranger may write them: it counts for them too. */
VT_TEST(an_origin_counts_for_positions_in_double)
{
    static const double xyz[] = {0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3};
    static const double origin[3] = {637000.5, -849000.25, 1e6};
    struct vor_draco_meter meter = {NULL, no_charge, no_release};
    struct vor_draco_column column = {
        .kind = VOR_DRACO_POSITION, .scalar = VOR_DRACO_FLOAT64, .components = 3, .data = xyz};
    struct vor_draco_source source = {.n = 4,
                                      .count = 1,
                                      .columns = &column,
                                      .origin = origin,
                                      .position_type = "float64",
                                      .speed = 3};
    struct vt_bytes bytes = {0};
    struct vor_cloud cloud;
    char message[96];

    ck_assert_int_eq(vor_draco_encode(&source, &meter, &bytes, vt_bytes_write, message),
                     VOR_DRACO_DONE);
    vt_assert_ok(draco_decode(&cloud, &bytes));
    for (size_t i = 0; i < 4; i++) {
        double x[3];

        vor_cloud_position(&cloud, i, x);
        for (size_t c = 0; c < 3; c++)
            ck_assert_double_eq(x[c], origin[c] + xyz[3 * i + c]);
    }
    free(bytes.data);
    vor_cloud_free(&cloud);
}
