#include "core/cloud/cloud.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct {
    size_t size;
    const char *ply, *sized;
} types[VOR_TYPE_COUNT] = {
#define TYPE_ROW(name, ctype, ply, sized) {sizeof(ctype), ply, sized},
    VOR_TYPE_TABLE(TYPE_ROW)
#undef TYPE_ROW
};

size_t vor_type_size(enum vor_type type)
{
    assert((unsigned)type < VOR_TYPE_COUNT);
    return types[type].size;
}

const char *vor_type_name(enum vor_type type)
{
    assert((unsigned)type < VOR_TYPE_COUNT);
    return types[type].ply[0] != '\0' ? types[type].ply : types[type].sized;
}

const char *vor_type_name_sized(enum vor_type type)
{
    assert((unsigned)type < VOR_TYPE_COUNT);
    return types[type].sized;
}

static int same(const char *word, const char *name, size_t length)
{
    return word[0] != '\0' && strlen(word) == length && memcmp(word, name, length) == 0;
}

int vor_type_parse(enum vor_type *out, const char *name, size_t length)
{
    for (int i = 0; i < VOR_TYPE_COUNT; i++) {
        if (!same(types[i].ply, name, length) && !same(types[i].sized, name, length))
            continue;
        *out = (enum vor_type)i;
        return 1;
    }
    return 0;
}

double vor_attribute_scalar(const struct vor_attribute *attribute, size_t at)
{
    switch (attribute->type) {
#define SCALAR_CASE(id, ctype, ply, sized)                                                         \
    case VOR_##id:                                                                                 \
        return (double)((const ctype *)attribute->data)[at];
        VOR_TYPE_TABLE(SCALAR_CASE)
#undef SCALAR_CASE
    case VOR_TYPE_COUNT:
        break;
    }
    return 0;
}

int vor_attribute_is_packed(const struct vor_attribute *attribute)
{
    const char *name = attribute->name;
    size_t length = strlen(name);

    if (attribute->type != VOR_FLOAT32 || attribute->components != 1 || length < 3 || length > 4)
        return 0;
    for (size_t i = 0; i < length; i++)
        if ((name[i] | 0x20) != "rgba"[i])
            return 0;
    return 1;
}

static size_t size_of(const struct vor_attribute *attribute)
{
    return attribute->components * vor_type_size(attribute->type);
}

static void store(void *data, enum vor_type type, size_t at, double value)
{
    switch (type) {
#define STORE_CASE(id, ctype, ply, sized)                                                          \
    case VOR_##id:                                                                                 \
        ((ctype *)data)[at] = (ctype)value;                                                        \
        break;
        VOR_TYPE_TABLE(STORE_CASE)
#undef STORE_CASE
    case VOR_TYPE_COUNT:
        break;
    }
}

static int is_real(const struct vor_attribute *attribute)
{
    return attribute->type == VOR_FLOAT32 || attribute->type == VOR_FLOAT64;
}

/* The mean of values; false where there is none that makes sense. */
static int find_mean(double value[16], const struct vor_attribute *from, const struct vor_mix *mix)
{
    double square = 0;

    if (vor_attribute_is_packed(from))
        return 0;
    if (!is_real(from) && (from->semantic != VOR_COLOR || vor_type_size(from->type) > 4))
        return 0;
    for (unsigned c = 0; c < from->components; c++) {
        value[c] = 0;
        for (unsigned k = 0; k < mix->count; k++)
            value[c] += mix->weight[k] *
                        vor_attribute_scalar(from, (size_t)mix->point[k] * from->components + c);
        square += value[c] * value[c];
        if (!is_real(from))
            value[c] = rint(value[c]);
    }
    if (from->semantic != VOR_NORMAL || !isfinite(square))
        return isfinite(square);
    for (unsigned c = 0; square > 0 && c < from->components; c++)
        value[c] /= sqrt(square);
    return square > 0;
}

void vor_attribute_mix(struct vor_attribute *to, size_t i, const struct vor_attribute *from,
                       const struct vor_mix *mix)
{
    size_t size = size_of(from);
    unsigned most = 0;
    double value[16];

    if (find_mean(value, from, mix)) {
        for (unsigned c = 0; c < from->components; c++)
            store(to->data, to->type, i * to->components + c, value[c]);
        return;
    }
    for (unsigned k = 1; k < mix->count; k++)
        if (mix->weight[k] > mix->weight[most])
            most = k;
    memcpy((char *)to->data + i * size, (const char *)from->data + mix->point[most] * size, size);
}

void vor_cloud_init(struct vor_cloud *cloud, struct vor_memory *memory)
{
    memset(cloud, 0, sizeof *cloud);
    cloud->memory = memory;
    cloud->position_type = VOR_FLOAT32;
}

void vor_cloud_free(struct vor_cloud *cloud)
{
    for (size_t i = 0; i < cloud->attribute_count; i++)
        vor_free(cloud->memory, cloud->attributes[i].data);
    VOR_FREE_ALL(cloud->memory, cloud->notes.remarks, cloud->triangles, cloud->exact, cloud->xyz);
    vor_cloud_init(cloud, cloud->memory);
}

vor_status vor_cloud_resize(struct vor_cloud *cloud, size_t n, struct vor_error *err)
{
    assert(cloud->n == 0 && cloud->attribute_count == 0);
    if (n == 0)
        return vor_fail(err, VOR_E_EMPTY, "the cloud has 0 points, want at least 1");
    if (n > VOR_POINTS_MAX) {
        vor_fail(err, VOR_E_LIMIT, "the cloud has %zu points, want 1 to %zu", n, VOR_POINTS_MAX);
        return vor_fail_over(err, VOR_E_LIMIT, VOR_POINTS_MAX, n);
    }
    cloud->xyz = vor_malloc(cloud->memory, n, 3 * sizeof *cloud->xyz);
    if (cloud->xyz == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    cloud->n = n;
    return VOR_OK;
}

/* As much of a name as most bytes hold, cut between characters of UTF-8. */
static int fit_name(const char *name, size_t most)
{
    size_t length = strlen(name);

    if (length <= most)
        return (int)length;
    for (length = most; length > 0 && ((unsigned char)name[length] & 0xc0) == 0x80;)
        length--;
    return (int)length;
}

/* The name itself, or the name with the first free suffix. */
static void unique_name(struct vor_cloud *cloud, const char *name, char *out, size_t size)
{
    enum { SUFFIX = 11 };
    char what[VOR_MEMBER_TEXT_SIZE];
    int whole = fit_name(name, size - 1);

    (void)snprintf(out, size, "%.*s", whole, name);
    for (unsigned i = 2; vor_cloud_find_name(cloud, out) != NULL; i++)
        (void)snprintf(out, size, "%.*s_%u", fit_name(name, size - 1 - SUFFIX), name, i);
    if (name[whole] == '\0')
        return;
    (void)snprintf(what, sizeof what, "name of %.*s", fit_name(name, sizeof what - 9), name);
    vor_dropped_add(cloud->notes.dropped, &cloud->notes.dropped_count, what, 1);
}

vor_status vor_cloud_add_attribute(struct vor_cloud *cloud, const char *name,
                                   enum vor_semantic semantic, enum vor_type type,
                                   unsigned components, struct vor_attribute **out,
                                   struct vor_error *err)
{
    struct vor_attribute *attribute;

    assert(cloud->n > 0 && components >= 1 && components <= 16);
    if (cloud->attribute_count == VOR_ATTRIBUTES_MAX)
        return vor_fail(err, VOR_E_LIMIT, "the cloud has more than %d attributes",
                        VOR_ATTRIBUTES_MAX);
    attribute = &cloud->attributes[cloud->attribute_count];
    attribute->data = vor_malloc(cloud->memory, cloud->n, components * vor_type_size(type));
    if (attribute->data == NULL)
        return vor_fail(err, VOR_E_NOMEM, "attribute %.48s of %zu points", name, cloud->n);
    unique_name(cloud, name, attribute->name, sizeof attribute->name);
    attribute->semantic = semantic;
    attribute->type = type;
    attribute->components = components;
    cloud->attribute_count++;
    if (out != NULL)
        *out = attribute;
    return VOR_OK;
}

static vor_status copy_attribute(struct vor_cloud *out, const struct vor_attribute *from,
                                 struct vor_error *err)
{
    struct vor_attribute *to;
    vor_status status = vor_cloud_add_attribute(out, from->name, from->semantic, from->type,
                                                from->components, NULL, err);

    if (status != VOR_OK)
        return status;
    to = &out->attributes[out->attribute_count - 1];
    memcpy(to->name, from->name, sizeof to->name); /* unchanged, however long */
    memcpy(to->data, from->data, out->n * from->components * vor_type_size(from->type));
    return VOR_OK;
}

static vor_status copy_exact(struct vor_cloud *out, const struct vor_cloud *in,
                             struct vor_error *err)
{
    if (in->exact == NULL)
        return VOR_OK;
    out->exact = vor_malloc(out->memory, in->n, 3 * sizeof *out->exact);
    if (out->exact == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", in->n);
    memcpy(out->exact, in->exact, in->n * 3 * sizeof *in->exact);
    return VOR_OK;
}

vor_status vor_cloud_copy(struct vor_cloud *out, const struct vor_cloud *in, struct vor_error *err)
{
    vor_status status = vor_cloud_resize(out, in->n, err);

    if (status != VOR_OK)
        return status;
    status = copy_exact(out, in, err);
    memcpy(out->xyz, in->xyz, in->n * 3 * sizeof *in->xyz);
    memcpy(out->origin, in->origin, sizeof out->origin);
    out->position_type = in->position_type;
    for (size_t i = 0; i < in->attribute_count && status == VOR_OK; i++)
        status = copy_attribute(out, &in->attributes[i], err);
    VOR_THEN(status, vor_notes_copy_remarks(&out->notes, &in->notes, out->memory, err));
    if (status != VOR_OK)
        vor_cloud_free(out);
    return status;
}

const struct vor_attribute *vor_cloud_find(const struct vor_cloud *cloud,
                                           enum vor_semantic semantic)
{
    for (size_t i = 0; i < cloud->attribute_count; i++)
        if (cloud->attributes[i].semantic == semantic)
            return &cloud->attributes[i];
    return NULL;
}

const struct vor_attribute *vor_cloud_find_name(const struct vor_cloud *cloud, const char *name)
{
    for (size_t i = 0; i < cloud->attribute_count; i++)
        if (strcmp(cloud->attributes[i].name, name) == 0)
            return &cloud->attributes[i];
    return NULL;
}

static vor_status double_bounds(const double *xyz, size_t n, double low[3], double high[3],
                                struct vor_error *err)
{
    for (int c = 0; c < 3; c++)
        low[c] = high[c] = xyz[c];
    for (size_t i = 0; i < 3 * n; i++) {
        if (!isfinite(xyz[i]))
            return vor_fail(err, VOR_E_NONFINITE,
                            "coordinate %c of point %zu is %g, want a finite number", "xyz"[i % 3],
                            i / 3, xyz[i]);
        low[i % 3] = fmin(low[i % 3], xyz[i]);
        high[i % 3] = fmax(high[i % 3], xyz[i]);
    }
    return VOR_OK;
}

/* About half an extent, so that relative coordinates are small: a multiple of 2^(exponent - 6). The
 * irrational summand (2 minus the golden ratio) keeps extents that people choose, such as 100, away
 * from where floor jumps; the bounds keep every coordinate within 2^24 multiples of the grid. */
static double half_extent(double extent, int exponent)
{
    double grid = ldexp(1.0, exponent - 25), step = ldexp(1.0, exponent - 6);
    double whole = rint(extent / grid) * grid, most = ldexp(1.0, exponent - 1);
    double half = floor(whole / 2 / step + 0.3819660113) * step;

    return fmin(fmax(half, whole - most), most);
}

vor_status vor_cloud_set_double(struct vor_cloud *cloud, const double *xyz, struct vor_error *err)
{
    double low[3], high[3], half[3], extent, grid;
    int exponent;
    vor_status status = double_bounds(xyz, cloud->n, low, high, err);

    if (status != VOR_OK)
        return status;
    extent = fmax(fmax(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
    if (!(extent <= FLT_MAX / 4))
        return vor_fail(err, VOR_E_NONFINITE, "the cloud spans %g, want at most %g", extent,
                        (double)FLT_MAX / 4);
    (void)frexp(extent, &exponent); /* extent < 2^exponent */
    if (exponent < -100)
        exponent = -100; /* keeps the grid clear of float32's denormals */
    if (rint(ldexp(extent, 25 - exponent)) == 0x1p25)
        exponent++; /* the upper corner rounds up to a power of two: the next time it is one */
    grid = ldexp(1.0, exponent - 25);
    for (int c = 0; c < 3; c++) {
        half[c] = half_extent(high[c] - low[c], exponent);
        cloud->origin[c] = low[c] + half[c];
    }
    /* A multiple of the grid, at most 2^24 of it from zero: exact in float32. */
    for (size_t i = 0; i < 3 * cloud->n; i++)
        cloud->xyz[i] = (float)(rint((xyz[i] - low[i % 3]) / grid) * grid - half[i % 3]);
    cloud->position_type = VOR_FLOAT64;
    return VOR_OK;
}

void vor_cloud_keep_double(struct vor_cloud *cloud, double **xyz)
{
    for (size_t i = 0; i < cloud->n; i++) {
        double at[3];

        vor_cloud_position(cloud, i, at);
        if (memcmp((const unsigned char *)at, (const unsigned char *)(*xyz + 3 * i), sizeof at) ==
            0)
            continue;
        cloud->exact = *xyz;
        *xyz = NULL;
        return;
    }
}

static void reorder_column(void *data, size_t size, const uint32_t *order, size_t n, void *scratch)
{
    for (size_t k = 0; k < n; k++)
        memcpy((char *)scratch + k * size, (const char *)data + order[k] * size, size);
    memcpy(data, scratch, n * size);
}

vor_status vor_cloud_copy_attribute(struct vor_cloud *cloud, const struct vor_attribute *from,
                                    const uint32_t *source, struct vor_error *err)
{
    size_t size = size_of(from);
    vor_status status = vor_cloud_add_attribute(cloud, from->name, from->semantic, from->type,
                                                from->components, NULL, err);
    char *to = status == VOR_OK ? cloud->attributes[cloud->attribute_count - 1].data : NULL;

    for (size_t i = 0; to != NULL && i < cloud->n; i++)
        memcpy(to + i * size, (const char *)from->data + source[i] * size, size);
    return status;
}

vor_status vor_cloud_reorder(struct vor_cloud *cloud, const uint32_t *order, struct vor_error *err)
{
    size_t widest = 3 * (cloud->exact != NULL ? sizeof *cloud->exact : sizeof *cloud->xyz);
    void *scratch;

    assert(cloud->triangle_count == 0);
    for (size_t i = 0; i < cloud->attribute_count; i++)
        if (size_of(&cloud->attributes[i]) > widest)
            widest = size_of(&cloud->attributes[i]);
    scratch = vor_malloc(cloud->memory, cloud->n, widest);
    if (scratch == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", cloud->n);
    reorder_column(cloud->xyz, 3 * sizeof *cloud->xyz, order, cloud->n, scratch);
    if (cloud->exact != NULL)
        reorder_column(cloud->exact, 3 * sizeof *cloud->exact, order, cloud->n, scratch);
    for (size_t i = 0; i < cloud->attribute_count; i++)
        reorder_column(cloud->attributes[i].data, size_of(&cloud->attributes[i]), order, cloud->n,
                       scratch);
    vor_free(cloud->memory, scratch);
    return VOR_OK;
}

void vor_cloud_position(const struct vor_cloud *cloud, size_t i, double out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = cloud->origin[c] + (double)cloud->xyz[3 * i + (size_t)c];
}

vor_status vor_cloud_check(const struct vor_cloud *cloud, struct vor_error *err)
{
    if (cloud->n == 0)
        return vor_fail(err, VOR_E_EMPTY, "the cloud has 0 points, want at least 1");
    for (int c = 0; c < 3; c++)
        if (!isfinite(cloud->origin[c]))
            return vor_fail(err, VOR_E_NONFINITE, "the origin's %c is %g, want a finite number",
                            "xyz"[c], cloud -> origin[c]);
    for (size_t i = 0; i < 3 * cloud->n; i++)
        if (!isfinite(cloud->xyz[i]))
            return vor_fail(err, VOR_E_NONFINITE,
                            "coordinate %c of point %zu is %g, want a finite number", "xyz"[i % 3],
                            i / 3, (double)cloud->xyz[i]);
    return VOR_OK;
}
