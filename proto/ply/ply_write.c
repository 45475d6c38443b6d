#include "proto/ply/ply.h"

#include "proto/ply/ply_body.h"
#include "proto/ply/ply_notes.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum { NAME_SIZE = 96, LINE_BYTES = 128, BUFFER_BYTES = 65536, PIECE = 256 };
enum { FACE_LINES = 2, FACE_MOST = 1 + (VOR_MESH_RUN_MOST + 2) * 4 };

/* One scalar of a row: a name, where the values are and how they are written. */
struct field {
    char name[NAME_SIZE];
    enum vor_type from_type, type; /* type is what PLY has for from_type */
    const uint8_t *from;           /* of point 0; NULL for a coordinate */
    size_t from_stride;
    int coordinate;
};

struct writer {
    const struct vor_sink *sink;
    const struct vor_cloud *cloud;
    const struct vor_mesh *mesh; /* NULL for none */
    struct field *fields;
    size_t field_count;
    uint8_t *buffer;
    size_t capacity, used;
};

static vor_status flush(struct writer *writer, struct vor_error *err)
{
    size_t size = writer->used;

    writer->used = 0;
    if (size > 0 && writer->sink->write(writer->sink->ctx, writer->buffer, size) < 0)
        return vor_fail(err, VOR_E_IO, "%zu bytes of a PLY file could not be written", size);
    return VOR_OK;
}

/* Names of an attribute's components where PLY has a custom for them, else NULL. Only the first
 * attribute of its kind has one: a row has no two of the same name. */
static const char *const *custom_names(const struct vor_cloud *cloud,
                                       const struct vor_attribute *attribute)
{
    static const char *const normal[4] = {"nx", "ny", "nz", ""};
    static const char *const color[4] = {"red", "green", "blue", "alpha"};
    static const char *const place[4] = {"tex_coord_0", "tex_coord_1", "tex_coord_2", ""};

    if (attribute->semantic == VOR_GENERIC ||
        vor_cloud_find(cloud, attribute->semantic) != attribute)
        return NULL;
    if (attribute->semantic == VOR_NORMAL && attribute->components == 3)
        return normal;
    if (attribute->semantic == VOR_COLOR &&
        (attribute->components == 3 || attribute->components == 4))
        return color;
    if (attribute->semantic == VOR_TEX_COORD &&
        (attribute->components == 2 || attribute->components == 3))
        return place;
    return NULL;
}

/* Whether a field has the name, or one that is the custom of an attribute will have it. */
static int is_taken(const struct writer *writer, const char *name)
{
    const struct vor_cloud *cloud = writer->cloud;

    for (size_t i = 0; i < writer->field_count; i++)
        if (strcmp(writer->fields[i].name, name) == 0)
            return 1;
    for (size_t i = 0; i < cloud->attribute_count; i++) {
        const char *const *names = custom_names(cloud, &cloud->attributes[i]);

        for (unsigned c = 0; names != NULL && c < cloud->attributes[i].components; c++)
            if (strcmp(names[c], name) == 0)
                return 1;
    }
    return 0;
}

/* Blanks and control characters become '_'; a name that is taken gets "_2", "_3" ... */
static void set_free_name(const struct writer *writer, char to[NAME_SIZE], const char *name)
{
    char base[NAME_SIZE - 12];

    (void)snprintf(base, sizeof base, "%.*s", (int)sizeof base - 1, name[0] != '\0' ? name : "_");
    for (size_t i = 0; base[i] != '\0'; i++)
        if ((uint8_t)base[i] <= 0x20 || base[i] == 0x7f)
            base[i] = '_';
    (void)snprintf(to, NAME_SIZE, "%s", base);
    for (unsigned suffix = 2; is_taken(writer, to); suffix++)
        (void)snprintf(to, NAME_SIZE, "%s_%u", base, suffix);
}

/* Adds a field under a name as it is. */
static void add_field(struct writer *writer, const char *name, const struct field *values)
{
    struct field *field = &writer->fields[writer->field_count++];

    *field = *values;
    (void)snprintf(field->name, sizeof field->name, "%s", name);
}

static void add_attribute(struct writer *writer, const struct vor_attribute *attribute)
{
    const char *const *names = custom_names(writer->cloud, attribute);
    size_t size = vor_type_size(attribute->type);
    struct field field = {.from_type = attribute->type,
                          .type = attribute->type,
                          .from_stride = attribute->components * size};
    char name[NAME_SIZE], free_name[NAME_SIZE];

    if (attribute->type == VOR_INT64 || attribute->type == VOR_UINT64)
        field.type = VOR_FLOAT64;
    for (unsigned i = 0; i < attribute->components; i++) {
        field.from = (const uint8_t *)attribute->data + i * size;
        if (attribute->components == 1)
            (void)snprintf(name, sizeof name, "%s", attribute->name);
        else
            (void)snprintf(name, sizeof name, "%s_%u", attribute->name, i);
        set_free_name(writer, free_name, name);
        add_field(writer, names != NULL ? names[i] : free_name, &field);
    }
}

/* The header always fits into the buffer: a field's line has at most NAME_SIZE + 17 bytes, and the
 * buffer has LINE_BYTES for each field and for two lines of faces, or at least BUFFER_BYTES, beside
 * the remarks. */
static void put_bytes(struct writer *writer, const char *bytes, size_t size)
{
    assert(size <= writer->capacity - writer->used);
    if (size > 0)
        memcpy(writer->buffer + writer->used, bytes, size);
    writer->used += size;
}

static void put(struct writer *writer, const char *line)
{
    put_bytes(writer, line, strlen(line));
}

static void put_header(struct writer *writer)
{
    const struct vor_notes *notes = &writer->cloud->notes;
    char line[LINE_BYTES];

    put(writer, "ply\nformat binary_little_endian 1.0\ncomment " VOR_PLY_SIGNATURE "\n");
    put_bytes(writer, notes->remarks, notes->remarks_size);
    (void)snprintf(line, sizeof line, "element vertex %zu\n", writer->cloud->n);
    put(writer, line);
    for (size_t i = 0; i < writer->field_count; i++) {
        const struct field *field = &writer->fields[i];

        (void)snprintf(line, sizeof line, "property %s %s\n", vor_type_name(field->type),
                       field->name);
        put(writer, line);
    }
    if (writer->mesh != NULL) {
        (void)snprintf(line, sizeof line, "element face %zu\n", vor_mesh_faces(writer->mesh));
        put(writer, line);
        put(writer, "property list uchar int vertex_indices\n");
    }
    put(writer, "end_header\n");
}

/* n scalars that lie side by side become those of rows begin .. begin + n - 1. */
static void put_piece(struct vor_ply_strided to, size_t begin, const void *from, enum vor_type type,
                      size_t n)
{
    struct vor_ply_strided at = {to.base + begin * to.stride, to.stride};

    vor_ply_copy(at, (struct vor_ply_source){from, vor_type_size(type)}, n, vor_type_size(type), 1,
                 vor_ply_swaps(VOR_PLY_LITTLE));
}

/* Adding an origin of 0 would turn -0 into 0. */
static void put_coordinate(const struct writer *writer, const struct field *field, size_t first,
                           size_t n, struct vor_ply_strided to)
{
    const float *xyz = writer->cloud->xyz + 3 * first + field->coordinate;
    double origin = writer->cloud->origin[field->coordinate];

    for (size_t begin = 0, size; begin < n; begin += size) {
        double wide[PIECE];
        float single[PIECE];
        const void *from = field->type == VOR_FLOAT32 ? (void *)single : (void *)wide;

        size = n - begin < PIECE ? n - begin : PIECE;
        for (size_t i = 0; i < size; i++) {
            double relative = (double)xyz[3 * (begin + i)];

            wide[i] = origin == 0 ? relative : origin + relative;
            single[i] = (float)wide[i];
        }
        put_piece(to, begin, from, field->type, size);
    }
}

static void put_long(const struct field *field, size_t first, size_t n, struct vor_ply_strided to)
{
    const uint8_t *from = field->from + first * field->from_stride;

    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        double wide;

        memcpy(&bits, from + i * field->from_stride, sizeof bits);
        wide = field->from_type == VOR_INT64 ? (double)(int64_t)bits : (double)bits;
        put_piece(to, i, &wide, VOR_FLOAT64, 1);
    }
}

/* What put_header left goes first: rows begin at the buffer's. */
static vor_status write_rows(struct writer *writer, struct vor_error *err)
{
    size_t row = 0, block, n;
    vor_status status = flush(writer, err);
    size_t offset;

    for (size_t i = 0; i < writer->field_count; i++)
        row += vor_type_size(writer->fields[i].type);
    assert(row > 0); /* x, y and z are fields */
    block = writer->capacity / row;
    for (size_t first = 0; status == VOR_OK && first < writer->cloud->n; first += n) {
        n = writer->cloud->n - first < block ? writer->cloud->n - first : block;
        offset = 0;
        for (size_t k = 0; k < writer->field_count; k++) {
            const struct field *field = &writer->fields[k];
            struct vor_ply_strided to = {writer->buffer + offset, row};

            if (field->from == NULL)
                put_coordinate(writer, field, first, n, to);
            else if (field->from_type != field->type)
                put_long(field, first, n, to);
            else
                vor_ply_copy(to,
                             (struct vor_ply_source){field->from + first * field->from_stride,
                                                     field->from_stride},
                             n, vor_type_size(field->type), 1, vor_ply_swaps(VOR_PLY_LITTLE));
            offset += vor_type_size(field->type);
        }
        writer->used = n * row;
        status = flush(writer, err);
    }
    return status;
}

/* A face of `run` triangles is the number of its corners, then their points, which int holds
 * (VOR_POINTS_MAX). */
static vor_status write_faces(struct writer *writer, struct vor_error *err)
{
    uint32_t corner[VOR_MESH_RUN_MOST + 2];
    const struct vor_mesh *mesh = writer->mesh;
    vor_status status = VOR_OK;

    for (size_t t = 0, run; status == VOR_OK && t < mesh->count; t += run) {
        run = vor_mesh_run(mesh, t);
        if (writer->capacity - writer->used < FACE_MOST)
            status = flush(writer, err);
        corner[0] = mesh->triangle[3 * t];
        corner[1] = mesh->triangle[3 * t + 1];
        for (size_t k = 0; k < run; k++)
            corner[2 + k] = mesh->triangle[3 * (t + k) + 2];
        writer->buffer[writer->used] = (uint8_t)(run + 2);
        vor_ply_copy((struct vor_ply_strided){writer->buffer + writer->used + 1, 0},
                     (struct vor_ply_source){(const uint8_t *)corner, 0}, 1, sizeof *corner,
                     run + 2, vor_ply_swaps(VOR_PLY_LITTLE));
        writer->used += 1 + (run + 2) * sizeof *corner;
    }
    return status == VOR_OK ? flush(writer, err) : status;
}

vor_status vor_ply_write(const struct vor_sink *sink, const struct vor_cloud *cloud,
                         const struct vor_write_options *options, struct vor_error *err)
{
    struct writer writer = {.sink = sink, .cloud = cloud};
    size_t count = 3, lines;
    vor_status status;

    for (size_t i = 0; i < cloud->attribute_count; i++)
        count += cloud->attributes[i].components;
    lines = count + FACE_LINES;
    if (options != NULL && options->mesh != NULL && options->mesh->count > 0)
        writer.mesh = options->mesh;
    writer.capacity = lines * LINE_BYTES > BUFFER_BYTES ? lines * LINE_BYTES : BUFFER_BYTES;
    writer.capacity += cloud->notes.remarks_size;
    writer.fields = vor_malloc(cloud->memory, count, sizeof *writer.fields);
    writer.buffer = vor_malloc(cloud->memory, writer.capacity, 1);
    if (writer.fields == NULL || writer.buffer == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "writing a PLY file");
        goto done;
    }
    for (int c = 0; c < 3; c++) {
        const char name[2] = {"xyz"[c], '\0'};
        struct field field = {
            .coordinate = c, .from_type = cloud->position_type, .type = cloud->position_type};

        if (cloud->exact != NULL) {
            field.from = (const uint8_t *)(cloud->exact + c);
            field.from_stride = 3 * sizeof *cloud->exact;
        }
        add_field(&writer, name, &field);
    }
    for (size_t i = 0; i < cloud->attribute_count; i++)
        add_attribute(&writer, &cloud->attributes[i]);
    put_header(&writer);
    status = write_rows(&writer, err);
    if (status == VOR_OK && writer.mesh != NULL)
        status = write_faces(&writer, err);
done:
    vor_free(cloud->memory, writer.buffer);
    vor_free(cloud->memory, writer.fields);
    return status;
}
