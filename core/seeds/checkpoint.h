/** Checkpoints: what the next step of a stage reads, as bytes. A run tells them as it goes on
 *  (struct vor_watch); another run of the same request that is given the last one (vor_run.saved)
 *  prepares the input anew, goes on from there, and has the same result, to the byte, as one that
 *  was not broken off.
 *
 *  A checkpoint is made before the first step after each vor_run.every of counted work: searches
 *  and cells, which are the same for any number of threads. Seeds then forget their lists and fits,
 *  in every run, whether somebody keeps the checkpoint or not: so it has positions alone, and what
 *  a method adds to its stage. None is made where the request limits the time, nor while seeds
 *  start or a stage has none. */
#ifndef VOR_SEEDS_CHECKPOINT_H
#define VOR_SEEDS_CHECKPOINT_H

#include "core/seeds/outcome.h"
#include "core/seeds/seeds.h"

/** Room for the parts of a stage. */
#define VOR_CHECKPOINT_SLOTS 13

/** The checkpoints of one run of the engine. */
struct vor_checkpoints {
    uint64_t of;           /* sum over the request and its inputs */
    uint64_t done;         /* work that was counted before the last one */
    struct vor_part saved; /* to go on from; its size is 0 for none, and once it was taken */
};

/** Has checkpoints made of a run from now on, which goes on from run->saved if that is whole and of
 *  the same request and clouds.
 *
 *  @param[out] out       borrows run->saved; outlives the run
 *  @param[in]  previous  the earlier result, NULL for none
 *
 *  O(N) where there is a checkpoint, or somebody to tell of them. */
void vor_checkpoints_begin(struct vor_checkpoints *out, struct vor_run *run,
                           const struct vor_spec *spec, const struct vor_cloud *in,
                           const struct vor_cloud *previous);

/** Whether the run goes on from a checkpoint that was not taken yet: of whichever stage, or of that
 *  one. */
int vor_checkpoint_is(const struct vor_run *run);
int vor_checkpoint_is_in(const struct vor_run *run, enum vor_run_stage stage);

/** Makes the seeds of the checkpoint that the run goes on from, on the whole domain, instead of
 *  first positions.
 *
 *  @param[out] out   free with vor_seeds_free; untouched on failure
 *  @param[out] told  as it was
 *
 *  @retval VOR_E_NOMEM, VOR_E_INTERNAL  it is of other seeds */
VOR_NODISCARD vor_status vor_checkpoint_seeds(struct vor_seeds *out, struct vor_outcome *told,
                                              const struct vor_domain *domain,
                                              const struct vor_run *run, struct vor_error *err);

/** A stage whose next step follows. */
struct vor_checkpoint_of {
    const struct vor_run *run;
    const struct vor_spec *spec;
    struct vor_seeds *seeds;
    struct vor_outcome *told;
    enum vor_run_stage stage;
    struct vor_part part[VOR_CHECKPOINT_SLOTS]; /**< what of its own the step reads */
};

/** Fills all of that from the checkpoint, if the run goes on from one. Seeds that had come to the
 *  whole domain are put there.
 *
 *  @param[out] taken  whether there was one
 *
 *  @retval VOR_E_INTERNAL  it is of another stage */
VOR_NODISCARD vor_status vor_checkpoint_take(const struct vor_checkpoint_of *of, int *taken,
                                             struct vor_error *err);

/** Makes a checkpoint, if enough work was counted. O(n). */
void vor_checkpoint_make(const struct vor_checkpoint_of *of);

#endif
