#include "core/mesh/over.h"

#include "core/base/linalg.h"
#include "core/base/rng.h"
#include "core/mesh/peel.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Cosine of the angle that the surface turns by at an edge: of one that is taken at all (150
 * degrees: sharper is folded back), and from which on the smaller ball is better whatever the angle
 * (30 degrees). Both are Cohen-Steiner and Da's. */
#define SMOOTH (-VOR_PEEL_BLUNT)
#define FOLDED VOR_PEEL_BLUNT

/* Edges kept for each that is open, no more than points: it is looked at among few points and among
 * many, and so are those of the triangles around it that come and go. With more than points, kitti
 * to 10,000 takes 3 to 5 % less time, and 32 MB in the place of 25. */
enum { EACH_SLOTS = 16 };

vor_status vor_overs_make(struct vor_overs *out, struct vor_balls *balls, size_t edges,
                          struct vor_error *err)
{
    struct vor_memory *memory = balls->sheet->seeds->run.memory;
    size_t slots = 1;

    while (slots < EACH_SLOTS * edges && slots < balls->sheet->seeds->n)
        slots *= 2;
    if (out->slot != NULL && slots <= out->last + 1)
        return VOR_OK;
    vor_free(memory, out->slot);
    out->balls = balls;
    out->last = slots - 1;
    out->slot = vor_calloc(memory, slots, sizeof *out->slot);
    return out->slot != NULL ? VOR_OK : vor_fail(err, VOR_E_NOMEM, "%zu open edges", edges);
}

void vor_overs_free(struct vor_overs *overs)
{
    if (overs->balls != NULL)
        vor_free(overs->balls->sheet->seeds->run.memory, overs->slot);
    memset(overs, 0, sizeof *overs);
}

/* An edge over which third points are looked for. */
struct search {
    const struct vor_balls *balls;
    const uint32_t *edge;
    double before[3]; /* the normal of its triangle */
    const double *to; /* the offset of its second point from its first; NULL: it is too far */
};

static void begin(struct search *search, const struct vor_overs *overs, const struct vor_over *over)
{
    *search = (struct search){overs->balls, over->edge, {0, 0, 0}, NULL};
    if (!vor_triangle_unit_normal(search->before, overs->balls->sheet->seeds->xyz, over->edge))
        return;
    vor_balls_look(overs->balls, over->edge[0], over->around);
    search->to = vor_balls_find(overs->balls, over->edge[1]);
}

/* Whether a triangle lies along the surface, on either side of it. */
static int is_along(const struct vor_sheet *sheet, const uint32_t corner[3], const double normal[3])
{
    double sum = 0;

    for (int c = 0; c < 3; c++) {
        const float *m = &sheet->normal[3 * (size_t)corner[c]];

        sum += fabs(normal[0] * (double)m[0] + normal[1] * (double)m[1] + normal[2] * (double)m[2]);
    }
    return sum >= 3 * VOR_OVER_ALONG;
}

/* What the triangle with a point around as its third corner is worth; -INFINITY where there is
 * none, or none worth more than `least`. */
static float worth_of(const struct search *search, unsigned i, float least)
{
    const struct vor_balls *balls = search->balls;
    const uint32_t *edge = search->edge;
    uint32_t corner[3] = {edge[1], edge[0], balls->index[i]};
    double normal[3], turned, radius2, most2 = INFINITY;

    if (corner[2] == edge[0] || corner[2] == edge[1] || corner[2] == edge[2] ||
        !vor_triangle_unit_normal(normal, balls->sheet->seeds->xyz, corner))
        return -INFINITY;
    turned = vor_dot(normal, search->before);
    if (!(turned > FOLDED) || (turned < SMOOTH && (float)(turned - 1) <= least) ||
        !is_along(balls->sheet, corner, normal))
        return -INFINITY;
    if (turned >= SMOOTH && least > 0)
        most2 = 1 / ((double)least * (double)least);
    radius2 = vor_balls_radius2(balls, search->to, balls->x[i], most2);
    if (!(radius2 < (double)INFINITY))
        return -INFINITY;
    return turned < SMOOTH ? (float)(turned - 1) : (float)(1 / sqrt(radius2));
}

/* Where an edge is kept, whether or not another one is there. */
static struct vor_over *slot_of(const struct vor_overs *overs, const uint32_t edge[3],
                                unsigned around)
{
    return &overs->slot[(vor_rng_bits(edge[0], edge[1], edge[2]) + around) & overs->last];
}

static int is_kept(const struct vor_over *over, const uint32_t edge[3], unsigned around)
{
    return over->around == around && memcmp(over->edge, edge, sizeof over->edge) == 0;
}

struct vor_over *vor_overs_look(struct vor_overs *overs, const uint32_t edge[3], unsigned around)
{
    struct vor_over *over = slot_of(overs, edge, around);
    struct search search;
    float best = -INFINITY;

    if (is_kept(over, edge, around))
        return over;
    *over = (struct vor_over){{edge[0], edge[1], edge[2]}, (unsigned char)around, 0, 0, {{0}}};
    begin(&search, overs, over);
    for (unsigned i = 0; search.to != NULL && i < overs->balls->around; i++) {
        float here = worth_of(&search, i, best);

        if (here > best) {
            best = here;
            over->count = 1;
            over->best[0] = (struct vor_candidate){overs->balls->index[i], here, 0, 0};
        }
    }
    over->whole = over->count == 0;
    return over;
}

struct vor_candidate *vor_overs_find(const struct vor_overs *overs, const uint32_t edge[3],
                                     unsigned around, uint32_t point)
{
    struct vor_over *over = slot_of(overs, edge, around);

    for (unsigned k = 0; is_kept(over, edge, around) && k < over->count; k++)
        if (over->best[k].point == point)
            return &over->best[k];
    return NULL;
}

unsigned vor_overs_list(struct vor_overs *overs, struct vor_over *over,
                        struct vor_candidate out[VOR_BALLS_MANY])
{
    struct search search;
    unsigned count = 0;

    begin(&search, overs, over);
    for (unsigned i = 0; search.to != NULL && i < overs->balls->around; i++) {
        struct vor_candidate here = {overs->balls->index[i], worth_of(&search, i, -INFINITY), 0, 0};
        unsigned at = count;

        if (!(here.worth > -INFINITY))
            continue;
        for (; at > 0 && out[at - 1].worth < here.worth; at--)
            out[at] = out[at - 1];
        out[at] = here;
        count++;
    }
    for (unsigned k = over->count; k < count && k < VOR_OVER_SLOTS; k++)
        over->best[over->count++] = out[k];
    over->whole = over->count == count;
    return count;
}
