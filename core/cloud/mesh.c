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
