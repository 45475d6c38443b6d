#include "proto/ply/ply_faces.h"

#include "core/base/quote.h"

enum { SHOWN = 40, CORNERS = 3 };

/* Triangles that there is first room for where the rows of an element do not say. */
enum { CAPACITY_LEAST = 1024 };

static int is_strips(const struct vor_ply_element *element)
{
    return vor_ply_alike(element->name, element->name_length, "tristrips");
}

int vor_ply_face_list(const struct vor_ply_element *element)
{
    if (!is_strips(element) && !vor_ply_alike(element->name, element->name_length, "face"))
        return -1;
    for (unsigned k = 0; k < element->property_count; k++) {
        const struct vor_ply_property *property = &element->properties[k];

        if (property->list &&
            (vor_ply_alike(property->name, property->name_length, "vertex_indices") ||
             vor_ply_alike(property->name, property->name_length, "vertex_index")))
            return (int)k;
    }
    return -1;
}

static vor_status too_many(const struct vor_ply_faces *faces, const char *what, uint64_t got,
                           struct vor_error *err)
{
    vor_fail(err, VOR_E_LIMIT, "the file has %llu %s, want at most %zu", (unsigned long long)got,
             what, faces->most);
    return vor_fail_over(err, VOR_E_LIMIT, faces->most, got);
}

static vor_status reserve(struct vor_ply_faces *faces, size_t capacity, struct vor_error *err)
{
    uint32_t *triangles;

    if (capacity <= faces->capacity)
        return VOR_OK;
    triangles = vor_realloc(faces->memory, faces->triangles, capacity, CORNERS * sizeof *triangles);
    if (triangles == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu triangles", capacity);
    faces->triangles = triangles;
    faces->capacity = capacity;
    return VOR_OK;
}

static vor_status add(struct vor_ply_faces *faces, uint32_t a, uint32_t b, uint32_t c,
                      struct vor_error *err)
{
    uint32_t *to;
    vor_status status = VOR_OK;

    if (faces->count == faces->most)
        return too_many(faces, "triangles or more", (uint64_t)faces->count + 1, err);
    if (faces->count == faces->capacity)
        status = reserve(faces, faces->capacity > 0 ? 2 * faces->capacity : CAPACITY_LEAST, err);
    if (status != VOR_OK)
        return status;
    to = &faces->triangles[CORNERS * faces->count++];
    to[0] = a;
    to[1] = b;
    to[2] = c;
    return VOR_OK;
}

/* A fan of m triangles from t on, around its first corner c0, that continues the one before: turns
 * it around c1. (c0, c1, c2) (c0, c2, c3) becomes (c1, c2, c3) (c1, c3, c0). */
static void tell_apart(uint32_t *triangles, size_t t, size_t m)
{
    uint32_t *fan = &triangles[CORNERS * t], first = fan[0], second = fan[1];

    if (t == 0 || first != fan[-3] || second != fan[-1])
        return;
    for (size_t i = 0; i < m; i++) {
        uint32_t *to = &fan[CORNERS * i];

        to[0] = second;
        to[1] = to[2];
        to[2] = i + 1 < m ? to[CORNERS + 2] : first;
    }
}

/* Triangles are told apart once there is a polygon: without any, no face continues another. */
static void end_face(struct vor_ply_faces *faces)
{
    size_t m = faces->count - faces->first;

    if (faces->tells_apart && m > 1 && !faces->polygons) {
        faces->polygons = 1;
        for (size_t t = 0; t < faces->first; t++)
            tell_apart(faces->triangles, t, 1);
    }
    if (faces->polygons && m > 0)
        tell_apart(faces->triangles, faces->first, m);
    faces->first = faces->count;
}

static vor_status take(void *ctx, uint64_t row, uint64_t item, double value, struct vor_error *err)
{
    struct vor_ply_faces *faces = ctx;
    uint32_t *last = faces->corner, index;
    uint64_t before = item == 0 ? 0 : faces->corners;
    vor_status status = VOR_OK;

    if (item == 0 || faces->is_strip)
        end_face(faces);
    faces->corners = 0;
    if (faces->is_strip && value == -1)
        return VOR_OK;
    if (!(value >= 0 && value < (double)faces->vertices))
        return vor_fail(
            err, VOR_E_FORMAT, "corner %llu of %s %llu is vertex %.0f, want %s0 to %llu",
            (unsigned long long)item, faces->is_strip ? "strip" : "face", (unsigned long long)row,
            value, faces->is_strip ? "-1, or " : "", (unsigned long long)faces->vertices - 1);
    index = (uint32_t)value;
    if (before >= 2 && faces->is_strip && before % 2 == 1) /* every other one is turned over */
        status = add(faces, last[1], last[0], index, err);
    else if (before >= 2)
        status = add(faces, last[0], last[1], index, err);
    if (before == 0 || faces->is_strip)
        last[0] = before == 0 ? index : last[1];
    last[1] = index;
    faces->corners = before + 1;
    return status;
}

static vor_status check_type(const struct vor_ply_element *element, unsigned list,
                             struct vor_error *err)
{
    const struct vor_ply_property *property = &element->properties[list];

    if (property->type != VOR_FLOAT32 && property->type != VOR_FLOAT64)
        return VOR_OK;
    return VOR_PLY_FAIL(
        err, element->offset, "property %s of %s is a list of %s, want a list of integers",
        VOR_QUOTED(SHOWN, property->name, property->name_length),
        VOR_QUOTED(SHOWN, element->name, element->name_length), vor_type_name(property->type));
}

vor_status vor_ply_faces_read(struct vor_ply_faces *faces, struct vor_ply_body *body,
                              const struct vor_ply_element *element, struct vor_error *err)
{
    const struct vor_ply_items items = {faces, take};
    unsigned list = (unsigned)vor_ply_face_list(element);
    vor_status status = check_type(element, list, err);

    if (status == VOR_OK && element->count > faces->most)
        return vor_fail_at(err, too_many(faces, "faces", element->count, err), element->offset);
    VOR_THEN(status, vor_ply_rows_fit(body, element, err));
    faces->is_strip = is_strips(element);
    if (status == VOR_OK && !faces->is_strip)
        status = reserve(faces, faces->count + (size_t)element->count, err);
    if (status != VOR_OK)
        return status;
    status = body->encoding == VOR_PLY_ASCII
                 ? vor_ply_ascii_items(body, element, list, &items, err)
                 : vor_ply_binary_items(body, element, list, &items, err);
    end_face(faces);
    return status;
}
