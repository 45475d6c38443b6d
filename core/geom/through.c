#include "core/geom/through.h"

#include <math.h>
#include <string.h>

/* Equations. */
enum { ORDER = VOR_THROUGH_MOST + VOR_THROUGH_TERMS };

/* Smallest pivot at which the points are believed to determine the height; entries are at most 23,
 * the cube of the diagonal of [-1, 1]^2. */
#define RANK 1e-9

struct system {
    unsigned order;
    double row[ORDER][ORDER + 1]; /* the right side is the last column */
};

static double kernel(const double a[2], double u, double v)
{
    double x = a[0] - u, y = a[1] - v, r2 = x * x + y * y;

    return r2 * sqrt(r2);
}

static void set_up(struct system *system, const struct vor_through *through,
                   const double (*local)[3])
{
    unsigned n = through->n, order = n + VOR_THROUGH_TERMS;

    system->order = order;
    memset(system->row, 0, sizeof system->row);
    for (unsigned i = 0; i < n; i++) {
        const double *at = through->at[i];
        double *row = system->row[i];

        for (unsigned j = 0; j < n; j++)
            row[j] = kernel(through->at[j], at[0], at[1]);
        row[n] = system->row[n][i] = 1;
        row[n + 1] = system->row[n + 1][i] = at[0];
        row[n + 2] = system->row[n + 2][i] = at[1];
        row[order] = local[i][2] / through->scale;
    }
}

static void eliminate(struct system *system, unsigned k)
{
    for (unsigned i = k + 1; i < system->order; i++) {
        double factor = system->row[i][k] / system->row[k][k];

        for (unsigned j = k; factor != 0 && j <= system->order; j++)
            system->row[i][j] -= factor * system->row[k][j];
    }
}

/* Solves by elimination with pivots from columns. False without a solution that rounding does not
 * spoil. */
static int solve(double *out, struct system *system)
{
    unsigned order = system->order;

    for (unsigned k = 0; k < order; k++) {
        unsigned best = k;

        for (unsigned i = k + 1; i < order; i++)
            if (fabs(system->row[i][k]) > fabs(system->row[best][k]))
                best = i;
        if (!(fabs(system->row[best][k]) > RANK))
            return 0;
        for (unsigned j = 0; best != k && j <= order; j++) {
            double held = system->row[k][j];

            system->row[k][j] = system->row[best][j];
            system->row[best][j] = held;
        }
        eliminate(system, k);
    }
    for (unsigned k = order; k-- > 0;) {
        out[k] = system->row[k][order];
        for (unsigned j = k + 1; j < order; j++)
            out[k] -= system->row[k][j] * out[j];
        out[k] /= system->row[k][k];
    }
    return 1;
}

int vor_through_fit(struct vor_through *out, const double (*local)[3], unsigned n)
{
    struct vor_through through = {.n = n};
    struct system system;

    for (unsigned i = 0; i < n; i++)
        through.scale = fmax(through.scale, fmax(fabs(local[i][0]), fabs(local[i][1])));
    if (n < 4 || !(through.scale > 0))
        return 0;
    for (unsigned i = 0; i < n; i++)
        for (int c = 0; c < 2; c++)
            through.at[i][c] = local[i][c] / through.scale;
    set_up(&system, &through, local);
    if (!solve(through.weight, &system))
        return 0;
    *out = through;
    return 1;
}

double vor_through_height(const struct vor_through *through, double u, double v)
{
    unsigned n = through->n;
    double x = u / through->scale, y = v / through->scale;
    double sum = through->weight[n] + through->weight[n + 1] * x + through->weight[n + 2] * y;

    for (unsigned i = 0; i < n; i++)
        sum += through->weight[i] * kernel(through->at[i], x, y);
    return sum * through->scale;
}
