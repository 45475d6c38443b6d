/* What edges the detector finds of a cloud, beside those of the mesh that it was taken from, and
 * what it costs: a JSON object.
 *
 * usage: edges CLOUD.ply MESH.ply|-, - for a cloud of no mesh */
#include "core/input/edges.h"
#include "core/input/input.h"
#include "tests/support/read_cloud.h"
#include "tests/support/vt_mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double sharp_degrees = 30; /* where an edge of the mesh counts */

static double cpu_seconds(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* The true edges, the area of the mesh, and what a detector made of them. */
static vor_status judge(const struct vor_edges *edges, const struct vor_domain *domain,
                        const struct vor_cloud *cloud, const char *path, struct vor_error *err)
{
    struct vt_segments truth = {0};
    struct vt_mesh mesh;
    struct vt_judged judged;
    double *xyz = malloc(domain->n * 3 * sizeof *xyz), spacing;

    if (xyz == NULL || vt_mesh_read(&mesh, path) != 0)
        return vor_fail(err, VOR_E_IO, "%s cannot be read", path);
    if (vt_mesh_sharp(&truth, &mesh, sharp_degrees) != 0)
        return vor_fail(err, VOR_E_NOMEM, "edges of %s", path);
    for (size_t i = 0; i < domain->n; i++)
        vor_cloud_position(cloud, domain->source[i], &xyz[3 * i]);
    spacing = sqrt(vt_mesh_area(&mesh) / (double)domain->n);
    judged = vt_segments_judge(&truth, xyz, edges->flag, domain->n, spacing);
    (void)printf(",\"precision\":%.4f,\"recall\":%.4f,\"length_true\":%.4f", judged.precision,
                 judged.recall, vt_segments_length(&truth));
    vt_segments_free(&truth);
    vt_mesh_free(&mesh);
    free(xyz);
    return VOR_OK;
}

static vor_status measure(struct vor_cloud *cloud, char **argv, const struct vor_run *run,
                          struct vor_error *err)
{
    struct vor_spec spec;
    struct vor_domain domain;
    struct vor_edges edges;
    double began;
    vor_status status = read_cloud(cloud, argv[1], err);

    if (status != VOR_OK)
        return status;
    vor_spec_init(&spec);
    status = vor_input_prepare(&domain, cloud, &spec, run, err);
    if (status != VOR_OK)
        return status;
    began = cpu_seconds();
    status = vor_edges_find(&edges, &domain, run, err);
    if (status == VOR_OK) {
        (void)printf("{\"n\":%zu,\"neighbors\":%u,\"us\":%.3f,", domain.n,
                     domain.known.neighbors.usual,
                     (cpu_seconds() - began) / (double)domain.n * 1e6);
        (void)printf("\"share\":%.6f,\"length\":%.4f", (double)edges.flagged / (double)domain.n,
                     edges.length * domain.unit);
        if (strcmp(argv[2], "-") != 0)
            status = judge(&edges, &domain, cloud, argv[2], err);
        (void)printf("}\n");
        vor_edges_free(&edges);
    }
    vor_domain_free(&domain);
    return status;
}

int main(int argc, char **argv)
{
    struct vor_memory memory;
    struct vor_run run = {.memory = &memory};
    struct vor_cloud cloud;
    struct vor_error err;
    vor_status status;

    if (argc != 3) {
        (void)fprintf(stderr, "usage: edges CLOUD.ply MESH.ply|-\n");
        return 2;
    }
    vor_memory_init(&memory, SIZE_MAX);
    vor_cloud_init(&cloud, &memory);
    status = vor_pool_create(&run.pool, 1, &err);
    if (status == VOR_OK)
        status = measure(&cloud, argv, &run, &err);
    if (status != VOR_OK)
        (void)fprintf(stderr, "%s\n", err.message);
    vor_cloud_free(&cloud);
    vor_pool_destroy(run.pool);
    return status == VOR_OK ? 0 : 1;
}
