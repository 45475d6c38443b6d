#include "core/mesh/relax.h"

#include "core/base/linalg.h"
#include "core/mesh/quality.h"

#include <string.h>

/* Share of Newton's step: all points move at once. At 0.5 / 0.7 / 1 mean quality on fandisk differs
 * by 0.002. */
#define DAMP 0.7

/* Cosine between the normal at a point and those of its triangles, below which it is on a crease or
 * a tip, which it would cut off as it moves. At 0 / 0.7 / 0.9, fandisk to 10,000: least quality
 * 0.77 / 0.66 / 0.66, mean 0.959 / 0.955 / 0.953, Hausdorff distance 0.58 / 0.43 / 0.43 spacings
 * (0.42 where no point moves). */
#define SMOOTH 0.7

/* Quality of a triangle below which its corners move even there. Without, the least quality on
 * armadillo, 30,000 points, is 0.45. */
#define POOR 0.7

struct relax {
    struct vor_sheet *sheet;
    struct vor_seeds *seeds;
    const struct vor_complex *complex;
    float *next;           /* n x 3 */
    unsigned char *moves;  /* n: of enum vor_relax_motion */
    unsigned char *near;   /* n: how many rings nearer to a crease than those that do not care */
    struct vor_recall how; /* last fits are used again */
    enum vor_relax_aim aim;
    double length; /* that edges are brought to */
};

/* With the apex at (u, v) from the base's middle, v across it, and the ideal one at (0, h), the
 * strain is (u^2 + v^2 + h^2) / (2 h v). */
void vor_relax_add(struct vor_relax_pull *pull, const struct vor_frame *frame, const float *x,
                   const float *a, const float *b)
{
    double base[3] = {0}, across[3] = {0}, length, u, v, h, slope[2], bend[3], along[2], up[2];

    for (int c = 0; c < 3; c++) {
        base[c] = (double)b[c] - (double)a[c];
        across[c] = (double)x[c] - ((double)a[c] + (double)b[c]) / 2;
    }
    length = sqrt(vor_dot(base, base));
    u = length > 0 ? vor_dot(across, base) / length : 0;
    for (int c = 0; c < 3; c++)
        across[c] -= length > 0 ? u * base[c] / length : 0;
    v = sqrt(vor_dot(across, across));
    h = sqrt(3) / 2 * length;
    pull->triangles++;
    if (!(v > VOR_ROUNDED * length) || !(length > 0))
        return;
    slope[0] = u / (h * v);
    slope[1] = (1 - (u * u + h * h) / (v * v)) / (2 * h);
    bend[0] = 1 / (h * v);
    bend[1] = -u / (h * v * v);
    bend[2] = (u * u + h * h) / (h * v * v * v);
    if (pull->area > 0) { /* adds v / height + height / v */
        double height = 2 * pull->area / length;

        slope[1] += 1 / height - height / (v * v);
        bend[2] += 2 * height / (v * v * v);
    }
    for (int e = 0; e < 2; e++) {
        along[e] = vor_dot(frame->axis[e], base) / length;
        up[e] = vor_dot(frame->axis[e], across) / v;
        pull->slope[e] += slope[0] * along[e] + slope[1] * up[e];
    }
    pull->bend[0] +=
        bend[0] * along[0] * along[0] + 2 * bend[1] * along[0] * up[0] + bend[2] * up[0] * up[0];
    pull->bend[1] += bend[0] * along[0] * along[1] +
                     bend[1] * (along[0] * up[1] + along[1] * up[0]) + bend[2] * up[0] * up[1];
    pull->bend[2] +=
        bend[0] * along[1] * along[1] + 2 * bend[1] * along[1] * up[1] + bend[2] * up[1] * up[1];
    pull->edge += sqrt(vor_distance2f(x, a)) + sqrt(vor_distance2f(x, b));
}

void vor_relax_step(double step[2], const struct vor_relax_pull *pull)
{
    double determinant = pull->bend[0] * pull->bend[2] - pull->bend[1] * pull->bend[1];
    double limit, length;

    step[0] = step[1] = 0;
    if (!(determinant > 0))
        return;
    step[0] =
        -DAMP * (pull->bend[2] * pull->slope[0] - pull->bend[1] * pull->slope[1]) / determinant;
    step[1] =
        -DAMP * (pull->bend[0] * pull->slope[1] - pull->bend[1] * pull->slope[0]) / determinant;
    length = sqrt(step[0] * step[0] + step[1] * step[1]);
    limit = VOR_RELAX_STEP_MAX * pull->edge / (2 * pull->triangles);
    for (int e = 0; e < 2 && length > limit; e++)
        step[e] *= limit / length;
}

void vor_relax_hold(struct vor_relax_pull *pull)
{
    pull->slope[1] = pull->bend[1] = 0;
    pull->bend[2] = 1;
}

/* Of the triangles around point i. */
static double mean_area(const struct vor_complex *complex, const float *xyz, size_t i)
{
    double sum = 0;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[i * VOR_AROUND_MOST + t];
        double normal[3];

        vor_triangle_normal(normal, xyz, &complex->triangle[3 * (size_t)at]);
        sum += sqrt(vor_dot(normal, normal)) / 2;
    }
    return sum / complex->degree[i];
}

/* The step of point i in its tangent plane, or along the first axis of its frame. */
static void step_of(const struct relax *relax, const struct vor_frame *frame, size_t i,
                    double step[2])
{
    const struct vor_complex *complex = relax->complex;
    const float *xyz = relax->seeds->xyz;
    struct vor_relax_pull pull = {.triangles = 0};

    if (relax->aim == VOR_RELAX_SIZE && relax->near[i] == 0)
        pull.area = mean_area(complex, xyz, i);
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t other[2];

        vor_complex_others(complex, complex->around[i * VOR_AROUND_MOST + t], (uint32_t)i, other);
        vor_relax_add(&pull, frame, &xyz[3 * i], &xyz[3 * (size_t)other[0]],
                      &xyz[3 * (size_t)other[1]]);
    }
    if (relax->moves[i] == VOR_RELAX_ALONG)
        vor_relax_hold(&pull);
    vor_relax_step(step, &pull);
}

/* The step of point i towards where the edges to its neighbours, each of which two triangles have,
 * are least too short, squared and summed: Newton's, with the second derivative of edges in all
 * directions, half of how many there are. Were long ones to pull, those of five neighbours and of
 * seven would not become equally long. */
static void push_of(const struct relax *relax, const struct vor_frame *frame, size_t i,
                    double step[2])
{
    const struct vor_complex *complex = relax->complex;
    const struct vor_wanted *wanted = &relax->seeds->wanted;
    const float *x = &relax->seeds->xyz[3 * i];

    step[0] = step[1] = 0;
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t other[2];

        vor_complex_others(complex, complex->around[i * VOR_AROUND_MOST + t], (uint32_t)i, other);
        for (int e = 0; e < 2; e++) {
            const float *y = &relax->seeds->xyz[3 * (size_t)other[e]];
            double to =
                relax->length * (vor_wanted_at(wanted, i) + vor_wanted_at(wanted, other[e])) / 2;
            double d[3] = {(double)x[0] - (double)y[0], (double)x[1] - (double)y[1],
                           (double)x[2] - (double)y[2]};
            double length = sqrt(vor_dot(d, d));

            for (int a = 0; a < 2 && length > 0; a++)
                step[a] += DAMP * fmax(to - length, 0) / length * vor_dot(frame->axis[a], d) /
                           complex->degree[i];
        }
    }
}

/* The step of point i to the mean of the middles of its triangles by their areas. */
static void mean_of(const struct relax *relax, const struct vor_frame *frame, size_t i,
                    double step[2])
{
    const struct vor_complex *complex = relax->complex;
    const struct vor_wanted *wanted = &relax->seeds->wanted;
    const float *xyz = relax->seeds->xyz;
    double sum = 0;

    step[0] = step[1] = 0;
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[i * VOR_AROUND_MOST + t], other[2];
        double normal[3], area, d[3], w;

        vor_complex_others(complex, at, (uint32_t)i, other);
        vor_triangle_normal(normal, xyz, &complex->triangle[3 * (size_t)at]);
        w = (vor_wanted_at(wanted, other[0]) + vor_wanted_at(wanted, other[1])) / 2;
        area = sqrt(vor_dot(normal, normal)) / (w * w);
        for (size_t c = 0; c < 3; c++)
            d[c] = (double)xyz[3 * (size_t)other[0] + c] + (double)xyz[3 * (size_t)other[1] + c] -
                   2 * (double)xyz[3 * i + c];
        for (int a = 0; a < 2; a++)
            step[a] += area * vor_dot(frame->axis[a], d) / 3;
        sum += area;
    }
    for (int a = 0; a < 2 && sum > 0; a++)
        step[a] /= sum;
}

/* Sets the normal of the sheet at point i, which lies on `surface`. */
static void set_normal(struct vor_sheet *sheet, const struct vor_surface *surface, size_t i,
                       const double x[3])
{
    double local[3], normal[3];

    vor_surface_to_local(surface, x, local);
    vor_surface_normal(surface, local, normal);
    vor_to_floats(&sheet->normal[3 * i], normal);
}

/* Whether a seed that moves to x leaves the input, or goes into a hole that is kept. */
static int leaves(const struct vor_seeds *seeds, struct vor_scratch *scratch, size_t i,
                  const struct vor_recall *how, const double x[3])
{
    const struct vor_place *here = &scratch->here;
    struct vor_border border = {&here->surface, here->near, here->k, here->surface.spacing};
    double from[3], to[3];

    if (scratch->interior || !seeds->policy.keep_border)
        return 0;
    vor_seeds_position(seeds, i, from);
    memcpy(to, x, sizeof to);
    return vor_boundary_leaves(&border, VOR_OUTSIDE_EVENING, from, x) ||
           (how->keep_holes && vor_seeds_hold(seeds, scratch, i, to));
}

/* The step of a point, by what it moves to. */
static void (*const steps_of[])(const struct relax *, const struct vor_frame *, size_t,
                                double[2]) = {step_of, step_of, mean_of, push_of};

static void move_row(void *ctx, size_t i, unsigned worker)
{
    struct relax *relax = ctx;
    struct vor_seeds *seeds = relax->seeds;
    struct vor_scratch *scratch = &seeds->scratch[worker];

    memcpy(&relax->next[3 * i], &seeds->xyz[3 * i], 3 * sizeof(float));
    if (relax->moves[i] && vor_seeds_recall(seeds, scratch, i, &relax->how) != VOR_SURFACE_NONE) {
        struct vor_frame frame;
        enum vor_relax_aim aim = relax->near[i] > 0 ? VOR_RELAX_STRAIN : relax->aim;
        double x[3], step[2];

        vor_seeds_position(relax->seeds, i, x);
        set_normal(relax->sheet, &scratch->onto, i, x);
        vor_frame_of(&frame, &relax->sheet->normal[3 * i]);
        if (relax->moves[i] == VOR_RELAX_ALONG)
            vor_relax_axes(frame.axis, relax->complex, seeds->xyz, (uint32_t)i);
        steps_of[aim](relax, &frame, i, step);
        for (int c = 0; c < 3; c++)
            x[c] += step[0] * frame.axis[0][c] + step[1] * frame.axis[1][c];
        vor_surface_put(&scratch->onto, x);
        if (aim != VOR_RELAX_STRAIN && leaves(seeds, scratch, i, &relax->how, x))
            return;
        set_normal(relax->sheet, &scratch->onto, i, x);
        vor_to_floats(&relax->next[3 * i], x);
    }
}

void vor_relax_axes(double axis[3][3], const struct vor_complex *complex, const float *xyz,
                    uint32_t i)
{
    double m[6] = {0}, values[3];

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t];
        double n[3];

        vor_triangle_normal(n, xyz, &complex->triangle[3 * (size_t)at]);
        for (int a = 0, k = 0; a < 3; a++)
            for (int b = a; b < 3; b++)
                m[k++] += n[a] * n[b];
    }
    vor_eigen3(values, axis, m);
}

int vor_relax_is_smooth(const struct vor_complex *complex, const struct vor_sheet *sheet,
                        uint32_t i)
{
    const float *m = &sheet->normal[3 * (size_t)i];
    int smooth = 1;

    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t];
        double n[3], up;

        vor_triangle_normal(n, sheet->seeds->xyz, &complex->triangle[3 * (size_t)at]);
        up = fabs(n[0] * (double)m[0] + n[1] * (double)m[1] + n[2] * (double)m[2]);
        smooth &= up >= SMOOTH * sqrt(vor_dot(n, n));
    }
    return smooth;
}

int vor_relax_is_free(const struct vor_complex *complex, const struct vor_sheet *sheet, uint32_t i)
{
    for (unsigned t = 0; t < complex->degree[i]; t++) {
        uint32_t at = complex->around[(size_t)i * VOR_AROUND_MOST + t];

        if (vor_triangle_quality(sheet->seeds->xyz, &complex->triangle[3 * (size_t)at]) < POOR)
            return 1;
    }
    return vor_relax_is_smooth(complex, sheet, i);
}

/* Finds the points less than so many rings from creases. */
static void find_near(struct relax *relax, unsigned rings)
{
    const struct vor_complex *complex = relax->complex;
    unsigned char *near = relax->near;

    for (size_t i = 0; i < complex->n; i++)
        near[i] = relax->moves[i] == VOR_RELAX_ALONG ? (unsigned char)rings : 0;
    for (unsigned left = rings; left-- > 1;)
        for (size_t t = 0; t < complex->count; t++) {
            const uint32_t *at = &complex->triangle[3 * t];

            if (at[0] != VOR_COMPLEX_GONE &&
                (near[at[0]] == left + 1 || near[at[1]] == left + 1 || near[at[2]] == left + 1))
                for (int c = 0; c < 3; c++)
                    near[at[c]] = near[at[c]] > left ? near[at[c]] : (unsigned char)left;
        }
}

static vor_status steps(struct relax *relax, const struct vor_relax_how *how, struct vor_error *err)
{
    struct vor_seeds *seeds = relax->seeds;
    vor_status status = VOR_OK;

    memset(relax->moves, 0, seeds->n);
    for (size_t t = how->since; t < relax->complex->count; t++)
        for (int c = 0; c < 3 && relax->complex->triangle[3 * t] != VOR_COMPLEX_GONE; c++)
            relax->moves[relax->complex->triangle[3 * t + (size_t)c]] = VOR_RELAX_FREE;
    for (size_t i = 0; i < seeds->n; i++)
        if (relax->moves[i] == VOR_RELAX_STAYS || i + how->fixed >= seeds->n ||
            !vor_complex_surrounds(relax->complex, (uint32_t)i))
            relax->moves[i] = VOR_RELAX_STAYS;
        else if (!vor_relax_is_free(relax->complex, relax->sheet, (uint32_t)i))
            relax->moves[i] = how->creases ? VOR_RELAX_ALONG : VOR_RELAX_STAYS;
    find_near(relax, how->creases);
    for (unsigned step = 0; step < how->steps + how->after && status == VOR_OK; step++) {
        for (size_t i = 0; step == how->steps && i < seeds->n; i++)
            relax->moves[i] = relax->near[i] > 0 ? relax->moves[i] : VOR_RELAX_STAYS;
        status = vor_run_rows(&seeds->run, seeds->n, VOR_SEEDS_BLOCK, move_row, relax, err);
        if (status == VOR_OK)
            memcpy(seeds->xyz, relax->next, 3 * seeds->n * sizeof *seeds->xyz);
    }
    return status;
}

vor_status vor_relax(struct vor_sheet *sheet, struct vor_seeds *seeds,
                     const struct vor_complex *complex, const struct vor_relax_how *how,
                     struct vor_error *err)
{
    struct vor_memory *memory = seeds->run.memory;
    struct relax relax = {
        .sheet = sheet,
        .seeds = seeds,
        .complex = complex,
        .how = {.slack = VOR_SEEDS_SLACK, .keep_holes = how->keep_holes, .refine = how->refine},
        .aim = how->aim,
        .length = how->length};
    vor_status status;

    status = VOR_MAKE_ALL(memory, err, seeds->n, VOR_ARRAY(relax.next, seeds->n, 3),
                          VOR_ARRAY(relax.moves, seeds->n, 1), VOR_ARRAY(relax.near, seeds->n, 1));
    VOR_THEN(status, steps(&relax, how, err));
    VOR_FREE_ALL(memory, relax.near, relax.moves, relax.next);
    return status;
}
