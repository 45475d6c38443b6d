#include "core/process.h"
#include "core/report.h"
#include "tests/support/toy/points.h"
#include "tests/support/toy/steps.h"

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
    struct toy_box box;
};

static vor_status tally_part(void *ctx, size_t begin, size_t end, struct vor_error *err)
{
    struct taking *taking = ctx;

    (void)err;
    for (size_t i = begin; i < end; i++) {
        double x[3];

        if (!toy_counts(taking->among, i))
            continue;
        vor_cloud_position(taking->cloud, i, x);
        toy_box_add(&taking->box, x);
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

        if (!toy_counts(taking->among, i))
            continue;
        vor_cloud_position(taking->cloud, i, x);
        for (unsigned c = 0; c < 3; c++)
            if (toy_has_axis(taking->spec, &taking->box, c))
                sum += (x[c] - census->middle[c]) * (x[c] - census->middle[c]);
        census->close += (uint64_t)toy_is_near(taking->spec, sqrt(sum), census->nearby);
    }
    return VOR_OK;
}

/* What follows from the box: its parts, its middle, what is near. */
static void measure_box(struct taking *taking)
{
    struct census *census = taking->census;
    const struct toy_box *box = &taking->box;
    double sum = 0;

    for (unsigned c = 0; c < 3 && census->counted > 0; c++) {
        census->size[c] = toy_has_axis(taking->spec, box, c) ? box->high[c] - box->low[c] : 0;
        census->middle[c] = (box->low[c] + box->high[c]) / 2;
        sum += census->size[c] * census->size[c];
    }
    census->nearby = toy_nearby(taking->spec, sqrt(sum) / 2);
}

static vor_status take_census(struct taking *taking, struct toy_steps *steps, struct vor_error *err)
{
    size_t n = taking->cloud->n;
    vor_status status = toy_enter(steps, VOR_RUN_STAGE_TALLY, 1, err);

    if (status == VOR_OK)
        status = toy_go_through(steps, n, tally_part, taking, err);
    measure_box(taking);
    if (status == VOR_OK)
        status = toy_enter(steps, VOR_RUN_STAGE_REACH, 0, err);
    if (status == VOR_OK)
        status = toy_go_through(steps, n, reach_part, taking, err);
    return status == VOR_E_STOPPED ? VOR_OK : status;
}

vor_status vor_toy_census(struct vor_artefacts *out, const struct vor_artefacts *in,
                          const struct vor_spec *spec, const struct vor_run *run,
                          struct vor_error *err)
{
    struct census *census = vor_artefacts_put_document(out, "census", &vor_toy_census_members, err);
    struct taking taking = {census, vor_artefacts_cloud(in, "cloud"), spec, NULL, TOY_NO_BOX};
    struct toy_steps steps = toy_steps_of(spec, run);
    vor_status status;

    if (census == NULL)
        return VOR_E_NOMEM;
    status = toy_find_among(&taking.among, taking.cloud, spec, err);
    if (status != VOR_OK)
        return status;
    census->points = taking.cloud->n;
    census->has_box = vor_list_has(spec->value[VOR_PARAM_TELL], 0);
    census->has_middle = vor_list_has(spec->value[VOR_PARAM_TELL], 1);
    census->parameters = *spec;
    return take_census(&taking, &steps, err);
}
