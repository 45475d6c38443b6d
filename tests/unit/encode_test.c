/* Results as a codec child writes them: the same bytes as in this process, within the same memory.
 */
#include "server/base/log.h"
#include "server/work/artefacts.h"
#include "server/work/codec_child.h"
#include "tests/support/vt.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { POINTS = 20000 };

static const struct vor_child_kind kinds[] = {{"t-codec", vor_codec_child}};

struct scene {
    struct vor_zygote zygote;
    struct vor_codec_place place;
    struct vor_memory memory;
    struct vor_cloud cloud;
    struct vor_mesh mesh;
    struct vor_write_options options;
};

static void add_column(struct vor_cloud *cloud, const char *name, enum vor_semantic semantic,
                       enum vor_type type, unsigned components)
{
    struct vor_attribute *column;
    uint8_t *bytes;

    vt_assert_ok(
        vor_cloud_add_attribute(cloud, name, semantic, type, components, &column, &vt_err));
    bytes = column->data;
    for (size_t i = 0; i < cloud->n * components * vor_type_size(type); i++)
        bytes[i] = (uint8_t)(i * 7 % 61);
}

/* A cloud with columns whose bytes leave the next one unaligned, remarks, and faces. */
static void start(struct scene *scene)
{
    static const char remark[] = "made by a test";
    struct vor_error why;
    struct vor_cloud sphere;

    scene->place =
        (struct vor_codec_place){.zygote = &scene->zygote, .sandbox = vor_sandbox_probe(&why)};
    vt_assert_ok(vor_zygote_start(&scene->zygote, kinds, 1, &vt_err));
    vor_memory_init(&scene->memory, (size_t)1 << 28);
    vt_cloud_sphere(&sphere, 5, POINTS);
    vor_cloud_init(&scene->cloud, &scene->memory);
    vt_assert_ok(vor_cloud_copy(&scene->cloud, &sphere, &vt_err));
    vor_cloud_free(&sphere);
    add_column(&scene->cloud, "color", VOR_COLOR, VOR_UINT8, 3);
    add_column(&scene->cloud, "weight", VOR_GENERIC, VOR_FLOAT64, 1);
    scene->cloud.notes.remarks = vor_malloc(&scene->memory, sizeof remark, 1);
    memcpy(scene->cloud.notes.remarks, remark, sizeof remark);
    scene->cloud.notes.remarks_size = sizeof remark;
    vor_mesh_init(&scene->mesh, &scene->memory);
    scene->mesh.count = POINTS - 3;
    scene->mesh.polygons = 1;
    scene->mesh.triangle = vor_malloc(&scene->memory, scene->mesh.count, 12);
    for (uint32_t t = 0; t < scene->mesh.count; t++)
        for (uint32_t corner = 0; corner < 3; corner++)
            scene->mesh.triangle[3 * t + corner] = t + corner;
    scene->options =
        (struct vor_write_options){.quantization_bits = 12, .compression = 7, .mesh = &scene->mesh};
}

static void stop(struct scene *scene)
{
    vor_mesh_free(&scene->mesh);
    vor_cloud_free(&scene->cloud);
    vor_zygote_stop(&scene->zygote);
}

static vor_status encode(struct scene *scene, const struct vor_codec_place *place, unsigned format,
                         struct vt_bytes *out)
{
    const struct vor_sink sink = {.ctx = out, .write = vt_bytes_write};

    *out = (struct vt_bytes){0};
    return vor_encode(&sink, place, &scene->cloud, format, &scene->options, &vt_err);
}

/* _i: the format, with and without faces. */
VT_TEST_LOOP(a_child_writes_the_bytes_that_this_process_writes, 4)
{
    const struct vor_codec_place here = {.zygote = NULL};
    struct vt_bytes wanted, got;
    struct scene scene;

    start(&scene);
    if (_i / 2 == 1)
        scene.options.mesh = NULL;
    vt_assert_ok(encode(&scene, &here, (unsigned)_i % 2, &wanted));
    vt_assert_ok(encode(&scene, &scene.place, (unsigned)_i % 2, &got));
    ck_assert_uint_gt(wanted.size, POINTS);
    ck_assert_uint_eq(got.size, wanted.size);
    ck_assert_mem_eq(got.data, wanted.data, got.size);
    free(wanted.data);
    free(got.data);
    stop(&scene);
}

VT_TEST(the_memory_of_a_child_counts_as_the_job_s)
{
    struct vt_bytes bytes;
    struct scene scene;
    size_t used;

    start(&scene);
    used = atomic_load(&scene.memory.used);
    vt_assert_ok(encode(&scene, &scene.place, VOR_FORMAT_DRC, &bytes));
    ck_assert_uint_eq(atomic_load(&scene.memory.used), used);
    ck_assert_uint_gt(atomic_load(&scene.memory.peak), used + 2 * (12 + 11 + 12) * POINTS);
    free(bytes.data);
    stop(&scene);
}

/* _i: 0 not even the copy that the child reads, 1 not what the child makes of it. */
VT_TEST_LOOP(what_does_not_fit_under_the_job_s_cap_is_refused, 2)
{
    struct vt_bytes bytes;
    struct scene scene;
    size_t used;

    start(&scene);
    used = atomic_load(&scene.memory.used);
    scene.memory.cap = used + (_i == 0 ? 1000 : 40 * POINTS);
    vt_assert_fails(VOR_E_NOMEM, encode(&scene, &scene.place, VOR_FORMAT_DRC, &bytes));
    ck_assert_uint_eq(atomic_load(&scene.memory.used), used);
    free(bytes.data);
    stop(&scene);
}

VT_TEST(a_result_that_is_none_is_told_as_our_fault)
{
    static const char nonsense[] = "no triangles, and no dump";
    struct vor_codec_order order = {
        .op = VOR_CODEC_ENCODE, .size = sizeof nonsense, .memory = 4096};
    struct vt_bytes bytes = {0};
    const struct vor_sink sink = {.ctx = &bytes, .write = vt_bytes_write};
    struct vor_codec_facts facts;

    vt_assert_fails(VOR_E_INTERNAL,
                    vor_codec_do(&facts, &sink, &order, (const uint8_t *)nonsense, &vt_err));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "the decoded cloud is damaged"));
    order.triangles = 3;
    vt_assert_fails(VOR_E_INTERNAL,
                    vor_codec_do(&facts, &sink, &order, (const uint8_t *)nonsense, &vt_err));
    ck_assert_str_eq(vt_err.message, "the codec process received an invalid request");
    ck_assert_uint_eq(bytes.size, 0);
}

void vt_suite(Suite *suite VOR_UNUSED)
{
    vor_log_open(STDERR_FILENO, VOR_LOG_OFF);
}
