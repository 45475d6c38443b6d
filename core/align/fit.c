#include "core/align/fit.h"

#include "core/geom/surface.h"

#include <math.h>
#include <string.h>

enum {
    FEW_STEPS = 12, /* of the few samples, and of points */
    STEPS = 30,
    LOOKED_AT = 4000, /* points at least, if there are as many, for a step and to weigh a pose */
    CARRIERS = 6,     /* points of one cloud of which each may carry a point of the other one */
    UNKNOWNS = 7,     /* turn, shift, scale */
    BINS = 256        /* of a histogram */
};

/* A point farther than this many gaps along the plane from the sample is beside the reference; one
 * farther than this many reaches from a point is not on its plane. */
#define BESIDE 1.6

/* Mean square by which offsets must change with the scale for it to be fitted: it is kept on a
 * plane. */
#define GROWS 0.01

/* Offsets that count in the next step, over the median of this one. The first steps take points as
 * many gaps or reaches from the reference, those by points one reach less after as many steps. */
#define WIDEST VOR_SURE

/* A point lies on a plane within VOR_SURE times the noise of either cloud, or this share of how far
 * the plane reaches. It hovers if it is nearer the point than the plane reaches, seen along the
 * normal, and within so many reaches. */
#define THICK 0.15
#define HIGHEST WIDEST

/* Noise at least, over how far planes reach. */
#define EXACT 0.015

/* A sample of the cloud on a plane of the reference. */
struct contact {
    double x[3], normal[3], off;
};

struct equations {
    double a[UNKNOWNS * UNKNOWNS], b[UNKNOWNS], weight;
};

/* Whether out->x, with that normal, lies on the plane of a sample: within that distance, beside the
 * sample not too far, and facing the same way. Sets the sample's normal and the distance. */
static int find_contact(struct contact *out, const struct vor_align_samples *onto, uint32_t at,
                        const double normal[3], double within)
{
    const float *q = &onto->xyz[3 * (size_t)at];
    double d[3], along2;

    vor_to_doubles(out->normal, &onto->normal[3 * (size_t)at]);
    if (!(vor_dot(out->normal, normal) > VOR_ALIGN_ALIKE))
        return 0;
    for (int c = 0; c < 3; c++)
        d[c] = out->x[c] - (double)q[c];
    out->off = vor_dot(d, out->normal);
    along2 = vor_dot(d, d) - out->off * out->off;
    return along2 < BESIDE * BESIDE * onto->gap * onto->gap && fabs(out->off) < within;
}

/* Adds a contact: how its offset changes as the cloud turns about 0, shifts and grows. */
static void add(struct equations *eq, const struct contact *contact, double weight, int scales)
{
    double row[UNKNOWNS];
    int n = scales ? UNKNOWNS : UNKNOWNS - 1;

    vor_cross(row, contact->x, contact->normal);
    memcpy(row + 3, contact->normal, sizeof contact->normal);
    row[6] = vor_dot(contact->x, contact->normal);
    for (int r = 0; r < n; r++) {
        for (int c = 0; c <= r; c++)
            eq->a[r * n + c] += weight * row[r] * row[c];
        eq->b[r] -= weight * row[r] * contact->off;
    }
    eq->weight += weight;
}

/* Applies a small motion to a pose; the turn is that of the quaternion (1, by / 2). */
static void apply(struct vor_pose *pose, const double by[UNKNOWNS], int scales)
{
    double q[4] = {1, by[0] / 2, by[1] / 2, by[2] / 2};
    double n = 1 / (1 + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    double scale = scales ? 1 + by[6] : 1;
    struct vor_pose was = *pose;
    double turn[3][3];

    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            turn[r][c] = 2 * n * (q[r + 1] * q[c + 1]);
    for (int r = 0; r < 3; r++) {
        int s = (r + 1) % 3, t = (r + 2) % 3;

        turn[r][r] += 2 * n - 1;
        turn[r][s] -= 2 * n * q[t + 1];
        turn[s][r] += 2 * n * q[t + 1];
    }
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            pose->turn[r][c] = turn[r][0] * was.turn[0][c] + turn[r][1] * was.turn[1][c] +
                               turn[r][2] * was.turn[2][c];
        pose->shift[r] = scale * vor_dot(turn[r], was.shift) + by[3 + r];
    }
    pose->scale = was.scale * scale;
}

/* Solves and applies one step. Returns about how far points move. */
static double step(struct vor_pose *pose, struct equations *eq, int scales)
{
    int n = scales ? UNKNOWNS : UNKNOWNS - 1;
    double sum = 0;

    if (!(eq->weight > 0))
        return 0;
    for (int i = 0; i < n; i++) /* so that the pose stays where it is free */
        eq->a[i * n + i] += VOR_NEGLIGIBLE * eq->weight;
    if (scales && eq->a[UNKNOWNS * UNKNOWNS - 1] < GROWS * eq->weight)
        eq->a[UNKNOWNS * UNKNOWNS - 1] += eq->weight;
    if (!(vor_solve_spd(eq->a, eq->b, n, 1e-12) > 0))
        return 0;
    for (int i = 0; i < n; i++)
        sum += eq->b[i] * eq->b[i];
    if (sum > 0.1) /* more than the linear motion is good for */
        for (int i = 0; i < n; i++)
            eq->b[i] *= sqrt(0.1 / sum);
    apply(pose, eq->b, scales);
    return sqrt(sum);
}

/* Moves sample i of the cloud. */
static void move_sample(const struct vor_align_samples *cloud, size_t i,
                        const struct vor_pose *pose, int flip, double x[3], double normal[3])
{
    double from[3];

    vor_to_doubles(from, &cloud->xyz[3 * i]);
    vor_pose_move(pose, from, x);
    vor_to_doubles(from, &cloud->normal[3 * i]);
    vor_pose_turn(pose, from, normal);
    for (int c = 0; c < 3 && flip; c++)
        normal[c] = -normal[c];
}

/* Samples of one cloud on their way onto the other, and the nearest to the last one moved. */
struct nearest {
    const struct vor_align_samples *from, *onto;
    struct vor_knn_last last;
    uint32_t at;
    float d2;
};

/* Moves sample i by a fit and finds its contact. */
static int meets(struct contact *out, struct nearest *nearest, size_t i,
                 const struct vor_align_fit *fit, double within)
{
    double normal[3];
    float x[3];

    move_sample(nearest->from, i, &fit->pose, fit->flip, out->x, normal);
    vor_to_floats(x, out->x);
    vor_knn_search_next(nearest->onto->knn, &nearest->last, x, 1, &nearest->at, &nearest->d2);
    return find_contact(out, nearest->onto, nearest->at, normal, within);
}

void vor_align_refine_few(struct vor_pose *pose, int flip, const struct vor_align_fit_of *of)
{
    const struct vor_align_samples *cloud = of->cloud;

    for (int k = 0; k < FEW_STEPS; k++) {
        double within = of->grid->reach * (1 - 0.6 * k / FEW_STEPS);
        struct equations eq = {.weight = 0};

        for (size_t i = 0; i < cloud->few; i++) {
            struct contact contact;
            double normal[3], near;
            uint32_t at;

            move_sample(cloud, cloud->chosen[i], pose, flip, contact.x, normal);
            at = vor_align_grid_at(of->grid, contact.x);
            if (at == UINT32_MAX || !find_contact(&contact, of->reference, at, normal, within))
                continue;
            near = 1 - contact.off * contact.off / (within * within);
            add(&eq, &contact, near * near, of->scales && k > FEW_STEPS / 2);
        }
        (void)step(pose, &eq, of->scales && k > FEW_STEPS / 2);
    }
}

/* Numbers from 0 to `most` by size. */
struct histogram {
    double most;
    uint32_t count[BINS], all;
};

static void tell(struct histogram *h, double value)
{
    double bin = value / h->most * BINS;

    h->count[bin < BINS - 1 ? (unsigned)bin : BINS - 1]++;
    h->all++;
}

/* The value that `rank` of them are below. */
static double ranked(const struct histogram *h, double rank)
{
    double sum = 0;
    unsigned bin = 0;

    while (bin < BINS - 1 && sum + h->count[bin] < rank)
        sum += h->count[bin++];
    return (bin + 1) * h->most / BINS;
}

/* Adds all samples within that distance. Returns the distance for the next step. */
static double add_all(struct equations *eq, const struct vor_align_fit *fit,
                      const struct vor_align_fit_of *of, double within)
{
    const struct vor_align_samples *cloud = of->cloud;
    struct nearest nearest = {.from = of->cloud, .onto = of->reference};
    struct histogram h = {.most = within};

    for (size_t i = of->first; i < cloud->n; i += of->every) {
        struct contact contact;
        double near;

        if (!meets(&contact, &nearest, i, fit, within))
            continue;
        tell(&h, fabs(contact.off));
        near = 1 - contact.off * contact.off / (within * within);
        add(eq, &contact, near * near, of->scales);
    }
    if (of->overlap > 0 && h.all > of->overlap * (double)cloud->n / of->every)
        return 1.5 * ranked(&h, of->overlap * (double)cloud->n / of->every);
    return fmin(within, WIDEST * ranked(&h, h.all / 2.0));
}

void vor_align_refine(struct vor_align_fit *fit, const struct vor_align_fit_of *of)
{
    double gap = of->reference->gap, within = WIDEST * gap, moved = INFINITY;

    for (int k = 0; k < STEPS && moved > VOR_NEGLIGIBLE * gap; k++) {
        struct equations eq = {.weight = 0};

        within = fmax(0.25 * gap, add_all(&eq, fit, of, within));
        moved = step(&fit->pose, &eq, of->scales);
    }
}

/* What one cloud's samples find on the other one. */
struct side {
    size_t on, beside, conflict;
    double sum, sum2, x[3], x2; /* of kernels, of offsets, of positions */
    struct histogram off;
};

/* Judges the samples of the cloud by a fit, or back those of the reference by its inverse. */
static void judge_side(struct side *side, const struct vor_align_fit_of *of, int back,
                       const struct vor_align_fit *fit, double within)
{
    const struct vor_align_samples *from = back ? of->reference : of->cloud;
    const struct vor_align_samples *onto = back ? of->cloud : of->reference;
    double reach = of->grid->reach * (back ? fit->pose.scale : 1);
    struct nearest nearest = {.from = from, .onto = onto};

    memset(side, 0, sizeof *side);
    side->off.most = within;
    for (size_t i = 0; i < from->n; i += of->every) {
        struct contact contact;

        if (meets(&contact, &nearest, i, fit, within)) {
            side->on++;
            side->sum += 1 - contact.off * contact.off / (within * within);
            side->sum2 += contact.off * contact.off;
            tell(&side->off, fabs(contact.off));
            for (int c = 0; c < 3; c++)
                side->x[c] += contact.x[c];
            side->x2 += vor_dot(contact.x, contact.x);
        } else if ((double)nearest.d2 < reach * reach) {
            const float *q = &onto->xyz[3 * (size_t)nearest.at];
            double d[3], off;

            for (int c = 0; c < 3; c++)
                d[c] = contact.x[c] - (double)q[c];
            off = vor_dot(d, contact.normal);
            if (vor_dot(d, d) - off * off > BESIDE * BESIDE * onto->gap * onto->gap &&
                off * off < vor_dot(d, d) / 2)
                side->beside++;
            else
                side->conflict++;
        }
    }
}

/* The smallest eigenvalue of the motions of `a` (3 x 3 of a 6 x 6 matrix, from row `at`) when the
 * other three follow; and its direction. */
static double firmness(double direction[3], const double m[6][6], int at)
{
    int other = 3 - at;
    double square[6], values[3], vectors[3][3], follow[3][3];
    int k = 0;

    for (int c = 0; c < 3; c++) {
        double a[9];

        for (int r = 0; r < 3; r++) {
            for (int s = 0; s < 3; s++)
                a[3 * r + s] = m[other + r][other + s] + (r == s ? VOR_NEGLIGIBLE : 0);
            follow[c][r] = m[other + r][at + c];
        }
        (void)vor_solve_spd(a, follow[c], 3, 1e-12);
    }
    for (int r = 0; r < 3; r++)
        for (int c = r; c < 3; c++) {
            square[k] = m[at + r][at + c];
            for (int s = 0; s < 3; s++)
                square[k] -= m[at + r][other + s] * follow[c][s];
            k++;
        }
    vor_eigen3(values, vectors, square);
    memcpy(direction, vectors[0], sizeof vectors[0]);
    return fmax(values[0], 0);
}

/* Finds the motions that change offsets least, about the middle of the contacts. */
static void find_free(struct vor_align_fit *fit, const struct vor_align_fit_of *of,
                      const struct side *side, double within)
{
    struct nearest nearest = {.from = of->cloud, .onto = of->reference};
    double middle[3], radius, m[6][6] = {{0}}, along[6] = {0}, grow = 0, n = (double)side->on;

    for (int c = 0; c < 3; c++)
        middle[c] = side->x[c] / n;
    radius = sqrt(side->x2 / n - vor_dot(middle, middle));
    for (size_t i = 0; i < of->cloud->n; i += of->every) {
        struct contact contact;
        double row[6], g;

        if (!meets(&contact, &nearest, i, fit, within))
            continue;
        for (int c = 0; c < 3; c++)
            contact.x[c] = (contact.x[c] - middle[c]) / radius;
        vor_cross(row, contact.x, contact.normal);
        memcpy(row + 3, contact.normal, sizeof contact.normal);
        g = vor_dot(contact.x, contact.normal);
        for (int r = 0; r < 6; r++) {
            for (int c = 0; c < 6; c++)
                m[r][c] += row[r] * row[c] / n;
            along[r] += row[r] * g / n;
        }
        grow += g * g / n;
    }
    fit->turn = firmness(fit->turns, (const double(*)[6])m, 0);
    fit->slide = firmness(fit->slides, (const double(*)[6])m, 3);
    fit->grow = grow;
    if (of->scales) {
        double a[36], follow[6];

        memcpy(follow, along, sizeof follow);
        for (int i = 0; i < 36; i++)
            a[i] = m[i / 6][i % 6] + (i / 6 == i % 6 ? VOR_NEGLIGIBLE : 0);
        if (vor_solve_spd(a, follow, 6, 1e-12) > 0)
            for (int i = 0; i < 6; i++)
                fit->grow -= follow[i] * along[i];
    }
}

void vor_align_judge(struct vor_align_fit *fit, const struct vor_align_fit_of *of, double within)
{
    double score = 0;
    struct vor_align_fit back = *fit;
    struct side side[2];

    vor_pose_invert(&back.pose, &fit->pose);
    judge_side(&side[0], of, 0, fit, within);
    judge_side(&side[1], of, 1, &back, within * back.pose.scale);
    for (int k = 0; k < 2; k++) {
        double n = (double)vor_blocks_of(k == 0 ? of->cloud->n : of->reference->n, of->every);
        double seen = (double)(side[k].on + side[k].conflict);

        fit->overlap[k] = (double)side[k].on / n;
        fit->conflict[k] = seen > 0 ? (double)side[k].conflict / seen : 1;
        score += side[k].sum / n / 2 * (1 - fit->conflict[k]);
    }
    fit->score = score;
    fit->rms = side[0].on > 0 ? sqrt(side[0].sum2 / (double)side[0].on) : 0;
    fit->median = ranked(&side[0].off, side[0].off.all / 2.0);
    fit->slide = fit->turn = fit->grow = 0;
    if (side[0].on >= UNKNOWNS)
        find_free(fit, of, &side[0], within);
}

/* A point of a cloud, moved. */
struct moved {
    double x[3], normal[3], reach, off;
};

static struct moved move_point(const struct vor_align_points *points, size_t i,
                               const struct vor_pose *pose)
{
    const struct vor_align_plane *plane = &points->plane[i];
    struct moved out = {.reach = (double)plane->reach * pose->scale,
                        .off = (double)plane->off * pose->scale};
    double from[3] = {0, 0, 0};

    vor_to_doubles(from, &points->xyz[3 * i]);
    vor_pose_move(pose, from, out.x);
    vor_to_doubles(from, plane->normal);
    vor_pose_turn(pose, from, out.normal);
    return out;
}

/* A point of a cloud at a point of the other one: how far from its plane, how far beside it, and
 * the cosine between the planes, 0 where there is none. */
struct meeting {
    double off, beside2, cosine;
};

static struct meeting meet(const struct moved *point, const struct vor_align_points *onto,
                           uint32_t at)
{
    const struct vor_align_plane *plane = &onto->plane[at];
    double n[3], d[3], m[3], up;

    vor_to_doubles(n, plane->normal);
    for (int c = 0; c < 3; c++) {
        d[c] = point->x[c] - (double)onto->xyz[3 * (size_t)at + (size_t)c];
        m[c] = point->x[c] - (double)plane->middle[c];
    }
    up = vor_dot(d, n);
    return (struct meeting){.off = vor_dot(m, n),
                            .beside2 = vor_dot(d, d) - up * up,
                            .cosine = plane->reach > 0 ? fabs(vor_dot(n, point->normal)) : 0};
}

static int is_within(double d2, double share, double reach)
{
    return d2 < share * share * reach * reach;
}

/* Adds points within that distance of planes that reach so many times farther. Returns the distance
 * for the next step. */
static double add_points(struct equations *eq, const struct vor_pose *pose,
                         const struct vor_align_fit_of *of, double within, double farther)
{
    const struct vor_align_points *cloud = of->points[0], *onto = of->points[1];
    struct vor_knn_last last = {.k = 0};
    struct histogram h = {.most = within};
    size_t stride = 1 + cloud->n / LOOKED_AT, all = 0;
    double share;

    for (size_t i = of->first * stride; i < cloud->n; i += of->every * stride, all++) {
        struct moved point = move_point(cloud, i, pose);
        struct contact contact;
        struct meeting met;
        double near;
        float x[3], d2;
        uint32_t at;

        vor_to_floats(x, point.x);
        vor_knn_search_next(onto->knn, &last, x, 1, &at, &d2);
        met = meet(&point, onto, at);
        if (met.cosine < VOR_ALIGN_ALIKE || fabs(met.off) >= within ||
            !is_within((double)d2, farther, (double)onto->plane[at].reach))
            continue;
        contact.off = met.off;
        memcpy(contact.x, point.x, sizeof contact.x);
        vor_to_doubles(contact.normal, onto->plane[at].normal);
        tell(&h, fabs(met.off));
        near = 1 - met.off * met.off / (within * within);
        add(eq, &contact, near * near, of->scales);
    }
    share = of->overlap * (double)all;
    if (of->overlap > 0 && h.all > share)
        return 1.5 * ranked(&h, share);
    return WIDEST * ranked(&h, h.all / 2.0);
}

void vor_align_settle(struct vor_pose *pose, const struct vor_align_fit_of *of)
{
    double reach = of->points[1]->reach, within = WIDEST * reach;

    for (int k = 0; k < FEW_STEPS; k++) {
        struct equations eq = {.weight = 0};

        within = add_points(&eq, pose, of, within, fmax(1, WIDEST - k / WIDEST));
        within = fmax(VOR_NEGLIGIBLE * reach, fmin(WIDEST * reach, within));
        (void)step(pose, &eq, of->scales);
    }
}

/* What points of one cloud find on the other one. */
struct found {
    size_t all, near, on, hover;
    struct histogram off, own[2]; /* distances: from planes, of both points from their own */
};

/* Median distance from planes, over that of the points from their own, which has the noise and the
 * curvature of both. */
static double loose(const struct found *found, double reach)
{
    double half = found->off.all / 2.0, own2 = EXACT * reach * EXACT * reach;

    if (!(half > 0))
        return INFINITY;
    for (int k = 0; k < 2; k++)
        own2 += ranked(&found->own[k], half) * ranked(&found->own[k], half);
    return ranked(&found->off, half) / sqrt(own2);
}

/* Whether the point lies on the plane of a point that is so far from it. */
static int lies_on(const struct meeting *met, const struct vor_align_plane *plane, double rough,
                   double d2)
{
    double within =
        fmax(VOR_SURE * fmax(rough, (double)plane->rough), THICK * (double)plane->reach);

    return met->cosine > VOR_ALIGN_ALIKE && fabs(met->off) < within &&
           is_within(d2, BESIDE, (double)plane->reach);
}

static void weigh_side(struct found *found, const struct vor_align_points *from,
                       const struct vor_align_points *onto, const struct vor_pose *pose)
{
    struct vor_knn_last last = {.k = 0};

    memset(found, 0, sizeof *found);
    found->off.most = found->own[0].most = found->own[1].most = onto->reach;
    for (size_t i = 0; i < from->n; i += 1 + from->n / LOOKED_AT) {
        struct moved point = move_point(from, i, pose);
        const struct vor_align_plane *plane;
        struct meeting met;
        uint32_t at[CARRIERS];
        float x[3], d2[CARRIERS];
        double reach;
        int on = 0;

        vor_to_floats(x, point.x);
        vor_knn_search_next(onto->knn, &last, x, CARRIERS, at, d2);
        for (int k = CARRIERS - 1; k >= 0; k--) {
            int lies;

            plane = &onto->plane[at[k]];
            met = meet(&point, onto, at[k]);
            lies = lies_on(&met, plane, from->rough * pose->scale, (double)d2[k]);
            on |= lies;
            if (k == 0 && lies) {
                tell(&found->off, fabs(met.off));
                tell(&found->own[0], point.off);
                tell(&found->own[1], (double)plane->off);
            }
        }
        reach = (double)plane->reach; /* of the nearest */
        found->all++;
        found->on += on != 0;
        found->near += is_within((double)d2[0], BESIDE, fmax(reach, point.reach)) != 0;
        found->hover += !on && !plane->border && is_within(met.beside2, 1, reach) &&
                        fabs(met.off) < HIGHEST * onto->reach;
    }
}

void vor_align_weigh(struct vor_align_fit *fit, const struct vor_align_fit_of *of)
{
    struct found found[2];
    struct vor_pose back;

    vor_pose_invert(&back, &fit->pose);
    weigh_side(&found[0], of->points[0], of->points[1], &fit->pose);
    weigh_side(&found[1], of->points[1], of->points[0], &back);
    fit->on = fit->hover = fit->beside = fit->loose = 0;
    for (int k = 0; k < 2; k++) {
        double on = (double)found[k].on, hover = (double)found[k].hover;
        double near = (double)found[k].near;

        fit->on += on / (double)found[k].all / 2;
        fit->hover += hover > 0 ? hover / (on + hover) / 2 : 0;
        fit->beside += near > on ? (near - on) / near / 2 : 0;
        fit->loose = fmax(fit->loose, loose(&found[k], of->points[!k]->reach));
    }
}
