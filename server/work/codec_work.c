#include "server/work/codec_work.h"

#include "proto/dump.h"
#include "proto/gzip.h"

#include <assert.h>

/* Measures a cloud while its bytes are taken elsewhere: behind each piece of them a piece of the
 * walk. A PLY of 12 MB takes a child 23.1 ms; 28.6 where the walk was behind all bytes, and 23.5
 * here. */
struct measured_sink {
    const struct vor_sink *sink;
    struct vor_extent_walk walk;
};

static int write_and_measure(void *ctx, const void *bytes, size_t size)
{
    enum { PIECE = 128 << 10, POSITION = 3 * sizeof(float), PASSES = 2 };
    struct measured_sink *measured = ctx;
    const uint8_t *at = bytes;

    while (size > 0) {
        size_t now = size < PIECE ? size : PIECE;

        if (measured->sink->write(measured->sink->ctx, at, now) < 0)
            return -1;
        vor_extent_walk(&measured->walk, PASSES * now / POSITION);
        at += now;
        size -= now;
    }
    return 0;
}

static vor_status decode(struct vor_codec_facts *facts, const struct vor_sink *sink,
                         const struct vor_codec_order *order, const uint8_t *bytes,
                         struct vor_error *err)
{
    struct measured_sink measured = {.sink = sink};
    const struct vor_sink through = {.ctx = &measured, .write = write_and_measure};
    const struct vor_format *format = NULL;
    struct vor_codec_facts found = {0};
    struct vor_memory memory;
    struct vor_cloud cloud;
    vor_status status;

    vor_memory_init(&memory, order->memory);
    vor_cloud_init(&cloud, &memory);
    status = vor_codec_read(&cloud, &format, bytes, (size_t)order->size, &order->limits, err);
    if (status == VOR_OK) {
        for (; vor_format(found.format) != format; found.format++)
            assert(vor_format(found.format) != NULL);
        found.points = cloud.n;
        vor_extent_begin(&measured.walk, &cloud);
        status = vor_dump_write(&through, &cloud, err);
        vor_extent_end(&found.extent, &measured.walk);
    }
    vor_cloud_free(&cloud);
    if (status == VOR_OK)
        *facts = found;
    return status;
}

/* A result as it was written. */
struct result {
    struct vor_cloud cloud;
    struct vor_mesh mesh; /* its triangles are the cloud's, or the engine's */
};

/* What we wrote ourselves and cannot read is our fault, not a caller's. */
static vor_status read_result(struct result *result, const struct vor_codec_order *order,
                              const uint8_t *bytes, struct vor_error *err)
{
    const struct vor_limits limits = {
        .points = VOR_POINTS_MAX, .header_bytes = (size_t)1 << 24, .keep_faces = VOR_FACES_KEPT};
    struct vor_cloud *cloud = &result->cloud;
    struct vor_error why;
    vor_status status = vor_codec_read(cloud, NULL, bytes, (size_t)order->size, &limits, &why);

    result->mesh = (struct vor_mesh){
        .triangle = cloud->triangles, .count = cloud->triangle_count, .polygons = cloud->polygons};
    if (status == VOR_OK)
        return VOR_OK;
    return vor_fail(err, status == VOR_E_NOMEM ? VOR_E_NOMEM : VOR_E_INTERNAL,
                    "the result cannot be read: %.900s", why.message);
}

static vor_status write_result(struct vor_codec_facts *facts, const struct vor_sink *sink,
                               const struct vor_codec_order *order, const struct result *result,
                               struct vor_error *err)
{
    const struct vor_format *format = vor_format(order->format);
    struct vor_result_facts known = {.spacing = order->spacing};
    struct vor_write_options options;
    vor_status status;

    vor_extent_measure(&known.input, &result->cloud);
    status = vor_write_options_from(&options, format, &order->spec, &known, err);
    if (status != VOR_OK)
        return status;
    options.mesh = &result->mesh;
    status = format->write(sink, &result->cloud, &options, err);
    if (status != VOR_OK)
        return status;
    *facts = (struct vor_codec_facts){.format = order->format,
                                      .points = result->cloud.n,
                                      .extent = known.input,
                                      .has_origin = options.has_origin};
    for (int k = 0; options.has_origin && k < 3; k++)
        facts->origin[k] = options.origin[k];
    return VOR_OK;
}

/* Reads what the engine made, whose triangles stay where they are. */
static vor_status load_result(struct result *result, const struct vor_codec_order *order,
                              const uint8_t *bytes, struct vor_error *err)
{
    const size_t triangle = 3 * sizeof(uint32_t);
    size_t size = (size_t)order->size;
    struct vor_error why;
    vor_status status;

    if (order->triangles > size / triangle || vor_format(order->format) == NULL)
        return vor_fail(err, VOR_E_INTERNAL, "the codec process received an invalid request");
    result->mesh = (struct vor_mesh){.triangle = (uint32_t *)(uintptr_t)bytes,
                                     .count = order->triangles,
                                     .polygons = order->polygons};
    size -= order->triangles * triangle;
    status = vor_dump_read(&result->cloud, bytes + order->triangles * triangle, size, &why);
    if (status == VOR_OK)
        return VOR_OK;
    return vor_fail(err, status == VOR_E_NOMEM ? VOR_E_NOMEM : VOR_E_INTERNAL,
                    "the result cannot be written: %.900s", why.message);
}

/* VOR_CODEC_CONVERT and VOR_CODEC_ENCODE. */
static vor_status write_again(struct vor_codec_facts *facts, const struct vor_sink *sink,
                              const struct vor_codec_order *order, const uint8_t *bytes,
                              struct vor_error *err)
{
    struct vor_write_options options = order->options;
    int is_made = order->op == VOR_CODEC_ENCODE; /* by the engine; else read from a file */
    struct vor_memory memory;
    struct result result = {.mesh = {.count = 0}};
    vor_status status;

    vor_memory_init(&memory, order->memory);
    vor_cloud_init(&result.cloud, &memory);
    status = (is_made ? load_result : read_result)(&result, order, bytes, err);
    options.mesh = &result.mesh;
    if (status == VOR_OK && is_made)
        status = vor_format(order->format)->write(sink, &result.cloud, &options, err);
    else if (status == VOR_OK)
        status = write_result(facts, sink, order, &result, err);
    vor_cloud_free(&result.cloud);
    if (status == VOR_OK && is_made)
        *facts = (struct vor_codec_facts){.memory = atomic_load(&memory.peak)};
    return status;
}

vor_status vor_codec_do(struct vor_codec_facts *facts, const struct vor_sink *sink,
                        const struct vor_codec_order *order, const uint8_t *bytes,
                        struct vor_error *err)
{
    vor_status status;

    switch (order->op) {
    case VOR_CODEC_DECODE:
        return decode(facts, sink, order, bytes, err);
    case VOR_CODEC_CONVERT:
    case VOR_CODEC_ENCODE:
        return write_again(facts, sink, order, bytes, err);
    case VOR_CODEC_INFLATE:
        status = vor_gzip_inflate(sink, bytes, (size_t)order->size, order->most, err);
        if (status == VOR_OK)
            *facts = (struct vor_codec_facts){0};
        return status;
    default:
        return vor_fail(err, VOR_E_INTERNAL,
                        "the codec process received an unknown operation, "
                        "%d",
                        (int)order->op);
    }
}
