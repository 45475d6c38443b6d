#include "core/input/satellites.h"

#include "core/base/linalg.h"
#include "core/geom/march.h"
#include "core/geom/plane.h"
#include "core/input/adjacency.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK = 256,    /* points of one task */
    SATELLITES = 3, /* [1] Sec. 3.2 */
    /* Nearest points of each that a march may go to; both must have each other among them. Pairs
     * across a fold of 3 spacings and two sheets of 3 (20,000 points of white noise, the sum of six
     * clouds, of 2.4 million pairs) at 8 / 10 / 12 / 16: 18 / 214 / 1150 / 13,778; mean error of
     * distances on the fold 0.6 % / 0.6 % / 1 to 24 % / 10 to 28 %. */
    MARCHED = 10,
    /* Points of each of both sets that a neighbour must be a member of. On a fold, two sheets and
     * two spheres of 20,000 points, two seeds each, at 1.5 / 3 / 6 times VOR_ADJACENT: 95 / 205 /
     * 328 pairs across, 83 / 99 / 100 % of the lists' places filled, 2.2 / 2.9 / 4.5 s of CPU. */
    WIDE = 3 * VOR_ADJACENT
};

struct make {
    const struct vor_domain *domain;
    struct vor_graph *graph; /* until the end: where a march may go */
    uint32_t *component;     /* n */
    size_t components;
    uint32_t *source; /* for each component: where the next march begins */
    float *far;       /* SATELLITES x n: the distances along the surface */
    uint32_t *member; /* n: the points, one component after another */
    uint32_t *first;  /* where those of each component begin */
    float *at;        /* n x 3: coordinates of the members, in their order */
    /* Of the component at work. */
    const struct vor_knn *knn;
    uint32_t begin;
    unsigned wide; /* points of both sets; 0: lists are plain */
};

/* The point of each component that is farthest from the sources so far: those of the last march, or
 * the nearest of the first `marches`. */
static void farthest(struct make *make, size_t marches)
{
    size_t n = make->domain->n;

    for (size_t c = 0; c < make->components; c++) {
        double most = -1;

        for (size_t m = make->first[c]; m < make->first[c + 1]; m++) {
            uint32_t i = make->member[m];
            double far = (double)make->far[i];

            for (size_t s = 1; s < marches; s++)
                far = fmin(far, (double)make->far[s * n + i]);
            if (far > most) {
                most = far;
                make->source[c] = i;
            }
        }
    }
}

/* Marches from a first point of each component, to find the first satellite, and from the
 * satellites. */
static vor_status march_all(struct make *make, const struct vor_run *run, struct vor_error *err)
{
    struct vor_march march;
    size_t n = make->domain->n;
    vor_status status = vor_march_init(&march, make->graph, make->domain->xyz, err);

    if (status != VOR_OK)
        return status;
    for (size_t c = 0; c < make->components; c++)
        make->source[c] = make->member[make->first[c]];
    status = vor_march_from(&march, make->far, make->source, make->components, run, err);
    for (size_t s = 0; s < SATELLITES && status == VOR_OK; s++) {
        farthest(make, s);
        status =
            vor_march_from(&march, &make->far[s * n], make->source, make->components, run, err);
    }
    vor_march_free(&march);
    return status;
}

/* Makes the list of a point of those of its nearest ones, near[1] onwards, that are also near in
 * the coordinates. */
static void take_both(struct make *make, uint32_t i, const uint32_t *near, unsigned nears,
                      const uint32_t *along)
{
    struct vor_graph *graph = make->graph;
    uint32_t *list = &graph->list[(size_t)i * graph->most];
    unsigned taken = 0;
    int own = 0;

    for (unsigned j = 0; j < nears && taken < graph->most; j++)
        if (near[j] != i) {
            unsigned a = 0;

            while (a < make->wide && make->member[make->begin + along[a]] != near[j])
                a++;
            if (a < make->wide || make->wide == 0)
                list[taken++] = near[j];
            else
                own = 1;
        }
    graph->own[i] = (unsigned char)own;
    graph->count[i] = (unsigned char)taken;
}

static void list_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    struct make *make = ctx;
    const struct vor_domain *domain = make->domain;
    unsigned nears = vor_domain_most(domain, WIDE);
    uint32_t near[WIDE], along[WIDE];
    float distance2[WIDE];

    for (size_t m = begin; m < end; m++) {
        uint32_t i = make->member[make->begin + m];

        vor_knn_search(domain->knn, &domain->xyz[3 * (size_t)i], 1, nears, near, distance2);
        if (make->wide > 0)
            vor_knn_search(make->knn, &make->at[3 * (make->begin + m)], 1, make->wide, along,
                           distance2);
        take_both(make, i, near, nears, along);
    }
}

/* Makes the lists of a component. One of so few points that all of them are near has plain lists.
 */
static vor_status list_component(struct make *make, size_t c, const struct vor_run *run,
                                 struct vor_error *err)
{
    size_t n = make->first[c + 1] - make->first[c];
    struct vor_knn *knn = NULL;
    vor_status status = VOR_OK;

    make->begin = make->first[c];
    make->wide = n <= WIDE ? 0 : WIDE;
    if (make->wide > 0)
        status = vor_knn_build(&knn, &make->at[3 * (size_t)make->begin], n, run->memory, err);
    make->knn = knn;
    VOR_THEN(status, vor_run_for(run, n, BLOCK, list_block, make, err));
    vor_knn_free(knn);
    return status;
}

/* Sets the normal of a plane through a point and its nearest neighbours. */
static void normal_row(void *ctx, size_t i, VOR_UNUSED unsigned worker)
{
    const struct make *make = ctx;
    struct vor_graph *graph = make->graph;
    unsigned k = graph->count[i] < VOR_PLANE_POINTS ? graph->count[i] : VOR_PLANE_POINTS - 1;
    uint32_t index[VOR_PLANE_POINTS] = {(uint32_t)i};
    struct vor_plane plane;

    memcpy(&index[1], &graph->list[i * graph->most], k * sizeof *index);
    vor_plane_fit(&plane, make->domain->xyz, index, k + 1);
    memcpy(&graph->normal[3 * i], plane.normal, sizeof plane.normal);
}

static vor_status allocate(struct make *make, const struct vor_run *run, struct vor_error *err)
{
    size_t n = make->domain->n;

    return VOR_MAKE_ALL(run->memory, err, n, VOR_ARRAY(make->source, make->components, 1),
                        VOR_ZEROED(make->first, make->components + 1, 1),
                        VOR_ARRAY(make->member, n, 1), VOR_ARRAY(make->far, n, SATELLITES),
                        VOR_ARRAY(make->at, n, SATELLITES));
}

/* Makes the lists of the nearest points into those that are near both ways. */
static vor_status make_lists(struct make *make, const struct vor_run *run, struct vor_error *err)
{
    vor_status status = vor_graph_components(make->component, &make->components, make->graph, err);
    size_t n = make->domain->n;

    VOR_THEN(status, allocate(make, run, err));
    if (status != VOR_OK)
        return status;
    /* Puts the points into the order of their components. */
    for (size_t i = 0; i < n; i++)
        make->first[make->component[i] + 1]++;
    for (size_t c = 0; c < make->components; c++)
        make->first[c + 1] += make->first[c];
    for (size_t i = n; i-- > 0;)
        make->member[--make->first[make->component[i] + 1]] = (uint32_t)i;
    memmove(make->first, make->first + 1, make->components * sizeof *make->first);
    make->first[make->components] = (uint32_t)n;
    status = march_all(make, run, err);
    if (status == VOR_OK) {
        for (size_t m = 0; m < n; m++)
            for (size_t s = 0; s < SATELLITES; s++)
                make->at[3 * m + s] = make->far[s * n + make->member[m]];
    }
    for (size_t c = 0; c < make->components && status == VOR_OK; c++)
        status = list_component(make, c, run, err);
    VOR_THEN(status, vor_run_rows(run, make->domain->n, BLOCK, normal_row, make, err));
    return status;
}

vor_status vor_satellites_make(struct vor_graph *out, const struct vor_domain *domain,
                               const struct vor_run *run, struct vor_error *err)
{
    struct vor_graph graph = {.n = 0};
    struct make make = {.domain = domain, .graph = &graph};
    unsigned most = domain->n > VOR_ADJACENT ? VOR_ADJACENT : (unsigned)domain->n - 1;
    vor_status status = vor_graph_init(&graph, domain->n, most, run->memory, err);

    if (status != VOR_OK)
        return status;
    make.component = vor_malloc(run->memory, domain->n, sizeof *make.component);
    if (make.component == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    if (status == VOR_OK)
        status = vor_graph_nearest(&graph, domain->knn, domain->xyz,
                                   most < MARCHED ? most : MARCHED, run, err);
    VOR_THEN(status, vor_graph_keep_mutual(&graph, run, err));
    VOR_THEN(status, make_lists(&make, run, err));
    VOR_FREE_ALL(run->memory, make.at, make.far, make.member, make.first, make.source,
                 make.component);
    if (status == VOR_OK)
        *out = graph;
    else
        vor_graph_free(&graph);
    return status;
}
