#include "tests/unit/draco_files.h"

/* What a scan with everything looks like. */
static void full_cloud(struct vor_cloud *cloud, uint64_t seed, size_t n)
{
    float *normal, *intensity, *class;
    uint8_t *color;
    int16_t *ring;

    vt_cloud_sphere(cloud, seed, n);
    draco_number(cloud);
    normal = draco_add(cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3);
    color = draco_add(cloud, "color", VOR_COLOR, VOR_UINT8, 4);
    intensity = draco_add(cloud, "intensity", VOR_GENERIC, VOR_FLOAT32, 1);
    class = draco_add(cloud, "scalar_class", VOR_GENERIC, VOR_FLOAT32, 1);
    ring = draco_add(cloud, "ring", VOR_GENERIC, VOR_INT16, 2);
    for (size_t i = 0; i < n; i++) {
        memcpy(normal + 3 * i, cloud->xyz + 3 * i, 3 * sizeof *normal);
        for (size_t c = 0; c < 4; c++)
            color[4 * i + c] = (uint8_t)(256 * vt_unit(seed + 1, 4 * i + c));
        intensity[i] = (float)(1000 * vt_unit(seed + 2, i));
        class[i] = (float)(int)(32 * vt_unit(seed + 3, i)) / 2;
        ring[2 * i] = (int16_t)(65536 * vt_unit(seed + 4, i) - 32768);
        ring[2 * i + 1] = (int16_t)i;
    }
}

/* Vector: what comes back from the encoding asked for, attribute by attribute. */
static void check_full(int bits, int keep_order)
{
    struct vor_cloud cloud, back;
    const struct vor_attribute *normal, *intensity, *was_normal, *was_intensity;
    uint32_t *numbers;

    full_cloud(&cloud, 7, 3000);
    draco_trip(&back, &cloud, bits, keep_order);
    numbers = draco_numbers(&back);
    ck_assert_uint_eq(back.attribute_count, cloud.attribute_count);
    draco_assert_same(&back, &cloud, "color", numbers);
    draco_assert_same(&back, &cloud, "ring", numbers);
    draco_assert_same(&back, &cloud, "scalar_class", numbers);
    normal = vor_cloud_find(&back, VOR_NORMAL);
    was_normal = vor_cloud_find(&cloud, VOR_NORMAL);
    intensity = vor_cloud_find_name(&back, "intensity");
    was_intensity = vor_cloud_find_name(&cloud, "intensity");
    ck_assert(normal != NULL && normal->type == VOR_FLOAT32 && normal->components == 3);
    ck_assert(intensity != NULL && intensity->type == VOR_FLOAT32);
    for (size_t i = 0; i < back.n; i++) {
        size_t j = numbers[i];

        for (size_t c = 0; c < 3; c++)
            must_be_near(((const float *)normal->data)[3 * i + c],
                         ((const float *)was_normal->data)[3 * j + c], 1e-3);
        must_be_near(((const float *)intensity->data)[i], ((const float *)was_intensity->data)[j],
                     1000 / 65535.0 * 0.51);
        ck_assert_msg(!keep_order || i == j, "point %zu is not in its place", i);
    }
    free(numbers);
    vt_free_last(&back, &cloud);
}

/* By the kd-tree, by sequential encoding in order, by auto. */
VT_TEST_LOOP(everything_survives, 3)
{
    check_full(_i < 2 ? 14 : -1, _i == 1);
}

/* Vector: byte 8 of a Draco file is the method, 1 the kd-tree. */
VT_TEST(the_kd_tree_is_used_where_it_can_be_and_only_there)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;
    static const struct {
        enum vor_type type;
        unsigned components;
        int bits, keep_order, method;
    } cases[] = {
        {VOR_UINT8, 3, 10, 0, 1},   {VOR_INT32, 1, 10, 0, 1},   {VOR_FLOAT32, 2, 10, 0, 1},
        {VOR_FLOAT32, 2, 10, 1, 0}, {VOR_FLOAT32, 2, 0, 0, 0},  {VOR_FLOAT64, 1, 10, 0, 0},
        {VOR_INT64, 1, 10, 0, 0},   {VOR_UINT64, 16, -1, 0, 0}, {VOR_UINT32, 16, -1, 0, 1},
    };

    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        vt_cloud_cube(&cloud, k, 50);
        (void)draco_add(&cloud, "extra", VOR_GENERIC, cases[k].type, cases[k].components);
        vt_assert_ok(draco_encode(&bytes, &cloud, cases[k].bits, cases[k].keep_order));
        ck_assert_msg(bytes.data[8] == cases[k].method, "case %zu: method %d", k, bytes.data[8]);
        free(bytes.data);
        vor_cloud_free(&cloud);
    }
    vt_cloud_cube(&cloud, 1, 50);
    for (int k = 0; k < 4; k++)
        (void)draco_add(&cloud, "wide", VOR_GENERIC, VOR_UINT8, 16);
    vt_assert_ok(draco_encode(&bytes, &cloud, 10, 0));
    ck_assert_msg(bytes.data[8] == 0, "67 scalars a point went into a kd-tree");
    free(bytes.data);
    vor_cloud_free(&cloud);
}

/* Vector: the library computes in int32 and would lose these. */
VT_TEST(integers_of_every_size_are_exact_up_to_their_ends)
{
    static const enum vor_type types[] = {VOR_INT8,  VOR_UINT8,  VOR_INT16, VOR_UINT16,
                                          VOR_INT32, VOR_UINT32, VOR_INT64, VOR_UINT64};
    struct vor_cloud cloud, back;
    uint32_t *numbers;

    for (int k = 0; k < 4 * 8; k++) {
        enum vor_type type = types[k % 8];
        size_t size = vor_type_size(type);
        unsigned char *data;

        vt_cloud_cube(&cloud, 3, 40);
        draco_number(&cloud);
        data = draco_add(&cloud, "value", VOR_GENERIC, type, 2);
        for (size_t i = 0; i < 80 * size; i++)
            data[i] = (unsigned char)(256 * vt_unit(11, i));
        memset(data, 0, size);
        memset(data + size, 0xff, size);
        memset(data + 2 * size, 0xff, size);
        data[3 * size - 1] = 0x7f;
        memset(data + 3 * size, 0, size);
        data[4 * size - 1] = 0x80;
        draco_trip(&back, &cloud, k / 8 % 2 == 0 ? 0 : 12, k / 16);
        numbers = draco_numbers(&back);
        draco_assert_same(&back, &cloud, "value", numbers);
        free(numbers);
        vor_cloud_free(&back);
        vor_cloud_free(&cloud);
    }
}

/* Regression: the encoder fails on NaN, and computes a range of infinity. */
VT_TEST(values_that_are_not_finite_are_kept_as_they_are)
{
    struct vor_cloud cloud, back;
    float *value;

    vt_cloud_cube(&cloud, 5, 100);
    value = draco_add(&cloud, "value", VOR_GENERIC, VOR_FLOAT32, 1);
    value[0] = 1;
    value[17] = NAN;
    value[18] = INFINITY;
    value[19] = -INFINITY;
    draco_trip(&back, &cloud, 12, 0);
    draco_assert_same(&back, &cloud, "value", NULL);
    vor_cloud_free(&back);
    value[17] = 0;
    value[18] = 3e38f;
    value[19] = -3e38f;
    draco_trip(&back, &cloud, 12, 0);
    draco_assert_same(&back, &cloud, "value", NULL);
    vt_free_last(&back, &cloud);
}

/* Vector: normals that are not of length 1 do not lose their length in sequential encoding. */
VT_TEST(long_normals_stay_long)
{
    struct vor_cloud cloud, back;
    float *normal;

    for (int keep_order = 0; keep_order < 2; keep_order++) {
        vt_cloud_sphere(&cloud, 5, 100);
        draco_number(&cloud);
        normal = draco_add(&cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3);
        for (size_t i = 0; i < 300; i++)
            normal[i] = 5 * cloud.xyz[i];
        draco_trip(&back, &cloud, 12, keep_order);
        uint32_t *numbers = draco_numbers(&back);
        const float *got = vor_cloud_find(&back, VOR_NORMAL)->data;
        for (size_t i = 0; i < 300; i++)
            must_be_near(got[i], normal[3 * numbers[i / 3] + i % 3], 10.0 / 4095);
        free(numbers);
        vor_cloud_free(&back);
        vor_cloud_free(&cloud);
    }
}

/* Vector: everything of ours stands in the metadata, which other readers skip. */
VT_TEST(a_reader_that_ignores_the_metadata_gets_the_relative_positions)
{
    struct vor_cloud cloud;
    struct vt_bytes plain, ours;

    vt_cloud_cube(&cloud, 5, 64);
    vt_assert_ok(draco_encode(&plain, &cloud, 0, 1));
    cloud.origin[1] = 5e6;
    cloud.position_type = VOR_FLOAT64;
    vt_assert_ok(draco_encode(&ours, &cloud, 0, 1));
    ck_assert_uint_gt(ours.size, plain.size);
    ck_assert_uint_eq(ours.data[10], 0x80);
    ck_assert_mem_eq(ours.data + 11 + (ours.size - plain.size), plain.data + 11, plain.size - 11);
    free(plain.data);
    free(ours.data);
    vor_cloud_free(&cloud);
}

VT_TEST(names_survive_and_implied_ones_cost_nothing)
{
    static const char *const names[] = {"generic",         "generic_2",          "a",
                                        "GPS time",        "tex\ncoord\xc3\xa9", "normal",
                                        "scalar_Intensity"};
    static const char *const want[] = {
        "generic", "generic_2", "a", "GPS time", "tex_coord\xc3\xa9", "normal", "scalar_Intensity"};
    struct vor_cloud cloud, back;
    struct vt_bytes bytes;

    vt_cloud_cube(&cloud, 5, 64);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        (void)draco_add(&cloud, names[i], VOR_GENERIC, VOR_UINT8, 1);
    draco_trip(&back, &cloud, 10, 0);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        ck_assert_str_eq(back.attributes[i].name, want[i]);
        ck_assert_int_eq(back.attributes[i].semantic, VOR_GENERIC);
    }
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    vt_cloud_cube(&cloud, 5, 64);
    (void)draco_add(&cloud, "normal", VOR_NORMAL, VOR_FLOAT32, 3);
    (void)draco_add(&cloud, "color", VOR_COLOR, VOR_UINT8, 3);
    vt_assert_ok(draco_encode(&bytes, &cloud, 10, 0));
    ck_assert_msg((bytes.data[10] & 0x80) == 0, "metadata without need");
    free(bytes.data);
    vor_cloud_free(&cloud);
}

VT_TEST(more_compression_makes_a_flat_cloud_smaller)
{
    struct vor_sink sink;
    struct vor_cloud cloud;
    size_t sizes[2];

    vt_cloud_square(&cloud, 5, 20000);
    for (int k = 0; k < 2; k++) {
        struct vor_write_options options = {.quantization_bits = 12, .compression = 10 * k};
        struct vt_bytes bytes = {0};

        sink = (struct vor_sink){.ctx = &bytes, .write = vt_bytes_write};
        vt_assert_ok(vor_draco_write(&sink, &cloud, &options, &vt_err));
        sizes[k] = bytes.size;
        free(bytes.data);
    }
    ck_assert_uint_lt(sizes[1], sizes[0]);
    vor_cloud_free(&cloud);
}

/* Vector: the smallest clouds there are. */
VT_TEST(clouds_of_one_two_and_three_points_and_of_one_place_survive)
{
    struct vor_cloud cloud, back;

    for (int k = 0; k < 18; k++) {
        size_t n = 1 + (size_t)k % 3;

        vt_cloud_cube(&cloud, 5, n);
        if (k >= 9)
            for (size_t i = 0; i < 3 * n; i++)
                cloud.xyz[i] = 5;
        draco_trip(&back, &cloud, k / 3 % 3 * 6 - (k / 3 % 3 == 2 ? 13 : 0), k & 1);
        if (k >= 9)
            ck_assert_mem_eq(back.xyz, cloud.xyz, 3 * n * sizeof *back.xyz);
        vor_cloud_free(&back);
        vor_cloud_free(&cloud);
    }
}

/* Regression: such a file is a hundred bytes long, and the reader's gate takes it for a bomb. */
VT_TEST(many_points_in_few_places_can_be_read_back)
{
    struct vor_cloud cloud, back;
    size_t n = 300000;

    for (int k = 0; k < 4; k++) {
        vt_cloud_cube(&cloud, 5, n);
        (void)draco_add(&cloud, "wide", VOR_GENERIC, VOR_INT16, 8);
        for (size_t i = 0; k < 2 && i < 3 * n; i++)
            cloud.xyz[i] = 5;
        draco_trip(&back, &cloud, k < 2 ? -1 : 1, k & 1);
        vor_cloud_free(&back);
        vor_cloud_free(&cloud);
    }
}

/* Regression: the encoder counts in a table as long as the largest number, so that 30 bits in
 * sequential encoding, or integers far apart, took it 4 GB. */
VT_TEST(large_numbers_do_not_take_large_memory)
{
    struct vor_cloud cloud, back;

    for (int k = 0; k < 8; k++) {
        int32_t *value;

        vt_cloud_cube(&cloud, 5, 1000);
        draco_number(&cloud);
        value = draco_add(&cloud, "value", VOR_GENERIC, VOR_INT32, 2);
        for (size_t i = 0; i < 1000; i++) {
            value[2 * i] = (int32_t)(k & 2 ? i : i * 2147483 % 2000000000);
            value[2 * i + 1] = 1000000000;
        }
        atomic_store(&vt_memory.peak, 0);
        draco_trip(&back, &cloud, k & 4 ? 30 : 0, k & 1);
        ck_assert_uint_le(atomic_load(&vt_memory.peak), 24 << 20);
        uint32_t *numbers = draco_numbers(&back);
        draco_assert_same(&back, &cloud, "value", numbers);
        free(numbers);
        vor_cloud_free(&back);
        vor_cloud_free(&cloud);
    }
}

static int refuse_bytes(void *ctx, const void *bytes, size_t size)
{
    (void)ctx;
    (void)bytes;
    (void)size;
    return -1;
}

VT_TEST(a_sink_that_refuses_is_an_io_error)
{
    struct vor_write_options options = {.quantization_bits = 10, .compression = 7};
    struct vor_sink sink = {.ctx = NULL, .write = refuse_bytes};
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 5, 64);
    vt_assert_fails(VOR_E_IO, vor_draco_write(&sink, &cloud, &options, &vt_err));
    vor_cloud_free(&cloud);
}

VT_TEST(clouds_without_points_or_with_nan_are_refused)
{
    struct vor_cloud cloud;
    struct vt_bytes bytes;

    vor_cloud_init(&cloud, &vt_memory);
    vt_assert_fails(VOR_E_EMPTY, draco_encode(&bytes, &cloud, 10, 0));
    vt_cloud_cube(&cloud, 5, 64);
    cloud.xyz[3 * 33 + 1] = NAN;
    vt_assert_fails(VOR_E_NONFINITE, draco_encode(&bytes, &cloud, 10, 0));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "33"));
    ck_assert_ptr_null(bytes.data);
    vor_cloud_free(&cloud);
}
