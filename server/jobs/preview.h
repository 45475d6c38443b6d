/** What a running job's points look like now: one buffer a job, overwritten, and only while
 * somebody looks, be it at another daemon. Thread-safe. */
#ifndef VOR_SERVER_JOBS_PREVIEW_H
#define VOR_SERVER_JOBS_PREVIEW_H

#include "core/base/watch.h"
#include "core/cloud/cloud.h"

#include <stdint.h>

/** Points that a preview has at most: 600 KB, which a browser draws in a moment and loopback
 *  carries in 1 ms. */
enum { VOR_PREVIEW_POINTS_MAX = 50000 };

/** Seconds between two previews of a job. */
#define VOR_PREVIEW_SECONDS 1.0

/** Points of a run as they move, and where in the run. */
struct vor_shown {
    struct vor_moving moving;
    double origin[3]; /**< that the positions are relative to */
    uint32_t iteration, polish;
};

/** How many of n points are shown where `most` may be. */
static inline size_t vor_shown_count(size_t n, size_t most)
{
    return n < most ? n : most;
}

/** The position of point `index` of `count` that are picked evenly from those that move, which are
 *  the same ones as long as there are as many. */
static inline void vor_shown_point(const struct vor_moving *moving, size_t index, size_t count,
                                   float out[3])
{
    size_t from = (size_t)((uint64_t)index * moving->n / count);

    for (int c = 0; c < 3; c++)
        out[c] =
            (float)((double)moving->xyz[3 * from + (size_t)c] * moving->unit + moving->shift[c]);
}

struct vor_preview;

/** One that nobody looks at, and that shows nothing; NULL when memory is out. */
struct vor_preview *vor_preview_create(void);

/** preview may be NULL. */
void vor_preview_destroy(struct vor_preview *preview);

/** Somebody begins to look, or ends. */
void vor_preview_look(struct vor_preview *preview);
void vor_preview_look_away(struct vor_preview *preview);

/** Up to that time (vor_clock_seconds) somebody looks by another daemon; or, where another daemon
 *  runs the job, that one has been told so. */
void vor_preview_look_elsewhere(struct vor_preview *preview, double until);

/** True while somebody looks; here; by another daemon, for so many seconds at least. Quick. */
int vor_preview_is_looked_at(const struct vor_preview *preview);
int vor_preview_is_looked_at_here(const struct vor_preview *preview);
int vor_preview_is_looked_at_elsewhere(const struct vor_preview *preview, double seconds);

/** Takes points in, at most VOR_PREVIEW_POINTS_MAX of them. Without memory it shows what it did. */
void vor_preview_put(struct vor_preview *preview, const struct vor_shown *shown);

/** What it shows. */
struct vor_preview_info {
    uint64_t version; /**< counts vor_preview_put; 0: nothing yet */
    size_t points;
    uint32_t iteration, polish;
};
void vor_preview_describe(struct vor_preview *preview, struct vor_preview_info *out);

/** What it shows, as bytes for another daemon: malloc, the caller frees; NULL where there is
 * nothing, or no memory. */
uint8_t *vor_preview_pack(struct vor_preview *preview, size_t *size, uint64_t *version);

/** Takes such bytes in, of an attempt of the job; and which version of it was taken in last, 0 for
 *  none. What is no preview, or finds no memory, changes nothing. */
void vor_preview_unpack(struct vor_preview *preview, uint32_t attempt, uint64_t version,
                        const uint8_t *bytes, size_t size);
uint64_t vor_preview_unpacked(struct vor_preview *preview, uint32_t attempt);

/** Makes *out, an initialised, empty cloud, of at most `most` of the points; its frame is that of
 *  the job's input.
 *
 *  @param[out] info  of what was taken
 *
 *  @retval VOR_E_EMPTY there is nothing to show yet
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_preview_cloud(struct vor_preview *preview, size_t most,
                                           struct vor_cloud *out, struct vor_preview_info *info,
                                           struct vor_error *err);

#endif
