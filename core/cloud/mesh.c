#include "core/cloud/mesh.h"

void vor_mesh_init(struct vor_mesh *out, struct vor_memory *memory)
{
    *out = (struct vor_mesh){.memory = memory};
}

void vor_mesh_free(struct vor_mesh *mesh)
{
    vor_free(mesh->memory, mesh->triangle);
    vor_mesh_init(mesh, mesh->memory);
}

size_t vor_mesh_run(const struct vor_mesh *mesh, size_t t)
{
    size_t run = 1;

    while (mesh->polygons && t + run < mesh->count && run < VOR_MESH_RUN_MOST) {
        const uint32_t *corner = &mesh->triangle[3 * (t + run)];

        if (corner[0] != corner[-3] || corner[1] != corner[-1])
            break;
        run++;
    }
    return run;
}

size_t vor_mesh_faces(const struct vor_mesh *mesh)
{
    size_t faces = 0;

    for (size_t t = 0; t < mesh->count; t += vor_mesh_run(mesh, t))
        faces++;
    return faces;
}
