#include "core/lop/project.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/geom/patch.h"
#include "core/knn/input_lists.h"
#include "core/knn/point_lists.h"
#include "core/lop/drawn.h"
#include "core/lop/normals.h"
#include "core/lop/weights.h"
#include "core/seeds/stage.h"

#include <math.h>
#include <string.h>

/* Points of a task. */
enum { BLOCK = 128 };

/* Data that count for a point: fewest, and most, which then are the nearest. The fewest are those
 * that tell how dense they are, and say the height, as they are smoothed already: igea of 30,000
 * points to 10,000, rms 3.8e-4 by all within the reach, 3.3e-4 by these. At 48 / 96 most, igea of
 * 134,000 points to 20,000: delta alike, a third more time. */
enum { DATA_LEAST = VOR_LOP_AREA_OF, DATA_MOST = VOR_LOP_DATA_MOST };
/* Shortest distance to a datum that counts, squared, in its area as density_block has it: that is
 * the spacing there, of which an even disc to the twelfth neighbour has a radius of 1.8. Else
 * points stick to single data where these are not many times as many. */
#define SHORTEST_DATA 0.3

/* Share of mu that counts without normals. Bunny to 5,000 after 36 steps, at mu .45 and 0.44 / 0.67
 * / 0.89 / 1: delta 0.073 / 0.052 / 0.080 / 0.099, because points jump past each other. */
#define PUSH_SHARE 0.67

struct project {
    struct vor_lop_samples *samples;
    const struct vor_lop_samples *data;
    const struct vor_domain *domain;
    const struct vor_lop_project_how *how;
    const struct vor_run *run;
    unsigned k; /* data for each point */
    struct vor_input_lists near_data;
    struct vor_point_lists others;
    struct vor_point_lists_view view;
    float *own_area;      /* where the data have none */
    const float *area;    /* around each datum: squared distance to its twelfth neighbour, 1 / v */
    float *crowding;      /* of the points: w */
    float *next, *turned; /* positions, normals */
    float *nearest;       /* distance of each point to its nearest other */
    double scale;         /* of vor_lop_alike */
};

static void density_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct project *project = ctx;
    unsigned k = project->domain->n < DATA_LEAST ? (unsigned)project->domain->n : DATA_LEAST;
    uint32_t index[DATA_LEAST];
    float distance2[DATA_LEAST];
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        vor_knn_search_next(project->domain->knn, &last, &project->domain->xyz[3 * i], k, index,
                            distance2);
        project->own_area[i] = distance2[k - 1];
    }
}

/* The sum of theta over the other points around each, and the point itself. */
static void crowding_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct project *project = ctx;
    double inverse = 1 / (project->how->reach * project->how->reach);
    struct vor_crowd crowd;

    for (size_t i = begin; i < end; i++) {
        double sum = 1, least = INFINITY;

        (void)vor_point_lists_within(&crowd, &project->others, &project->view, i,
                                     project->how->reach);
        for (unsigned j = 0; j < crowd.count; j++) {
            sum += vor_lop_near((double)crowd.distance2[j], inverse);
            least = fmin(least, (double)crowd.distance2[j]);
        }
        project->crowding[i] = (float)sum;
        project->nearest[i] = isfinite(least) ? (float)sqrt(least) : (float)project->how->reach;
    }
}

/* How much of the way to the data a point goes: less than all of it where there is less than a
 * datum for each point, else points gather at single data. At one / two: delta by ear of three
 * boxes of 36,000 uneven points to 8,000 0.27 / 0.15; points between two sheets as near as four
 * spacings less than 1 / 1.7 %, as these no longer keep to their data. By the nearest datum alone,
 * at 2: 0.085, but rms of fandisk30k_noisy 1.6e-3 for 1.36e-3, because strays stay where they are.
 */
static double part_of(const struct project *project, const struct vor_lop_drawn *drawn)
{
    double spacing2 = project->how->spacing * project->how->spacing;
    double each = spacing2 * drawn->density / (SHORTEST_DATA * project->k);

    return each < 1 ? each * each : 1;
}

/* Gathers the data around point i. Returns the squared distance of the farthest. */
static double gather(struct vor_lop_data *out, struct project *project, size_t i)
{
    const float *x = &project->samples->xyz[3 * i];
    const uint32_t *index;
    double far2 = 0;

    (void)vor_input_lists_search(&project->near_data, i, x, project->k, &index);
    out->count = project->k;
    for (unsigned j = 0; j < project->k; j++) {
        size_t at = index[j];
        const float *q = &project->data->xyz[3 * at];
        const float there[3] = {q[0] - x[0], q[1] - x[1], q[2] - x[2]};
        double d2 = vor_distance2f(x, &project->domain->xyz[3 * at]);

        far2 = d2 > far2 ? d2 : far2;
        out->area[j] = project->area[at];
        for (size_t c = 0; c < 3; c++)
            out->there[c][j] = there[c];
        for (size_t c = 0; c < 3 && project->how->normals; c++)
            out->normal[c][j] = project->data->normal[3 * at + c];
    }
    return far2;
}

/* Sums over the data around point i. */
static void look_at_data(struct vor_lop_drawn *drawn, struct project *project, size_t i)
{
    struct vor_lop_counting how = {.along2 = project->how->reach * project->how->reach,
                                   .scale = project->scale,
                                   .nearest = SHORTEST_DATA};
    struct vor_lop_data data;
    double far2 = gather(&data, project, i);

    how.along2 = project->k <= DATA_LEAST || far2 < how.along2 ? far2 : how.along2;
    how.across2 = fmin(how.along2, far2 * DATA_LEAST / project->k);
    if (!(far2 > 0))
        data.count = 0;
    vor_lop_drawn_by(drawn, &data, project->how->normals ? &project->samples->normal[3 * i] : NULL,
                     &how);
}

/* Adds half of what point i lacks of VOR_LOP_CLOSE to the point j at a squared distance. */
static void part(double apart[3], const struct project *project, size_t i, size_t j, double d2)
{
    const float *x = &project->samples->xyz[3 * i], *y = &project->samples->xyz[3 * j];
    double distance = sqrt(d2), lack = VOR_LOP_CLOSE * project->how->spacing - distance;

    for (unsigned c = 0; c < 3 && lack > 0; c++) {
        double away = (double)x[c] - (double)y[c];

        if (!(distance > 0)) /* in one place: any direction, but opposite ones */
            away = (i < j ? 1 : -1) * (vor_rng_unit(i < j ? i : j, i < j ? j : i, c) - 0.5);
        apart[c] += lack / 2 * away / (distance > 0 ? distance : 1);
    }
}

/* The push of the other points on point i. */
static void repel(double push[3], struct project *project, size_t i)
{
    const float *x = &project->samples->xyz[3 * i];
    double reach = project->how->reach, sum = 0;
    double mu = project->how->mu * (project->how->normals ? 1 : PUSH_SHARE);
    double apart[3] = {0}, longest = VOR_LOP_CLOSE * project->how->spacing, length;
    struct vor_crowd crowd;

    push[0] = push[1] = push[2] = 0;
    (void)vor_point_lists_within(&crowd, &project->others, &project->view, i, reach);
    for (unsigned j = 0; j < crowd.count; j++) {
        const float *y = &project->samples->xyz[3 * (size_t)crowd.index[j]];
        double d2 = (double)crowd.distance2[j];
        double beta = (double)project->crowding[crowd.index[j]] *
                      vor_lop_near(d2, 1 / (reach * reach)) / fmax(d2, VOR_ROUNDED * reach * reach);

        sum += beta;
        for (unsigned c = 0; c < 3; c++)
            push[c] += beta * ((double)x[c] - (double)y[c]);
        part(apart, project, i, crowd.index[j], d2);
    }
    length = sqrt(vor_dot(apart, apart));
    for (unsigned c = 0; c < 3; c++) {
        push[c] = sum > 0 ? mu * push[c] / sum : 0;
        push[c] += length > longest ? apart[c] * longest / length : apart[c];
    }
}

/* Takes the height from a move along the plane of point i, sets that to what the data say, and
 * turns the point's normal. */
static void stay_on_side(double move[3], const struct vor_lop_drawn *drawn, struct project *project,
                         size_t i)
{
    const float *n = &project->samples->normal[3 * i];
    const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
    double length = sqrt(vor_dot(drawn->normal, drawn->normal));
    double up = vor_dot(move, normal),
           height = drawn->weight > 0 ? drawn->height / drawn->weight : 0;

    for (unsigned c = 0; c < 3; c++) {
        move[c] += (height - up) * normal[c];
        project->turned[3 * i + c] = length > 0 ? (float)(drawn->normal[c] / length) : n[c];
    }
}

static void step_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct project *project = ctx;
    struct vor_lop_drawn drawn;
    double push[3], move[3], share;

    for (size_t i = begin; i < end; i++) {
        look_at_data(&drawn, project, i);
        repel(push, project, i);
        share = part_of(project, &drawn);
        for (unsigned c = 0; c < 3; c++)
            move[c] = push[c] + (drawn.alpha > 0 ? share * drawn.to[c] / drawn.alpha : 0);
        if (project->how->normals)
            stay_on_side(move, &drawn, project, i);
        for (unsigned c = 0; c < 3; c++)
            project->next[3 * i + c] = project->samples->xyz[3 * i + c] + (float)move[c];
    }
}

/* Finds out who is near whom, and how even the points are. */
static vor_status index_points(struct vor_stage *stage, const struct vor_run *run,
                               struct vor_error *err)
{
    struct project *project = stage->of;
    const float *xyz = project->samples->xyz;
    struct vor_uniformity even;
    vor_status status = VOR_OK;

    if (!vor_point_lists_look(&project->view, &project->others, xyz, VOR_POINT_LISTS_FAR)) {
        status = vor_point_lists_index(&project->others, xyz, run, err);
        if (status == VOR_OK)
            (void)vor_point_lists_look(&project->view, &project->others, xyz, VOR_POINT_LISTS_FAR);
    }
    VOR_THEN(status, vor_run_for(run, project->samples->n, BLOCK, crowding_block, project, err));
    if (status != VOR_OK)
        return status;
    vor_uniformity_from(&even, project->nearest, project->samples->n);
    vor_stage_note(stage, &even);
    return VOR_OK;
}

/* Makes the step the present, and says how far the farthest point went. */
static double take_step(struct project *project)
{
    struct vor_lop_samples *samples = project->samples;
    double longest2 = 0;

    for (size_t i = 0; i < samples->n; i++) {
        double move2 = vor_distance2f(&samples->xyz[3 * i], &project->next[3 * i]);

        longest2 = move2 > longest2 ? move2 : longest2; /* gcc 12 for arm64 fails on fmax here */
    }
    memcpy(samples->xyz, project->next, 3 * samples->n * sizeof *samples->xyz);
    if (project->how->normals)
        memcpy(samples->normal, project->turned, 3 * samples->n * sizeof *samples->normal);
    return sqrt(longest2);
}

static vor_status step(struct vor_stage *stage, struct vor_error *err)
{
    struct project *project = stage->of;
    vor_status status = vor_run_for(stage->run, stage->n, BLOCK, step_block, project, err);

    if (status != VOR_OK)
        return status;
    stage->record.max_move = take_step(project) * stage->domain->unit;
    return index_points(stage, stage->run, err);
}

static vor_status alloc_project(struct project *project, struct vor_error *err)
{
    struct vor_memory *memory = project->run->memory;
    size_t n = project->samples->n;
    const struct vor_domain *domain = project->domain;
    struct vor_input_lists_of near = {
        .knn = domain->knn, .reference = domain->xyz, .m = domain->n, .most = project->k};
    vor_status status;

    if (project->data->area == NULL)
        project->own_area = vor_malloc(memory, domain->n, sizeof *project->own_area);
    project->area = project->data->area != NULL ? project->data->area : project->own_area;
    project->crowding = vor_malloc(memory, n, sizeof *project->crowding);
    project->nearest = vor_malloc(memory, n, sizeof *project->nearest);
    project->next = vor_malloc(memory, n, 3 * sizeof *project->next);
    project->turned = vor_malloc(memory, n, 3 * sizeof *project->turned);
    if (project->area == NULL || project->crowding == NULL || project->nearest == NULL ||
        project->next == NULL || project->turned == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    status = vor_input_lists_init(&project->near_data, n, &near, memory, err);
    if (status != VOR_OK)
        return status;
    return vor_point_lists_init(&project->others, n,
                                n > VOR_SEEDS_LISTED ? VOR_SEEDS_LISTED : (unsigned)n - 1, memory,
                                err);
}

/* As many data as lie within the reach, by those for each point: a disc of the reach r holds
 * pi r^2 / (sqrt(3) / 2 h^2) points of spacing h. */
static unsigned data_of(const struct project *project, double spacing)
{
    const struct vor_domain *domain = project->domain;
    double ratio = project->how->reach / spacing;
    double wanted =
        VOR_HEXAGON_WITHIN * ratio * ratio * (double)domain->n / (double)project->samples->n;
    double k = fmin(fmax(ceil(wanted), DATA_LEAST), DATA_MOST);

    return (unsigned)fmin(k, (double)domain->n);
}

vor_status vor_lop_project(struct vor_lop_samples *samples, const struct vor_lop_samples *data,
                           const struct vor_domain *domain, const struct vor_lop_project_how *how,
                           struct vor_outcome *told, const struct vor_run *run,
                           struct vor_error *err)
{
    struct project project = {.samples = samples,
                              .data = data,
                              .domain = domain,
                              .how = how,
                              .run = run,
                              .scale = how->normals ? vor_lop_scale(how->sigma_n) : 0};
    struct vor_stage stage = {.spec = how->spec,
                              .run = run,
                              .told = told,
                              .record = {.stage = VOR_RUN_STAGE_PROJECT,
                                         .of = how->rounds * how->steps,
                                         .ahead = how->ahead},
                              .domain = domain,
                              .xyz = samples->xyz,
                              .n = samples->n,
                              .of = &project,
                              .step = step,
                              .share = VOR_STAGE_SHARE};
    const struct vor_run whole = vor_run_unstoppable(run);
    vor_status status;

    project.k = data_of(&project, how->spacing);
    status = alloc_project(&project, err);
    if (status == VOR_OK && project.own_area != NULL)
        status = vor_run_for(&whole, domain->n, BLOCK, density_block, &project, err);
    VOR_THEN(status, index_points(&stage, &whole, err));
    VOR_THEN(status, vor_stage_run(&stage, err));
    vor_point_lists_free(&project.others);
    vor_input_lists_free(&project.near_data);
    VOR_FREE_ALL(run->memory, project.turned, project.next, project.nearest, project.crowding,
                 project.own_area);
    return status;
}
