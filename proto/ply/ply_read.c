#include "proto/ply/ply.h"

#include "core/cloud/sift.h"
#include "proto/ply/ply_body.h"
#include "proto/ply/ply_faces.h"
#include "proto/ply/ply_notes.h"

#include <stdio.h>

/* An attribute of several properties. */
struct group {
    const char *attribute;
    enum vor_semantic semantic;
    unsigned least, most; /* properties that make it; the ones past `least` may be missing */
    const char *parts[4];
};

static const struct group groups[] = {
    {"normal", VOR_NORMAL, 3, 3, {"nx", "ny", "nz", ""}},
    {"normal", VOR_NORMAL, 3, 3, {"normal_x", "normal_y", "normal_z", ""}},
    {"color", VOR_COLOR, 3, 4, {"red", "green", "blue", "alpha"}},
    {"color", VOR_COLOR, 3, 4, {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"}},
    {"color", VOR_COLOR, 3, 4, {"r", "g", "b", "a"}},
    {"tex_coord", VOR_TEX_COORD, 2, 3, {"tex_coord_0", "tex_coord_1", "tex_coord_2", ""}},
};

enum { GROUP_COUNT = sizeof groups / sizeof groups[0], ABSENT = VOR_PLY_PROPERTIES_MAX };

/* What is known while a file is read; freed as a whole. */
struct reader {
    struct vor_cloud cloud;
    struct vor_ply_header header;
    const struct vor_ply_element *vertex;
    struct vor_ply_body body;
    struct vor_ply_rows rows;
    double *wide; /* n x 3 coordinates, where they are not float32 */
    struct vor_ply_faces faces;
    int keep_faces;
};

static vor_status find_vertex(struct reader *reader, const struct vor_limits *limits,
                              struct vor_error *err)
{
    const struct vor_ply_header *header = &reader->header;
    const struct vor_ply_element *element = NULL;
    size_t most = limits->points < VOR_POINTS_MAX ? limits->points : VOR_POINTS_MAX;

    for (unsigned i = 0; i < header->element_count; i++) {
        const struct vor_ply_element *one = &header->elements[i];
        int is_exact = vor_ply_named(one->name, one->name_length, "vertex");

        if (is_exact || (element == NULL && vor_ply_alike(one->name, one->name_length, "vertex")))
            element = one;
        if (is_exact)
            break;
    }
    if (element == NULL)
        return VOR_PLY_FAIL(err, header->body,
                            "the header has no element vertex, want one with x, y and z");
    reader->vertex = element;
    if (element->count == 0)
        return vor_fail_at(err,
                           vor_fail(err, VOR_E_EMPTY, "the file has 0 vertices, want at least 1"),
                           element->offset);
    if (element->count <= most)
        return VOR_OK;
    vor_fail(err, VOR_E_LIMIT, "the file has %llu vertices, want 1 to %zu",
             (unsigned long long)element->count, most);
    (void)vor_fail_over(err, VOR_E_LIMIT, most, element->count);
    return vor_fail_at(err, VOR_E_LIMIT, element->offset);
}

/* Where x, y and z are among the vertex's properties. */
static vor_status find_coordinates(const struct reader *reader, unsigned at[3],
                                   struct vor_error *err)
{
    static const char *const names[] = {"x", "y", "z"};
    const struct vor_ply_element *vertex = reader->vertex;

    for (int c = 0; c < 3; c++) {
        at[c] = vor_ply_find(vertex, names[c], 0);
        if (at[c] == ABSENT && vor_ply_find(vertex, "packed_position", 0) != ABSENT)
            vor_fail(err, VOR_E_FORMAT,
                     "the file is a compressed 3D Gaussian splat (element vertex has the "
                     "property packed_position): unpack it with splat-transform in.ply out.ply");
        else if (at[c] == ABSENT)
            vor_fail(err, VOR_E_FORMAT, "element vertex has no property %s, want x, y and z",
                     names[c]);
        else if (vertex->properties[at[c]].list)
            vor_fail(err, VOR_E_FORMAT, "property %s of vertex is a list, want a number", names[c]);
        else
            continue;
        return vor_fail_at(err, VOR_E_FORMAT, vertex->offset);
    }
    return VOR_OK;
}

static vor_status plan_coordinates(struct reader *reader, struct vor_error *err)
{
    const struct vor_ply_property *properties = reader->vertex->properties;
    size_t n = reader->rows.n;
    enum vor_type type = VOR_FLOAT32;
    unsigned at[3] = {0};
    vor_status status = find_coordinates(reader, at, err);

    VOR_THEN(status, vor_ply_rows_fit(&reader->body, reader->vertex, err));
    VOR_THEN(status, vor_cloud_resize(&reader->cloud, n, err));
    if (status != VOR_OK)
        return status;
    for (int c = 0; c < 3; c++)
        if (properties[at[c]].type != VOR_FLOAT32 &&
            (properties[at[c]].type == VOR_FLOAT64 || vor_type_size(properties[at[c]].type) > 2))
            type = VOR_FLOAT64; /* floats do not hold all of it */
    if (type == VOR_FLOAT64) {
        reader->wide = vor_malloc(reader->cloud.memory, n, 3 * sizeof *reader->wide);
        if (reader->wide == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    }
    for (int c = 0; c < 3; c++) {
        struct vor_ply_column *column = &reader->rows.columns[at[c]];
        uint8_t *base =
            reader->wide != NULL ? (uint8_t *)reader->wide : (uint8_t *)reader->cloud.xyz;

        column->coordinate = c;
        column->to_type = type;
        column->to_stride = 3 * vor_type_size(type);
        column->to = base + (size_t)c * vor_type_size(type);
    }
    return VOR_OK;
}

/* How many of the group's parts the vertex has as scalars of one type; at[] gets where. 0 where it
 * lacks one it needs. */
static unsigned match_group(const struct vor_ply_element *vertex, const struct group *group,
                            unsigned at[4])
{
    unsigned count = 0;

    while (count < group->most) {
        const struct vor_ply_property *property;

        at[count] = vor_ply_find(vertex, group->parts[count], 1);
        if (at[count] == ABSENT)
            break;
        property = &vertex->properties[at[count]];
        if (property->type != vertex->properties[at[0]].type)
            break;
        count++;
    }
    return count < group->least ? 0 : count;
}

/* Adds an attribute of the properties at[0 .. count - 1]. */
static vor_status add_columns(struct reader *reader, const char *name, enum vor_semantic semantic,
                              const unsigned *at, unsigned count, struct vor_error *err)
{
    enum vor_type type = reader->vertex->properties[at[0]].type;
    struct vor_attribute *attribute;
    vor_status status =
        vor_cloud_add_attribute(&reader->cloud, name, semantic, type, count, &attribute, err);

    for (unsigned i = 0; status == VOR_OK && i < count; i++) {
        struct vor_ply_column *column = &reader->rows.columns[at[i]];

        column->to_type = type;
        column->to_stride = count * vor_type_size(type);
        column->to = (uint8_t *)attribute->data + i * vor_type_size(type);
    }
    return status;
}

/* Adds the attribute that property k begins, unless it is a coordinate, a list, or taken. */
static vor_status plan_property(struct reader *reader, unsigned k, unsigned taken[GROUP_COUNT],
                                struct vor_error *err)
{
    const struct vor_ply_property *property = &reader->vertex->properties[k];
    char name[VOR_PLY_LINE_MAX + 1];

    if (property->list || reader->rows.columns[k].to != NULL)
        return VOR_OK;
    for (unsigned g = 0; g < GROUP_COUNT; g++) {
        unsigned at[4], count = taken[g] ? 0 : match_group(reader->vertex, &groups[g], at);

        for (unsigned i = 0; i < count; i++) {
            if (at[i] != k)
                continue;
            taken[g] = 1;
            return add_columns(reader, groups[g].attribute, groups[g].semantic, at, count, err);
        }
    }
    (void)snprintf(name, sizeof name, "%.*s", (int)property->name_length, property->name);
    return add_columns(reader, name, VOR_GENERIC, &k, 1, err);
}

/* Whether the vertex has a property of the name that a part of the group would be written under, or
 * of an earlier spelling: a cloud has one NORMAL and one COLOR. */
static int is_ruled_out(const struct vor_ply_element *vertex, unsigned g)
{
    for (unsigned k = 0; k < g; k++)
        for (unsigned i = 0; i < groups[k].most && groups[k].semantic == groups[g].semantic; i++)
            if (vor_ply_find(vertex, groups[k].parts[i], 1) != ABSENT)
                return 1;
    return 0;
}

static vor_status plan(struct reader *reader, struct vor_error *err)
{
    struct vor_ply_rows *rows = &reader->rows;
    unsigned taken[GROUP_COUNT];
    vor_status status;

    rows->n = (size_t)reader->vertex->count;
    rows->column_count = reader->vertex->property_count;
    for (unsigned k = 0; k < rows->column_count; k++) {
        rows->columns[k].property = &reader->vertex->properties[k];
        rows->columns[k].to_type = reader->vertex->properties[k].type;
        rows->columns[k].coordinate = -1;
    }
    status = plan_coordinates(reader, err);
    for (unsigned g = 0; g < GROUP_COUNT; g++)
        taken[g] = (unsigned)is_ruled_out(reader->vertex, g);
    for (unsigned k = 0; status == VOR_OK && k < reader->vertex->property_count; k++)
        status = plan_property(reader, k, taken, err);
    return status;
}

static int is_kept(const struct reader *reader, const struct vor_ply_element *element)
{
    return element == reader->vertex || (reader->keep_faces && vor_ply_face_list(element) >= 0);
}

static vor_status read_element(struct reader *reader, const struct vor_ply_element *element,
                               struct vor_error *err)
{
    if (element == reader->vertex) {
        vor_status status = plan(reader, err);

        if (status != VOR_OK)
            return status;
        return reader->body.encoding == VOR_PLY_ASCII
                   ? vor_ply_ascii_rows(&reader->body, &reader->rows, err)
                   : vor_ply_binary_rows(&reader->body, &reader->rows, err);
    }
    if (is_kept(reader, element))
        return vor_ply_faces_read(&reader->faces, &reader->body, element, err);
    return reader->body.encoding == VOR_PLY_ASCII
               ? vor_ply_ascii_skip(&reader->body, element, err)
               : vor_ply_binary_skip(&reader->body, element, err);
}

static vor_status read_file(struct reader *reader, const struct vor_limits *limits,
                            struct vor_error *err)
{
    struct vor_ply_body *body = &reader->body;
    struct vor_ply_header *header = &reader->header;
    unsigned last;
    vor_status status =
        vor_ply_header_read(header, body->bytes, body->size, limits->header_bytes, err);

    if (status != VOR_OK)
        return status;
    body->at = header->body;
    body->encoding = header->encoding;
    status = find_vertex(reader, limits, err);
    if (status != VOR_OK)
        return status;
    /* What faces may be: as many as a Draco file may have of them, and with indices of its
     * vertices. */
    reader->keep_faces = limits->keep_faces;
    reader->faces.memory = reader->cloud.memory;
    reader->faces.tells_apart = limits->keep_faces == VOR_FACES_KEPT;
    reader->faces.vertices = reader->vertex->count;
    reader->faces.most = 2 * (limits->points < VOR_POINTS_MAX ? limits->points : VOR_POINTS_MAX);
    for (last = header->element_count - 1; !is_kept(reader, &header->elements[last]);)
        last--;
    for (unsigned i = 0; status == VOR_OK && i <= last; i++)
        status = read_element(reader, &header->elements[i], err);
    reader->cloud.triangles = reader->faces.triangles;
    reader->cloud.triangle_count = reader->faces.count;
    reader->cloud.polygons = reader->faces.polygons;
    if (status == VOR_OK && body->not_finite > 0) {
        status = vor_cloud_sift(&reader->cloud, reader->wide, limits->drop_invalid, err);
        if (status != VOR_OK)
            status = vor_fail_at(err, status, body->not_finite);
    }
    if (status == VOR_OK && reader->wide != NULL)
        status = vor_cloud_set_double(&reader->cloud, reader->wide, err);
    if (status == VOR_OK && reader->wide != NULL && limits->keep_doubles)
        vor_cloud_keep_double(&reader->cloud, &reader->wide);
    VOR_THEN(status, vor_ply_note(&reader->cloud, body->bytes, header, reader->vertex,
                                  limits->keep_faces, err));
    return status;
}

vor_status vor_ply_read(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                        const struct vor_limits *limits, struct vor_error *err)
{
    struct vor_memory *memory = out->memory;
    struct reader *reader = vor_calloc(memory, 1, sizeof *reader);
    vor_status status;

    if (reader == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the header of a PLY file");
    vor_cloud_init(&reader->cloud, memory);
    reader->body.bytes = bytes;
    reader->body.size = size;
    status = read_file(reader, limits, err);
    vor_free(memory, reader->wide);
    if (status == VOR_OK)
        *out = reader->cloud;
    else
        vor_cloud_free(&reader->cloud);
    vor_free(memory, reader);
    return status;
}
