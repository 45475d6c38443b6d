#include "core/input/ridges.h"

#include "core/base/linalg.h"
#include "core/geom/boundary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    NEAR = VOR_NEIGHBORS_FEWEST, /* feet that are looked at around a place, points of a spacing */
    POLL_EVERY = 256             /* places between two looks at whether to go on */
};

/* Spacings within which feet count. */
#define REACH 1.5

/* Spacings: a line that is no longer than one foot counts for, either way, is none. */
#define LEAST (2 * REACH)

/* Where a line passed a foot: how many places from where it began, below 0 the other way. */
struct pass {
    uint32_t line; /* the foot that it began at, plus 1 */
    int32_t at;
};

/* Edges being followed. */
struct follow {
    const struct vor_domain *domain;
    const struct vor_run *run;
    struct vor_memory *memory;
    struct vor_ridges *ridges;
    size_t n, room;      /* feet; places that there is room for */
    float *foot, *way;   /* n x 3 */
    unsigned char *used; /* n: a line went along there */
    struct pass *pass;   /* n: the last line that passed, and where it did first */
    struct vor_knn *knn;
};

/* Where a line has come to. */
struct head {
    double at[3], way[3];
    struct pass pass;
    int is_back; /* the feet around were passed by the same line before */
};

/* Spacing of the input around x: that of a square lattice as dense. */
static double spacing_at(const struct vor_domain *domain, const float *x)
{
    unsigned k = domain->n < NEAR + 1 ? (unsigned)domain->n : NEAR + 1;
    uint32_t index[NEAR + 1];
    float distance2[NEAR + 1];

    vor_knn_search(domain->knn, x, 1, k, index, distance2);
    return sqrt(M_PI * (double)distance2[k - 1] / k);
}

/* What feet say of a place. */
struct vote {
    double off[3], way[3]; /* sums: of their offsets, and of the ways of their edges */
    unsigned count, fresh; /* how many, and no line went along there */
    unsigned near, back;   /* within a step, and were passed by the same line before */
    int ahead;             /* some lie ahead */
};

/* Notes that the head passes a foot. True if its line did so before: a foot counts for REACH either
 * way, and no longer. */
static int pass(struct pass *foot, const struct head *head)
{
    if (foot->line != head->pass.line)
        *foot = head->pass;
    return abs(foot->at - head->pass.at) > LEAST / VOR_RIDGES_STEP;
}

/* Asks the feet around `at` whose edges run about the way of the head. */
static void ask(struct vote *vote, const struct follow *follow, const struct head *head,
                double spacing)
{
    float x[3] = {(float)head->at[0], (float)head->at[1], (float)head->at[2]}, distance2[NEAR];
    uint32_t index[NEAR];
    unsigned k = follow->n < NEAR ? (unsigned)follow->n : NEAR;

    memset(vote, 0, sizeof *vote);
    vor_knn_search(follow->knn, x, 1, k, index, distance2);
    for (unsigned j = 0; j < k; j++) {
        const float *foot = &follow->foot[3 * (size_t)index[j]],
                    *way = &follow->way[3 * (size_t)index[j]];
        double d[3], w[3], cosine, sign;

        if ((double)distance2[j] > REACH * REACH * spacing * spacing)
            break;
        for (int c = 0; c < 3; c++) {
            d[c] = (double)foot[c] - head->at[c];
            w[c] = (double)way[c];
        }
        cosine = vor_dot(w, head->way);
        if (fabs(cosine) < VOR_AHEAD_NARROW)
            continue;
        sign = cosine < 0 ? -1 : 1;
        for (int c = 0; c < 3; c++) {
            vote->off[c] += d[c];
            vote->way[c] += sign * w[c];
        }
        vote->count++;
        vote->fresh += !follow->used[index[j]];
        if ((double)distance2[j] <= VOR_RIDGES_STEP * VOR_RIDGES_STEP * spacing * spacing) {
            vote->near++;
            vote->back += (unsigned)pass(&follow->pass[index[j]], head);
        }
        vote->ahead |= vor_dot(d, head->way) > 0;
    }
}

/* Moves a head onto the mean of the feet around, across its way, and turns it as they say. False
 * where the edge does not go on. */
static int settle(struct head *head, const struct follow *follow, double spacing)
{
    struct vote vote;
    double along, length;

    ask(&vote, follow, head, spacing);
    head->is_back = vote.near > 0 && vote.back == vote.near;
    length = sqrt(vor_dot(vote.way, vote.way));
    if (!vote.ahead || vote.fresh == 0 || !(length > 0))
        return 0;
    for (int c = 0; c < 3; c++)
        head->way[c] = vote.way[c] / length;
    along = vor_dot(vote.off, head->way);
    for (int c = 0; c < 3; c++)
        head->at[c] += (vote.off[c] - along * head->way[c]) / vote.count;
    return 1;
}

static vor_status put(struct follow *follow, const struct head *head, struct vor_error *err)
{
    struct vor_ridges *ridges = follow->ridges;

    if (ridges->places == follow->room) {
        size_t room = 2 * follow->room + NEAR;
        double *xyz = vor_realloc(follow->memory, ridges->xyz, room, 3 * sizeof *xyz);

        if (xyz == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu points", room);
        ridges->xyz = xyz;
        follow->room = room;
    }
    memcpy(&ridges->xyz[3 * ridges->places++], head->at, sizeof head->at);
    return VOR_OK;
}

/* Follows an edge from a head on; ridge->closed says that it came back to where the line began. A
 * line that comes back to another of its places ends there. */
static vor_status go(struct follow *follow, struct vor_ridge *ridge, struct head head, int32_t way,
                     struct vor_error *err)
{
    struct vor_ridges *ridges = follow->ridges;
    const struct head begin = head;
    double step = VOR_RIDGES_STEP * ridge->spacing, gone = 0;
    vor_status status = VOR_OK;

    while (status == VOR_OK && ridges->places - ridge->first < 8 * follow->n) {
        double d[3];

        for (int c = 0; c < 3; c++)
            head.at[c] += step * head.way[c];
        head.pass.at += way;
        if (!settle(&head, follow, ridge->spacing))
            break;
        for (int c = 0; c < 3; c++)
            d[c] = head.at[c] - begin.at[c];
        gone += step;
        if (gone > LEAST * ridge->spacing && vor_dot(d, d) < step * step) {
            ridge->closed = 1;
            break;
        }
        if (head.is_back)
            break;
        status = put(follow, &head, err);
        if (status == VOR_OK && ridges->places % POLL_EVERY == 0)
            status = vor_run_answered(vor_run_poll(follow->run), err);
    }
    return status;
}

static void reverse(double *xyz, size_t n)
{
    for (size_t i = 0; i < n / 2; i++)
        for (size_t c = 0; c < 3; c++) {
            double held = xyz[3 * i + c];

            xyz[3 * i + c] = xyz[3 * (n - 1 - i) + c];
            xyz[3 * (n - 1 - i) + c] = held;
        }
}

/* Marks the feet beside a line as used. */
static void use(const struct follow *follow, const struct vor_ridge *ridge)
{
    unsigned k = follow->n < NEAR ? (unsigned)follow->n : NEAR;

    for (size_t i = 0; i < ridge->count; i++) {
        const double *at = &follow->ridges->xyz[3 * (ridge->first + i)];
        float x[3] = {(float)at[0], (float)at[1], (float)at[2]}, distance2[NEAR];
        uint32_t index[NEAR];

        vor_knn_search(follow->knn, x, 1, k, index, distance2);
        for (unsigned j = 0; j < k; j++)
            if ((double)distance2[j] <= REACH * REACH * ridge->spacing * ridge->spacing)
                follow->used[index[j]] = 1;
    }
}

/* Follows the edge of a foot both ways. */
static vor_status follow_from(struct follow *follow, size_t i, struct vor_error *err)
{
    struct vor_ridges *ridges = follow->ridges;
    struct vor_ridge ridge = {.first = ridges->places,
                              .spacing = spacing_at(follow->domain, &follow->foot[3 * i])};
    struct head head = {.pass = {.line = (uint32_t)i + 1}};
    vor_status status;

    follow->used[i] = 1;
    for (size_t c = 0; c < 3; c++) {
        head.at[c] = (double)follow->foot[3 * i + c];
        head.way[c] = -(double)follow->way[3 * i + c];
    }
    if (!(ridge.spacing > 0) || !settle(&head, follow, ridge.spacing))
        return VOR_OK;
    status = go(follow, &ridge, head, 1, err);
    reverse(&ridges->xyz[3 * ridge.first], ridges->places - ridge.first);
    VOR_THEN(status, put(follow, &head, err));
    for (int c = 0; c < 3; c++)
        head.way[c] = -head.way[c];
    if (status == VOR_OK && !ridge.closed)
        status = go(follow, &ridge, head, 1, err);
    ridge.count = ridges->places - ridge.first;
    if (status == VOR_OK && (double)ridge.count * VOR_RIDGES_STEP >= LEAST) {
        use(follow, &ridge);
        ridges->ridge[ridges->count++] = ridge;
    } else {
        ridges->places = ridge.first;
    }
    return status;
}

/* Takes the feet of the flagged points. */
static vor_status take_feet(struct follow *follow, const struct vor_edges *edges,
                            struct vor_error *err)
{
    size_t m = edges->flagged;

    if (VOR_MAKE_ALL(follow->memory, err, m, VOR_ARRAY(follow->foot, m, 3),
                     VOR_ARRAY(follow->way, m, 3), VOR_ZEROED(follow->used, m, 1),
                     VOR_ZEROED(follow->pass, m, 1),
                     VOR_ARRAY(follow->ridges->ridge, m, 1)) != VOR_OK)
        return VOR_E_NOMEM;
    for (size_t i = 0; i < edges->n; i++) {
        if (!edges->flag[i])
            continue;
        memcpy(&follow->foot[3 * follow->n], &edges->foot[3 * i], 3 * sizeof *follow->foot);
        memcpy(&follow->way[3 * follow->n++], &edges->direction[3 * i], 3 * sizeof *follow->way);
    }
    return vor_knn_build(&follow->knn, follow->foot, follow->n, follow->memory, err);
}

vor_status vor_ridges_follow(struct vor_ridges *out, const struct vor_domain *domain,
                             const struct vor_edges *edges, const struct vor_run *run,
                             struct vor_error *err)
{
    struct vor_ridges ridges = {.memory = domain->memory};
    struct follow follow = {
        .domain = domain, .run = run, .memory = domain->memory, .ridges = &ridges};
    vor_status status = edges->flagged > 0 ? take_feet(&follow, edges, err) : VOR_OK;

    for (size_t i = 0; status == VOR_OK && i < follow.n; i++)
        if (!follow.used[i])
            status = follow_from(&follow, i, err);
    vor_knn_free(follow.knn);
    VOR_FREE_ALL(follow.memory, follow.pass, follow.used, follow.way, follow.foot);
    if (status == VOR_OK)
        *out = ridges;
    else
        vor_ridges_free(&ridges);
    return status;
}

void vor_ridges_free(struct vor_ridges *ridges)
{
    VOR_FREE_ALL(ridges->memory, ridges->ridge, ridges->xyz);
    memset(ridges, 0, sizeof *ridges);
}
