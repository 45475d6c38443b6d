/** What the tests of the engine share: a pool with a run and a request, shapes, and slow obvious
 *  twins. */
#ifndef VT_ENGINE_H
#define VT_ENGINE_H

#include "core/engine.h"
#include "tests/support/vt.h"

/** Cells that end where the input does, and patches of the usual width. */
#define vt_policy ((struct vor_seeds_policy){.keep_border = 1, .widen = 1})

/** A pool of threads, a run on it that allocates from vt_memory, a request at its defaults. */
struct vt_engine {
    struct vor_pool *pool;
    struct vor_run run;
    struct vor_spec spec;
    const struct vor_cloud *previous; /**< of vt_engine_try and vt_engine_resample; NULL: none */
};

void vt_engine_open(struct vt_engine *engine, unsigned threads);
void vt_engine_close(struct vt_engine *engine);

/** Sets one parameter of the request from text; a mistake fails the test. */
void vt_engine_set(struct vt_engine *engine, const char *name, const char *text);
void vt_engine_count(struct vt_engine *engine, const char *name, size_t value);

/** Resamples and asserts that it works; out is initialised here. */
void vt_engine_resample(struct vt_engine *engine, struct vor_cloud *out, struct vor_report *report,
                        const struct vor_cloud *in);

/** The same without asserting that it works; report is all zero where it does not. */
vor_status vt_engine_try(struct vt_engine *engine, struct vor_cloud *out, struct vor_report *report,
                         const struct vor_cloud *in);

/** vor_engine_run of a process with one cloud in, a cloud and a report out. out is initialised and
 * empty; in is borrowed; report is untouched on failure. */
vor_status vt_run_engine(struct vor_cloud *out, struct vor_report *report,
                         const struct vor_cloud *in, const struct vor_spec *spec,
                         const struct vor_run *run, struct vor_error *err);

/** A cloud of n points with unset positions. */
void vt_cloud_make(struct vor_cloud *cloud, size_t n);

/** n points, even by area, on the surface of the unit cube / on the upper half of the unit sphere.
 */
void vt_cloud_box(struct vor_cloud *cloud, uint64_t seed, size_t n);
void vt_cloud_dome(struct vor_cloud *cloud, uint64_t seed, size_t n);

/** A square lattice of side x side points at z = 0, one apart. */
void vt_cloud_lattice(struct vor_cloud *cloud, size_t side);

/** A standard normal number. */
double vt_normal(uint64_t seed, uint64_t index);

/** Squared distance from x to the nearest point, by looking at every one; *which may be NULL. */
double vt_nearest2(const struct vor_cloud *cloud, const double x[3], size_t *which);

/** Number of points that share their place with an earlier one. */
size_t vt_coincident(const struct vor_cloud *cloud);

/** FNV-1a. */
uint64_t vt_hash(const void *data, size_t size);

/** Hash of the positions, relative and origin. */
uint64_t vt_cloud_hash(const struct vor_cloud *cloud);

/** What a run of the process mesh came to. */
struct vt_meshed {
    struct vor_cloud cloud;
    struct vor_mesh mesh;
    struct vor_report report;
};

/** Runs the engine's request of a process whose cloud has faces. *out is all zero on failure, else
 *  freed with vt_meshed_free. */
vor_status vt_engine_mesh(struct vt_meshed *out, const struct vor_cloud *in,
                          const struct vt_engine *engine);

void vt_meshed_free(struct vt_meshed *meshed);

#endif
