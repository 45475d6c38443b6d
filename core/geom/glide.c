#include "core/geom/glide.h"

#include "core/base/vector.h"

#include <float.h>
#include <math.h>

enum { LANES = VOR_GLIDE_LANES };
typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef int64_t marks __attribute__((vector_size(8 * LANES)));

/* A member of each. */
#define EACH(of, member) ((lanes){of[0] member, of[1] member, of[2] member, of[3] member})

struct quadrics {
    lanes c[6], center[2], reach;
};

/* a where the mark is set, else b. */
#define CHOOSE(mark, a, b) ((lanes)(((marks)(a) & (mark)) | ((marks)(b) & ~(mark))))

VOR_INLINE int any(const marks *of)
{
    return ((*of)[0] | (*of)[1] | (*of)[2] | (*of)[3]) != 0;
}

VOR_INLINE void take_root(lanes *x)
{
    for (int i = 0; i < LANES; i++)
        (*x)[i] = sqrt((*x)[i]);
}

/* vor_surface_height at u, v of each. */
VOR_INLINE void find_height(lanes *height, lanes gradient[2], const struct quadrics *of,
                            const lanes at[3])
{
    const lanes *c = of->c;
    lanes u = at[0], v = at[1], du = u - of->center[0], dv = v - of->center[1];
    lanes share = {0}, d2 = du * du + dv * dv;
    marks beyond = d2 > of->reach * of->reach;

    if (any(&beyond)) {
        take_root(&d2);
        share = CHOOSE(beyond, 1 - of->reach / d2, share);
    }
    du *= share; /* how far beyond the reach */
    dv *= share;
    u -= du;
    v -= dv;
    gradient[0] = c[1] + 2 * c[3] * u + c[4] * v;
    gradient[1] = c[2] + c[4] * u + 2 * c[5] * v;
    *height = c[0] + u * (c[1] + c[3] * u + c[4] * v) + v * (c[2] + c[5] * v);
    *height += gradient[0] * du;
    *height += gradient[1] * dv;
}

/* vor_surface_project of each. */
VOR_INLINE void project(const struct quadrics *of, lanes local[3])
{
    const lanes near = (double)FLT_EPSILON * of->reach;
    lanes foot[3] = {local[0], local[1]}, g[2];
    marks moves = ~(marks){0};

    find_height(&foot[2], g, of, foot);
    for (int i = 0; i < VOR_SURFACE_PROJECTIONS; i++) {
        lanes residual =
            local[2] - foot[2] + g[0] * (foot[0] - local[0]) + g[1] * (foot[1] - local[1]);
        lanes t = residual / (1 + g[0] * g[0] + g[1] * g[1]), height;

        moves &= (residual > near) | (residual < -near);
        if (!any(&moves))
            break;
        foot[0] = CHOOSE(moves, local[0] + t * g[0], foot[0]);
        foot[1] = CHOOSE(moves, local[1] + t * g[1], foot[1]);
        find_height(&height, g, of, foot);
        foot[2] = CHOOSE(moves, height, foot[2]);
    }
    for (int c = 0; c < 3; c++)
        local[c] = foot[c];
}

VOR_CLONES void vor_glide_go(struct vor_glide *glide)
{
    const struct vor_surface **along = glide->along;
    lanes origin[3], axis[3][3], x[3], v[3], local[3], way[3], most, g[2], off, length2;
    struct quadrics of;
    marks longer;

    if (glide->count == 0)
        return;
    for (unsigned j = glide->count; j < LANES; j++) { /* as the first one */
        along[j] = along[0];
        glide->most[j] = glide->most[0];
        memcpy(glide->v[j], glide->v[0], sizeof glide->v[j]);
        memcpy(glide->x[j], glide->x[0], sizeof glide->x[j]);
    }
    most = (lanes){glide->most[0], glide->most[1], glide->most[2], glide->most[3]};
    for (int c = 0; c < 3; c++) {
        v[c] = EACH(glide->v, [c]);
        x[c] = EACH(glide->x, [c]);
        origin[c] = EACH(along, ->origin[c]);
        for (int a = 0; a < 3; a++)
            axis[a][c] = EACH(along, ->axis[a][c]);
        x[c] -= origin[c];
    }
    for (int i = 0; i < 6; i++)
        of.c[i] = EACH(along, ->c[i]);
    of.center[0] = EACH(along, ->center[0]);
    of.center[1] = EACH(along, ->center[1]);
    of.reach = EACH(along, ->reach);
    for (int a = 0; a < 3; a++) {
        local[a] = axis[a][0] * x[0] + axis[a][1] * x[1] + axis[a][2] * x[2];
        way[a] = axis[a][0] * v[0] + axis[a][1] * v[1] + axis[a][2] * v[2];
    }
    find_height(&off, g, &of, local);
    off = (way[2] - g[0] * way[0] - g[1] * way[1]) / (1 + g[0] * g[0] + g[1] * g[1]);
    way[0] += off * g[0];
    way[1] += off * g[1];
    way[2] -= off;
    length2 = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    longer = length2 > most * most;
    take_root(&length2);
    for (int a = 0; a < 3; a++)
        local[a] += CHOOSE(longer, way[a] * (most / length2), way[a]);
    project(&of, local);
    for (int c = 0; c < 3; c++) {
        x[c] = origin[c] + local[0] * axis[0][c] + local[1] * axis[1][c] + local[2] * axis[2][c];
        for (unsigned j = 0; j < glide->count; j++)
            glide->x[j][c] = x[c][j];
    }
}
