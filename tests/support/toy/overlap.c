#include "core/cloud/frame.h"
#include "core/knn/knn.h"
#include "core/process.h"
#include "core/report.h"
#include "tests/support/toy/points.h"
#include "tests/support/toy/steps.h"

#define VOR_KIND_OF_SPEC(type, field) .kind = VOR_MEMBER_REQUEST

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
    struct toy_box box; /* around both */
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
        for (size_t i = 0; i < side->n && !toy_has_axis(pair->spec, &pair->box, c); i++)
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
        vor_cloud_position(cloud, i, x), toy_box_add(&pair->box, x);
    for (size_t i = 0; i < other->n; i++)
        vor_cloud_position(other, i, x), toy_box_add(&pair->box, x);
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
        if (!toy_counts(crossing->among, i))
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
        count +=
            (uint64_t)toy_is_near(spec, crossing->distance[i], nearby); /* not where it is NAN */
    return count;
}

/* The stages of the overlap. */
static vor_status cross(struct overlap *overlap, struct crossing *there, struct crossing *back,
                        struct toy_steps *steps, struct vor_error *err)
{
    struct crossed crossed;
    vor_status status = toy_enter(steps, VOR_RUN_STAGE_FORTH, (uint32_t)overlap->has_back, err);

    if (status == VOR_OK)
        status = toy_go_through(steps, there->from->n, cross_part, there, err);
    if (status != VOR_OK)
        return status;
    sum_up(&crossed, there);
    overlap->counted = crossed.counted;
    overlap->forth = crossed.distances;
    overlap->nearby = toy_nearby(&overlap->parameters, crossed.distances.mean);
    overlap->close = count_near(there, &overlap->parameters, overlap->nearby);
    if (!overlap->has_back)
        return VOR_OK;
    status = toy_enter(steps, VOR_RUN_STAGE_BACK, 0, err);
    if (status == VOR_OK)
        status = toy_go_through(steps, back->from->n, cross_part, back, err);
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
    struct toy_steps steps = toy_steps_of(pair->spec, pair->run);
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
    struct pair pair = {.spec = spec, .run = run, .box = TOY_NO_BOX};
    const struct vor_attribute *among;
    vor_status status;

    if (overlap == NULL)
        return VOR_E_NOMEM;
    overlap->points = cloud->n;
    overlap->others = other->n;
    overlap->has_back = spec->value[VOR_PARAM_BACKWARD] != 0;
    overlap->parameters = *spec;
    status = toy_find_among(&among, cloud, spec, err);
    if (status == VOR_OK)
        status = take_pair(&pair, cloud, other, err);
    if (status == VOR_OK)
        status = compare(overlap, &pair, among, err);
    free_side(&pair.cloud, run->memory);
    free_side(&pair.other, run->memory);
    return status;
}
