#include "core/base/memory.h"
#include "core/cloud/sift.h"
#include "proto/draco/draco.h"
#include "proto/draco/draco_meter.h"
#include "proto/draco/draco_precheck.h"
#include "proto/draco/draco_shim.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* What the library may hold at a time, whatever the allocator's cap. */
static const size_t MEMORY_FREE = (size_t)64 << 20;
static const size_t MEMORY_PER_POINT = 40;

/* A file on its way into a cloud. */
struct load {
    const struct vor_draco_decoded *decoded;
    struct vor_cloud *cloud;
    const struct vor_limits *limits;
    size_t n;
    unsigned position; /* index of the attribute */
    int has_origin;    /* in the metadata, with the type that positions had */
    double origin[3];
    char type[16];
    struct vor_error *err;
};

static vor_status decode(struct vor_draco_decoded **out, struct vor_alloc_budget *budget,
                         const uint8_t *bytes, size_t size, struct vor_error *err)
{
    struct vor_draco_meter meter = vor_alloc_budget_meter(budget);
    size_t held = atomic_load(&budget->memory->used), used = size;
    size_t left = held < budget->memory->cap ? budget->memory->cap - held : 0;
    size_t zeros = 0;
    char message[96];

    switch (vor_draco_decode(out, &meter, bytes, &used, message)) {
    case VOR_DRACO_DONE:
        while (used + zeros < size && zeros < VOR_DRACO_PADDING_MAX && bytes[used + zeros] == 0)
            zeros++;
        if (used + zeros == size)
            return VOR_OK;
        (void)vor_fail(
            err, VOR_E_FORMAT,
            "the Draco data ends after %zu of %zu bytes; only up to %d zero bytes may follow the "
            "data",
            used, size, VOR_DRACO_PADDING_MAX);
        return vor_fail_at(err, VOR_E_FORMAT, used);
    case VOR_DRACO_NO_MEMORY:
        return vor_fail(err, VOR_E_NOMEM,
                        "decoding %zu bytes of Draco needs more than %zu bytes of memory", size,
                        left < budget->most ? left : budget->most);
    default:
        return vor_fail(err, VOR_E_FORMAT,
                        "the Draco file is damaged or cut short; the Draco library says: %s",
                        message[0] != '\0' ? message : "no reason given");
    }
}

static vor_status describe(const struct load *load, unsigned index, struct vor_draco_info *info)
{
    if (vor_draco_describe(load->decoded, index, info) != VOR_DRACO_DONE)
        return vor_fail(load->err, VOR_E_FORMAT, "attribute %u has an unknown type", index);
    if (info->components < 1 || info->components > 16)
        return vor_fail(load->err, VOR_E_FORMAT, "attribute %u has %u components, want 1 to 16",
                        index, info->components);
    return VOR_OK;
}

static vor_status find_position(struct load *load)
{
    unsigned count = vor_draco_attributes(load->decoded);
    struct vor_draco_info info;

    for (unsigned i = 0; i < count; i++) {
        vor_status status = describe(load, i, &info);

        if (status != VOR_OK)
            return status;
        if (info.kind != VOR_DRACO_POSITION)
            continue;
        if (info.components != 3)
            return vor_fail(load->err, VOR_E_FORMAT, "positions have %u components, want 3",
                            info.components);
        load->position = i;
        return VOR_OK;
    }
    return vor_fail(load->err, VOR_E_FORMAT,
                    "the Draco file has %u attributes, but none is a position", count);
}

static vor_status copy_values(const struct load *load, unsigned index, void *out)
{
    if (vor_draco_values(load->decoded, index, out) != VOR_DRACO_DONE)
        return vor_fail(load->err, VOR_E_FORMAT,
                        "attribute %u has no value for at least one "
                        "point",
                        index);
    return VOR_OK;
}

static vor_status load_wide_positions(const struct load *load, enum vor_type type)
{
    struct vor_memory *memory = load->cloud->memory;
    void *raw = vor_malloc(memory, load->n, 3 * vor_type_size(type));
    double *xyz = vor_malloc(memory, load->n, 3 * sizeof *xyz);
    vor_status status;

    if (raw == NULL || xyz == NULL) {
        status = vor_fail(load->err, VOR_E_NOMEM, "%zu points", load->n);
        goto done;
    }
    status = copy_values(load, load->position, raw);
    if (status != VOR_OK)
        goto done;
    switch (type) {
#define WIDEN(name, ctype, ply, sized)                                                             \
    case VOR_##name:                                                                               \
        for (size_t i = 0; i < 3 * load->n; i++)                                                   \
            xyz[i] = (double)((const ctype *)raw)[i];                                              \
        break;
        VOR_TYPE_TABLE(WIDEN)
#undef WIDEN
    case VOR_TYPE_COUNT:
        break;
    }
    status = vor_cloud_sift(load->cloud, xyz, load->limits->drop_invalid, load->err);
    for (size_t i = 0; status == VOR_OK && load->has_origin && i < 3 * load->cloud->n; i++)
        xyz[i] += load->origin[i % 3];
    VOR_THEN(status, vor_cloud_set_double(load->cloud, xyz, load->err));
    if (status == VOR_OK && load->limits->keep_doubles)
        vor_cloud_keep_double(load->cloud, &xyz);
done:
    vor_free(memory, xyz);
    vor_free(memory, raw);
    return status;
}

/* Comes last: points that are dropped go with all their values. */
static vor_status load_positions(const struct load *load)
{
    struct vor_draco_info info;
    vor_status status = describe(load, load->position, &info);

    if (status != VOR_OK)
        return status;
    if (info.scalar != VOR_DRACO_FLOAT32)
        return load_wide_positions(load, (enum vor_type)info.scalar);
    status = copy_values(load, load->position, load->cloud->xyz);
    VOR_THEN(status, vor_cloud_sift(load->cloud, NULL, load->limits->drop_invalid, load->err));
    if (status == VOR_OK && load->has_origin) {
        memcpy(load->cloud->origin, load->origin, sizeof load->origin);
        load->cloud->position_type =
            strcmp(load->type, vor_type_name_sized(VOR_FLOAT64)) == 0 ? VOR_FLOAT64 : VOR_FLOAT32;
    }
    return status;
}

/* The writer carries 32-bit integers that the library cannot encode in 64 bits and says so. */
static int narrow(struct vor_attribute *attribute, size_t n, enum vor_type type)
{
    size_t count = n * attribute->components;
    const int64_t *wide = attribute->data;
    int32_t *thin = attribute->data;
    int64_t low = type == VOR_INT32 ? INT32_MIN : 0;
    int64_t high = type == VOR_INT32 ? INT32_MAX : UINT32_MAX;

    for (size_t i = 0; i < count; i++)
        if (wide[i] < low || wide[i] > high)
            return 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t bits = (uint32_t)wide[i];

        memcpy(&thin[i], &bits, sizeof bits);
    }
    attribute->type = type;
    return 1;
}

static vor_status load_attribute(const struct load *load, unsigned index)
{
    static const char *const implied[] = {"position", "normal", "color", "tex_coord", "generic"};
    struct vor_draco_info info;
    struct vor_attribute *attribute;
    enum vor_type type = VOR_TYPE_COUNT;
    enum vor_semantic semantic = VOR_GENERIC;
    vor_status status = describe(load, index, &info);

    if (status != VOR_OK)
        return status;
    (void)vor_type_parse(&type, info.type, strlen(info.type));
    if (type == VOR_FLOAT32 && info.scalar == VOR_DRACO_UINT8 && info.components % 4 == 0) {
        info.scalar = VOR_DRACO_FLOAT32; /* the writer carries bits in bytes and says so */
        info.components /= 4;
    }
    if (info.name[0] == '\0')
        (void)snprintf(info.name, sizeof info.name, "%s", implied[info.kind]);
    for (char *c = info.name; *c != '\0'; c++) /* a stranger's: it ends up in headers and logs */
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            *c = '_';
    if (info.kind == VOR_DRACO_NORMAL && info.components == 3)
        semantic = VOR_NORMAL;
    else if (info.kind == VOR_DRACO_COLOR && (info.components == 3 || info.components == 4))
        semantic = VOR_COLOR;
    else if (info.kind == VOR_DRACO_TEX_COORD && (info.components == 2 || info.components == 3))
        semantic = VOR_TEX_COORD;
    status = vor_cloud_add_attribute(load->cloud, info.name, semantic, (enum vor_type)info.scalar,
                                     info.components, &attribute, load->err);
    if (status != VOR_OK)
        return status;
    if (semantic == VOR_GENERIC && info.kind != VOR_DRACO_GENERIC) {
        char what[VOR_MEMBER_TEXT_SIZE];

        (void)snprintf(what, sizeof what, "meaning of %.50s", attribute->name);
        vor_dropped_add(load->cloud->notes.dropped, &load->cloud->notes.dropped_count, what, 1);
    }
    status = copy_values(load, index, attribute->data);
    if (status == VOR_OK && attribute->type == VOR_INT64 &&
        (type == VOR_INT32 || type == VOR_UINT32))
        (void)narrow(attribute, load->n, type);
    return status;
}

/* The faces, if they are wanted. */
static vor_status load_faces(const struct load *load)
{
    struct vor_cloud *cloud = load->cloud;
    size_t faces = vor_draco_faces(load->decoded);

    cloud->notes.faces = faces;
    if (faces == 0 || !load->limits->keep_faces) {
        vor_dropped_add(cloud->notes.dropped, &cloud->notes.dropped_count, "face", faces);
        return VOR_OK;
    }
    cloud->triangles = vor_malloc(cloud->memory, faces, 3 * sizeof *cloud->triangles);
    if (cloud->triangles == NULL)
        return vor_fail(load->err, VOR_E_NOMEM, "%zu faces", faces);
    cloud->triangle_count = faces;
    if (vor_draco_corners(load->decoded, cloud->triangles) != VOR_DRACO_DONE)
        return vor_fail(load->err, VOR_E_FORMAT, "a face refers to a point that does not exist");
    if (load->limits->keep_faces == VOR_FACES_KEPT) {
        size_t kept = 0;

        /* Triangles of one point, which vor_draco_write fills up with, are left out. */
        for (size_t i = 0; i < faces; i++) {
            const uint32_t *corner = cloud->triangles + 3 * i;

            if (corner[0] == corner[1] && corner[0] == corner[2])
                continue;
            memmove(cloud->triangles + 3 * kept, corner, 3 * sizeof *corner);
            kept++;
        }
        cloud->triangle_count = kept;
    }
    return VOR_OK;
}

static vor_status load_cloud(struct load *load)
{
    size_t most = load->limits->points;
    vor_status status = find_position(load);

    load->n = vor_draco_points(load->decoded);
    load->has_origin = vor_draco_origin(load->decoded, load->origin, load->type) &&
                       isfinite(load->origin[0]) && isfinite(load->origin[1]) &&
                       isfinite(load->origin[2]);
    if (status != VOR_OK)
        return status;
    if (load->n > most) {
        (void)vor_fail(load->err, VOR_E_LIMIT, "the Draco file holds %zu points, want at most %zu",
                       load->n, most);
        return vor_fail_over(load->err, VOR_E_LIMIT, most, load->n);
    }
    status = vor_cloud_resize(load->cloud, load->n, load->err);
    for (unsigned i = 0; status == VOR_OK && i < vor_draco_attributes(load->decoded); i++)
        if (i != load->position)
            status = load_attribute(load, i);
    vor_dropped_add(load->cloud->notes.dropped, &load->cloud->notes.dropped_count, "metadata",
                    vor_draco_metadata(load->decoded));
    VOR_THEN(status, load_faces(load));
    VOR_THEN(status, load_positions(load));
    return status == VOR_OK ? vor_cloud_check(load->cloud, load->err) : status;
}

vor_status vor_draco_read(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                          const struct vor_limits *limits, struct vor_error *err)
{
    struct vor_alloc_budget budget = {.memory = out->memory, .most = MEMORY_FREE};
    struct vor_draco_decoded *decoded = NULL;
    struct load load = {.cloud = out, .limits = limits, .err = err};
    vor_status status = vor_draco_precheck(bytes, size, limits, err);

    if (status != VOR_OK)
        return status;
    budget.most += MEMORY_PER_POINT * vor_draco_points_max(size, limits);
    status = decode(&decoded, &budget, bytes, size, err);
    load.decoded = decoded;
    VOR_THEN(status, load_cloud(&load));
    vor_draco_free(decoded);
    if (status != VOR_OK)
        vor_cloud_free(out);
    return status;
}
