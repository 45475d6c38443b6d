#include "core/input/sheets.h"

#include "core/base/linalg.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 4, /* places of one task */
    /* Points around a place. At 25 / 50 / 100 shell (geom/layers.c) is 7.3e-4 / 7.4e-4 / 12.4e-4:
     * 100 points of it bend too much. */
    AROUND = 50,
    /* Places nearest to one, itself with them, that say together whether fits there look for
     * layers: if ten of them have some. With nine / ten / twelve, and of all or none by LEAST, an
     * office of 254,456 points, scanned in steps of depth that lie as layers do, takes 7.9 / 5.1 /
     * 3.7 and 17 CPU s to 10,000; a lens one spacing thick has delta 0.0261 / 0.0261 / 0.0292 and
     * 0.0261, vertices of wheels and boxes 0.249 / 0.243 / 0.264 and 0.248. Of an input with sheets
     * half as many are enough, as beside their borders few places have both: at four and five / six
     * and ten, four sheets upsampled fourfold are 0.079 / 0.184 and 0.205 spacings off. */
    POOL = 16,
    /* Places with layers that make an input one with sheets. Measured: inputs with two sheets have
     * 118 to 128, others at most 8, a scan of an office with its walls twice 36. At 1 / 48 /
     * 96: shell 7.4e-4 / 7.4e-4 / 12.4e-4 (it has fewer than 96), CPU of fandisk 7.5 / 0.6 / 0.6 s,
     * of autzen 25 / 1.4 / 1.4 s. */
    LEAST = 3 * POOL
};

/* Least and most points that are searched for layers around a seed. At 38 / 75 / 150: shell 5.7e-4
 * / 7.4e-4 / 8.5e-4, but at 38 the squares get 150 neighbours, as noise would. */
enum { WIDE_LEAST = 75, WIDE_MAX = VOR_NEIGHBORS_MAX };

/* Times the neighbours of a fit that are searched for layers: enough for a fit to each of two
 * sheets. At 1.5 / 2.25 / 4: shell 7.3e-4 / 7.4e-4 / 6.8e-4, but at 4 the squares get 150
 * neighbours. */
#define WIDE 2.25

/* Attempts, in order, until one finds layers: among that share of the nearest points, of which
 * every stride-th is taken so that about that share of WIDE_LEAST is left. The first has enough
 * points of each of two sheets for a fit of its own. The second is not tried for a list: the first
 * / two / five find 34.1 / 45.1 / 46.6 thousand of arma2's layers (input/adjacency.h) in 21.9 /
 * 21.6 / 29.5 CPU s of one iteration to 480,000. */
static const double attempts[] = {0.67, 1, 0.46, 0.83};
enum { ATTEMPTS = sizeof attempts / sizeof *attempts, RECENT = VOR_SHEETS_RECENT };

/* Takes the points of an attempt among the `most` nearest; returns how many they are. */
static unsigned take(float *some, const float *near, unsigned most, unsigned attempt)
{
    unsigned k = (unsigned)(attempts[attempt] * most);
    unsigned points = (unsigned)(attempts[attempt] * WIDE_LEAST);
    unsigned stride = (k + points - 1) / points, count = (k + stride - 1) / stride;

    for (unsigned j = 0; j < count; j++)
        memcpy(&some[3 * j], &near[3 * j * stride], 3 * sizeof *some);
    return count;
}

static int attempt_it(struct vor_layers *out, const float *near, unsigned most, unsigned attempt)
{
    float some[3 * VOR_NEIGHBORS_MAX];

    vor_layers_find(out, some, take(some, near, most, attempt));
    return out->count > 1;
}

/* The points around a place that are searched for layers. */
struct wide {
    unsigned most;
    uint32_t index[VOR_NEIGHBORS_MAX];
    float near[3 * VOR_NEIGHBORS_MAX], distance2[VOR_NEIGHBORS_MAX];
};

static void gather_wide(struct wide *out, const struct vor_domain *domain, const double x[3],
                        unsigned k)
{
    float query[3] = {(float)x[0], (float)x[1], (float)x[2]};
    unsigned want = (unsigned)fmax(WIDE * k, WIDE_LEAST);

    out->most = vor_domain_most(domain, want < WIDE_MAX ? want : WIDE_MAX);
    memset(out->near, 0, sizeof out->near); /* clang-analyzer cannot see that most >= 1 */
    vor_knn_search(domain->knn, query, 1, out->most, out->index, out->distance2);
    vor_gather(out->near, domain->xyz, out->index, out->most);
}

/* The points nearest to x of the layer that x is nearest to, at most k; how many they are. */
static unsigned take_layer(uint32_t *list, const struct vor_layers *layers, const struct wide *wide,
                           const double x[3], unsigned k)
{
    unsigned own = vor_layers_nearest(layers, x), taken = 0;

    for (unsigned j = 0; j < wide->most && taken < k; j++) {
        double at[3];

        vor_to_doubles(at, &wide->near[3 * j]);
        if (vor_layers_nearest(layers, at) == own)
            list[taken++] = wide->index[j];
    }
    return taken;
}

/* Looks for layers like those found last, the latest first. Returns the attempt that found what
 * they are like; ATTEMPTS: there are none. */
static unsigned find_like(struct vor_layers *out, const struct vor_sheets_recent *recent,
                          const struct wide *wide)
{
    for (unsigned back = 1; back <= recent->count; back++) {
        unsigned i = (recent->next + RECENT - back) % RECENT, attempt = recent->attempt[i];
        const struct vor_layers *like = &recent->layers[i];
        float some[3 * VOR_NEIGHBORS_MAX];
        double d2 = 0;

        for (int c = 0; c < 3; c++)
            d2 += (like->frame.origin[c] - (double)wide->near[c]) *
                  (like->frame.origin[c] - (double)wide->near[c]);
        if (d2 <= like->frame.reach * like->frame.reach &&
            vor_layers_find_like(out, like, some, take(some, wide->near, wide->most, attempt)))
            return attempt;
    }
    return ATTEMPTS;
}

unsigned vor_sheets_list(uint32_t *list, const struct vor_domain *domain, const double x[3],
                         unsigned k, struct vor_sheets_recent *recent)
{
    struct wide wide;
    struct vor_layers layers;
    unsigned attempt;

    gather_wide(&wide, domain, x, k);
    attempt = find_like(&layers, recent, &wide);
    for (unsigned i = 0; i < ATTEMPTS && attempt == ATTEMPTS; i += 2)
        if (attempt_it(&layers, wide.near, wide.most, i))
            attempt = i;
    if (attempt == ATTEMPTS)
        return 0;
    recent->layers[recent->next] = layers;
    recent->attempt[recent->next] = (unsigned char)attempt;
    recent->next = (recent->next + 1) % RECENT;
    recent->count += recent->count < RECENT;
    return take_layer(list, &layers, &wide, x, k);
}

/* Tries each way, first the one that is given, if any. Returns the one that finds layers. */
static unsigned find_way(struct vor_layers *out, const struct wide *wide, unsigned first)
{
    if (first > 0 && attempt_it(out, wide->near, wide->most, first - 1))
        return first;
    for (unsigned way = 1; way <= ATTEMPTS; way++)
        if (way != first && attempt_it(out, wide->near, wide->most, way - 1))
            return way;
    return VOR_SHEETS_NO_WAY;
}

unsigned char vor_sheets_way(const struct vor_domain *domain, uint32_t i, unsigned k)
{
    struct wide wide;
    struct vor_layers layers;
    double x[3];

    vor_to_doubles(x, vor_domain_point(domain, i));
    gather_wide(&wide, domain, x, k);
    return (unsigned char)find_way(&layers, &wide, 0);
}

int vor_sheets_gather(float *near, const struct vor_domain *domain, const double x[3], unsigned k,
                      struct vor_layer *layer, unsigned way)
{
    struct wide wide;
    struct vor_layers layers;
    struct vor_layer own = {.count = 0};
    unsigned n;

    gather_wide(&wide, domain, x, k);
    if (find_way(&layers, &wide, way) == VOR_SHEETS_NO_WAY)
        return 0;
    layer = layer != NULL ? layer : &own;
    layer->count = take_layer(layer->index, &layers, &wide, x, wide.most);
    layer->reach = sqrtf(wide.distance2[wide.most - 1]);
    n = layer->count < k ? layer->count : k;
    vor_gather(near, domain->xyz, layer->index, n);
    for (unsigned j = n; j < k; j++)
        memcpy(&near[3 * j], &near[3 * (j - n)], 3 * sizeof *near);
    return 1;
}

int vor_sheets_fit(struct vor_surface *out, float *near, const struct vor_domain *domain,
                   const double x[3], unsigned k, struct vor_layer *layer)
{
    vor_surface_fit(out, near, k);
    if (!vor_layers_possible(out) ||
        !(domain->known.sheets || vor_sheets_at(&domain->known.sheeted, x)) ||
        !vor_sheets_gather(near, domain, x, k, layer, 0))
        return 0;
    vor_surface_fit(out, near, k);
    return 1;
}

struct survey {
    const struct vor_domain *domain;
    struct vor_sheeted *out;
    unsigned char layered[VOR_SHEETS_PLACES];
    unsigned sheets; /* whether that many of them are that the input is one with sheets */
};

static void survey_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct survey *survey = ctx;
    const struct vor_domain *domain = survey->domain;
    unsigned k = vor_domain_most(domain, AROUND);
    float near[3 * AROUND];
    struct vor_surface surface;
    struct vor_layers layers;

    for (size_t place = begin; place < end; place++) {
        size_t at = (size_t)(((double)place + 0.5) / VOR_SHEETS_PLACES * (double)domain->n);
        float distance2[VOR_NEIGHBORS_MAX];
        uint32_t index[VOR_NEIGHBORS_MAX];

        memcpy(&survey->out->xyz[3 * place], &domain->xyz[3 * at], 3 * sizeof *domain->xyz);
        vor_knn_search(domain->knn, &domain->xyz[3 * at], 1, k, index, distance2);
        vor_gather(near, domain->xyz, index, k);
        vor_surface_fit(&surface, near, k);
        layers.count = 1;
        if (vor_layers_possible(&surface))
            vor_layers_find(&layers, near, k);
        survey->layered[place] = layers.count > 1;
    }
}

/* Whether so many of the POOL places nearest to one have layers that fits there look for them. */
static int is_sheeted(const struct survey *survey, size_t place)
{
    const float *xyz = survey->out->xyz;
    double distance2[VOR_SHEETS_PLACES];
    unsigned has = 0;

    for (size_t i = 0; i < VOR_SHEETS_PLACES; i++)
        distance2[i] = vor_distance2f(&xyz[3 * i], &xyz[3 * place]);
    for (size_t i = 0; i < VOR_SHEETS_PLACES; i++) {
        unsigned nearer = 0;

        for (size_t j = 0; j < VOR_SHEETS_PLACES; j++)
            nearer += distance2[j] < distance2[i];
        has += survey->layered[i] && nearer < POOL;
    }
    return 8 * has * (1 + survey->sheets) >= 5 * POOL;
}

vor_status vor_sheets_find(struct vor_conditioning *out, const struct vor_domain *domain,
                           const struct vor_run *run, struct vor_error *err)
{
    struct vor_sheeted sheeted = {.count = 0};
    struct survey survey = {.domain = domain, .out = &sheeted};
    vor_status status = vor_run_for(run, VOR_SHEETS_PLACES, BLOCK, survey_block, &survey, err);
    unsigned layered = 0;

    if (status != VOR_OK)
        return status;
    for (size_t place = 0; place < VOR_SHEETS_PLACES; place++)
        layered += survey.layered[place];
    survey.sheets = layered >= LEAST;
    for (size_t place = 0; place < VOR_SHEETS_PLACES && 8 * layered >= 5 * POOL; place++) {
        sheeted.has[place] = (unsigned char)is_sheeted(&survey, place);
        sheeted.count += sheeted.has[place];
    }
    out->sheets = survey.sheets;
    out->sheeted = sheeted;
    return VOR_OK;
}

int vor_sheets_at(const struct vor_sheeted *sheeted, const double x[3])
{
    double least = INFINITY;
    size_t nearest = 0;

    if (sheeted->count == 0 || sheeted->count == VOR_SHEETS_PLACES)
        return sheeted->count > 0;
    for (size_t place = 0; place < VOR_SHEETS_PLACES; place++) {
        double d2 = 0;

        for (size_t c = 0; c < 3; c++)
            d2 += ((double)sheeted->xyz[3 * place + c] - x[c]) *
                  ((double)sheeted->xyz[3 * place + c] - x[c]);
        if (d2 < least) {
            least = d2;
            nearest = place;
        }
    }
    return sheeted->has[nearest];
}
