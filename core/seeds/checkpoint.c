#include "core/seeds/checkpoint.h"

#include "core/base/rng.h"

#include <stddef.h>
#include <string.h>

/* Of this layout: anything else is not a checkpoint. */
static const uint64_t kind = UINT64_C(0x31736b63656863);

/* Parts: those of the seeds, and those of their stage. */
enum { SEED_SLOTS = 3, PARTS = SEED_SLOTS + VOR_CHECKPOINT_SLOTS };

/* What a checkpoint begins with; its parts follow. */
struct saved {
    uint64_t kind, of;
    uint64_t sum; /* over all that follows */
    uint64_t size[PARTS];
    enum vor_run_stage stage;
    struct vor_outcome told;
    /* of the seeds: */
    uint64_t n, fixed, half, indexed_before, indexed;
    struct vor_counts counts;
    struct vor_seeds_policy policy;
    double coherence, area;
    uint32_t unused;
    int on_whole, tracks, normals;
};

enum { SUMMED = offsetof(struct saved, size) };

/* A sum over bytes, after those of `sum`: any changed bit changes it. */
static uint64_t add(uint64_t sum, const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    uint64_t word = 0;

    for (; size >= sizeof word; size -= sizeof word, at += sizeof word) {
        memcpy(&word, at, sizeof word);
        sum = vor_rng_mix(sum ^ word);
    }
    word = size;
    for (; size > 0; size--)
        word = word << 8 | *at++;
    return vor_rng_mix(sum ^ word);
}

/* Whether a checkpoint is whole: its parts fill it, and the sum is right. */
static int is_whole(const struct saved *saved, const struct vor_part *block)
{
    const unsigned char *at = block->bytes;
    size_t left = block->size - sizeof *saved;
    uint64_t sum = add(0, at + SUMMED, sizeof *saved - SUMMED);

    at += sizeof *saved;
    for (int i = 0; i < PARTS; i++) {
        if (saved->size[i] > left)
            return 0;
        sum = add(sum, at, saved->size[i]);
        at += saved->size[i];
        left -= saved->size[i];
    }
    return left == 0 && sum == saved->sum;
}

static uint64_t add_cloud(uint64_t sum, const struct vor_cloud *cloud)
{
    sum = add(sum, cloud->origin, sizeof cloud->origin);
    return add(sum, cloud->xyz, 3 * cloud->n * sizeof *cloud->xyz);
}

void vor_checkpoints_begin(struct vor_checkpoints *out, struct vor_run *run,
                           const struct vor_spec *spec, const struct vor_cloud *in,
                           const struct vor_cloud *previous)
{
    struct saved saved;

    *out = (struct vor_checkpoints){.of = run->every};
    run->checkpoints = out;
    if (run->saved.size == 0 && (run->watch == NULL || run->watch->checkpoint == NULL))
        return;
    out->of = add(out->of, spec->process->id, strlen(spec->process->id));
    out->of = add(out->of, spec->value, sizeof spec->value);
    out->of = add(out->of, spec->texts, sizeof spec->texts);
    out->of = add_cloud(out->of, in);
    if (previous != NULL)
        out->of = add_cloud(out->of, previous);
    if (run->saved.size < sizeof saved)
        return;
    memcpy(&saved, run->saved.bytes, sizeof saved);
    if (saved.kind == kind && saved.of == out->of && is_whole(&saved, &run->saved))
        out->saved = run->saved;
}

/* The checkpoint that the run goes on from; false where there is none. */
static int look(struct saved *out, const struct vor_run *run)
{
    if (run->checkpoints == NULL || run->checkpoints->saved.size == 0)
        return 0;
    memcpy(out, run->checkpoints->saved.bytes, sizeof *out);
    return 1;
}

int vor_checkpoint_is(const struct vor_run *run)
{
    struct saved saved;

    return look(&saved, run);
}

int vor_checkpoint_is_in(const struct vor_run *run, enum vor_run_stage stage)
{
    struct saved saved;

    return look(&saved, run) && saved.stage == stage;
}

static void parts_of(struct vor_part out[SEED_SLOTS], const struct vor_seeds *seeds)
{
    size_t row = 3 * seeds->n * sizeof *seeds->xyz;

    out[0] = (struct vor_part){seeds->xyz, row};
    out[1] = (struct vor_part){seeds->normal, seeds->normal != NULL ? row : 0};
    out[2] =
        (struct vor_part){seeds->track, seeds->track != NULL ? seeds->n * sizeof *seeds->track : 0};
}

/* Fills the first parts from the checkpoint. */
static vor_status fill(const struct vor_part *part, unsigned count, const struct saved *saved,
                       const struct vor_run *run, struct vor_error *err)
{
    const unsigned char *at = run->checkpoints->saved.bytes;

    at += sizeof *saved;
    for (unsigned i = 0; i < count; i++) {
        if (part[i].size != saved->size[i])
            return vor_fail(err, VOR_E_INTERNAL, "a checkpoint is of another run");
        if (part[i].size > 0)
            memcpy(part[i].bytes, at, part[i].size);
        at += part[i].size;
    }
    return VOR_OK;
}

/* Forgets all that seeds know besides where they are. */
static void forget(struct vor_seeds *seeds)
{
    vor_seeds_forget_input(seeds);
    vor_point_lists_forget(&seeds->point_lists);
    if (seeds->wanted.near != NULL)
        memset(seeds->wanted.near, 0, seeds->n * sizeof *seeds->wanted.near);
    if (seeds->stretched.near != NULL)
        memset(seeds->stretched.near, 0, seeds->n * sizeof *seeds->stretched.near);
}

static void count_from(struct vor_seeds *seeds, const struct saved *saved)
{
    struct vor_scratch *scratch = seeds->scratch;

    for (unsigned i = 0; i < vor_pool_threads(seeds->run.pool); i++)
        scratch[i].queries = scratch[i].cells = scratch[i].bisectors = scratch[i].triangles = 0;
    scratch->queries = saved->counts.queries - saved->indexed * saved->n;
    scratch->cells = saved->counts.cells;
    scratch->bisectors = saved->counts.bisectors;
    scratch->triangles = saved->counts.triangles;
    seeds->indexed_before = saved->indexed_before;
    seeds->point_lists.indexed = saved->indexed;
}

vor_status vor_checkpoint_seeds(struct vor_seeds *out, struct vor_outcome *told,
                                const struct vor_domain *domain, const struct vor_run *run,
                                struct vor_error *err)
{
    struct vor_seeds seeds = {.n = 0};
    struct vor_part part[SEED_SLOTS];
    struct saved saved = {.n = 0};
    vor_status status = VOR_OK;

    if (!look(&saved, run) || saved.n == 0 || saved.size[0] / (3 * sizeof(float)) != saved.n)
        return vor_fail(err, VOR_E_INTERNAL, "a checkpoint is of another run");
    status = vor_seeds_init(&seeds, domain, saved.n, saved.policy, run, err);
    if (status == VOR_OK && saved.normals)
        seeds.normal = vor_malloc(run->memory, saved.n, 3 * sizeof *seeds.normal);
    if (status == VOR_OK && saved.tracks)
        seeds.track = vor_malloc(run->memory, saved.n, sizeof *seeds.track);
    if (status == VOR_OK &&
        ((saved.normals && seeds.normal == NULL) || (saved.tracks && seeds.track == NULL)))
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", seeds.n);
    if (status == VOR_OK) {
        parts_of(part, &seeds);
        status = fill(part, SEED_SLOTS, &saved, run, err);
    }
    if (status != VOR_OK) {
        vor_seeds_free(&seeds);
        return status;
    }
    seeds.fixed = saved.fixed;
    seeds.half = saved.half;
    seeds.coherence = saved.coherence;
    seeds.area = saved.area;
    seeds.unused = saved.unused;
    *told = saved.told;
    *out = seeds;
    return VOR_OK;
}

vor_status vor_checkpoint_take(const struct vor_checkpoint_of *of, int *taken,
                               struct vor_error *err)
{
    struct vor_checkpoints *checkpoints = of->run->checkpoints;
    struct vor_part part[PARTS];
    struct saved saved;
    vor_status status;

    *taken = look(&saved, of->run);
    if (!*taken)
        return VOR_OK;
    if (saved.stage != of->stage)
        return vor_fail(err, VOR_E_INTERNAL, "a checkpoint is of another stage");
    parts_of(part, of->seeds);
    memcpy(&part[SEED_SLOTS], of->part, sizeof of->part);
    status = fill(part, PARTS, &saved, of->run, err);
    checkpoints->saved.size = 0;
    checkpoints->done = saved.counts.queries + saved.counts.cells;
    if (status == VOR_OK && saved.on_whole)
        status = vor_seeds_onto(of->seeds, of->seeds->whole, err);
    forget(of->seeds);
    count_from(of->seeds, &saved);
    *of->told = saved.told;
    if (status == VOR_OK && of->run->watch != NULL && of->run->watch->checkpoint != NULL)
        of->run->watch->checkpoint(of->run->watch->ctx, NULL, 0);
    return status;
}

static void save(const struct vor_checkpoint_of *of, const struct vor_counts *counts)
{
    const struct vor_watch *watch = of->run->watch;
    const struct vor_seeds *seeds = of->seeds;
    struct vor_part part[1 + PARTS];
    struct saved saved;

    memset(&saved, 0, sizeof saved); /* and what lies between its members */
    saved.kind = kind;
    saved.of = of->run->checkpoints->of;
    saved.stage = of->stage;
    saved.told = *of->told;
    saved.n = seeds->n;
    saved.fixed = seeds->fixed;
    saved.half = seeds->half;
    saved.indexed_before = seeds->indexed_before;
    saved.indexed = seeds->point_lists.indexed;
    saved.counts = *counts;
    saved.policy = seeds->policy;
    saved.coherence = seeds->coherence;
    saved.area = seeds->area;
    saved.unused = seeds->unused;
    saved.on_whole = vor_seeds_on_whole(seeds);
    saved.tracks = seeds->track != NULL;
    saved.normals = seeds->normal != NULL;
    part[0] = (struct vor_part){&saved, sizeof saved};
    parts_of(&part[1], seeds);
    memcpy(&part[1 + SEED_SLOTS], of->part, sizeof of->part);
    for (int i = 0; i < PARTS; i++)
        saved.size[i] = part[1 + i].size;
    saved.sum = add(0, (unsigned char *)&saved + SUMMED, sizeof saved - SUMMED);
    for (int i = 0; i < PARTS; i++)
        saved.sum = add(saved.sum, part[1 + i].bytes, part[1 + i].size);
    watch->checkpoint(watch->ctx, part, 1 + PARTS);
}

void vor_checkpoint_make(const struct vor_checkpoint_of *of)
{
    const struct vor_run *run = of->run;
    struct vor_counts counts = vor_seeds_counts(of->seeds);
    uint64_t done = counts.queries + counts.cells;

    if (run->checkpoints == NULL || vor_spec_given(of->spec, VOR_PARAM_SECONDS) ||
        done - run->checkpoints->done < (run->every > 0 ? run->every : VOR_CHECKPOINT_WORK))
        return;
    run->checkpoints->done = done;
    forget(of->seeds);
    if (run->watch != NULL && run->watch->checkpoint != NULL)
        save(of, &counts);
}
