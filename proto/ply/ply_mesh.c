/* Faces as vor_ply_write writes them, behind the rows of the vertices: the number of corners in a
 * byte, then their points. */
#include "proto/ply/ply.h"
#include "proto/ply/ply_body.h"

enum { CORNERS = 3, FACE_BYTES = 1 + CORNERS * 4 }; /* of a triangle, the least */

/* What is known while the faces of n points are read. */
struct faces {
    struct vor_ply_header header;
    struct vor_ply_body body;
    struct vor_mesh *mesh;
    size_t n;
};

static int is_ours(const struct vor_ply_element *element)
{
    const struct vor_ply_property *list = &element->properties[0];

    return vor_ply_named(element->name, element->name_length, "face") &&
           element->property_count == 1 && list->list && list->count_type == VOR_UINT8 &&
           list->type == VOR_INT32;
}

static vor_status refuse(const struct faces *faces, size_t face, size_t at, struct vor_error *err)
{
    return vor_ply_at(err, at,
                      vor_fail(err, VOR_E_FORMAT,
                               "face %zu is not a polygon of the file's %zu points", face,
                               faces->n));
}

/* Counts the triangles of `count` faces, and checks that the file has them whole. */
static vor_status count_triangles(struct faces *faces, size_t count, struct vor_error *err)
{
    const struct vor_ply_body *body = &faces->body;
    size_t at = body->at;

    for (size_t i = 0; i < count; i++) {
        unsigned corners = at < body->size ? body->bytes[at] : 0;

        if (corners < CORNERS || body->size - at - 1 < corners * sizeof(uint32_t))
            return refuse(faces, i, at, err);
        at += 1 + corners * sizeof(uint32_t);
        faces->mesh->count += corners - 2;
        faces->mesh->polygons |= corners > CORNERS;
    }
    return VOR_OK;
}

static vor_status read_rows(struct faces *faces, size_t count, struct vor_error *err)
{
    const uint8_t *at = faces->body.bytes + faces->body.at;
    uint32_t *to = faces->mesh->triangle, corner[UINT8_MAX] = {0};

    for (size_t i = 0; i < count; i++) {
        unsigned corners = at[0];

        vor_ply_copy((struct vor_ply_strided){(uint8_t *)corner, 0},
                     (struct vor_ply_source){at + 1, 0}, 1, sizeof *corner, corners,
                     vor_ply_swaps(VOR_PLY_LITTLE));
        for (unsigned c = 0; c < corners; c++)
            if (corner[c] >= faces->n)
                return refuse(faces, i, (size_t)(at - faces->body.bytes), err);
        for (unsigned c = 2; c < corners; c++, to += CORNERS) {
            to[0] = corner[0];
            to[1] = corner[c - 1];
            to[2] = corner[c];
        }
        at += 1 + corners * sizeof *corner;
    }
    return VOR_OK;
}

static vor_status read_element(struct faces *faces, size_t count, struct vor_error *err)
{
    size_t left = faces->body.size - faces->body.at;
    struct vor_mesh *mesh = faces->mesh;
    vor_status status;

    if (count > left / FACE_BYTES)
        return vor_ply_at(err, faces->body.size,
                          vor_fail(err, VOR_E_FORMAT,
                                   "%zu faces need %d bytes each, but %zu are left", count,
                                   FACE_BYTES, left));
    status = count_triangles(faces, count, err);
    if (status != VOR_OK)
        return status;
    mesh->triangle = vor_malloc(mesh->memory, mesh->count, CORNERS * sizeof(uint32_t));
    if (mesh->triangle == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu triangles", mesh->count);
    return read_rows(faces, count, err);
}

static vor_status read_faces(struct faces *faces, size_t header_bytes, struct vor_error *err)
{
    const struct vor_ply_header *header = &faces->header;
    const struct vor_ply_element *element = &header->elements[1];
    struct vor_ply_body *body = &faces->body;
    vor_status status =
        vor_ply_header_read(&faces->header, body->bytes, body->size, header_bytes, err);

    if (status != VOR_OK || header->element_count < 2 || element->count == 0)
        return status;
    if (!is_ours(element) || header->encoding != VOR_PLY_LITTLE)
        return vor_ply_at(
            err, element->offset,
            vor_fail(err, VOR_E_FORMAT, "the second element of the PLY file is not the faces"));
    body->at = header->body;
    body->encoding = header->encoding;
    status = vor_ply_binary_skip(body, &header->elements[0], err);
    return status == VOR_OK ? read_element(faces, (size_t)element->count, err) : status;
}

vor_status vor_ply_read_mesh(struct vor_cloud *out, struct vor_mesh *mesh, const uint8_t *bytes,
                             size_t size, const struct vor_limits *limits, struct vor_error *err)
{
    struct vor_limits strict = *limits;
    struct faces *faces = vor_calloc(out->memory, 1, sizeof *faces);
    vor_status status;

    if (faces == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the header of a PLY file");
    strict.drop_invalid = 0;
    status = vor_ply_read(out, bytes, size, &strict, err);
    if (status == VOR_OK) {
        faces->body.bytes = bytes;
        faces->body.size = size;
        faces->mesh = mesh;
        faces->n = out->n;
        status = read_faces(faces, limits->header_bytes, err);
    }
    vor_free(out->memory, faces);
    if (status != VOR_OK) {
        vor_mesh_free(mesh);
        vor_cloud_free(out);
    }
    return status;
}
