#include "core/mesh/soup.h"

#include "core/base/linalg.h"

#include <assert.h>
#include <string.h>

struct soup {
    const struct vor_soup_of *of;
    const struct vor_attribute *normal; /* of the result, or NULL */
    size_t *corner, *triangle; /* n + 1: where those of each point begin; before, how many */
    struct vor_cloud cloud;
    struct vor_mesh mesh;
    uint32_t *source; /* for each corner, the point of the result */
};

/* Cuts the cell of point k; returns it, or NULL without a surface. */
static const struct vor_cell *cell_of(const struct soup *soup, struct vor_scratch *scratch,
                                      size_t k)
{
    return vor_seeds_cell(soup->of->seeds, scratch,
                          soup->of->order != NULL ? soup->of->order[k] : k) == VOR_SURFACE_NONE
               ? NULL
               : &scratch->cell;
}

static void count_row(void *ctx, size_t k, unsigned worker)
{
    struct soup *soup = ctx;
    const struct vor_cell *cell = cell_of(soup, &soup->of->seeds->scratch[worker], k);

    soup->corner[k + 1] = soup->triangle[k + 1] = 0;
    for (unsigned p = 0; cell != NULL && p < cell->count; p++)
        if (cell->piece[p].count >= 3) {
            soup->corner[k + 1] += cell->piece[p].count;
            soup->triangle[k + 1] += cell->piece[p].count - 2;
        }
}

/* Whether the surface's normal points away from that of point k. */
static int faces_away(const struct soup *soup, const struct vor_surface *surface, size_t k)
{
    double cosine = 0;

    for (size_t c = 0; soup->normal != NULL && c < 3; c++)
        cosine += surface->axis[2][c] * vor_attribute_scalar(soup->normal, 3 * k + c);
    return cosine < 0;
}

/* Puts a polygon of the cell of point k, whose corners begin at `corner`; returns where triangles
 * go on. */
static uint32_t *put_piece(struct soup *soup, const struct vor_surface *surface, size_t k,
                           const struct vor_polygon *piece, size_t corner, uint32_t *triangle)
{
    int turned = faces_away(soup, surface, k);

    assert(corner + piece->count <= soup->corner[k + 1]); /* the cell is that counted */
    for (unsigned v = 0; v < piece->count; v++) {
        unsigned from = turned ? piece->count - 1 - v : v;
        float *out = soup->cloud.xyz + 3 * (corner + v);
        const float *at = &soup->of->result->xyz[3 * k];
        double unit = soup->of->seeds->domain->unit;

        soup->source[corner + v] = (uint32_t)k;
        for (int c = 0; c < 3; c++)
            out[c] = (float)((double)at[c] + unit * (piece->vertex[from][0] * surface->axis[0][c] +
                                                     piece->vertex[from][1] * surface->axis[1][c] +
                                                     piece->vertex[from][2] * surface->axis[2][c]));
        if (v < 2)
            continue;
        *triangle++ = (uint32_t)corner;
        *triangle++ = (uint32_t)corner + v - 1;
        *triangle++ = (uint32_t)corner + v;
    }
    return triangle;
}

static void put_row(void *ctx, size_t k, unsigned worker)
{
    struct soup *soup = ctx;
    struct vor_scratch *scratch = &soup->of->seeds->scratch[worker];
    const struct vor_cell *cell = cell_of(soup, scratch, k);
    uint32_t *triangle = &soup->mesh.triangle[3 * soup->triangle[k]];
    size_t corner = soup->corner[k];

    for (unsigned p = 0; cell != NULL && p < cell->count; p++) {
        const struct vor_polygon *piece = &cell->piece[p];

        if (piece->count < 3)
            continue;
        triangle = put_piece(soup, &scratch->here.surface, k, piece, corner, triangle);
        corner += piece->count;
    }
}

/* Turns numbers into places. */
static void add_up(size_t *count, size_t n)
{
    count[0] = 0;
    for (size_t k = 0; k < n; k++)
        count[k + 1] += count[k];
}

/* Gives the corners the attributes of their points. */
static vor_status copy_attributes(struct soup *soup, struct vor_error *err)
{
    const struct vor_cloud *from = soup->of->result;
    vor_status status = VOR_OK;

    for (size_t a = 0; a < from->attribute_count && status == VOR_OK; a++)
        status = vor_cloud_copy_attribute(&soup->cloud, &from->attributes[a], soup->source, err);
    return status;
}

static vor_status put(struct soup *soup, struct vor_error *err)
{
    const struct vor_cloud *result = soup->of->result;
    struct vor_seeds *seeds = soup->of->seeds;
    struct vor_mesh *mesh = &soup->mesh;
    size_t corners = soup->corner[result->n];
    vor_status status = vor_cloud_resize(&soup->cloud, corners, err);

    if (status != VOR_OK)
        return status;
    mesh->count = soup->triangle[result->n];
    mesh->polygons = 1;
    mesh->triangle = vor_malloc(mesh->memory, mesh->count, 3 * sizeof *mesh->triangle);
    soup->source = vor_malloc(mesh->memory, corners, sizeof *soup->source);
    if (mesh->triangle == NULL || soup->source == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu corners", corners);
    status = vor_run_rows(&seeds->run, result->n, VOR_SEEDS_BLOCK, put_row, soup, err);
    if (status != VOR_OK)
        return status;
    soup->cloud.position_type = result->position_type;
    memcpy(soup->cloud.origin, result->origin, sizeof soup->cloud.origin);
    return copy_attributes(soup, err);
}

static vor_status make(struct soup *soup, struct vor_error *err)
{
    struct vor_seeds *seeds = soup->of->seeds;
    struct vor_memory *memory = seeds->run.memory;
    size_t n = soup->of->result->n;
    vor_status status;

    soup->corner = vor_malloc(memory, n + 1, sizeof *soup->corner);
    soup->triangle = vor_malloc(memory, n + 1, sizeof *soup->triangle);
    if (soup->corner == NULL || soup->triangle == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_seeds_index(seeds, &seeds->run, err);
    VOR_THEN(status, vor_run_rows(&seeds->run, n, VOR_SEEDS_BLOCK, count_row, soup, err));
    if (status != VOR_OK)
        return status;
    add_up(soup->corner, n);
    add_up(soup->triangle, n);
    return put(soup, err);
}

vor_status vor_soup_make(struct vor_cloud *out, struct vor_mesh *mesh, const struct vor_soup_of *of,
                         struct vor_error *err)
{
    struct vor_memory *memory = of->seeds->run.memory;
    struct soup soup = {.of = of, .normal = vor_cloud_find(of->result, VOR_NORMAL)};
    vor_status status;

    vor_cloud_init(&soup.cloud, memory);
    vor_mesh_init(&soup.mesh, memory);
    status = make(&soup, err);
    if (status == VOR_OK) {
        *out = soup.cloud;
        *mesh = soup.mesh;
    } else {
        vor_cloud_free(&soup.cloud);
        vor_mesh_free(&soup.mesh);
    }
    VOR_FREE_ALL(memory, soup.source, soup.triangle, soup.corner);
    return status;
}
