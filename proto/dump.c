/* A head, a row for each attribute, then the positions and the values, notes and faces, and doubles
 * where the cloud keeps them, all as they lie in memory: the file never leaves the machine that
 * wrote it, and `order` tells when it did. */
#include "proto/dump.h"

#include <math.h>
#include <string.h>

enum { VERSION = 5, ORDER = 0x01020304 };

static const char magic[8] = "vordump";

struct head {
    char magic[8];
    uint32_t version, order;
    uint64_t n;
    uint32_t position_type, attribute_count;
    double origin[3];
};

struct row {
    char name[64];
    uint32_t semantic, type, components, unused;
};

/* Then dropped_count times struct vor_dropped, and the remarks. */
struct tail {
    uint64_t invalid, remarks_size;
    uint32_t format, dropped_count;
};

/* Then three indices for each triangle. */
struct faces {
    uint64_t faces, triangle_count;
    uint32_t polygons, has_doubles;
};

_Static_assert(sizeof(struct faces) == 24, "no padding in the file");
_Static_assert(sizeof(struct head) == 56 && sizeof(struct row) == 80 && sizeof(struct tail) == 24 &&
                   sizeof(struct vor_dropped) == 72,
               "no padding in the file");

/* Most bytes of remarks, and formats: more than any header that a reader lets pass, and than there
 * are. */
static const uint64_t REMARKS_MAX = (uint64_t)1 << 24;
static const size_t TRIANGLE = 3 * sizeof(uint32_t); /* bytes */
enum { FORMATS_MAX = 63 };

static vor_status put(const struct vor_sink *sink, const void *bytes, size_t size,
                      struct vor_error *err)
{
    enum { CHUNK = 1 << 20 };
    const uint8_t *at = bytes;

    while (size > 0) {
        size_t now = size < CHUNK ? size : CHUNK;

        if (sink->write(sink->ctx, at, now) < 0)
            return vor_fail(err, VOR_E_IO, "%zu bytes of the decoded cloud could not be written",
                            now);
        at += now;
        size -= now;
    }
    return VOR_OK;
}

static vor_status put_head(const struct vor_sink *sink, const struct vor_cloud *cloud,
                           struct vor_error *err)
{
    struct head head = {.version = VERSION,
                        .order = ORDER,
                        .n = cloud->n,
                        .position_type = (uint32_t)cloud->position_type,
                        .attribute_count = (uint32_t)cloud->attribute_count};

    memcpy(head.magic, magic, sizeof magic);
    memcpy(head.origin, cloud->origin, sizeof head.origin);
    return put(sink, &head, sizeof head, err);
}

static vor_status put_tail(const struct vor_sink *sink, const struct vor_notes *notes,
                           struct vor_error *err)
{
    struct tail tail = {notes->invalid, notes->remarks_size, notes->format, notes->dropped_count};
    vor_status status = put(sink, &tail, sizeof tail, err);

    VOR_THEN(status, put(sink, notes->dropped, notes->dropped_count * sizeof *notes->dropped, err));
    VOR_THEN(status, put(sink, notes->remarks, notes->remarks_size, err));
    return status;
}

vor_status vor_dump_write(const struct vor_sink *sink, const struct vor_cloud *cloud,
                          struct vor_error *err)
{
    const struct faces faces = {cloud->notes.faces, cloud->triangle_count, cloud->polygons != 0,
                                cloud->exact != NULL};
    vor_status status = put_head(sink, cloud, err);

    for (size_t i = 0; status == VOR_OK && i < cloud->attribute_count; i++) {
        struct row row = {.semantic = (uint32_t)cloud->attributes[i].semantic,
                          .type = (uint32_t)cloud->attributes[i].type,
                          .components = cloud->attributes[i].components};

        memcpy(row.name, cloud->attributes[i].name,
               strnlen(cloud->attributes[i].name, sizeof row.name - 1));
        status = put(sink, &row, sizeof row, err);
    }
    VOR_THEN(status, put(sink, cloud->xyz, cloud->n * 3 * sizeof *cloud->xyz, err));
    for (size_t i = 0; status == VOR_OK && i < cloud->attribute_count; i++) {
        const struct vor_attribute *attribute = &cloud->attributes[i];

        status = put(sink, attribute->data,
                     cloud->n * attribute->components * vor_type_size(attribute->type), err);
    }
    VOR_THEN(status, put_tail(sink, &cloud->notes, err));
    VOR_THEN(status, put(sink, &faces, sizeof faces, err));
    VOR_THEN(status, put(sink, cloud->triangles, cloud->triangle_count * TRIANGLE, err));
    if (status == VOR_OK && cloud->exact != NULL)
        status = put(sink, cloud->exact, cloud->n * 3 * sizeof *cloud->exact, err);
    return status;
}

static int count(void *ctx, VOR_UNUSED const void *bytes, size_t size)
{
    *(uint64_t *)ctx += size;
    return 0;
}

uint64_t vor_dump_size(const struct vor_cloud *cloud)
{
    uint64_t size = 0;
    const struct vor_sink counter = {.ctx = &size, .write = count};

    (void)!vor_dump_write(&counter, cloud, NULL);
    return size;
}

static vor_status damaged(size_t offset, const char *what, struct vor_error *err)
{
    vor_fail(err, VOR_E_FORMAT, "the decoded cloud is damaged: %s", what);
    if (err != NULL)
        err->byte_offset = (int64_t)offset;
    return VOR_E_FORMAT;
}

/* Adds the row's bytes of values to *total. */
static int check_row(const struct row *row, uint64_t n, uint64_t *total)
{
    uint64_t bytes;

    if (memchr(row->name, '\0', sizeof row->name) == NULL || row->semantic > VOR_TEX_COORD ||
        row->type >= VOR_TYPE_COUNT || row->components < 1 || row->components > 16)
        return 0;
    return !__builtin_mul_overflow(n, row->components * vor_type_size((enum vor_type)row->type),
                                   &bytes) &&
           !__builtin_add_overflow(*total, bytes, total);
}

/* Adds the bytes of the tail, which begins at *total, to *total. */
static int check_tail(const uint8_t *bytes, size_t size, uint64_t *total)
{
    struct tail tail;

    if (*total > size || size - *total < sizeof tail)
        return 0;
    memcpy(&tail, bytes + *total, sizeof tail);
    if (tail.dropped_count > VOR_DROPPED_MAX || tail.remarks_size > REMARKS_MAX ||
        tail.format > FORMATS_MAX)
        return 0;
    *total += sizeof tail + tail.dropped_count * sizeof(struct vor_dropped) + tail.remarks_size;
    return 1;
}

/* The same of the faces, and of the doubles. */
static int check_faces(const struct head *head, const uint8_t *bytes, size_t size, uint64_t *total)
{
    struct faces faces;
    uint32_t corner;

    if (*total > size || size - *total < sizeof faces)
        return 0;
    memcpy(&faces, bytes + *total, sizeof faces);
    *total += sizeof faces;
    if (faces.triangle_count > (size - *total) / TRIANGLE)
        return 0;
    for (uint64_t end = *total + faces.triangle_count * TRIANGLE; *total < end;
         *total += sizeof corner) {
        memcpy(&corner, bytes + *total, sizeof corner);
        if (corner >= head->n)
            return 0;
    }
    *total += faces.has_doubles != 0 ? head->n * 3 * sizeof(double) : 0;
    return 1;
}

static vor_status take_attribute(struct vor_cloud *cloud, const struct row *row, const uint8_t **at,
                                 struct vor_error *err)
{
    size_t size = row->components * vor_type_size((enum vor_type)row->type);
    struct vor_attribute *attribute;
    vor_status status =
        vor_cloud_add_attribute(cloud, row->name, (enum vor_semantic)row->semantic,
                                (enum vor_type)row->type, row->components, &attribute, err);

    if (status != VOR_OK)
        return status;
    memcpy(attribute->name, row->name, sizeof row->name); /* unchanged, however long */
    memcpy(attribute->data, *at, cloud->n * size);
    *at += cloud->n * size;
    return VOR_OK;
}

static vor_status take_tail(struct vor_cloud *cloud, const uint8_t **from, struct vor_error *err)
{
    struct vor_notes *notes = &cloud->notes;
    const uint8_t *at = *from;
    struct tail tail;

    memcpy(&tail, at, sizeof tail);
    at += sizeof tail;
    notes->invalid = tail.invalid;
    notes->format = tail.format;
    notes->dropped_count = tail.dropped_count;
    memcpy(notes->dropped, at, tail.dropped_count * sizeof *notes->dropped);
    at += tail.dropped_count * sizeof *notes->dropped;
    for (unsigned i = 0; i < notes->dropped_count; i++)
        notes->dropped[i].what[sizeof notes->dropped[i].what - 1] = '\0';
    *from = at + tail.remarks_size;
    if (tail.remarks_size == 0)
        return VOR_OK;
    notes->remarks = vor_malloc(cloud->memory, (size_t)tail.remarks_size, 1);
    if (notes->remarks == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu bytes of comments", (size_t)tail.remarks_size);
    notes->remarks_size = (size_t)tail.remarks_size;
    memcpy(notes->remarks, at, notes->remarks_size);
    return VOR_OK;
}

static vor_status take_faces(struct vor_cloud *cloud, const uint8_t *at, struct vor_error *err)
{
    struct faces faces;

    memcpy(&faces, at, sizeof faces);
    at += sizeof faces;
    cloud->notes.faces = faces.faces;
    cloud->polygons = faces.polygons != 0;
    if (faces.triangle_count > 0) {
        cloud->triangles = vor_malloc(cloud->memory, (size_t)faces.triangle_count, TRIANGLE);
        if (cloud->triangles == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu triangles", (size_t)faces.triangle_count);
        cloud->triangle_count = (size_t)faces.triangle_count;
        memcpy(cloud->triangles, at, cloud->triangle_count * TRIANGLE);
    }
    if (faces.has_doubles == 0)
        return VOR_OK;
    cloud->exact = vor_malloc(cloud->memory, cloud->n, 3 * sizeof *cloud->exact);
    if (cloud->exact == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", cloud->n);
    memcpy(cloud->exact, at + cloud->triangle_count * TRIANGLE,
           cloud->n * 3 * sizeof *cloud->exact);
    return VOR_OK;
}

static vor_status take_values(struct vor_cloud *cloud, const struct head *head,
                              const uint8_t *bytes, struct vor_error *err)
{
    const uint8_t *rows = bytes + sizeof *head;
    const uint8_t *at = rows + head->attribute_count * sizeof(struct row);
    vor_status status = vor_cloud_resize(cloud, (size_t)head->n, err);

    if (status != VOR_OK)
        return status;
    memcpy(cloud->origin, head->origin, sizeof cloud->origin);
    cloud->position_type = (enum vor_type)head->position_type;
    memcpy(cloud->xyz, at, cloud->n * 3 * sizeof *cloud->xyz);
    at += cloud->n * 3 * sizeof *cloud->xyz;
    for (uint32_t i = 0; status == VOR_OK && i < head->attribute_count; i++) {
        struct row row;

        memcpy(&row, rows + i * sizeof row, sizeof row);
        status = take_attribute(cloud, &row, &at, err);
    }
    VOR_THEN(status, take_tail(cloud, &at, err));
    VOR_THEN(status, take_faces(cloud, at, err));
    return status == VOR_OK ? vor_cloud_check(cloud, err) : status;
}

static vor_status check(struct head *head, const uint8_t *bytes, size_t size, struct vor_error *err)
{
    uint64_t total;

    if (size < sizeof *head)
        return damaged(size, "length", err);
    memcpy(head, bytes, sizeof *head);
    if (memcmp(head->magic, magic, sizeof magic) != 0 || head->order != ORDER ||
        head->version != VERSION)
        return damaged(0, "not a dump of this version and machine", err);
    if (head->n == 0 || head->n > VOR_POINTS_MAX)
        return damaged(16, "number of points", err);
    if (head->position_type != VOR_FLOAT32 && head->position_type != VOR_FLOAT64)
        return damaged(24, "type of the positions", err);
    if (head->attribute_count > VOR_ATTRIBUTES_MAX ||
        size - sizeof *head < head->attribute_count * sizeof(struct row))
        return damaged(28, "number of attributes", err);
    /* The file must be exactly as long as its tables say. */
    total = sizeof *head + head->attribute_count * sizeof(struct row);
    total += head->n * 3 * sizeof(float); /* n is at most 2^31 */
    for (uint32_t i = 0; i < head->attribute_count; i++) {
        size_t at = sizeof *head + i * sizeof(struct row);
        struct row row;

        memcpy(&row, bytes + at, sizeof row);
        if (!check_row(&row, head->n, &total))
            return damaged(at, "attribute", err);
    }
    if (!check_tail(bytes, size, &total))
        return damaged(size, "notes", err);
    if (!check_faces(head, bytes, size, &total))
        return damaged(size, "faces", err);
    return total == size ? VOR_OK : damaged(size, "length", err);
}

vor_status vor_dump_check(size_t *points, const uint8_t *bytes, size_t size, struct vor_error *err)
{
    struct head head;
    vor_status status = check(&head, bytes, size, err);
    const uint8_t *at = bytes + sizeof head;
    size_t bad = 0;
    float value;

    if (status != VOR_OK)
        return status;
    at += head.attribute_count * sizeof(struct row);
    for (size_t i = 0; i < 3 * (size_t)head.n; i++) {
        memcpy(&value, at + i * sizeof value, sizeof value);
        bad += !isfinite(value);
    }
    if (bad > 0 || !isfinite(head.origin[0]) || !isfinite(head.origin[1]) ||
        !isfinite(head.origin[2]))
        return vor_fail(err, VOR_E_NONFINITE,
                        "the decoded cloud is damaged: coordinates that are not finite");
    *points = (size_t)head.n;
    return VOR_OK;
}

vor_status vor_dump_read(struct vor_cloud *out, const uint8_t *bytes, size_t size,
                         struct vor_error *err)
{
    struct vor_cloud cloud;
    struct head head;
    vor_status status = check(&head, bytes, size, err);

    if (status != VOR_OK)
        return status;
    vor_cloud_init(&cloud, out->memory);
    status = take_values(&cloud, &head, bytes, err);
    if (status == VOR_OK)
        *out = cloud;
    else
        vor_cloud_free(&cloud);
    return status;
}
