#include "core/cloud/mesh.h"

#include <string.h>

void vor_mesh_init(struct vor_mesh *out, struct vor_memory *memory)
{
    memset(out, 0, sizeof *out);
    out->memory = memory;
}

void vor_mesh_free(struct vor_mesh *mesh)
{
    struct vor_memory *memory = mesh->memory;

    if (memory == NULL)
        return;
    vor_free(memory, mesh->triangle);
    vor_mesh_init(mesh, memory);
}
