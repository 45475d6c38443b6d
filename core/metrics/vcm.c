#include "core/metrics/vcm.h"

#include "core/base/linalg.h"
#include "core/input/neighbors.h"
#include "core/knn/knn.h"

enum {
    BLOCK = 64,     /* points of one task */
    SEGMENTS = 512, /* of a cell: 3 faces - 6 edges, from both sides; some 120 are usual */
    CUTS = 32       /* that make a ball of a cube: points with no other near them take 30 */
};

/* An edge of a face, which lies to its left as seen from outside. A face is its edges in any order:
 * integrals over it need no other. */
struct segment {
    double a[3], b[3];
    unsigned face;
};

struct cell {
    unsigned count, faces, now; /* edges, all faces so far, which array the edges are in */
    struct segment segment[2][SEGMENTS];
};

static void make_cube(struct cell *cell)
{
    cell->count = cell->now = 0;
    cell->faces = 6;
    for (unsigned face = 0; face < 6; face++) {
        unsigned axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        double side = face % 2 ? 1 : -1;
        static const double turn[5][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};

        for (unsigned e = 0; e < 4; e++) {
            struct segment *to = &cell->segment[0][cell->count++];
            double *from[2] = {side > 0 ? to->a : to->b, side > 0 ? to->b : to->a};

            for (unsigned end = 0; end < 2; end++) {
                from[end][axis] = side;
                from[end][u] = turn[e + end][0];
                from[end][v] = turn[e + end][1];
            }
            to->face = face;
        }
    }
}

/* Keeps what has x . n <= d, d > 0. Does nothing where there is no room for more faces. */
static void cut(struct cell *cell, const double n[3], double d)
{
    const struct segment *from = cell->segment[cell->now];
    struct segment *to = cell->segment[!cell->now], cap[SEGMENTS / 4], gap = {.face = 0};
    unsigned count = 0, caps = 0, i = 0;
    int open = 0;

    while (i < cell->count && vor_dot(from[i].a, n) <= d)
        i++;
    if (i == cell->count)
        return;
    for (i = 0; i < cell->count; i++) {
        double a = vor_dot(from[i].a, n) - d, b = vor_dot(from[i].b, n) - d;
        struct segment *s = &to[count];

        if (i > 0 && from[i].face != from[i - 1].face)
            open = 0;
        if (a > 0 && b > 0)
            continue;
        if (count + 2 > SEGMENTS || caps == SEGMENTS / 4)
            return;
        *s = from[i];
        count++;
        if (a <= 0 && b <= 0)
            continue;
        /* From the end that stays: both faces of an edge get the same corner. */
        for (int c = 0; c < 3; c++)
            if (b > 0)
                gap.a[c] = s->b[c] = s->a[c] + a / (a - b) * (s->b[c] - s->a[c]);
            else
                gap.b[c] = s->a[c] = s->b[c] + b / (b - a) * (s->a[c] - s->b[c]);
        open |= b > 0 ? 1 : 2;
        if (open == 3) {
            gap.face = s->face;
            to[count++] = gap;
            memcpy(cap[caps].a, gap.b, sizeof gap.b);
            memcpy(cap[caps].b, gap.a, sizeof gap.a);
            cap[caps++].face = cell->faces;
            open = 0;
        }
    }
    if (count + caps > SEGMENTS)
        return;
    memcpy(&to[count], cap, caps * sizeof *cap);
    cell->count = count + caps;
    cell->faces++;
    cell->now = !cell->now;
}

/* Cuts corners off until none lies far beyond the unit ball. */
static void make_round(struct cell *cell)
{
    for (unsigned i = 0; i < CUTS; i++) {
        double far2 = 0, n[3] = {0}, far;

        for (unsigned j = 0; j < cell->count; j++) {
            const double *a = cell->segment[cell->now][j].a;

            if (vor_dot(a, a) > far2) {
                far2 = vor_dot(a, a);
                memcpy(n, a, sizeof n);
            }
        }
        if (far2 <= VOR_VCM_BEYOND * VOR_VCM_BEYOND)
            return;
        far = sqrt(far2);
        for (int c = 0; c < 3; c++)
            n[c] /= far;
        cut(cell, n, 1);
    }
}

void vor_vcm_cell(double out[6], const float *around, size_t k, double radius)
{
    struct cell cell;

    make_cube(&cell);
    for (size_t j = 1; j < k; j++) {
        double q[3], half2 = 0;

        for (int c = 0; c < 3; c++) {
            q[c] = ((double)around[3 * j + (size_t)c] - (double)around[c]) / radius;
            half2 += q[c] * q[c] / 2;
        }
        cut(&cell, q, half2);
    }
    make_round(&cell);
    memset(out, 0, 6 * sizeof *out);
    /* Tetrahedra from the point to a corner of each face and an edge of it: the second moments of
     * one are its volume / 20 times the sum of its corners' squares and of that of their sum. */
    for (unsigned i = 0, first = 0; i < cell.count; i++) {
        const struct segment *s = &cell.segment[cell.now][i], *base;
        double normal[3], sum[3], m[6] = {0}, share;

        if (s->face != cell.segment[cell.now][first].face)
            first = i;
        base = &cell.segment[cell.now][first];
        vor_cross(normal, s->a, s->b);
        share = vor_dot(base->a, normal) / 120;
        for (int c = 0; c < 3; c++)
            sum[c] = base->a[c] + s->a[c] + s->b[c];
        vor_add_square(m, sum);
        vor_add_square(m, base->a);
        vor_add_square(m, s->a);
        vor_add_square(m, s->b);
        for (int c = 0; c < 6; c++)
            out[c] += share * m[c];
    }
}

struct mark {
    const struct vor_domain *domain;
    unsigned around, summed; /* points of a cell, and of a sum */
    unsigned char *flag;
    float *moments; /* n x 6, in units of each point's radius^5 */
};

static void cell_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct mark *mark = ctx;
    const struct vor_domain *domain = mark->domain;
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        uint32_t index[VOR_VCM_MOST];
        float distance2[VOR_VCM_MOST], near[3 * VOR_VCM_MOST];
        double m[6], far2;

        vor_knn_search_next(domain->knn, &last, vor_domain_point(domain, i), mark->around, index,
                            distance2);
        vor_gather(near, domain->xyz, index, mark->around);
        /* That of the search may be 0: it is in single precision. */
        far2 = vor_distance2f(vor_domain_point(domain, i),
                              vor_domain_point(domain, index[mark->around - 1]));
        vor_vcm_cell(m, near, mark->around, sqrt(far2) / 2);
        for (size_t c = 0; c < 6; c++)
            mark->moments[6 * i + c] = (float)m[c];
    }
}

static void mark_block(void *ctx, size_t begin, size_t end, VOR_UNUSED unsigned worker)
{
    const struct mark *mark = ctx;
    const struct vor_domain *domain = mark->domain;
    struct vor_knn_last last = {.k = 0};

    for (size_t i = begin; i < end; i++) {
        uint32_t index[VOR_VCM_MOST];
        float distance2[VOR_VCM_MOST];
        double m[6] = {0}, values[3], axes[3][3];

        vor_knn_search_next(domain->knn, &last, vor_domain_point(domain, i), mark->summed, index,
                            distance2);
        for (unsigned j = 0; j < mark->summed; j++)
            for (size_t c = 0; c < 6; c++)
                m[c] += (double)mark->moments[6 * (size_t)index[j] + c];
        vor_eigen3(values, axes, m);
        mark->flag[i] = values[1] >= VOR_VCM_EDGE * (values[0] + values[1] + values[2]);
    }
}

/* `few` points, or more where fits take more. */
static unsigned points_of(const struct vor_domain *domain, unsigned few)
{
    unsigned k = few * domain->known.neighbors.usual / VOR_NEIGHBORS_FEWEST;

    return vor_domain_most(domain, k < few ? few : k > VOR_VCM_MOST ? VOR_VCM_MOST : k);
}

vor_status vor_vcm_mark(unsigned char *flag, const struct vor_domain *domain,
                        const struct vor_run *run, struct vor_error *err)
{
    struct mark mark = {.domain = domain,
                        .around = points_of(domain, VOR_VCM_AROUND),
                        .summed = points_of(domain, VOR_VCM_SUMMED),
                        .flag = flag};
    vor_status status;

    mark.moments = vor_malloc(run->memory, domain->n, 6 * sizeof *mark.moments);
    if (mark.moments == NULL)
        return vor_fail(err, VOR_E_NOMEM, "%zu points", domain->n);
    status = vor_run_for(run, domain->n, BLOCK, cell_block, &mark, err);
    VOR_THEN(status, vor_run_for(run, domain->n, BLOCK, mark_block, &mark, err));
    vor_free(run->memory, mark.moments);
    return status;
}
