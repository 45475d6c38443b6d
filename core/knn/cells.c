#include "core/knn/cells.h"

#include "core/base/linalg.h"

#include <string.h>

#define NONE UINT32_MAX

/* Fewest entries of the table. */
enum { LEAST = 64 };

/* Entry of the table for a cube. */
static uint32_t *entry_of(const struct vor_cells *cells, const int64_t cube[3])
{
    uint64_t hash = 0;

    for (int c = 0; c < 3; c++) {
        hash = (hash ^ (uint64_t)cube[c]) * 0x9e3779b97f4a7c15ULL;
        hash ^= hash >> 29;
    }
    return &cells->first[hash & (cells->entries - 1)];
}

/* The cube of x, moved by `off` along each axis. */
static void cube_of(int64_t cube[3], const struct vor_cells *cells, const float x[3], double off)
{
    for (int c = 0; c < 3; c++)
        cube[c] = (int64_t)floor(((double)x[c] + off) / cells->wide);
}

/* Puts point i, which is in xyz, into the table. */
static void put(struct vor_cells *cells, size_t i)
{
    int64_t cube[3];
    uint32_t *entry;

    cube_of(cube, cells, &cells->xyz[3 * i], 0);
    entry = entry_of(cells, cube);
    cells->next[i] = *entry;
    *entry = (uint32_t)i;
}

vor_status vor_cells_reserve(struct vor_cells *cells, size_t room, struct vor_error *err)
{
    size_t entries = LEAST;
    float *xyz = vor_realloc(cells->memory, cells->xyz, room, 3 * sizeof *xyz);
    uint32_t *next, *first;

    while (entries < room)
        entries *= 2;
    cells->xyz = xyz != NULL ? xyz : cells->xyz;
    next = vor_realloc(cells->memory, cells->next, room, sizeof *next);
    cells->next = next != NULL ? next : cells->next;
    first = vor_malloc(cells->memory, entries, sizeof *first);
    if (xyz == NULL || next == NULL || first == NULL) {
        vor_free(cells->memory, first);
        return vor_fail(err, VOR_E_NOMEM, "%zu points", room);
    }
    vor_free(cells->memory, cells->first);
    cells->first = first;
    cells->entries = entries;
    cells->room = room;
    memset(first, 0xff, entries * sizeof *first);
    for (size_t i = 0; i < cells->n; i++)
        put(cells, i);
    return VOR_OK;
}

vor_status vor_cells_add(struct vor_cells *cells, const float x[3], struct vor_error *err)
{
    if (cells->n == cells->room) {
        vor_status status = vor_cells_reserve(cells, 2 * cells->room + LEAST, err);

        if (status != VOR_OK)
            return status;
    }
    memcpy(&cells->xyz[3 * cells->n], x, 3 * sizeof *x);
    put(cells, cells->n++);
    return VOR_OK;
}

int vor_cells_has(const struct vor_cells *cells, const float x[3], double radius)
{
    int64_t low[3], high[3], at[3];

    if (cells->n == 0)
        return 0;
    cube_of(low, cells, x, -radius);
    cube_of(high, cells, x, radius);
    for (at[0] = low[0]; at[0] <= high[0]; at[0]++)
        for (at[1] = low[1]; at[1] <= high[1]; at[1]++)
            for (at[2] = low[2]; at[2] <= high[2]; at[2]++)
                for (uint32_t i = *entry_of(cells, at); i != NONE; i = cells->next[i])
                    if (vor_distance2f(&cells->xyz[3 * (size_t)i], x) < radius * radius)
                        return 1;
    return 0;
}

void vor_cells_free(struct vor_cells *cells)
{
    VOR_FREE_ALL(cells->memory, cells->first, cells->next, cells->xyz);
    cells->first = cells->next = NULL;
    cells->xyz = NULL;
    cells->n = cells->room = cells->entries = 0;
}
