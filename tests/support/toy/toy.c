#include "tests/support/toy/toy.h"

#include "core/cloud/frame.h"
#include "core/method.h"
#include "core/process.h"
#include "core/report.h"

#include <math.h>
#include <string.h>
#include <time.h>

/* --- steps ------------------------------------------------------------------------------------ */

/* The stages of a run as they are told, all of as many steps. */
struct steps {
    const struct vor_run *run;
    struct vor_record record;
    double pause;
};

static struct steps steps_of(const struct vor_spec *spec, const struct vor_run *run)
{
    static const double blink = 0.05;
    double pause = spec->value[VOR_PARAM_PAUSE];
    struct steps steps = {.run = run, .record = {.of = (uint32_t)spec->value[VOR_PARAM_PARTS]}};

    if (vor_spec_form(spec, VOR_PARAM_PAUSE) == VOR_FORM_WORD)
        pause = pause == VOR_WORD(1) ? blink : 0;
    steps.pause = pause;
    /* Nothing here is iterated: no such member has a value. */
    steps.record.delta = steps.record.sigma = steps.record.epsilon = (double)NAN;
    steps.record.energy = steps.record.max_move = (double)NAN;
    return steps;
}

static vor_status answered(enum vor_answer answer, struct vor_error *err)
{
    if (answer == VOR_CONTINUE)
        return VOR_OK;
    return answer == VOR_STOP ? vor_fail(err, VOR_E_STOPPED, "stopped by the caller")
                              : vor_fail(err, VOR_E_CANCELLED, "cancelled by the caller");
}

static vor_status tell(struct steps *steps, struct vor_error *err)
{
    const struct vor_watch *watch = steps->run->watch;

    steps->record.seconds = vor_run_seconds(steps->run);
    if (watch == NULL || watch->progress == NULL)
        return VOR_OK;
    return answered(watch->progress(watch->ctx, &steps->record), err);
}

/* Enters a stage, which so many others follow. */
static vor_status enter(struct steps *steps, enum vor_run_stage stage, uint32_t others,
                        struct vor_error *err)
{
    steps->record.stage = stage;
    steps->record.step = 0;
    steps->record.ahead = others * steps->record.of;
    return tell(steps, err);
}

/* Waits until a step that began then has lasted long enough. Without a clock it has. */
static vor_status wait(const struct steps *steps, double began, struct vor_error *err)
{
    static const struct timespec blink = {0, 1000000};
    const struct vor_watch *watch = steps->run->watch;
    vor_status status = VOR_OK;

    if (watch == NULL || watch->clock == NULL)
        return VOR_OK;
    while (status == VOR_OK && vor_run_clock(steps->run) < began + steps->pause) {
        (void)nanosleep(&blink, NULL);
        if (watch->poll != NULL)
            status = answered(watch->poll(watch->ctx), err);
    }
    return status;
}

/* Where part `part` of n rows begins. */
static size_t part_of(const struct steps *steps, size_t n, uint32_t part)
{
    return (size_t)((double)n * part / steps->record.of);
}

typedef vor_status (*part_task)(void *ctx, size_t begin, size_t end, struct vor_error *err);

/* Goes through a stage: does a part of n rows with each step. */
static vor_status go_through(struct steps *steps, size_t n, part_task task, void *ctx,
                             struct vor_error *err)
{
    struct vor_record *record = &steps->record;
    vor_status status = VOR_OK;

    while (status == VOR_OK && record->step < record->of) {
        double began = vor_run_clock(steps->run);

        status =
            task(ctx, part_of(steps, n, record->step), part_of(steps, n, record->step + 1), err);
        if (status == VOR_OK)
            status = wait(steps, began, err);
        record->step++;
        if (status == VOR_OK)
            status = tell(steps, err);
    }
    return status;
}

/* --- the method ------------------------------------------------------------------------------- */

static vor_status copy_part(void *ctx, size_t begin, size_t end, struct vor_error *err)
{
    struct vor_seeds *seeds = ctx;
    const struct vor_domain *domain = seeds->domain;

    (void)err;
    for (size_t i = begin; i < end; i++) {
        size_t from = (size_t)((double)i * (double)domain->n / (double)seeds->n);

        memcpy(&seeds->xyz[3 * i], &domain->xyz[3 * from], 3 * sizeof *seeds->xyz);
    }
    return VOR_OK;
}

static vor_status prove_part(void *ctx, size_t begin, size_t end, struct vor_error *err)
{
    const struct vor_seeds *seeds = ctx;

    for (size_t i = begin; i < end; i++) {
        uint32_t index;
        float distance2;

        vor_knn_search(seeds->domain->knn, &seeds->xyz[3 * i], 1, 1, &index, &distance2);
        if (distance2 > 0)
            return vor_fail(err, VOR_E_INTERNAL, "copy %zu is no point of the input", i);
    }
    return VOR_OK;
}

/* Goes through one stage of the method and notes it. */
static vor_status place(struct vor_seeds *seeds, struct vor_outcome *told, struct steps *steps,
                        part_task task, struct vor_error *err)
{
    double began = vor_run_clock(steps->run);
    vor_status status = go_through(steps, seeds->n, task, seeds, err);

    vor_outcome_stage(told, steps->record.stage, steps->record.step,
                      vor_run_clock(steps->run) - began);
    told->last = steps->record;
    if (status != VOR_E_STOPPED)
        return status;
    told->stopped = VOR_STOPPED_CALLER;
    return VOR_OK;
}

/* What a stop left out. */
static vor_status copy_rest(struct vor_seeds *seeds, const struct steps *steps,
                            struct vor_error *err)
{
    return copy_part(seeds, part_of(steps, seeds->n, steps->record.step), seeds->n, err);
}

static vor_status copy_and_prove(struct vor_seeds *seeds, struct vor_outcome *told,
                                 struct steps *steps, struct vor_error *err)
{
    vor_status status = enter(steps, VOR_RUN_STAGE_COPY, 1, err);

    told->stopped = VOR_STOPPED_COPIED;
    if (status == VOR_OK)
        status = place(seeds, told, steps, copy_part, err);
    if (status == VOR_E_STOPPED || told->stopped == VOR_STOPPED_CALLER) {
        told->stopped = VOR_STOPPED_CALLER;
        return copy_rest(seeds, steps, err);
    }
    if (status == VOR_OK)
        status = enter(steps, VOR_RUN_STAGE_PROVE, 0, err);
    if (status == VOR_OK)
        return place(seeds, told, steps, prove_part, err);
    if (status != VOR_E_STOPPED)
        return status;
    told->stopped = VOR_STOPPED_CALLER;
    return VOR_OK;
}

vor_status vor_toy_run(struct vor_seeds *out, struct vor_outcome *told,
                       const struct vor_domain *domain, size_t n, const struct vor_spec *spec,
                       const struct vor_run *run, struct vor_error *err)
{
    struct steps steps = steps_of(spec, run);
    struct vor_seeds seeds;
    vor_status status;

    if (n > domain->n)
        return vor_fail_param(err, VOR_E_TARGET, "points",
                              "%zu points are asked for, want 1 to %zu: toy copies points of the "
                              "input, and only those at different places",
                              n, domain->n);
    status = vor_seeds_init(&seeds, domain, n, vor_seeds_policy_of(spec), run, err);
    if (status != VOR_OK)
        return status;
    status = copy_and_prove(&seeds, told, &steps, err);
    if (status != VOR_OK) {
        vor_seeds_free(&seeds);
        return status;
    }
    *out = seeds;
    return VOR_OK;
}

/* --- points that count ------------------------------------------------------------------------ */

/* A box around points; low > high where there is none. */
struct box {
    double low[3], high[3];
};

static const struct box no_box = {{INFINITY, INFINITY, INFINITY},
                                  {-INFINITY, -INFINITY, -INFINITY}};

static void box_add(struct box *box, const double x[3])
{
    for (int c = 0; c < 3; c++) {
        box->low[c] = fmin(box->low[c], x[c]);
        box->high[c] = fmax(box->high[c], x[c]);
    }
}

/* Finds the attribute that points must have to count; *out is NULL where all do. */
static vor_status find_among(const struct vor_attribute **out, const struct vor_cloud *cloud,
                             const struct vor_spec *spec, struct vor_error *err)
{
    const char *name = vor_spec_name(spec, VOR_PARAM_AMONG);

    *out = name != NULL ? vor_cloud_find_name(cloud, name) : NULL;
    if (name == NULL || *out != NULL)
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, "among",
                          "among is attribute:%s, want all or an attribute that the cloud has",
                          name);
}

/* Whether any byte of the attribute's value is set. */
static int counts(const struct vor_attribute *among, size_t i)
{
    size_t size = among != NULL ? among->components * vor_type_size(among->type) : 0;
    const unsigned char *value = among != NULL ? (unsigned char *)among->data + i * size : NULL;

    for (size_t b = 0; b < size; b++)
        if (value[b] != 0)
            return 1;
    return among == NULL;
}

/* Whether lengths are taken along axis c, where points lie in the box. */
static int has_axis(const struct vor_spec *spec, const struct box *box, unsigned c)
{
    if (vor_spec_form(spec, VOR_PARAM_AXES) == VOR_FORM_AUTO)
        return box->high[c] > box->low[c];
    return vor_list_has(spec->value[VOR_PARAM_AXES], c);
}

static int is_near(const struct vor_spec *spec, double distance, double nearby)
{
    return spec->value[VOR_PARAM_STRICT] != 0 ? distance < nearby : distance <= nearby;
}

/* The distance that is near: the one given, else `usual`. */
static double nearby_of(const struct vor_spec *spec, double usual)
{
    int is_auto = vor_spec_form(spec, VOR_PARAM_NEARBY) == VOR_FORM_AUTO;

    return is_auto ? usual : spec->value[VOR_PARAM_NEARBY];
}

/* --- the census ------------------------------------------------------------------------------- */

#define VOR_KIND_OF_SPEC(type, field) .kind = VOR_MEMBER_REQUEST

#define CENSUS_TABLE(X)                                                                            \
    X(U64, points, "points", "points", "Points of the cloud")                                      \
    X(U64, seen, "seen", "points", "Points that were looked at: all, but after a stop")            \
    X(U64, counted, "counted", "points", "Those of them that count")                               \
    X(U64, close, "near", "points", "Those of them near the middle")                               \
    X(REAL, nearby, "nearby", "unit of the cloud", "Distance that is near")                        \
    X(OPTIONAL, has_box, "box", "", "Only on request")                                             \
    X(VECTOR, size, "box", "unit of the cloud", "Length of the box, 0 along axes left out")        \
    X(OPTIONAL, has_middle, "middle", "", "Only on request")                                       \
    X(VECTOR, middle, "middle", "unit of the cloud", "Middle of the box")                          \
    X(SPEC, parameters, "parameters", "", "The request")

struct census {
    CENSUS_TABLE(VOR_FIELD)
};

static const struct vor_member census_rows[] = {
#define CENSUS_ROW(...) VOR_MEMBER(struct census, __VA_ARGS__)
    CENSUS_TABLE(CENSUS_ROW)
#undef CENSUS_ROW
};

const struct vor_members vor_toy_census_members = VOR_MEMBERS(struct census, census_rows);

/* A census that is taken. */
struct taking {
    struct census *census;
    const struct vor_cloud *cloud;
    const struct vor_spec *spec;
    const struct vor_attribute *among;
    struct box box;
};

static vor_status tally_part(void *ctx, size_t begin, size_t end, struct vor_error *err)
{
    struct taking *taking = ctx;

    (void)err;
    for (size_t i = begin; i < end; i++) {
        double x[3];

        if (!counts(taking->among, i))
            continue;
        vor_cloud_position(taking->cloud, i, x);
        box_add(&taking->box, x);
        taking->census->counted++;
    }
    taking->census->seen = end;
    return VOR_OK;
}

static vor_status reach_part(void *ctx, size_t begin, size_t end, struct vor_error *err)
{
    struct taking *taking = ctx;
    struct census *census = taking->census;

    (void)err;
    for (size_t i = begin; i < end; i++) {
        double x[3], sum = 0;

        if (!counts(taking->among, i))
            continue;
        vor_cloud_position(taking->cloud, i, x);
        for (unsigned c = 0; c < 3; c++)
            if (has_axis(taking->spec, &taking->box, c))
                sum += (x[c] - census->middle[c]) * (x[c] - census->middle[c]);
        census->close += (uint64_t)is_near(taking->spec, sqrt(sum), census->nearby);
    }
    return VOR_OK;
}

/* What follows from the box: its parts, its middle, what is near. */
static void measure_box(struct taking *taking)
{
    struct census *census = taking->census;
    const struct box *box = &taking->box;
    double sum = 0;

    for (unsigned c = 0; c < 3 && census->counted > 0; c++) {
        census->size[c] = has_axis(taking->spec, box, c) ? box->high[c] - box->low[c] : 0;
        census->middle[c] = (box->low[c] + box->high[c]) / 2;
        sum += census->size[c] * census->size[c];
    }
    census->nearby = nearby_of(taking->spec, sqrt(sum) / 2);
}

static vor_status take_census(struct taking *taking, struct steps *steps, struct vor_error *err)
{
    size_t n = taking->cloud->n;
    vor_status status = enter(steps, VOR_RUN_STAGE_TALLY, 1, err);

    if (status == VOR_OK)
        status = go_through(steps, n, tally_part, taking, err);
    measure_box(taking);
    if (status == VOR_OK)
        status = enter(steps, VOR_RUN_STAGE_REACH, 0, err);
    if (status == VOR_OK)
        status = go_through(steps, n, reach_part, taking, err);
    return status == VOR_E_STOPPED ? VOR_OK : status;
}

vor_status vor_toy_census(struct vor_artefacts *out, const struct vor_artefacts *in,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    struct census *census = vor_artefacts_put_document(out, "census", &vor_toy_census_members, err);
    struct taking taking = {census, vor_artefacts_cloud(in, "cloud"), spec, NULL, no_box};
    struct steps steps = steps_of(spec, run);
    vor_status status;

    if (census == NULL)
        return VOR_E_NOMEM;
    status = find_among(&taking.among, taking.cloud, spec, err);
    if (status != VOR_OK)
        return status;
    census->points = taking.cloud->n;
    census->has_box = vor_list_has(spec->value[VOR_PARAM_TELL], 0);
    census->has_middle = vor_list_has(spec->value[VOR_PARAM_TELL], 1);
    census->parameters = *spec;
    return take_census(&taking, &steps, err);
}

/* --- the overlap ------------------------------------------------------------------------------ */

#define DISTANCES_TABLE(X)                                                                         \
    X(REAL, mean, "mean", "unit of the cloud", "Their mean")                                       \
    X(REAL, max, "max", "unit of the cloud", "The largest")

struct distances {
    DISTANCES_TABLE(VOR_FIELD)
};

#define VOR_FIELD_DISTANCES(field) struct distances field;
#define VOR_KIND_OF_DISTANCES(type, field) .kind = VOR_MEMBER_OBJECT, .inner = &distances_members

#define OVERLAP_TABLE(X)                                                                           \
    X(U64, points, "points.cloud", "points", "Points of the cloud")                                \
    X(U64, others, "points.other", "points", "Points of the other one")                            \
    X(U64, counted, "points.counted", "points", "Points of the cloud that count")                  \
    X(U64, close, "near", "points", "Those of them near the other cloud")                          \
    X(REAL, nearby, "nearby", "unit of the cloud", "Distance that is near")                        \
    X(DISTANCES, forth, "forth", "", "Distances of those to the nearest point of the other cloud") \
    X(OPTIONAL, has_back, "back", "", "Distances from the other cloud to this one")                \
    X(REAL, back_mean, "back.mean", "unit of the cloud", "Their mean")                             \
    X(REAL, back_max, "back.max", "unit of the cloud", "The largest")                              \
    X(SPEC, parameters, "parameters", "", "The request")

struct overlap {
    OVERLAP_TABLE(VOR_FIELD)
};

static const struct vor_member distances_rows[] = {
#define DISTANCES_ROW(...) VOR_MEMBER(struct distances, __VA_ARGS__)
    DISTANCES_TABLE(DISTANCES_ROW)
#undef DISTANCES_ROW
};

static const struct vor_members distances_members = VOR_MEMBERS(struct distances, distances_rows);

static const struct vor_member overlap_rows[] = {
#define OVERLAP_ROW(...) VOR_MEMBER(struct overlap, __VA_ARGS__)
    OVERLAP_TABLE(OVERLAP_ROW)
#undef OVERLAP_ROW
};

const struct vor_members vor_toy_overlap_members = VOR_MEMBERS(struct overlap, overlap_rows);

/* One cloud of two, in the frame of both and flat along the axes that do not count. */
struct side {
    float *xyz;
    size_t n;
    struct vor_knn *knn;
};

/* Two clouds that are compared. */
struct pair {
    const struct vor_spec *spec;
    const struct vor_run *run;
    struct vor_frame frame;
    struct box box; /* around both */
    struct side cloud, other;
};

/* Distances from points of one side to the nearest of the other. */
struct crossing {
    const struct side *from, *to;
    const struct vor_attribute *among; /* of the points that count */
    double unit;
    double *distance; /* from->n; NAN: the point does not count */
};

/* What comes of a crossing. */
struct crossed {
    struct distances distances;
    uint64_t counted;
};

static vor_status take_side(struct side *side, const struct vor_cloud *cloud,
                            const struct pair *pair, struct vor_error *err)
{
    struct vor_memory *memory = pair->run->memory;
    vor_status status = vor_frame_positions(&side->xyz, cloud, &pair->frame, memory, err);

    side->n = cloud->n;
    if (status != VOR_OK)
        return status;
    for (unsigned c = 0; c < 3; c++)
        for (size_t i = 0; i < side->n && !has_axis(pair->spec, &pair->box, c); i++)
            side->xyz[3 * i + c] = 0;
    return vor_knn_build(&side->knn, side->xyz, side->n, memory, err);
}

static void free_side(struct side *side, struct vor_memory *memory)
{
    vor_knn_free(side->knn);
    vor_free(memory, side->xyz);
}

static vor_status take_pair(struct pair *pair, const struct vor_cloud *cloud,
                            const struct vor_cloud *other, struct vor_error *err)
{
    double x[3];
    vor_status status;

    vor_frame_choose(&pair->frame, cloud, other);
    for (size_t i = 0; i < cloud->n; i++)
        vor_cloud_position(cloud, i, x), box_add(&pair->box, x);
    for (size_t i = 0; i < other->n; i++)
        vor_cloud_position(other, i, x), box_add(&pair->box, x);
    status = take_side(&pair->cloud, cloud, pair, err);
    return status == VOR_OK ? take_side(&pair->other, other, pair, err) : status;
}

static vor_status cross_part(void *ctx, size_t begin, size_t end, struct vor_error *err)
{
    const struct crossing *crossing = ctx;

    (void)err;
    for (size_t i = begin; i < end; i++) {
        uint32_t index;
        float distance2;

        crossing->distance[i] = (double)NAN;
        if (!counts(crossing->among, i))
            continue;
        vor_knn_search(crossing->to->knn, &crossing->from->xyz[3 * i], 1, 1, &index, &distance2);
        crossing->distance[i] = sqrt((double)distance2) * crossing->unit;
    }
    return VOR_OK;
}

static void sum_up(struct crossed *out, const struct crossing *crossing)
{
    *out = (struct crossed){.counted = 0};
    for (size_t i = 0; i < crossing->from->n; i++) {
        if (isnan(crossing->distance[i]))
            continue;
        out->counted++;
        out->distances.mean += crossing->distance[i];
        out->distances.max = fmax(out->distances.max, crossing->distance[i]);
    }
    if (out->counted > 0)
        out->distances.mean /= (double)out->counted;
}

static uint64_t count_near(const struct crossing *crossing, const struct vor_spec *spec,
                           double nearby)
{
    uint64_t count = 0;

    for (size_t i = 0; i < crossing->from->n; i++)
        count += (uint64_t)is_near(spec, crossing->distance[i], nearby); /* not where it is NAN */
    return count;
}

/* The stages of the overlap. */
static vor_status cross(struct overlap *overlap, struct crossing *there, struct crossing *back,
                        struct steps *steps, struct vor_error *err)
{
    struct crossed crossed;
    vor_status status = enter(steps, VOR_RUN_STAGE_FORTH, (uint32_t)overlap->has_back, err);

    if (status == VOR_OK)
        status = go_through(steps, there->from->n, cross_part, there, err);
    if (status != VOR_OK)
        return status;
    sum_up(&crossed, there);
    overlap->counted = crossed.counted;
    overlap->forth = crossed.distances;
    overlap->nearby = nearby_of(&overlap->parameters, crossed.distances.mean);
    overlap->close = count_near(there, &overlap->parameters, overlap->nearby);
    if (!overlap->has_back)
        return VOR_OK;
    status = enter(steps, VOR_RUN_STAGE_BACK, 0, err);
    if (status == VOR_OK)
        status = go_through(steps, back->from->n, cross_part, back, err);
    if (status != VOR_OK)
        return status;
    sum_up(&crossed, back);
    overlap->back_mean = crossed.distances.mean;
    overlap->back_max = crossed.distances.max;
    return VOR_OK;
}

static vor_status compare(struct overlap *overlap, const struct pair *pair,
                          const struct vor_attribute *among, struct vor_error *err)
{
    struct vor_memory *memory = pair->run->memory;
    struct steps steps = steps_of(pair->spec, pair->run);
    double unit = pair->frame.unit;
    struct crossing there = {&pair->cloud, &pair->other, among, unit, NULL};
    struct crossing back = {&pair->other, &pair->cloud, NULL, unit, NULL};
    vor_status status = VOR_E_NOMEM;

    there.distance = vor_malloc(memory, pair->cloud.n, sizeof *there.distance);
    back.distance = vor_malloc(memory, pair->other.n, sizeof *back.distance);
    if (there.distance != NULL && back.distance != NULL)
        status = cross(overlap, &there, &back, &steps, err);
    else
        (void)vor_fail(err, VOR_E_NOMEM, "distances between two clouds");
    vor_free(memory, there.distance);
    vor_free(memory, back.distance);
    return status;
}

vor_status vor_toy_overlap(struct vor_artefacts *out, const struct vor_artefacts *in,
                           const struct vor_spec *spec, const struct vor_run *run,
                           struct vor_error *err)
{
    struct overlap *overlap =
        vor_artefacts_put_document(out, "overlap", &vor_toy_overlap_members, err);
    const struct vor_cloud *cloud = vor_artefacts_cloud(in, "cloud"),
                           *other = vor_artefacts_cloud(in, "other");
    struct pair pair = {.spec = spec, .run = run, .box = no_box};
    const struct vor_attribute *among;
    vor_status status;

    if (overlap == NULL)
        return VOR_E_NOMEM;
    overlap->points = cloud->n;
    overlap->others = other->n;
    overlap->has_back = spec->value[VOR_PARAM_BACKWARD] != 0;
    overlap->parameters = *spec;
    status = find_among(&among, cloud, spec, err);
    if (status == VOR_OK)
        status = take_pair(&pair, cloud, other, err);
    if (status == VOR_OK)
        status = compare(overlap, &pair, among, err);
    free_side(&pair.cloud, run->memory);
    free_side(&pair.other, run->memory);
    return status;
}
