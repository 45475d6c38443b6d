/* How right principal curvatures are: 50,000 exact points on a sphere, a cylinder, a torus and a
 * saddle, at 5,000 of them. Prints a JSON object for each: errors of both curvatures over the
 * larger one without its sign, and CPU microseconds a place, the search not among them.
 *
 * usage: curvature NEIGHBORS */
#include "core/geom/curvature.h"
#include "core/base/rng.h"
#include "core/knn/knn.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { N = 50000, PLACES = 5000, MOST = 128 };

#define TUBE 0.4 /* radius of the torus's tube, around a circle of radius 1 */

/* Point i of a surface, and its curvatures there, the smaller one first. */
struct shape {
    const char *name;
    void (*make)(double x[3], uint64_t i);
    void (*kappa)(const float *x, double kappa[2]);
};

static double unit(uint64_t stream, uint64_t i)
{
    return vor_rng_unit(1, stream, i);
}

static void make_sphere(double x[3], uint64_t i)
{
    double z = 2 * unit(0, i) - 1, turn = 2 * M_PI * unit(1, i);

    x[0] = sqrt(1 - z * z) * cos(turn);
    x[1] = sqrt(1 - z * z) * sin(turn);
    x[2] = z;
}

static void kappa_sphere(const float *x, double kappa[2])
{
    (void)x;
    kappa[0] = kappa[1] = 1;
}

static void make_cylinder(double x[3], uint64_t i)
{
    double turn = 2 * M_PI * unit(1, i);

    x[0] = cos(turn);
    x[1] = sin(turn);
    x[2] = 3 * unit(0, i) - 1.5;
}

static void kappa_cylinder(const float *x, double kappa[2])
{
    (void)x;
    kappa[0] = 0;
    kappa[1] = 1;
}

/* Even by area: the angle around the tube is drawn until one is taken. */
static void make_torus(double x[3], uint64_t i)
{
    double around = 2 * M_PI * unit(0, i), tube = 0;

    for (uint64_t draw = 0; draw < 64; draw++) {
        tube = 2 * M_PI * unit(2 + 2 * draw, i);
        if ((1 + TUBE) * unit(3 + 2 * draw, i) <= 1 + TUBE * cos(tube))
            break;
    }
    x[0] = (1 + TUBE * cos(tube)) * cos(around);
    x[1] = (1 + TUBE * cos(tube)) * sin(around);
    x[2] = TUBE * sin(tube);
}

static void kappa_torus(const float *x, double kappa[2])
{
    double away = hypot((double)x[0], (double)x[1]);

    kappa[0] = (away - 1) / (TUBE * away);
    kappa[1] = 1 / TUBE;
}

static void make_saddle(double x[3], uint64_t i)
{
    x[0] = 2 * unit(0, i) - 1;
    x[1] = 2 * unit(1, i) - 1;
    x[2] = (x[0] * x[0] - x[1] * x[1]) / 2;
}

static void kappa_saddle(const float *at, double kappa[2])
{
    double x = (double)at[0], y = (double)at[1], w2 = 1 + x * x + y * y;
    double gauss = -1 / (w2 * w2), mean = (y * y - x * x) / (2 * w2 * sqrt(w2));
    double apart = sqrt(mean * mean - gauss);

    kappa[0] = mean - apart;
    kappa[1] = mean + apart;
}

static const struct shape shapes[] = {{"sphere", make_sphere, kappa_sphere},
                                      {"cylinder", make_cylinder, kappa_cylinder},
                                      {"torus", make_torus, kappa_torus},
                                      {"saddle", make_saddle, kappa_saddle}};

static double larger(double a, double b)
{
    return fabs(a) > fabs(b) ? fabs(a) : fabs(b);
}

/* Whichever side is up. */
static double error_of(const double found[2], const double truth[2])
{
    double same = larger(found[0] - truth[0], found[1] - truth[1]);
    double other = larger(found[0] + truth[1], found[1] + truth[0]);

    return fmin(same, other) / larger(truth[0], truth[1]);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static double cpu_seconds(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* The error at point i; adds the time that the fit and the curvature took. */
static double error_at(const struct shape *shape, const struct vor_knn *knn, const float *xyz,
                       size_t i, unsigned k, double *seconds)
{
    uint32_t index[MOST];
    float distance2[MOST], near[3 * MOST];
    struct vor_surface surface;
    double found[2], truth[2], began;

    vor_knn_search(knn, &xyz[3 * i], 1, k, index, distance2);
    for (unsigned j = 0; j < k; j++)
        memcpy(&near[3 * j], &xyz[3 * (size_t)index[j]], 3 * sizeof *near);
    began = cpu_seconds();
    vor_surface_fit(&surface, near, k);
    vor_curvature_at(found, &surface, near, k);
    *seconds += cpu_seconds() - began;
    shape->kappa(&xyz[3 * i], truth);
    return error_of(found, truth);
}

static int measure(const struct shape *shape, unsigned k, struct vor_memory *memory)
{
    static float xyz[3 * N];
    static double error[PLACES];
    struct vor_knn *knn;
    double seconds = 0;

    for (size_t i = 0; i < N; i++) {
        double x[3];

        shape->make(x, i);
        for (size_t c = 0; c < 3; c++)
            xyz[3 * i + c] = (float)x[c];
    }
    if (vor_knn_build(&knn, xyz, N, memory, NULL) != VOR_OK)
        return 1;
    for (size_t i = 0; i < PLACES; i++)
        error[i] = error_at(shape, knn, xyz, i, k, &seconds);
    vor_knn_free(knn);
    qsort(error, PLACES, sizeof *error, ascending);
    (void)printf("{\"name\":\"%s\",\"neighbors\":%u,\"median\":%.3g,\"p95\":%.3g,\"most\":%.3g,"
                 "\"us\":%.3f}\n",
                 shape->name, k, error[PLACES / 2], error[PLACES * 95 / 100], error[PLACES - 1],
                 seconds / PLACES * 1e6);
    return 0;
}

int main(int argc, char **argv)
{
    unsigned long k = argc == 2 ? strtoul(argv[1], NULL, 10) : 0;
    struct vor_memory memory;
    int failed = 0;

    if (k < 6 || k > MOST) {
        (void)fprintf(stderr, "usage: curvature NEIGHBORS, 6 to %d\n", (int)MOST);
        return 2;
    }
    vor_memory_init(&memory, SIZE_MAX);
    for (size_t s = 0; s < sizeof shapes / sizeof shapes[0]; s++)
        failed |= measure(&shapes[s], (unsigned)k, &memory);
    return failed;
}
