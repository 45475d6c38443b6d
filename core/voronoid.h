/** libvoronoid: the engine in the process of a caller, for a codec that cannot afford HTTP. Arrays
 * of floats in and out; no files, sockets, environment, clock or globals. This is the only header
 * that is installed, and its functions are all that the library exports.
 *
 *  Clouds are n points of three float32 each, x y z x y z ..., in any unit. All arrays are the
 *  caller's. Each function may be called from several threads at once with arrays of their own,
 * also with the same pool, whose threads they then share. The same input gives the same bytes for
 * any number of threads.
 *
 *  Version 0: structs and functions may still change with the name of the library
 *  (libvoronoid.so.0). */
#ifndef VORONOID_H
#define VORONOID_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define VOR_API __attribute__((visibility("default")))

/** Points, and of each `components` further float32 (colours, intensities), which a result takes
 *  over from the points of the input around it. */
struct vor_points {
    size_t n;            /**< points; 1 to 2^31 - 2 */
    float *xyz;          /**< n x 3, finite */
    float *values;       /**< n x components; NULL if components is 0 */
    unsigned components; /**< 0 to 16 */
};

/** How far a run is. */
struct vor_state {
    unsigned iteration; /**< iterations, then steps of the polish, done so far */
    double delta;       /**< standard deviation of the distances to the nearest neighbour over their
                             mean */
};

/** What a progress function answers. */
enum vor_told {
    VOR_GO_ON,
    VOR_TAKE_BEST, /**< end now with the best result so far */
    VOR_GIVE_UP    /**< end now with none: the call fails, "cancelled" */
};

struct vor_threads;

/** How a call runs. Zero bytes are the defaults. */
struct vor_call {
    struct vor_threads *threads; /**< pool; NULL: the call starts one thread of its own */
    size_t memory;               /**< most bytes that the call may take; 0: no limit */
    /** Parameters and values in turn, "neighbors", "20", "method", "ear", then NULL: those of the
     *  process, as `voronoid help parameters` lists them, but the number of points; NULL: none. */
    const char *const *parameters;
    /** Called from the calling thread after each iteration and step; may be NULL. restore is too
     *  short for it. */
    enum vor_told (*progress)(void *ctx, const struct vor_state *state);
    void *ctx; /**< handed to progress */
};

/** Why a call failed. */
struct vor_failure {
    char name[32];      /**< as the problems of the HTTP interface: "degenerate-cloud",
                             "too-much-memory", "invalid-parameter"; "" where it did not fail */
    char parameter[32]; /**< the parameter at fault, or "" */
    char message[1024]; /**< a sentence */
};

/** Starts a pool of 1 to 256 threads. Returns NULL, and says why in *failure (may be NULL), if it
 *  cannot. */
VOR_API struct vor_threads *vor_threads_start(unsigned threads, struct vor_failure *failure);

/** Ends the threads of a pool that no call uses any more. threads may be NULL. */
VOR_API void vor_threads_end(struct vor_threads *threads);

/** Moves the points of a decoded cloud towards the surface, each in the cell that a codec rounded
 * it to. Their number and order stay, and values are not looked at. Where the cloud has no lattice,
 * or cells smaller than a tenth of the spacing, the points stay as they are, bit for bit.
 *
 *  @param[in]  call     may be NULL
 *  @param[out] failure  may be NULL
 *
 *  @return 0; or -1, with the points as they were
 *
 *  1 to 4 us of CPU and up to 180 bytes a point. */
VOR_API int vor_restore(struct vor_points *points, const struct vor_call *call,
                        struct vor_failure *failure);

/** Spreads out->n points evenly over the surface of a cloud.
 *
 *  @param[in,out] out  n, components and the arrays set by the caller; xyz and values are written.
 *                      components is that of `in`, or 0; n at most 16 times in->n
 *  @param[in]     in   not changed
 *  @param[in]  call     may be NULL
 *  @param[out] failure  may be NULL
 *
 *  @return 0; or -1, with nothing written
 *
 *  O(in->n log in->n + out->n) an iteration, 20 to 100 us of CPU a point of the larger; memory as
 *  that of the command. */
VOR_API int vor_resample(struct vor_points *out, const struct vor_points *in,
                         const struct vor_call *call, struct vor_failure *failure);

/** The same with the defaults of upsample: one iteration and a few steps. out->n is at least in->n.
 */
VOR_API int vor_upsample(struct vor_points *out, const struct vor_points *in,
                         const struct vor_call *call, struct vor_failure *failure);

#ifdef __cplusplus
}
#endif

#endif
