#include "core/lop/drawn.h"

#include "core/lop/weights.h"

#include <math.h>
#include <string.h>

/* What each datum says. */
struct said {
    double alpha[VOR_LOP_DATA_MOST];  /* before the side of the point counts: theta */
    double height[VOR_LOP_DATA_MOST]; /* times weight */
    double weight[VOR_LOP_DATA_MOST];
};

/* How much each datum counts by its distance. */
VOR_CLONES static void weigh(double *restrict alpha, const struct vor_lop_data *data,
                             double inverse_along2)
{
    for (unsigned j = 0; j < data->count; j++) {
        double x = (double)data->there[0][j], y = (double)data->there[1][j],
               z = (double)data->there[2][j];

        alpha[j] = vor_lop_near(x * x + y * y + z * z, inverse_along2);
    }
}

/* Lets only the data of the point's side count, by their heights over its plane and their normals,
 * and finds where they see the point along the mean of both normals. */
VOR_CLONES static void take_side(double *restrict alpha, double *restrict height,
                                 double *restrict weight, const struct vor_lop_data *data,
                                 const double n[3], const struct vor_lop_counting *how)
{
    double along = 1 / how->along2, across = 1 / how->across2, scale = how->scale;
    double n0 = n[0], n1 = n[1], n2 = n[2];

    for (unsigned j = 0; j < data->count; j++) {
        double x = (double)data->there[0][j], y = (double)data->there[1][j],
               z = (double)data->there[2][j];
        double m0 = (double)data->normal[0][j], m1 = (double)data->normal[1][j],
               m2 = (double)data->normal[2][j];
        double up = x * n0 + y * n1 + z * n2, cosine = n0 * m0 + n1 * m1 + n2 * m2;
        double side = vor_lop_near(up * up, along) * vor_lop_alike(cosine, scale);
        double w = side * vor_lop_near(x * x + y * y + z * z, across);
        double seen = w * (up + (x * m0 + y * m1 + z * m2)) / (1 + cosine);

        alpha[j] *= side;
        height[j] = w > 0 ? seen : 0;
        weight[j] = w;
    }
}

/* Lets data count for the area around each, and the nearer the more. */
VOR_CLONES static void draw(double *restrict alpha, const struct vor_lop_data *data, double nearest)
{
    for (unsigned j = 0; j < data->count; j++) {
        double x = (double)data->there[0][j], y = (double)data->there[1][j],
               z = (double)data->there[2][j];
        double d2 = x * x + y * y + z * z, area = (double)data->area[j], least = nearest * area;
        double drawn = alpha[j] * area / sqrt(d2 > least ? d2 : least);

        alpha[j] = alpha[j] > 0 ? drawn : 0;
    }
}

void vor_lop_drawn_by(struct vor_lop_drawn *out, const struct vor_lop_data *data,
                      const float *normal, const struct vor_lop_counting *how)
{
    struct said said;

    memset(out, 0, sizeof *out);
    /* cppcheck cannot see that take_side fills them */
    memset(said.height, 0, data->count * sizeof *said.height);
    memset(said.weight, 0, data->count * sizeof *said.weight);
    weigh(said.alpha, data, 1 / how->along2);
    if (normal != NULL) {
        const double n[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};

        take_side(said.alpha, said.height, said.weight, data, n, how);
        for (unsigned j = 0; j < data->count; j++) {
            out->height += said.height[j];
            out->weight += said.weight[j];
            for (int c = 0; c < 3; c++)
                out->normal[c] += said.weight[j] * (double)data->normal[c][j];
        }
    }
    draw(said.alpha, data, how->nearest);
    for (unsigned j = 0; j < data->count; j++) {
        out->alpha += said.alpha[j];
        out->density += 1 / (double)data->area[j];
        for (int c = 0; c < 3; c++)
            out->to[c] += said.alpha[j] * (double)data->there[c][j];
    }
}
