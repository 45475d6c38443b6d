/* A made cloud for the benchmark: n points spread at random and evenly over a torus, one closed
 * smooth surface whatever n is.
 *
 * usage: torus POINTS OUT.ply */
#include "core/base/rng.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define TUBE 0.4 /* radius of the tube; that of its middle line is 1 */
#define TURN 6.283185307179586

/* Point number i: an angle along the tube, and one around it that is drawn again until the surface,
 * which is wider outside, is covered evenly. */
static void torus_point(float xyz[3], uint64_t i)
{
    double u = TURN * vor_rng_unit(1, i, 0), v, ring;
    uint64_t draw = 1;

    do {
        v = TURN * vor_rng_unit(1, i, draw);
        ring = 1 + TUBE * cos(v);
        draw += 2;
    } while (vor_rng_unit(1, i, draw - 1) * (1 + TUBE) > ring);
    xyz[0] = (float)(ring * cos(u));
    xyz[1] = (float)(ring * sin(u));
    xyz[2] = (float)(TUBE * sin(v));
}

int main(int argc, char **argv)
{
    uint64_t n = argc == 3 ? strtoull(argv[1], NULL, 10) : 0;
    FILE *out;
    int failed;

    if (n == 0) {
        (void)fprintf(stderr, "usage: torus POINTS OUT.ply\n");
        return 2;
    }
    out = fopen(argv[2], "wb");
    if (out == NULL) {
        perror(argv[2]);
        return 1;
    }
    (void)fprintf(out,
                  "ply\nformat binary_little_endian 1.0\nelement vertex %llu\nproperty float x\n"
                  "property float y\nproperty float z\nend_header\n",
                  (unsigned long long)n);
    for (uint64_t i = 0; i < n; i++) {
        float xyz[3];

        torus_point(xyz, i);
        (void)fwrite(xyz, sizeof xyz, 1, out);
    }
    failed = ferror(out);
    failed = fclose(out) != 0 || failed;
    if (failed)
        perror(argv[2]);
    return failed ? 1 : 0;
}
