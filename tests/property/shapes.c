/* Shapes of which the truth is known, requests for them, and how near to the truth a result is:
 * points lie on one of the sheets, normals lead outward, triangles join points of one sheet. */
#include "tests/support/vt_engine.h"
#include "tests/support/vt_shape.h"

#include <math.h>
#include <string.h>

enum { SEEDS = 5 };

/* The nearest place of a shape. */
struct place {
    double off;       /* distance from it */
    double normal[3]; /* outward, or to either side of an open sheet */
    int sheet;
};

static void set(struct place *at, double off, int sheet, double x, double y, double z)
{
    double length = sqrt(x * x + y * y + z * z);

    *at = (struct place){fabs(off), {x / length, y / length, z / length}, sheet};
}

static void nearest_of_sheets(struct place *at, const double x[3], double gap)
{
    int upper = x[2] > gap / 2;

    set(at, x[2] - (upper ? gap : 0), upper, 0, 0, 1);
}

static void nearest_of_spheres(struct place *at, const double x[3], double gap)
{
    int right = x[0] > 0;
    double dx = x[0] + (right ? -1 : 1) * (1 + gap / 2),
           r = sqrt(dx * dx + x[1] * x[1] + x[2] * x[2]);

    set(at, r - 1, right, dx, x[1], x[2]);
}

static void nearest_of_sphere(struct place *at, const double x[3], double gap)
{
    (void)gap;
    set(at, sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) - 1, 0, x[0], x[1], x[2]);
}

/* A sphere beside five of the corners of a cube of 1e6 radii, of 10 with a gap, itself at another.
 */
static void make_far(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    vt_cloud_sphere(cloud, seed, n);
    for (size_t i = 0; i < 15; i++)
        cloud->xyz[i] = ((i / 3 + 1) >> i % 3 & 1) * (gap > 0 ? 10 : 1e6F);
}

/* One sphere in another, half as large. */
static void make_nested(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    (void)gap;
    vt_cloud_sphere(cloud, seed, n);
    for (size_t i = 0; i < 3 * n; i++)
        cloud->xyz[i] *= i / 3 % 5 == 0 ? 0.5F : 1;
}

static void nearest_of_nested(struct place *at, const double x[3], double gap)
{
    double r = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);

    (void)gap;
    set(at, r - (r < 0.75 ? 0.5 : 1), r < 0.75, x[0], x[1], x[2]);
}

static void make_torus(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    (void)gap;
    vt_cloud_torus(cloud, seed, n);
}

static void nearest_of_torus(struct place *at, const double x[3], double gap)
{
    double r = hypot(x[0], x[1]), out = r - 1;

    (void)gap;
    set(at, hypot(out, x[2]) - VT_TORUS_TUBE, 0, out * x[0] / r, out * x[1] / r, x[2]);
}

/* A round plate, as thick as the gap, with a rounded rim. */
static void make_plate(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    double rim = M_PI * gap / 2; /* its area over that of both faces */

    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double u = vt_unit(seed, 3 * i) * (1 + rim), way = 2 * M_PI * vt_unit(seed, 3 * i + 1);
        double t = vt_unit(seed, 3 * i + 2), up = M_PI * (u > 1 ? t - 0.5 : i % 2 ? 0.5 : -0.5);
        double r = (u > 1 ? 1 : sqrt(t)) + gap / 2 * cos(up);

        cloud->xyz[3 * i] = (float)(r * cos(way));
        cloud->xyz[3 * i + 1] = (float)(r * sin(way));
        cloud->xyz[3 * i + 2] = (float)(gap / 2 * sin(up));
    }
}

static void nearest_of_plate(struct place *at, const double x[3], double gap)
{
    double r = hypot(x[0], x[1]), out = fmax(0, r - 1);

    set(at, hypot(out, x[2]) - gap / 2, x[2] > 0, out * x[0] / r, out * x[1] / r, x[2]);
}

/* Four fifths lie side by side on a plane, with as many on their area. */
static void make_few_sheets(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    vt_cloud_sheets(cloud, seed, n, gap);
    for (size_t i = 0; i < n; i++)
        if (i % 10 > 1) {
            cloud->xyz[3 * i] = 8 * cloud->xyz[3 * i] + 2;
            cloud->xyz[3 * i + 2] = 0;
        }
}

/* Its sheets are its two squares; the bend belongs to the nearer one. */
static void nearest_of_fold(struct place *at, const double x[3], double gap)
{
    double r = gap / 2, dx = fmax(0, x[0] - 1), dz = x[2] - r;

    set(at, (dx > 0 ? hypot(dx, dz) : fabs(dz)) - r, dz > 0, dx, 0, dz);
}

/* Two unit squares that cross along a line, at 30 degrees. */
static void make_crossing(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    (void)gap;
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double u = vt_unit(seed, 2 * i) - 0.5, v = vt_unit(seed, 2 * i + 1);

        cloud->xyz[3 * i] = (float)(u * (i % 2 ? sqrt(0.75) : 1));
        cloud->xyz[3 * i + 1] = (float)v;
        cloud->xyz[3 * i + 2] = (float)(i % 2 ? u / 2 : 0);
    }
}

static void nearest_of_crossing(struct place *at, const double x[3], double gap)
{
    double steep = x[2] * sqrt(0.75) - x[0] / 2;

    (void)gap;
    if (fabs(steep) < fabs(x[2]))
        set(at, steep, 1, -0.5, 0, sqrt(0.75));
    else
        set(at, x[2], 0, 0, 0, 1);
}

/* Two sheets that bend together. */
static double wave(const double x[3])
{
    return 0.03 * sin(18 * x[0]) * sin(18 * x[1]);
}

static void make_waves(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap)
{
    vt_cloud_sheets(cloud, seed, n, gap);
    for (size_t i = 0; i < n; i++) {
        float *x = &cloud->xyz[3 * i];

        x[2] += (float)wave((const double[3]){(double)x[0], (double)x[1], 0});
    }
}

static void nearest_of_waves(struct place *at, const double x[3], double gap)
{
    double flat = x[2] - wave(x);
    int upper = flat > gap / 2;

    set(at, flat - (upper ? gap : 0), upper, -0.54 * cos(18 * x[0]) * sin(18 * x[1]),
        -0.54 * sin(18 * x[0]) * cos(18 * x[1]), 1);
}

/* Two unit squares, x and z <= 0, whose edge along y is rounded off by a radius. */
static void nearest_of_wedge(struct place *at, const double x[3], double radius)
{
    double a = x[0] + radius, b = x[2] + radius;

    if (radius > 0 && a > 0 && b > 0)
        set(at, hypot(a, b) - radius, 0, a, 0, b);
    else
        set(at, fmax(x[0], x[2]), 0, x[0] > x[2], 0, x[0] <= x[2]);
}

static void make_wedge(struct vor_cloud *cloud, uint64_t seed, size_t n, double radius)
{
    vt_cloud_make(cloud, n);
    for (size_t i = 0; i < n; i++) {
        double side = 2 * vt_unit(seed, 2 * i) - 1;
        double x[3] = {fmin(side, 0), vt_unit(seed, 2 * i + 1), fmin(-side, 0)};
        struct place at;

        nearest_of_wedge(&at, x, radius);
        for (int c = 0; c < 3; c++)
            cloud->xyz[3 * i + (size_t)c] = (float)(x[c] - at.off * at.normal[c]);
    }
}

/* Away from the rim of a unit square. */
static int inside(const double x[3])
{
    return x[0] > 0.1 && x[0] < 0.9 && x[1] > 0.1 && x[1] < 0.9;
}

static int inside_crossing(const double x[3])
{
    return fabs(x[0]) < 0.35 && x[1] > 0.05 && x[1] < 0.95;
}

static int inside_wedge(const double x[3])
{
    return x[1] > 0.1 && x[1] < 0.9 && x[0] + x[2] > -0.9;
}

enum shape {
    SPHERE,
    FAR,
    TORUS,
    PLATE,
    NESTED,
    SPHERES,
    SHEETS,
    FEW,
    FOLD,
    CROSSING,
    WAVES,
    WEDGE
};

static const struct {
    const char *name;
    void (*make)(struct vor_cloud *cloud, uint64_t seed, size_t n, double gap);
    void (*nearest)(struct place *at, const double x[3], double gap);
    int (*counts)(const double x[3]); /* NULL: all do */
    int closed;
    double area;
} shapes[] = {
    [SPHERE] = {"sphere", NULL, nearest_of_sphere, NULL, 1, 4 * M_PI},
    [FAR] = {"sphere and far points", make_far, nearest_of_sphere, NULL, 1, 4 * M_PI},
    [TORUS] = {"torus", make_torus, nearest_of_torus, NULL, 1, 0.8 * 2 * M_PI *M_PI},
    [PLATE] = {"plate", make_plate, nearest_of_plate, NULL, 1, 2 * M_PI},
    [NESTED] = {"nested spheres", make_nested, nearest_of_nested, NULL, 1, 5 * M_PI},
    [SPHERES] = {"two spheres", NULL, nearest_of_spheres, NULL, 1, 8 * M_PI},
    [SHEETS] = {"two sheets", NULL, nearest_of_sheets, inside, 0, 2},
    [FEW] = {"sheets on a fifth", make_few_sheets, nearest_of_sheets, inside, 0, 10},
    [FOLD] = {"fold", NULL, nearest_of_fold, inside, 0, 2},
    [CROSSING] = {"crossing squares", make_crossing, nearest_of_crossing, inside_crossing, 0, 2},
    [WAVES] = {"wavy sheets", make_waves, nearest_of_waves, inside, 0, 2},
    [WEDGE] = {"rounded wedge", make_wedge, nearest_of_wedge, inside_wedge, 0, 2},
};

static void make(struct vor_cloud *cloud, enum shape shape, uint64_t seed, size_t n, double gap)
{
    static const int metric_of[] = {
        [SPHERE] = VT_BALL,
        [SPHERES] = VT_SPHERES,
        [SHEETS] = VT_SHEETS,
        [FOLD] = VT_FOLD,
    };

    if (shapes[shape].make != NULL)
        shapes[shape].make(cloud, seed, n, gap);
    else
        vt_metrics[metric_of[shape]].make(cloud, seed, n, gap);
}

/* Sets "name=value" separated by blanks. */
static void request(struct vt_engine *engine, const char *text)
{
    char copy[200], *save = NULL;

    ck_assert_uint_lt(strlen(text), sizeof copy);
    strcpy(copy, text);
    for (char *word = strtok_r(copy, " ", &save); word; word = strtok_r(NULL, " ", &save)) {
        char *value = strchr(word, '=');

        ck_assert_ptr_nonnull(value);
        *value++ = 0;
        vt_engine_set(engine, word, value);
    }
}

/* Figures of a result, over the points that count. */
struct figures {
    double off;     /* rms distance from the shape */
    size_t between; /* points in the middle third between two sheets */
    size_t inward;  /* normals that lead into the shape; of an open one, that lie in its sheet */
    size_t points;
};

static void see(struct figures *out, const struct vor_cloud *cloud, enum shape shape, double gap)
{
    const float *normal = vor_cloud_find(cloud, VOR_NORMAL)->data;

    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < cloud->n; i++) {
        struct place at;
        double x[3], along = 0;

        vor_cloud_position(cloud, i, x);
        shapes[shape].nearest(&at, x, gap);
        if (shapes[shape].counts != NULL && !shapes[shape].counts(x))
            continue;
        for (size_t c = 0; c < 3; c++)
            along += at.normal[c] * (double)normal[3 * i + c];
        out->points++;
        out->off += at.off * at.off;
        out->between += gap > 0 && at.off > gap / 3;
        out->inward += (shapes[shape].closed ? along : fabs(along)) < 0.3;
    }
    out->off = sqrt(out->off / (double)out->points);
}

/* What a result has to be; gap and noise in spacings of the input, the radius of a wedge as it is,
 * `off` in spacings of the result. `off` is 1.3 times the worst of five draws and 1e-4 at least,
 * `between` and `inward` 1.3 times it and one more. With intrinsic=none the crossing squares are
 * 0.14 off, twice what they may be; two sheets that bend fall together in some draws. */
static const struct {
    enum shape shape;
    size_t n;
    double gap, noise;
    const char *request;
    double off;
    size_t between, inward;
} rows[] = {
    {SPHERE, 8000, 0, 0.5, "points=800 polish=8", 0.036, 0, 0},
    {FAR, 4000, 0, 0, "points=3500 method=ear polish=8", 0.001, 0, 0},
    {FAR, 4000, 0, 0, "points=700 polish=8", 0.001, 0, 0},
    {FAR, 4000, 1, 0, "points=300 polish=8", 0.001, 0, 0},
    {TORUS, 5000, 0, 0, "points=800 polish=8", 0.001, 0, 0},
    {PLATE, 6000, 1.5, 0, "points=2400 polish=8", 0.073, 28, 12},
    {NESTED, 5000, 0, 0, "points=800 polish=8", 4e-4, 0, 0},
    {SPHERES, 8000, 3, 0, "points=800 polish=8", 1e-4, 0, 0},
    {SHEETS, 3000, 3, 0, "points=1500 iterations=3 polish=4 intrinsic=satellites", 0.042, 2, 2},
    {SHEETS, 8000, 0.5, 0, "points=1000 polish=20", 0.0012, 0, 0},
    {SHEETS, 4000, 1, 0, "points=800 polish=20 patch=plane", 0.0035, 0, 0},
    {SHEETS, 60000, 4.2, 0, "points=1000 polish=20", 1e-4, 0, 0},
    {SHEETS, 3000, 1, 0.05, "points=1500 iterations=3 polish=4", 0.0082, 0, 0},
    {FEW, 16000, 1, 0, "points=2000 polish=20", 0.002, 0, 0},
    {FOLD, 8000, 3, 0, "points=1500 iterations=6 polish=8", 1e-4, 0, 0},
    {CROSSING, 6000, 0, 0, "points=6000 iterations=2 polish=8", 0.06, 0, 7},
    {WAVES, 8000, 0.4, 0, "points=1500 iterations=6 polish=8", 0.0054, 0, 0},
    {WAVES, 8000, 2.5, 0, "points=3200 iterations=6 polish=8", 0.045, 5, 1},
    {WEDGE, 4000, 0.3, 0.3, "points=1500 method=ear polish=8", 0.094, 0, 0},
    {WEDGE, 4000, 0, 0.3, "points=1500 method=ear polish=8", 0.039, 0, 17},
};

enum { ROWS = sizeof rows / sizeof *rows };

VT_TEST_FIGURES(points_lie_on_the_sheets_and_normals_lead_outward, VT_SOAK_LOOPS(ROWS, SEEDS *ROWS))
{
    size_t k = (size_t)_i % ROWS, seed = (size_t)_i / ROWS;
    enum shape shape = rows[k].shape;
    double spacing = sqrt(shapes[shape].area / (double)rows[k].n);
    double gap = rows[k].gap * (shape == WEDGE ? 1 : spacing), noise = rows[k].noise * spacing;
    struct vt_engine engine;
    struct vor_report report;
    struct vor_cloud in, out;
    struct figures figures;

    make(&in, shape, seed, rows[k].n, gap);
    for (size_t i = 0; noise > 0 && i < 3 * in.n; i++)
        in.xyz[i] += (float)(noise * vt_normal(seed + 1000, i));
    vt_engine_open(&engine, 2);
    vt_engine_set(&engine, "normals", "fit");
    request(&engine, rows[k].request);
    vt_engine_resample(&engine, &out, &report, &in);
    see(&figures, &out, shape, gap);
    figures.off /= sqrt(shapes[shape].area / (double)out.n);
    ck_assert_msg(figures.off <= rows[k].off, "%s: %.4f spacings off", shapes[shape].name,
                  figures.off);
    ck_assert_msg(figures.between <= rows[k].between, "%s: %zu points between sheets",
                  shapes[shape].name, figures.between);
    ck_assert_msg(figures.inward <= rows[k].inward, "%s: %zu normals inward", shapes[shape].name,
                  figures.inward);
    vt_engine_close(&engine);
    vt_free_last(&out, &in);
}
