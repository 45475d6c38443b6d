#include "core/input/fill.h"

#include "core/base/linalg.h"
#include "core/geom/patch.h"
#include "core/geom/spline.h"
#include "core/input/hole_sides.h"
#include "core/knn/cells.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum {
    /* Most points that a spline goes through: it takes the cube of them, 30 ms. A hole of ten
     * spacings has 250 around it. */
    CENTRES = 400,
    BLOCK = 256,        /* places, or new points, of one task */
    POLL_EVERY = 1024,  /* points of the band between two looks at whether to go on */
    AT_A_TIME = 1 << 16 /* places that are computed before any is taken */
};

/* Spacings between points of the spline, at least, and times the root of two, until they are few.
 */
#define CENTRE_GAP 0.5

/* Spacings between the places that are tried, in the plane. */
#define STEP 0.2

/* Share of the new points above which another part of the input is there, if that many have a point
 * within a spacing that is not of the band. */
#define COVERED 0.25

/* A hole being filled. */
struct fill {
    struct vor_filling *filling;
    const struct vor_domain *domain;
    const struct vor_loop *loop;
    struct vor_memory *memory;
    struct vor_band band;
    unsigned sides;      /* of the surface, which meet at creases */
    unsigned char *side; /* of each point of the band */
    struct vor_spline spline[VOR_HOLE_SIDES];
    double ahead;           /* 1: the surface is where the highest side is; -1: the lowest */
    double scale;           /* places of the spline are those of the plane times this */
    double low[2];          /* least corner of the outline */
    size_t grid[2], row;    /* places along u and v; first row of those that are computed */
    double *place;          /* those rows, in space; NAN outside the outline */
    struct vor_cells cells; /* points of the band and new ones */
    size_t before;          /* points of the filling when this hole began */
    atomic_size_t in_the_way;
};

vor_status vor_filling_init(struct vor_filling *out, const struct vor_domain *domain,
                            const struct vor_loops *loops, struct vor_error *err)
{
    struct vor_filling filling = {.domain = domain, .loops = loops};
    vor_status status = vor_band_search_init(&filling.search, domain->n, domain->memory, err);

    if (status == VOR_OK)
        *out = filling;
    return status;
}

void vor_filling_free(struct vor_filling *filling)
{
    if (filling->domain == NULL)
        return;
    vor_band_search_free(&filling->search, filling->domain->memory);
    VOR_FREE_ALL(filling->domain->memory, filling->xyz, filling->source);
    memset(filling, 0, sizeof *filling);
}

/* Chooses points of a side that lie `gap` apart in the plane, those of the loop first. *count is
 * how many, or CENTRES + 1 if there are more than CENTRES. */
static vor_status choose(size_t *count, uint32_t *chosen, const struct fill *fill, unsigned side,
                         double gap, const struct vor_run *run, struct vor_error *err)
{
    const struct vor_band *band = &fill->band;
    vor_status status = VOR_OK;

    *count = 0;
    for (size_t i = 0; i < band->count && *count <= CENTRES && status == VOR_OK; i++) {
        const double *u = &band->at[2 * i];
        int is_far = fill->sides == 1 || fill->side[i] == side;

        for (size_t j = 0; j < *count && is_far; j++) {
            const double *v = &band->at[2 * (size_t)chosen[j]];
            double x = u[0] - v[0], y = u[1] - v[1];

            is_far = x * x + y * y >= gap * gap;
        }
        if (is_far)
            chosen[(*count)++] = (uint32_t)i;
        if (i % POLL_EVERY == 0)
            status = vor_run_answered(vor_run_poll(run), err);
    }
    return status;
}

/* Sets the scale and the corner of the places. False if there would be too many of them. */
static int frame(struct fill *fill)
{
    const struct vor_band *band = &fill->band;
    double high[2] = {-INFINITY, -INFINITY}, most = 0, step = STEP * fill->loop->spacing;

    fill->low[0] = fill->low[1] = INFINITY;
    for (size_t i = 0; i < 2 * band->rim; i++) {
        fill->low[i % 2] = fmin(fill->low[i % 2], band->outline[i]);
        high[i % 2] = fmax(high[i % 2], band->outline[i]);
        most = fmax(most, fabs(band->outline[i]));
    }
    for (size_t i = 0; i < 2 * band->count; i++)
        most = fmax(most, fabs(band->at[i]));
    if (!(most > 0) || !((high[0] - fill->low[0]) * (high[1] - fill->low[1]) <=
                         VOR_FILL_POINTS * fill->loop->spacing * fill->loop->spacing))
        return 0;
    fill->scale = 1 / most;
    for (int c = 0; c < 2; c++)
        fill->grid[c] = (size_t)((high[c] - fill->low[c]) / step) + 1;
    return 1;
}

/* How much the spline smooths, in cubed places of it: detail of the points around a hole that is
 * smaller by far than the spacing, or the gap if that is wider. At 0.05 / 0.2 / 1 times that, as
 * VOR_BAND_WIDTH: 0.204 / 0.206 / 0.206 spacings. */
static double smoothing(const struct fill *fill, double gap)
{
    double wide = fmax(gap, fill->loop->spacing) * fill->scale;
    double usual = fill->domain->known.neighbors.usual, more = usual / VOR_NEIGHBORS_FEWEST;

    return more * more * sqrt(more) * wide * wide * wide;
}

/* Fits the spline of a side to chosen points. */
static vor_status fit_to(struct fill *fill, unsigned side, const uint32_t *chosen, size_t count,
                         double gap, struct vor_error *err)
{
    double at[2 * CENTRES], value[3 * CENTRES];
    vor_status status;

    for (size_t i = 0; i < count; i++) {
        const float *x = &fill->domain->xyz[3 * (size_t)fill->band.point[chosen[i]]];

        for (size_t c = 0; c < 2; c++)
            at[2 * i + c] = fill->scale * fill->band.at[2 * (size_t)chosen[i] + c];
        for (size_t c = 0; c < 3; c++)
            value[3 * i + c] = (double)x[c] - fill->band.middle[c];
    }
    status = vor_spline_fit(&fill->spline[side], at, value, count, smoothing(fill, gap),
                            fill->memory, NULL);
    return status == VOR_E_NOMEM ? vor_fail(err, status, "the surface of a hole") : status;
}

/* Fits the spline of a side to its points of the band, as many as it can take.
 *
 * @retval VOR_E_DEGENERATE they determine none; without a message */
static vor_status fit_side(struct fill *fill, unsigned side, const struct vor_run *run,
                           struct vor_error *err)
{
    uint32_t chosen[CENTRES + 1];
    double gap = CENTRE_GAP * fill->loop->spacing;
    size_t count;
    vor_status status = choose(&count, chosen, fill, side, gap, run, err);

    while (status == VOR_OK && count > CENTRES) {
        gap *= M_SQRT2;
        status = choose(&count, chosen, fill, side, gap, run, err);
    }
    return status == VOR_OK ? fit_to(fill, side, chosen, count, gap, err) : status;
}

static void free_splines(struct fill *fill)
{
    for (unsigned s = 0; s < VOR_HOLE_SIDES; s++) {
        vor_spline_free(&fill->spline[s]);
        memset(&fill->spline[s], 0, sizeof fill->spline[s]);
    }
}

/* Where a side is at u, and how high over the plane of the loop. */
static double side_at(const struct fill *fill, unsigned side, const double u[2], double x[3])
{
    double at[2] = {fill->scale * u[0], fill->scale * u[1]};

    vor_spline_at(&fill->spline[side], at, x);
    return vor_dot(x, fill->band.up);
}

/* Whether the surface is everywhere the highest side, as in a valley, or everywhere the lowest, as
 * on a roof: the points of the loop say which. At a saddle of creases it is neither. */
static int meet(struct fill *fill)
{
    size_t highest = 0, lowest = 0;

    for (size_t i = 0; i < fill->band.rim; i++) {
        const double *u = fill->band.at + 2 * i;
        double x[3], own = side_at(fill, fill->side[i], u, x);
        int high = 1, low = 1;

        for (unsigned s = 0; s < fill->sides; s++) {
            double other = s == fill->side[i] ? own : side_at(fill, s, u, x);

            high &= own >= other;
            low &= own <= other;
        }
        highest += (size_t)high;
        lowest += (size_t)low;
    }
    fill->ahead = highest > lowest ? 1 : -1;
    return (double)(highest > lowest ? highest : lowest) >= (1 - COVERED) * (double)fill->band.rim;
}

/* Fits the sides, or one spline to all points where there are no sides that meet. */
static vor_status fit(struct fill *fill, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = VOR_OK;

    fill->side = vor_malloc(fill->memory, fill->band.count, sizeof *fill->side);
    if (fill->side == NULL)
        return vor_fail(err, VOR_E_NOMEM, "filling a hole");
    fill->sides = vor_hole_sides_find(fill->side, &fill->band, fill->domain);
    for (unsigned s = 0; s < fill->sides && status == VOR_OK; s++)
        status = fit_side(fill, s, run, err);
    if (fill->sides > 1 && (status == VOR_E_DEGENERATE || (status == VOR_OK && !meet(fill)))) {
        free_splines(fill);
        fill->sides = 1;
        status = fit_side(fill, 0, run, err);
    }
    return status;
}

/* Computes places of the rows, one after another. */
static void place_row(void *ctx, size_t k, VOR_UNUSED unsigned worker)
{
    struct fill *fill = ctx;
    double step = STEP * fill->loop->spacing;
    size_t column = k % fill->grid[0], row = fill->row + k / fill->grid[0];
    double u[2] = {fill->low[0] + (double)column * step, fill->low[1] + (double)row * step};
    double *x = &fill->place[3 * k], most = 0;

    x[0] = NAN;
    if (!vor_polygon_within(&fill->band.polygon, u))
        return;
    for (unsigned s = 0; s < fill->sides; s++) {
        double other[3], height = side_at(fill, s, u, other) * fill->ahead;

        if (s == 0 || height > most) {
            most = height;
            memcpy(x, other, sizeof other);
        }
    }
}

/* Makes the cells, of the points of the band alone. */
static vor_status make_cells(struct fill *fill, struct vor_error *err)
{
    struct vor_cells *cells = &fill->cells;
    double many = STEP * STEP * (double)fill->grid[0] * (double)fill->grid[1];
    vor_status status;

    *cells =
        (struct vor_cells){.memory = fill->memory, .wide = VOR_HEXAGON_APART * fill->loop->spacing};
    status = vor_cells_reserve(cells, fill->band.count + (size_t)many, err);
    for (size_t i = 0; i < fill->band.count && status == VOR_OK; i++)
        status = vor_cells_add(cells, &fill->domain->xyz[3 * (size_t)fill->band.point[i]], err);
    return status;
}

/* Makes room for one more point. */
static vor_status grow(struct fill *fill, struct vor_error *err)
{
    struct vor_filling *filling = fill->filling;

    if (filling->n == filling->room) {
        size_t room = 2 * filling->room + BLOCK;
        float *xyz = vor_realloc(fill->memory, filling->xyz, room, 3 * sizeof *xyz);
        uint32_t *source;

        filling->xyz = xyz != NULL ? xyz : filling->xyz;
        source = vor_realloc(fill->memory, filling->source, room, sizeof *source);
        filling->source = source != NULL ? source : filling->source;
        if (xyz == NULL || source == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu points", room);
        filling->room = room;
    }
    return VOR_OK;
}

/* Takes a place if no point is too near. False in *inside where it lies too far off. */
static vor_status try_place(struct fill *fill, const double place[3], int *inside,
                            struct vor_error *err)
{
    vor_status status;
    float x[3];

    if (isnan(place[0]))
        return VOR_OK;
    *inside &= vor_dot(place, place) <= fill->loop->length * fill->loop->length;
    for (int c = 0; c < 3; c++)
        x[c] = (float)(fill->band.middle[c] + place[c]);
    if (!*inside || vor_cells_has(&fill->cells, x, fill->cells.wide))
        return VOR_OK;
    status = grow(fill, err);
    if (status != VOR_OK)
        return status;
    memcpy(&fill->filling->xyz[3 * fill->filling->n++], x, sizeof x);
    return vor_cells_add(&fill->cells, x, err);
}

/* Puts points on the spline, some rows of places at a time. A hole that is not done when the time
 * of the run is over stays open. */
static vor_status put_points(struct fill *fill, int *inside, const struct vor_run *run,
                             struct vor_error *err)
{
    size_t rows = AT_A_TIME / fill->grid[0] + 1;
    vor_status status = make_cells(fill, err);

    fill->place = vor_malloc(fill->memory, rows * fill->grid[0], 3 * sizeof *fill->place);
    if (status == VOR_OK && fill->place == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "filling a hole");
    for (; status == VOR_OK && *inside && fill->row < fill->grid[1]; fill->row += rows) {
        if (rows > fill->grid[1] - fill->row)
            rows = fill->grid[1] - fill->row;
        status = vor_run_rows(run, rows * fill->grid[0], BLOCK, place_row, fill, err);
        *inside &= !vor_run_is_late(run);
        for (size_t i = 0; status == VOR_OK && i < rows * fill->grid[0]; i++)
            status = try_place(fill, &fill->place[3 * i], inside, err);
    }
    return status;
}

/* Gives new points their sources, and counts those that lie on another part of the input. */
static void source_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct fill *fill = ctx;
    const struct vor_band_search *search = &fill->filling->search;
    double near = fill->loop->spacing;
    size_t in_the_way = 0;

    for (size_t i = fill->before + begin; i < fill->before + end; i++) {
        uint32_t index;
        float distance2;

        vor_knn_search(fill->domain->knn, &fill->filling->xyz[3 * i], 1, 1, &index, &distance2);
        fill->filling->source[i] = fill->domain->source[index];
        in_the_way += (double)distance2 < near * near && search->seen[index] != search->searches;
    }
    atomic_fetch_add(&fill->in_the_way, in_the_way);
}

/* Fills the hole; *closed says whether it could be. */
static vor_status fill_it(struct fill *fill, int *closed, const struct vor_run *run,
                          struct vor_error *err)
{
    int inside = 1;
    size_t count;
    vor_status status;

    *closed = 0;
    if (!frame(fill))
        return VOR_OK;
    status = fit(fill, run, err);
    if (status == VOR_E_DEGENERATE)
        return VOR_OK;
    VOR_THEN(status, put_points(fill, &inside, run, err));
    count = fill->filling->n - fill->before;
    VOR_THEN(status, vor_run_for(run, count, BLOCK, source_block, fill, err));
    *closed = status == VOR_OK && inside && count > 0 &&
              (double)atomic_load(&fill->in_the_way) <= COVERED * (double)count;
    return status;
}

vor_status vor_fill_hole(struct vor_filling *filling, int *closed, size_t loop,
                         const struct vor_run *run, struct vor_error *err)
{
    const struct vor_loop *of = &filling->loops->loop[loop];
    struct fill fill = {.filling = filling,
                        .domain = filling->domain,
                        .loop = of,
                        .memory = filling->domain->memory,
                        .before = filling->n};
    vor_status status = VOR_OK;

    *closed = 0;
    if (vor_run_is_late(run))
        return VOR_OK;
    status = vor_band_find(&fill.band, &filling->search, filling->domain, filling->loops, loop, run,
                           err);
    VOR_THEN(status, fill_it(&fill, closed, run, err));
    if (status != VOR_OK || !*closed)
        filling->n = fill.before;
    vor_free(fill.memory, fill.place);
    vor_cells_free(&fill.cells);
    free_splines(&fill);
    vor_free(fill.memory, fill.side);
    vor_band_free(&fill.band);
    return status;
}
