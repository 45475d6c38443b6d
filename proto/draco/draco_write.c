#include "core/base/memory.h"
#include "proto/draco/draco.h"
#include "proto/draco/draco_meter.h"
#include "proto/draco/draco_precheck.h"
#include "proto/draco/draco_quantize.h"
#include "proto/draco/draco_shim.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Outside of the kd-tree the encoder counts in a table how often each number comes: of 30 bits, it
 * would take 4 GB. What needs more bits than these is kept as it is. */
enum { SYMBOL_BITS_MAX = 20, INT32_RANGE = INT32_MAX - 1 };

/* A cloud on its way into a file. Column 0 is the positions, column i + 1 is attribute i. */
struct plan {
    const struct vor_cloud *cloud;
    const struct vor_mesh *mesh; /* NULL: a point cloud */
    struct vor_mesh filled;      /* the mesh, where it has too few faces */
    struct vor_draco_column columns[VOR_ATTRIBUTES_MAX + 1];
    int64_t *carriers[VOR_ATTRIBUTES_MAX + 1]; /* owned copies of columns in 64 bits */
    double origin[3];                          /* that positions are relative to */
    float *xyz;                                /* owned positions; NULL: those of the cloud */
    unsigned count;
    int reorders; /* kd-tree, or edgebreaker for a mesh; else sequential */
};

/* Moves the positions into the frame that is asked for. A coordinate whose origin stays is not
 * touched: adding 0 would turn -0 into 0. */
static vor_status choose_frame(struct plan *plan, const struct vor_write_options *options,
                               struct vor_error *err)
{
    const struct vor_cloud *cloud = plan->cloud;
    const double *origin = options->has_origin ? options->origin : cloud->origin;

    for (int c = 0; c < 3; c++)
        plan->origin[c] = origin[c];
    if (origin[0] == cloud->origin[0] && origin[1] == cloud->origin[1] &&
        origin[2] == cloud->origin[2])
        return VOR_OK;
    plan->xyz = vor_malloc(cloud->memory, cloud->n, 3 * sizeof *plan->xyz);
    if (plan->xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", cloud->n);
    for (size_t i = 0; i < 3 * cloud->n; i++) {
        double shift = cloud->origin[i % 3] - origin[i % 3];

        plan->xyz[i] = shift == 0 ? cloud->xyz[i] : (float)((double)cloud->xyz[i] + shift);
    }
    return VOR_OK;
}

/* The library reads a mesh of at most three points a face: faces of one point, at the end, make up
 * for those that are missing. */
static vor_status choose_faces(struct plan *plan, const struct vor_mesh *mesh,
                               struct vor_error *err)
{
    size_t least = (plan->cloud->n + 2) / 3;

    if (mesh == NULL || mesh->count == 0)
        return VOR_OK;
    plan->mesh = mesh;
    if (mesh->count >= least)
        return VOR_OK;
    plan->filled.memory = plan->cloud->memory;
    plan->filled.triangle = vor_calloc(plan->cloud->memory, least, 3 * sizeof *mesh->triangle);
    if (plan->filled.triangle == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu faces", least);
    memcpy(plan->filled.triangle, mesh->triangle, 3 * mesh->count * sizeof *mesh->triangle);
    plan->filled.count = least;
    plan->mesh = &plan->filled;
    return VOR_OK;
}

static void add_columns(struct plan *plan)
{
    /* By semantic; the name is what the reader calls an attribute without one. */
    static const struct {
        enum vor_draco_kind kind;
        const char *name;
    } rows[] = {
        [VOR_GENERIC] = {VOR_DRACO_GENERIC, "generic"},
        [VOR_NORMAL] = {VOR_DRACO_NORMAL, "normal"},
        [VOR_COLOR] = {VOR_DRACO_COLOR, "color"},
        [VOR_TEX_COORD] = {VOR_DRACO_TEX_COORD, "tex_coord"},
    };
    const struct vor_cloud *cloud = plan->cloud;

    plan->columns[0] =
        (struct vor_draco_column){.kind = VOR_DRACO_POSITION,
                                  .scalar = VOR_DRACO_FLOAT32,
                                  .components = 3,
                                  .data = plan->xyz != NULL ? plan->xyz : cloud->xyz};
    plan->count = 1 + (unsigned)cloud->attribute_count;
    for (unsigned i = 1; i < plan->count; i++) {
        const struct vor_attribute *attribute = &cloud->attributes[i - 1];
        int implied = strcmp(attribute->name, rows[attribute->semantic].name) == 0;

        plan->columns[i] =
            (struct vor_draco_column){.kind = rows[attribute->semantic].kind,
                                      .scalar = (enum vor_draco_scalar)attribute->type,
                                      .components = attribute->components,
                                      .data = attribute->data,
                                      .name = implied ? NULL : attribute->name};
    }
}

/* Whether floats are no measured numbers but hold bits, as colours or labels that were packed into
 * them: quantised, none would be kept. Integers of up to 24 bits look like numbers below 2^-125. */
static int holds_bits(const struct vor_attribute *attribute, size_t n)
{
    const float *value = attribute->data;

    if (attribute->type != VOR_FLOAT32 || attribute->components > 4)
        return 0;
    for (size_t i = 0; i < n * attribute->components; i++)
        if (value[i] != 0 && fabsf(value[i]) < 0x1p-125F)
            return 1;
    return vor_attribute_is_packed(attribute);
}

static vor_status quantize(struct plan *plan, const struct vor_write_options *options,
                           struct vor_error *err)
{
    size_t n = plan->cloud->n;
    struct vor_draco_column *position = &plan->columns[0];

    if (options->quantization_bits == 0)
        return VOR_OK;
    for (unsigned i = 1; i < plan->count; i++)
        if (holds_bits(&plan->cloud->attributes[i - 1], n)) {
            plan->columns[i].type = vor_type_name_sized(VOR_FLOAT32);
            plan->columns[i].scalar = VOR_DRACO_UINT8;
            plan->columns[i].components *= (unsigned)sizeof(float);
        } else if (plan->columns[i].scalar == VOR_DRACO_FLOAT32 &&
                   vor_draco_bound(&plan->columns[i], n)) {
            vor_draco_fit_attribute(&plan->columns[i], n);
        }
    if (!vor_draco_bound(position, n))
        return VOR_OK;
    if (options->quantization_bits < 0)
        return vor_draco_fit_positions(position, plan->cloud, options->spacing, err);
    position->bits = options->quantization_bits;
    return VOR_OK;
}

static int64_t int32_at(const struct vor_draco_column *column, size_t i)
{
    return column->scalar == VOR_DRACO_INT32 ? ((const int32_t *)column->data)[i]
                                             : (int64_t)((const uint32_t *)column->data)[i];
}

static void span_of(const struct vor_draco_column *column, size_t n, int64_t *low, int64_t *high)
{
    *low = *high = int32_at(column, 0);
    for (size_t i = 1; i < n * column->components; i++) {
        int64_t value = int32_at(column, i);

        *low = value < *low ? value : *low;
        *high = value > *high ? value : *high;
    }
}

/* The library computes in int32: outside of a kd-tree it refuses a UINT32 that leaves it, and
 * everywhere it loses an INT32 whose range does. */
static int fits_int32(const struct vor_draco_column *column, size_t n, int64_t range)
{
    int64_t low, high;

    span_of(column, n, &low, &high);
    return high <= INT32_MAX && high - low <= range;
}

/* Sequential encoding codes the step to each point from the one before it, and to the first one
 * from the number next to 0 within the range. */
static int sequence_takes_int32(const struct vor_draco_column *column, size_t n)
{
    unsigned components = column->components;
    int64_t low, high, first;

    span_of(column, n, &low, &high);
    first = low > 0 ? low : high < 0 ? high : 0;
    for (size_t i = 0; i < n * components; i++) {
        int64_t before = i < components ? first : int32_at(column, i - components);

        if (llabs(int32_at(column, i) - before) > 1 << SYMBOL_BITS_MAX)
            return 0;
    }
    return fits_int32(column, n, INT32_RANGE);
}

static int kd_tree_possible(const struct plan *plan)
{
    size_t n = plan->cloud->n, scalars = 0;

    for (unsigned i = 0; i < plan->count; i++) {
        const struct vor_draco_column *column = &plan->columns[i];

        if ((column->scalar == VOR_DRACO_FLOAT32 && column->bits <= 0) ||
            (column->scalar == VOR_DRACO_INT32 && !fits_int32(column, n, INT32_RANGE)) ||
            column->scalar == VOR_DRACO_FLOAT64 || column->scalar == VOR_DRACO_INT64 ||
            column->scalar == VOR_DRACO_UINT64)
            return 0;
        scalars += column->components;
    }
    return scalars > 0 && scalars <= VOR_DRACO_KD_SCALARS && n <= INT32_MAX / scalars;
}

/* Outside of the kd-tree a quantised normal becomes a direction: that loses any other length. */
static int are_unit_vectors(const struct vor_draco_column *column, size_t n)
{
    const float *v = column->data;

    if (column->components != 3)
        return 0;
    for (size_t i = 0; i < n; i++, v += 3) {
        double square = (double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2];

        if (!(fabs(square - 1) < 1e-3))
            return 0;
    }
    return 1;
}

static vor_status carry(struct plan *plan, unsigned i, struct vor_error *err)
{
    struct vor_draco_column *column = &plan->columns[i];
    size_t count = plan->cloud->n * column->components;
    int64_t *wide = vor_malloc(plan->cloud->memory, count, sizeof *wide);

    if (wide == NULL)
        return vor_fail(err, VOR_E_NOMEM, "64-bit copy of attribute %s",
                        plan->cloud->attributes[i - 1].name);
    for (size_t k = 0; k < count; k++)
        wide[k] = int32_at(column, k);
    column->type = vor_type_name_sized((enum vor_type)column->scalar);
    column->scalar = VOR_DRACO_INT64;
    column->data = wide;
    plan->carriers[i] = wide;
    return VOR_OK;
}

/* Prepares the columns for every encoding but the kd-tree. */
static vor_status leave_kd_tree(struct plan *plan, struct vor_error *err)
{
    size_t n = plan->cloud->n;
    vor_status status = VOR_OK;

    for (unsigned i = 0; status == VOR_OK && i < plan->count; i++) {
        struct vor_draco_column *column = &plan->columns[i];

        if (column->kind == VOR_DRACO_NORMAL && column->bits > 0)
            column->bits = are_unit_vectors(column, n) ? VOR_DRACO_NORMAL_BITS : 0;
        if (column->bits > SYMBOL_BITS_MAX)
            column->bits = 0;
        /* Edgebreaker guesses a value from three others: it may be off by all of their range. */
        if ((column->scalar == VOR_DRACO_INT32 || column->scalar == VOR_DRACO_UINT32) &&
            !(plan->reorders ? fits_int32(column, n, 1 << SYMBOL_BITS_MAX)
                             : sequence_takes_int32(column, n)))
            status = carry(plan, i, err);
    }
    return status;
}

/* Between the encoder and the sink: what we write, we must be able to read. */
struct taker {
    const struct vor_sink *sink;
    int absurd; /* the gate would refuse the file */
    int loses;  /* edgebreaker cannot hold the mesh */
};

static int take(void *ctx, const void *bytes, size_t size)
{
    static const struct vor_limits limits = {.points = SIZE_MAX};
    struct taker *taker = ctx;

    taker->absurd = vor_draco_precheck(bytes, size, &limits, NULL) != VOR_OK;
    return taker->absurd ? -1 : taker->sink->write(taker->sink->ctx, bytes, size);
}

static vor_status encode(const struct plan *plan, struct taker *taker, int compression,
                         struct vor_error *err)
{
    const struct vor_cloud *cloud = plan->cloud;
    struct vor_alloc_budget budget = {.memory = cloud->memory, .most = SIZE_MAX};
    struct vor_draco_meter meter = vor_alloc_budget_meter(&budget);
    int relative = cloud->position_type == VOR_FLOAT64 || plan->origin[0] != 0 ||
                   plan->origin[1] != 0 || plan->origin[2] != 0;
    struct vor_draco_source source = {.n = cloud->n,
                                      .count = plan->count,
                                      .columns = plan->columns,
                                      .origin = relative ? plan->origin : NULL,
                                      .position_type = vor_type_name_sized(cloud->position_type),
                                      .reorders = plan->reorders,
                                      .speed = 10 - compression};
    char message[96];

    if (plan->mesh != NULL) {
        source.triangles = plan->mesh->triangle;
        source.triangle_count = plan->mesh->count;
    }

    switch (vor_draco_encode(&source, &meter, taker, take, message)) {
    case VOR_DRACO_DONE:
        return VOR_OK;
    case VOR_DRACO_NO_MEMORY:
        return vor_fail(err, VOR_E_NOMEM, "encoding %zu points as Draco", cloud->n);
    case VOR_DRACO_NOT_TAKEN:
        return vor_fail(err, VOR_E_IO, "the Draco file cannot be written");
    default:
        taker->loses = plan->mesh != NULL && plan->reorders;
        return vor_fail(err, VOR_E_INTERNAL, "the Draco library cannot encode %zu points: %s",
                        cloud->n, message);
    }
}

static vor_status encode_readably(struct plan *plan, const struct vor_sink *sink, int compression,
                                  struct vor_error *err)
{
    struct taker taker = {.sink = sink};
    vor_status status = VOR_OK;

    if (!plan->reorders || plan->mesh != NULL)
        status = leave_kd_tree(plan, err);
    VOR_THEN(status, encode(plan, &taker, compression, err));
    if (taker.loses) {
        /* A mesh with points that are no face's, or edges of more than two faces, that edgebreaker
         * cannot hold. */
        plan->reorders = 0;
        taker.loses = 0;
        status = leave_kd_tree(plan, err);
        VOR_THEN(status, encode(plan, &taker, compression, err));
    }
    if (!taker.absurd)
        return status;
    /* A file of next to no bytes for its points (all in one place, say) looks like a bomb. */
    plan->reorders = 0;
    for (unsigned i = 0; i < plan->count; i++)
        plan->columns[i].bits = 0;
    status = leave_kd_tree(plan, err);
    return status == VOR_OK ? encode(plan, &taker, compression, err) : status;
}

/* The library counts scalars, and corners of faces, in int. */
static vor_status check_size(const struct vor_cloud *cloud, const struct vor_mesh *mesh,
                             struct vor_error *err)
{
    const int has_faces = mesh != NULL && mesh->count > INT32_MAX / 3;
    char what[40] = "faces";
    size_t components = 3, got = has_faces ? mesh->count : cloud->n, limit = INT32_MAX / 3;

    for (size_t i = 0; i < cloud->attribute_count; i++)
        if (cloud->attributes[i].components > components)
            components = cloud->attributes[i].components;
    if (!has_faces) {
        limit = INT32_MAX / components;
        (void)snprintf(what, sizeof what, "points of %zu scalars", components);
    }
    if (got <= limit)
        return VOR_OK;
    (void)vor_fail(err, VOR_E_LIMIT, "the result has %zu %s, but a Draco file can have at most %zu",
                   got, what, limit);
    return vor_fail_over(err, VOR_E_LIMIT, limit, got);
}

vor_status vor_draco_write(const struct vor_sink *sink, const struct vor_cloud *cloud,
                           const struct vor_write_options *options, struct vor_error *err)
{
    struct plan *plan = NULL;
    vor_status status = vor_cloud_check(cloud, err);

    assert(options->quantization_bits >= -1 && options->quantization_bits <= 30);
    assert(options->compression >= 0 && options->compression <= 10);
    VOR_THEN(status, check_size(cloud, options->mesh, err));
    if (status != VOR_OK)
        return status;
    plan = vor_calloc(cloud->memory, 1, sizeof *plan);
    if (plan == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu attributes", cloud->attribute_count);
    plan->cloud = cloud;
    status = choose_faces(plan, options->mesh, err);
    VOR_THEN(status, choose_frame(plan, options, err));
    if (status != VOR_OK)
        goto done;
    add_columns(plan);
    status = quantize(plan, options, err);
    if (status != VOR_OK)
        goto done;
    /* Edgebreaker loses points of no face, which there are where faces are filled up. */
    plan->reorders = !options->keep_order &&
                     (plan->mesh != NULL ? plan->mesh != &plan->filled : kd_tree_possible(plan));
    status = encode_readably(plan, sink, options->compression, err);
done:
    for (unsigned i = 0; i < plan->count; i++)
        vor_free(cloud->memory, plan->carriers[i]);
    vor_free(cloud->memory, plan->xyz);
    vor_free(cloud->memory, plan->filled.triangle);
    vor_free(cloud->memory, plan);
    return status;
}
