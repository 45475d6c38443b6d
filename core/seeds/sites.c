#include "core/seeds/sites.h"

#include "core/base/linalg.h"
#include "core/geom/boundary.h"
#include "core/geom/patch.h"
#include "core/input/lists.h"
#include "core/input/loops.h"
#include "core/input/neighbors.h"
#include "core/input/ridges.h"
#include "core/knn/cells.h"

#include <math.h>
#include <string.h>

enum {
    /* Times that a line is averaged with its neighbours; with VOR_RIDGES_STEP it takes ragged ends
     * away over 1.5 spacings of the input. */
    ROUNDS = 18,
    /* Times that sites are moved along the line until they are evenly apart. */
    EVENINGS = 8,
    BLOCK = 64 /* places of one task */
};

/* A line: places one after another. Lengths along it are over the spacing wanted there, where there
 * is a density. */
struct line {
    struct vor_memory *memory;
    const struct vor_field *field;
    size_t n, parts;   /* parts: between places; n if it is closed, else n - 1 */
    double *at, *next; /* n x 3; scratch */
    double *sum;       /* parts + 1: length up to each place */
};

static void line_free(struct line *line)
{
    VOR_FREE_ALL(line->memory, line->sum, line->next, line->at);
    memset(line, 0, sizeof *line);
}

static vor_status line_init(struct line *out, size_t n, int closed, const struct vor_domain *domain,
                            struct vor_error *err)
{
    struct vor_memory *memory = domain->memory;
    struct line line = {
        .memory = memory, .field = &domain->field, .n = n, .parts = closed ? n : n - 1};

    if (VOR_MAKE_ALL(memory, err, n, VOR_ARRAY(line.at, n, 3), VOR_ARRAY(line.next, n, 3),
                     VOR_ARRAY(line.sum, n + 1, 1)) != VOR_OK) {
        line_free(&line);
        return VOR_E_NOMEM;
    }
    *out = line;
    return VOR_OK;
}

/* The spacing wanted at x, over the even one. */
static double unit_at(const struct vor_field *field, const double x[3])
{
    struct vor_field_near near;

    if (!vor_field_is(field))
        return 1;
    vor_field_find(&near, field, (float[3]){(float)x[0], (float)x[1], (float)x[2]});
    return (double)near.value;
}

/* Distance from a to b, over the spacing wanted between them. */
static double distance(const struct vor_field *field, const double a[3], const double b[3])
{
    double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    double middle[3] = {a[0] + d[0] / 2, a[1] + d[1] / 2, a[2] + d[2] / 2};

    return sqrt(vor_dot(d, d)) / unit_at(field, middle);
}

/* Place j of the line; after the last comes the first. */
static const double *place(const struct line *line, size_t j)
{
    return &line->at[3 * (j % line->n)];
}

/* Sums up the lengths; returns the whole. */
static double measure(struct line *line)
{
    line->sum[0] = 0;
    for (size_t j = 0; j < line->parts; j++)
        line->sum[j + 1] = line->sum[j] + distance(line->field, place(line, j), place(line, j + 1));
    return line->sum[line->parts];
}

/* Puts n points at these ascending lengths along a line that was measured. */
static void walk_along(double *out, const struct line *line, const double *along, size_t n)
{
    size_t j = 0;

    for (size_t i = 0; i < n; i++) {
        double share, length;

        while (j + 1 < line->parts && line->sum[j + 1] < along[i])
            j++;
        length = line->sum[j + 1] - line->sum[j];
        share = length > 0 ? fmax(0, fmin(1, (along[i] - line->sum[j]) / length)) : 0;
        for (size_t c = 0; c < 3; c++)
            out[3 * i + c] = (1 - share) * place(line, j)[c] + share * place(line, j + 1)[c];
    }
}

/* Averages each place with those beside it. */
static void smooth(struct line *line)
{
    for (int round = 0; round < ROUNDS; round++) {
        double *held = line->at;

        for (size_t j = 0; j < line->n; j++)
            for (size_t c = 0; c < 3; c++)
                line->next[3 * j + c] =
                    place(line, j)[c] / 2 +
                    (place(line, j + 1)[c] + place(line, j + line->n - 1)[c]) / 4;
        line->at = line->next;
        line->next = held;
    }
}

/* Fits a surface to the k input points around x, which are left in near. Returns k. */
static unsigned fit_around(struct vor_surface *surface, float near[3 * VOR_NEIGHBORS_MAX],
                           const struct vor_domain *domain, const double x[3])
{
    const float at[3] = {(float)x[0], (float)x[1], (float)x[2]};

    return vor_lists_fit_at(surface, near, domain, x,
                            vor_neighbors_at(&domain->known.neighbors, at));
}

/* The way out of the input at x, where a line along its border runs from `from` to `to`: across the
 * line, along the surface, away from the points around. */
static void way_out(double out[3], const struct vor_domain *domain, const double x[3],
                    const double from[3], const double to[3])
{
    float near[3 * VOR_NEIGHBORS_MAX];
    struct vor_surface surface;
    double along[3], away[3] = {0, 0, 0}, local[3], normal[3], length;
    unsigned k = fit_around(&surface, near, domain, x);

    memset(out, 0, 3 * sizeof *out);
    if (surface.kind == VOR_SURFACE_NONE)
        return;
    vor_surface_to_local(&surface, x, local);
    vor_surface_normal(&surface, local, normal);
    for (int c = 0; c < 3; c++)
        along[c] = to[c] - from[c];
    vor_cross(out, along, normal);
    for (unsigned i = 0; i < 3 * k; i++)
        away[i % 3] += x[i % 3] - (double)near[i];
    length = sqrt(vor_dot(out, out)) * (vor_dot(out, away) < 0 ? -1 : 1);
    for (int c = 0; c < 3; c++)
        out[c] = length != 0 ? out[c] / length : 0;
}

/* Lines that sites are being put on. */
struct place_on {
    struct vor_sites *sites;
    const struct vor_domain *domain;
    size_t n; /* points of the result */
    double h; /* their spacing */
    int is_edge;
    const struct vor_run *run;
    struct vor_cells cells;   /* the sites */
    size_t room, places_room; /* of the sites, and their places */
};

/* What threads work at: a line that moves out by a step, or walkers that become sites. */
struct work {
    const struct place_on *on;
    struct line *line;
    double step;
    const struct walkers *walkers;
};

static void move_row(void *ctx, size_t j, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    struct line *line = work->line;
    double out[3];

    way_out(out, work->on->domain, place(line, j), place(line, j + line->n - 1),
            place(line, j + 1));
    for (size_t c = 0; c < 3; c++)
        line->next[3 * j + c] = line->at[3 * j + c] + work->step * out[c];
}

/* Moves a line from the last points out to where the border lies, VOR_EDGE_ROOM spacings. */
static vor_status move_out(struct line *line, const struct place_on *on, double spacing,
                           struct vor_error *err)
{
    struct work work = {.on = on, .line = line, .step = VOR_EDGE_ROOM * spacing};
    vor_status status = vor_run_rows(on->run, line->n, BLOCK, move_row, &work, err);
    double *held = line->at;

    line->at = line->next;
    line->next = held;
    return status;
}

/* The line of a loop with even steps, smoothed and measured. */
static vor_status line_of(struct line *out, const struct place_on *on,
                          const struct vor_loops *loops, size_t l, struct vor_error *err)
{
    const struct vor_domain *domain = on->domain;
    const struct vor_loop *loop = &loops->loop[l];
    struct line raw = {0}, line = {0};
    size_t n = (size_t)fmax(0, loop->length / (VOR_RIDGES_STEP * loop->spacing)) + VOR_LOOPS_LEAST;
    double *along = vor_malloc(domain->memory, n, sizeof *along);
    vor_status status = line_init(&raw, loop->count, 1, domain, err);

    for (size_t i = 0; status == VOR_OK && i < 3 * loop->count; i++)
        raw.at[i] = (double)domain->xyz[3 * (size_t)loops->point[loop->first + i / 3] + i % 3];
    VOR_THEN(status, line_init(&line, n, 1, domain, err));
    if (along == NULL) {
        (void)vor_fail(err, VOR_E_NOMEM, "%zu points", n);
        status = VOR_E_NOMEM; /* clang-analyzer cannot see that vor_fail returns it */
    } else if (status == VOR_OK) {
        double step = measure(&raw) / (double)n;

        for (size_t i = 0; i < n; i++)
            along[i] = (double)i * step;
        walk_along(line.at, &raw, along, n);
        smooth(&line);
        status = move_out(&line, on, loop->spacing, err);
    }
    if (status == VOR_OK) {
        (void)measure(&line);
        *out = line;
        memset(&line, 0, sizeof line);
    }
    line_free(&line);
    line_free(&raw);
    vor_free(domain->memory, along);
    return status;
}

/* Sites on their way along a line. */
struct walkers {
    double *xyz, *along, *apart; /* n x 3; n: length along the line; n + 1: distances summed up */
    size_t n, gaps;              /* gaps: from one to the next; on an open line there is none after
                                    the last */
};

/* Moves each to where it would be as far from the one before as from the next, by the distances
 * that they have. xyz is scratch. */
static void step(struct walkers *walkers, double length)
{
    size_t i = 0;

    for (size_t j = 0; j < walkers->n; j++) {
        double wanted = (double)j * walkers->apart[walkers->gaps] / (double)walkers->gaps, to, gap;

        while (i + 1 < walkers->gaps && walkers->apart[i + 1] < wanted)
            i++;
        to = i + 1 < walkers->n ? walkers->along[i + 1] : length;
        gap = walkers->apart[i + 1] - walkers->apart[i];
        walkers->xyz[j] = walkers->along[i];
        if (gap > 0)
            walkers->xyz[j] += (wanted - walkers->apart[i]) / gap * (to - walkers->along[i]);
    }
    memcpy(walkers->along, walkers->xyz, walkers->n * sizeof *walkers->along);
}

/* Puts as many walkers on a line as leave `gaps` gaps, as far from each other. Returns how far. */
static double even_out(struct walkers *walkers, const struct line *line, size_t gaps)
{
    double length = line->sum[line->parts];

    walkers->gaps = gaps;
    walkers->n = line->parts == line->n ? gaps : gaps + 1;
    for (size_t i = 0; i < walkers->n; i++)
        walkers->along[i] = (double)i * (length / (double)gaps);
    for (int round = 0;; round++) {
        walk_along(walkers->xyz, line, walkers->along, walkers->n);
        walkers->apart[0] = 0;
        for (size_t j = 0; j < gaps; j++)
            walkers->apart[j + 1] =
                walkers->apart[j] + distance(line->field, &walkers->xyz[3 * j],
                                             &walkers->xyz[3 * ((j + 1) % walkers->n)]);
        if (round == EVENINGS)
            return walkers->apart[gaps] / (double)gaps;
        step(walkers, length);
    }
}

/* Writes the places of gaps, from walker i to the next: the walker's and the one halfway. */
static void place_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    const struct walkers *walkers = work->walkers;
    struct vor_sites *sites = work->on->sites;

    for (size_t k = 2 * begin; k < 2 * end; k++) {
        const double *from = &walkers->xyz[3 * (k / 2)],
                     *to = &walkers->xyz[3 * ((k / 2 + 1) % walkers->n)];
        size_t at = 3 * (sites->places + k);
        double x[3], out[3] = {0, 0, 0};

        for (int c = 0; c < 3; c++)
            x[c] = k % 2 ? from[c] / 2 + to[c] / 2 : from[c];
        if (!work->on->is_edge)
            way_out(out, work->on->domain, x, from, to);
        for (size_t c = 0; c < 3; c++) {
            sites->place[at + c] = (float)x[c];
            sites->outward[at + c] = (float)out[c];
        }
    }
}

static void put_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct work *work = ctx;
    float near[3 * VOR_NEIGHBORS_MAX];
    struct vor_surface surface;

    (void)fit_around(&surface, near, work->on->domain, &work->walkers->xyz[3 * i]);
    if (surface.kind != VOR_SURFACE_NONE)
        vor_surface_put(&surface, &work->walkers->xyz[3 * i]);
}

/* Makes room for walkers and the places of their gaps, and for as many again. */
static vor_status make_room(struct place_on *on, const struct walkers *walkers,
                            struct vor_error *err)
{
    struct vor_sites *sites = on->sites;
    size_t n = sites->n + walkers->n, places = sites->places + 2 * walkers->gaps;
    float *xyz, *place, *outward;

    if (n <= on->room && places <= on->places_room)
        return VOR_OK;
    on->room = 2 * n;
    on->places_room = 2 * places;
    xyz = vor_realloc(sites->memory, sites->xyz, on->room, 3 * sizeof *xyz);
    place = vor_realloc(sites->memory, sites->place, on->places_room, 3 * sizeof *place);
    outward = vor_realloc(sites->memory, sites->outward, on->places_room, 3 * sizeof *outward);
    sites->xyz = xyz != NULL ? xyz : sites->xyz;
    sites->place = place != NULL ? place : sites->place;
    sites->outward = outward != NULL ? outward : sites->outward;
    if (xyz == NULL || place == NULL || outward == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", n);
    return VOR_OK;
}

/* Adds walkers as sites, those of a border where the surface around them is, those of an edge
 * unless there is one already. */
static vor_status add_sites(struct place_on *on, const struct walkers *walkers,
                            struct vor_error *err)
{
    struct vor_sites *sites = on->sites;
    struct work work = {.on = on, .walkers = walkers};
    vor_status status = make_room(on, walkers, err);

    VOR_THEN(status, vor_run_for(on->run, walkers->gaps, BLOCK, place_block, &work, err));
    if (status == VOR_OK && !on->is_edge)
        status = vor_run_rows(on->run, walkers->n, BLOCK, put_row, &work, err);
    sites->places += status == VOR_OK ? 2 * walkers->gaps : 0;
    for (size_t i = 0; i < walkers->n && status == VOR_OK; i++) {
        float *to = &sites->xyz[3 * sites->n];
        const double *x = &walkers->xyz[3 * i];

        vor_to_floats(to, x);
        if (on->is_edge &&
            vor_cells_has(&on->cells, to, VOR_SITES_APART * on->h * unit_at(&on->domain->field, x)))
            continue;
        status = vor_cells_add(&on->cells, to, err);
        sites->n += status == VOR_OK;
    }
    return status;
}

/* Puts sites on a line, fewer than there are points in all. */
static vor_status put_on(struct place_on *on, const struct line *line, struct vor_error *err)
{
    struct vor_memory *memory = on->sites->memory;
    int closed = line->parts == line->n;
    size_t most = on->n - 1 - on->sites->n, least = closed ? VOR_LOOPS_LEAST : 1;
    size_t gaps = (size_t)rint(line->sum[line->parts] / on->h);
    struct walkers walkers = {.n = 0};
    vor_status status = vor_run_answered(vor_run_poll(on->run), err);

    gaps = gaps < most ? gaps : most;
    if (status != VOR_OK || gaps < least || (!closed && gaps == most))
        return status;
    status =
        VOR_MAKE_ALL(memory, err, gaps, VOR_ARRAY(walkers.xyz, gaps + 1, 3),
                     VOR_ARRAY(walkers.along, gaps + 1, 1), VOR_ARRAY(walkers.apart, gaps + 1, 1));
    if (status == VOR_OK) {
        /* Straight ways are shorter than the line between their ends. */
        size_t fewer = (size_t)rint((double)gaps * even_out(&walkers, line, gaps) / on->h);

        gaps = fewer < least ? least : fewer < gaps ? fewer : gaps;
        (void)even_out(&walkers, line, gaps);
        status = add_sites(on, &walkers, err);
    }
    VOR_FREE_ALL(memory, walkers.apart, walkers.along, walkers.xyz);
    return status;
}

/* The spacing of n points on an area with borders of that length in all. */
static double spacing_for(double n, double area, double length)
{
    double a = area / VOR_HEXAGON_HEIGHT;

    return 2 * a / (sqrt(length * length / 4 + 4 * n * a) - length / 2);
}

/* Adds up the lengths of the loops that are long enough for sites, and sets the spacing. */
static vor_status add_lengths(struct place_on *on, const struct vor_loops *loops, double area,
                              struct vor_error *err)
{
    const struct vor_field *field = &on->domain->field;
    double length = 0;

    for (size_t l = 0; l < loops->count; l++) {
        struct line line = {0};
        vor_status status = line_of(&line, on, loops, l, err);
        double more;

        if (status != VOR_OK)
            return status;
        more = line.sum[line.parts];
        if (more >= (VOR_LOOPS_LEAST - 0.5) * spacing_for((double)on->n, area, length + more))
            length += more;
        line_free(&line);
    }
    on->h = VOR_HEXAGON_APART * spacing_for((double)on->n, area, length);
    on->cells.memory = on->sites->memory;
    on->cells.wide = VOR_SITES_APART * on->h * (vor_field_is(field) ? field->most : 1);
    return VOR_OK;
}

static vor_status put_on_loops(struct place_on *on, const struct vor_loops *loops,
                               struct vor_error *err)
{
    vor_status status = VOR_OK;

    for (size_t l = 0; l < loops->count && status == VOR_OK; l++) {
        struct line line = {0};

        status = line_of(&line, on, loops, l, err);
        VOR_THEN(status, put_on(on, &line, err));
        line_free(&line);
    }
    on->sites->half = on->sites->n;
    return status;
}

static vor_status put_on_ridges(struct place_on *on, const struct vor_ridges *ridges,
                                struct vor_error *err)
{
    vor_status status = VOR_OK;

    for (size_t r = 0; r < ridges->count && status == VOR_OK; r++) {
        const struct vor_ridge *ridge = &ridges->ridge[r];
        struct line line = {0};

        status = line_init(&line, ridge->count, ridge->closed, on->domain, err);
        if (status == VOR_OK) {
            memcpy(line.at, &ridges->xyz[3 * ridge->first], 3 * ridge->count * sizeof *line.at);
            (void)measure(&line);
            status = put_on(on, &line, err);
        }
        line_free(&line);
    }
    return status;
}

static vor_status on_edges(struct place_on *on, const struct vor_run *run, struct vor_error *err)
{
    struct vor_edges edges = {0};
    struct vor_ridges ridges = {.memory = NULL};
    vor_status status = vor_edges_find(&edges, on->domain, run, err);

    on->is_edge = 1;
    VOR_THEN(status, vor_ridges_follow(&ridges, on->domain, &edges, run, err));
    VOR_THEN(status, put_on_ridges(on, &ridges, err));
    vor_ridges_free(&ridges);
    vor_edges_free(&edges);
    return status;
}

vor_status vor_sites_find(struct vor_sites *out, const struct vor_domain *domain,
                          const struct vor_sites_for *wanted, const struct vor_run *run,
                          struct vor_error *err)
{
    struct vor_sites sites = {.memory = run->memory};
    struct place_on on = {.sites = &sites, .domain = domain, .n = wanted->n, .run = run};
    struct vor_loops loops = {.memory = NULL};
    double even = domain->field.even, area = wanted->area;
    vor_status status = wanted->borders ? vor_loops_find(&loops, domain, run, err) : VOR_OK;

    if (vor_field_is(&domain->field))
        area = VOR_HEXAGON_HEIGHT * (double)wanted->n * even * even;
    VOR_THEN(status, add_lengths(&on, &loops, area, err));
    VOR_THEN(status, put_on_loops(&on, &loops, err));
    vor_loops_free(&loops);
    if (status == VOR_OK && wanted->edges)
        status = on_edges(&on, run, err);
    vor_cells_free(&on.cells);
    if (status != VOR_OK) {
        vor_sites_free(&sites);
        return status;
    }
    sites.spacing = on.h;
    *out = sites;
    return VOR_OK;
}

void vor_sites_free(struct vor_sites *sites)
{
    VOR_FREE_ALL(sites->memory, sites->outward, sites->place, sites->xyz);
    memset(sites, 0, sizeof *sites);
}
