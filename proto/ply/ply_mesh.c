/* Faces as vor_ply_write writes them: rows of 13 bytes behind those of the vertices. */
#include "proto/ply/ply.h"
#include "proto/ply/ply_body.h"

enum { CORNERS = 3, FACE_BYTES = 1 + CORNERS * 4 };

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

static vor_status read_rows(struct faces *faces, struct vor_error *err)
{
    const uint8_t *at = faces->body.bytes + faces->body.at;
    struct vor_mesh *mesh = faces->mesh;

    for (size_t i = 0; i < mesh->count; i++, at += FACE_BYTES) {
        uint32_t *corner = mesh->triangle + CORNERS * i;

        vor_ply_copy((struct vor_ply_strided){(uint8_t *)corner, 0}, at + 1, 0, 1, sizeof *corner,
                     CORNERS, vor_ply_swaps(VOR_PLY_LITTLE));
        if (at[0] != CORNERS || corner[0] >= faces->n || corner[1] >= faces->n ||
            corner[2] >= faces->n)
            return vor_ply_at(err, (size_t)(at - faces->body.bytes),
                              vor_fail(err, VOR_E_FORMAT,
                                       "face %zu is no triangle of the file's %zu points", i,
                                       faces->n));
    }
    return VOR_OK;
}

static vor_status read_element(struct faces *faces, size_t count, struct vor_error *err)
{
    size_t left = faces->body.size - faces->body.at;

    if (count > left / FACE_BYTES)
        return vor_ply_at(err, faces->body.size,
                          vor_fail(err, VOR_E_FORMAT,
                                   "%zu faces need %d bytes each, but %zu are left", count,
                                   FACE_BYTES, left));
    faces->mesh->triangle = vor_malloc(faces->mesh->memory, count, CORNERS * sizeof(uint32_t));
    if (faces->mesh->triangle == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu faces", count);
    faces->mesh->count = count;
    return read_rows(faces, err);
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
            vor_fail(err, VOR_E_FORMAT, "the second element of the PLY file is none of our faces"));
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
