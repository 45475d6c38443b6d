#include "core/align/fit.h"

#include <math.h>
#include <string.h>

enum {
    FEW_STEPS = 12,
    STEPS = 30,
    UNKNOWNS = 7, /* turn, shift, scale */
    AGAINST = 5,  /* the power of what is not in conflict, in a score */
    BINS = 256    /* of a histogram */
};

/* Cosine of normals that count as alike. */
#define ALIKE 0.5

/* A point farther than this many gaps along the plane from the sample is beside the reference. */
#define BESIDE 1.6

/* Least that a pose is held in every direction while it is fitted, so that it stays where it is
 * free. */
#define HELD 1e-4

/* Mean square by which offsets must change with the scale for it to be fitted: it is kept on a
 * plane. */
#define GROWS 0.01

/* Distance of plausible residuals from 0, over their median. */
#define PLAUSIBLE 4.0

/* Steps end once no point moves by this much of a gap. */
#define STILL 1e-3

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
    if (!(vor_dot(out->normal, normal) > ALIKE))
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
    for (int i = 0; i < n; i++)
        eq->a[i * n + i] += HELD * eq->weight;
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

double vor_align_roughness(const struct vor_align_samples *samples)
{
    struct vor_knn_last last = {.k = 0};
    struct histogram h = {.most = samples->gap};

    for (size_t i = 0; i < samples->n; i++) {
        struct contact contact;
        double normal[3];
        float d2[2];
        uint32_t at[2];

        vor_to_doubles(contact.x, &samples->xyz[3 * i]);
        vor_to_doubles(normal, &samples->normal[3 * i]);
        vor_knn_search_next(samples->knn, &last, &samples->xyz[3 * i], 2, at, d2);
        if (find_contact(&contact, samples, at[at[0] == i], normal, samples->gap))
            tell(&h, fabs(contact.off));
    }
    return h.all > 0 ? ranked(&h, h.all / 2.0) : 0;
}

/* Adds all samples within that distance. Returns the distance for the next step. */
static double add_all(struct equations *eq, const struct vor_align_fit *fit,
                      const struct vor_align_fit_of *of, double within)
{
    const struct vor_align_samples *cloud = of->cloud;
    struct vor_knn_last last = {.k = 0};
    struct histogram h = {.most = within};

    for (size_t i = of->first; i < cloud->n; i += of->every) {
        struct contact contact;
        double normal[3], near;
        float x[3], d2;
        uint32_t at;

        move_sample(cloud, i, &fit->pose, fit->flip, contact.x, normal);
        vor_to_floats(x, contact.x);
        vor_knn_search_next(of->reference->knn, &last, x, 1, &at, &d2);
        if (!find_contact(&contact, of->reference, at, normal, within))
            continue;
        tell(&h, fabs(contact.off));
        near = 1 - contact.off * contact.off / (within * within);
        add(eq, &contact, near * near, of->scales);
    }
    if (of->overlap > 0 && h.all > of->overlap * (double)cloud->n / of->every)
        return 1.5 * ranked(&h, of->overlap * (double)cloud->n / of->every);
    return fmin(within, PLAUSIBLE * ranked(&h, h.all / 2.0));
}

void vor_align_refine(struct vor_align_fit *fit, const struct vor_align_fit_of *of)
{
    double gap = of->reference->gap, within = 3 * gap, moved = INFINITY;

    for (int k = 0; k < STEPS && moved > STILL * gap; k++) {
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
    struct vor_knn_last last = {.k = 0};

    memset(side, 0, sizeof *side);
    side->off.most = within;
    for (size_t i = 0; i < from->n; i += of->every) {
        struct contact contact;
        double normal[3];
        float x[3], d2;
        uint32_t at;

        move_sample(from, i, &fit->pose, fit->flip, contact.x, normal);
        vor_to_floats(x, contact.x);
        vor_knn_search_next(onto->knn, &last, x, 1, &at, &d2);
        if (find_contact(&contact, onto, at, normal, within)) {
            side->on++;
            side->sum += 1 - contact.off * contact.off / (within * within);
            side->sum2 += contact.off * contact.off;
            tell(&side->off, fabs(contact.off));
            for (int c = 0; c < 3; c++)
                side->x[c] += contact.x[c];
            side->x2 += vor_dot(contact.x, contact.x);
        } else if ((double)d2 < reach * reach) {
            double n[3], d[3], off;

            vor_to_doubles(n, &onto->normal[3 * (size_t)at]);
            for (int c = 0; c < 3; c++)
                d[c] = contact.x[c] - (double)onto->xyz[3 * (size_t)at + (size_t)c];
            off = vor_dot(d, n);
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
                a[3 * r + s] = m[other + r][other + s] + (r == s ? HELD : 0);
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
    struct vor_knn_last last = {.k = 0};
    double middle[3], radius, m[6][6] = {{0}}, along[6] = {0}, grow = 0, n = (double)side->on;

    for (int c = 0; c < 3; c++)
        middle[c] = side->x[c] / n;
    radius = sqrt(side->x2 / n - vor_dot(middle, middle));
    for (size_t i = 0; i < of->cloud->n; i += of->every) {
        struct contact contact;
        double normal[3], row[6], g;
        float x[3], d2;
        uint32_t at;

        move_sample(of->cloud, i, &fit->pose, fit->flip, contact.x, normal);
        vor_to_floats(x, contact.x);
        vor_knn_search_next(of->reference->knn, &last, x, 1, &at, &d2);
        if (!find_contact(&contact, of->reference, at, normal, within))
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
            a[i] = m[i / 6][i % 6] + (i / 6 == i % 6 ? HELD : 0);
        if (vor_solve_spd(a, follow, 6, 1e-12) > 0)
            for (int i = 0; i < 6; i++)
                fit->grow -= follow[i] * along[i];
    }
}

void vor_align_judge(struct vor_align_fit *fit, const struct vor_align_fit_of *of, double within)
{
    double score = 0, agree = 0;
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
        agree += seen > 0 ? side[k].sum / seen / 2 : 0;
        score += side[k].sum / n / 2 * vor_power(1 - fit->conflict[k], AGAINST);
    }
    fit->score = score;
    fit->agree = agree;
    fit->rms = side[0].on > 0 ? sqrt(side[0].sum2 / (double)side[0].on) : 0;
    fit->median = ranked(&side[0].off, side[0].off.all / 2.0);
    fit->slide = fit->turn = fit->grow = 0;
    if (side[0].on >= UNKNOWNS)
        find_free(fit, of, &side[0], within);
}
