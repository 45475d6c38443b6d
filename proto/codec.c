#include "proto/codec.h"

#include "core/base/quote.h"
#include "core/cloud/faces.h"
#include "proto/draco/draco.h"
#include "proto/origin.h"
#include "proto/ply/ply.h"
#include "proto/ply/ply_header.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/* In the order of the words of parameter `format`. */
static const struct vor_format formats[] = {
    [VOR_FORMAT_PLY] = {"ply", "PLY", "application/ply", ".ply", "ply", 1, 0, 0, vor_ply_read,
                        vor_ply_write, 0, 1, 0},
    [VOR_FORMAT_DRC] = {"drc", "Draco", "application/draco", ".drc", "DRACO", 0, 1, 1,
                        vor_draco_read, vor_draco_write, 1, 0, 1},
};

enum { FORMAT_COUNT = sizeof formats / sizeof formats[0] };

/* Neither format has a registered media type; these are in use. */
static const struct {
    const char *media_type;
    unsigned format;
} aliases[] = {
    {"model/ply", VOR_FORMAT_PLY},       {"application/x-ply", VOR_FORMAT_PLY},
    {"model/draco", VOR_FORMAT_DRC},     {"application/vnd.draco", VOR_FORMAT_DRC},
    {"model/vnd.draco", VOR_FORMAT_DRC},
};

void vor_limits_want(struct vor_limits *limits, const struct vor_spec *spec)
{
    limits->drop_invalid = spec->value[VOR_PARAM_INVALID] == VOR_INVALID_DROP;
    limits->keep_doubles = vor_spec_keeps_points(spec);
    limits->keep_faces = (int)vor_spec_faces(spec);
}

const struct vor_format *vor_format(unsigned index)
{
    return index < FORMAT_COUNT ? &formats[index] : NULL;
}

const struct vor_format *vor_format_sniff(const uint8_t *bytes, size_t size)
{
    for (unsigned i = 0; i < FORMAT_COUNT; i++) {
        size_t length = strlen(formats[i].magic);
        int is = size >= length && memcmp(bytes, formats[i].magic, length) == 0;

        /* "ply" alone is too little: its line must end there. */
        if (i == VOR_FORMAT_PLY ? !vor_ply_is(bytes, size) : !is)
            continue;
        return &formats[i];
    }
    return NULL;
}

const struct vor_format *vor_format_by_suffix(const char *path)
{
    size_t length = strlen(path);

    for (unsigned i = 0; i < FORMAT_COUNT; i++) {
        size_t tail = strlen(formats[i].suffix);

        if (length >= tail && strcasecmp(path + length - tail, formats[i].suffix) == 0)
            return &formats[i];
    }
    return NULL;
}

const struct vor_format *vor_format_by_media_type(const char *media_type)
{
    const char *begin = media_type + strspn(media_type, " \t");
    size_t length = strcspn(begin, "; \t");

    for (unsigned i = 0; i < FORMAT_COUNT; i++)
        if (strlen(formats[i].media_type) == length &&
            strncasecmp(begin, formats[i].media_type, length) == 0)
            return &formats[i];
    for (size_t i = 0; i < sizeof aliases / sizeof aliases[0]; i++)
        if (strlen(aliases[i].media_type) == length &&
            strncasecmp(begin, aliases[i].media_type, length) == 0)
            return &formats[aliases[i].format];
    return NULL;
}

vor_status vor_codec_read(struct vor_cloud *out, const struct vor_format **format,
                          const uint8_t *bytes, size_t size, const struct vor_limits *limits,
                          struct vor_error *err)
{
    const struct vor_format *found = vor_format_sniff(bytes, size);
    vor_status status;

    if (found == NULL) {
        const struct vor_foreign *foreign = size > 0 ? vor_foreign_sniff(bytes, size) : NULL;

        if (size == 0)
            vor_fail(err, VOR_E_UNSUPPORTED, "the input is empty, want a PLY or a Draco file");
        else if (foreign != NULL)
            vor_fail(err, VOR_E_UNSUPPORTED, "the input is %s, want PLY or Draco: %s",
                     foreign->name, foreign->hint);
        else
            vor_fail(err, VOR_E_UNSUPPORTED,
                     "the input begins with \"%s\", want \"ply\" and a line end, or \"DRACO\"",
                     VOR_QUOTED(80, bytes, size < 16 ? size : 16));
        if (err != NULL)
            err->byte_offset = 0;
        return VOR_E_UNSUPPORTED;
    }
    if (format != NULL)
        *format = found;
    status = found->read(out, bytes, size, limits, err);
    if (status != VOR_OK)
        return status;
    out->notes.format = (unsigned)(found - formats);
    status = vor_cloud_check(out, err);
    if (status == VOR_OK && limits->keep_faces == VOR_FACES_NEEDED)
        status = vor_faces_check(out, err);
    if (status != VOR_OK)
        vor_cloud_free(out);
    return status;
}

vor_status vor_write_options_from(struct vor_write_options *out, const struct vor_format *format,
                                  const struct vor_spec *spec, const struct vor_result_facts *facts,
                                  struct vor_error *err)
{
    double bits = spec->value[VOR_PARAM_QUANTIZATION];
    struct vor_write_options options = {
        .quantization_bits = bits == VOR_UNSET ? -1 : (int)bits,
        .compression = (int)spec->value[VOR_PARAM_COMPRESSION],
        .keep_order = spec->value[VOR_PARAM_ORDER] == VOR_ORDER_PROGRESSIVE,
        .spacing = facts->spacing > 0 ? facts->spacing : 0,
        .has_origin = format->takes_origin,
    };
    double spacing = options.spacing > 0
                         ? options.spacing
                         : vor_extent_spacing(&facts->input, (double)facts->input.n);
    vor_status status = VOR_OK;

    if (format->takes_origin)
        status = vor_origin_resolve(options.origin, spec, &facts->input, spacing, err);
    if (status == VOR_OK)
        *out = options;
    return status;
}

vor_status vor_write_check(const struct vor_format *format, const struct vor_spec *spec,
                           const struct vor_extent *input, struct vor_error *err)
{
    return format->takes_origin ? vor_origin_check(spec, input, err) : VOR_OK;
}

/* Counts the integers of 64 bits that no double holds: those with bits further apart than 53. */
static uint64_t count_rounded(const struct vor_attribute *attribute, size_t n)
{
    uint64_t count = 0, bits;

    if (attribute->type != VOR_INT64 && attribute->type != VOR_UINT64)
        return 0;
    for (size_t i = 0; i < n * attribute->components; i++) {
        memcpy(&bits, (const char *)attribute->data + i * sizeof bits, sizeof bits);
        if (attribute->type == VOR_INT64 && bits >> 63 != 0)
            bits = -bits;
        count += bits != 0 && (bits >> __builtin_ctzll(bits)) >> 53 != 0;
    }
    return count;
}

/* Counts the points whose doubles a file without loss rounds all the same. Of quantisation nobody
 * expects them. */
static uint64_t count_narrowed(const struct vor_report *report, const struct vor_cloud *cloud,
                               const struct vor_format *format)
{
    uint64_t count = 0;

    if (cloud->exact == NULL || !format->takes_origin ||
        report->parameters.value[VOR_PARAM_QUANTIZATION] != 0)
        return 0;
    for (size_t i = 0; i < cloud->n; i++) {
        double at[3];

        vor_cloud_position(cloud, i, at);
        count += memcmp((const unsigned char *)at, (const unsigned char *)&cloud->exact[3 * i],
                        sizeof at) != 0;
    }
    return count;
}

void vor_codec_report_dropped(struct vor_report *report, const struct vor_cloud *cloud,
                              const struct vor_mesh *mesh, const struct vor_format *format)
{
    static const char *const words[] = {"comment", "obj_info"};
    char what[VOR_MEMBER_TEXT_SIZE];

    vor_dropped_add(report->dropped, &report->dropped_count, "digits of positions",
                    count_narrowed(report, cloud, format));
    for (size_t i = 0; i < cloud->attribute_count; i++) {
        const char *name = cloud->attributes[i].name;

        (void)snprintf(what, sizeof what, "name of %.50s", name);
        vor_dropped_add(report->dropped, &report->dropped_count, what,
                        !format->has_blanks && strchr(name, ' ') != NULL);
        (void)snprintf(what, sizeof what, "digits of %.50s", name);
        vor_dropped_add(report->dropped, &report->dropped_count, what,
                        format->has_int64 ? 0 : count_rounded(&cloud->attributes[i], cloud->n));
    }
    if (mesh != NULL && !format->has_polygons) {
        uint64_t polygons = 0; /* faces of more than three corners */

        for (size_t t = 0, run; t < mesh->count; t += run) {
            run = vor_mesh_run(mesh, t);
            polygons += run > 1;
        }
        vor_dropped_add(report->dropped, &report->dropped_count, "polygon, cut into triangles",
                        polygons);
    }
    for (size_t i = 0; !format->has_remarks && i < sizeof words / sizeof words[0]; i++)
        vor_dropped_add(report->dropped, &report->dropped_count, words[i],
                        vor_notes_remarks(&cloud->notes, words[i]));
}
