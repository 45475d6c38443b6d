/** A similarity: it turns, scales and shifts. */
#ifndef VOR_ALIGN_POSE_H
#define VOR_ALIGN_POSE_H

#include "core/base/linalg.h"

/** x becomes scale * turn * x + shift. */
struct vor_pose {
    double turn[3][3]; /**< a rotation */
    double scale;      /**< > 0 */
    double shift[3];
};

/** Turns a vector, without scale and shift; out is not v. */
static inline void vor_pose_turn(const struct vor_pose *pose, const double v[3], double out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = vor_dot(pose->turn[c], v);
}

/** Moves a point; out is not x. */
static inline void vor_pose_move(const struct vor_pose *pose, const double x[3], double out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = pose->scale * vor_dot(pose->turn[c], x) + pose->shift[c];
}

/** The pose that moves back; out is not pose. */
static inline void vor_pose_invert(struct vor_pose *out, const struct vor_pose *pose)
{
    double moved[3];

    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            out->turn[r][c] = pose->turn[c][r];
    out->scale = 1 / pose->scale;
    vor_pose_turn(out, pose->shift, moved);
    for (int c = 0; c < 3; c++)
        out->shift[c] = -moved[c] * out->scale;
}

/** How far apart two poses put a cloud of size 1: turned, shifted and grown; squared. */
static inline double vor_pose_apart2(const struct vor_pose *a, const struct vor_pose *b)
{
    double grown = a->scale / b->scale - 1, shifted2 = 0, trace = 0;

    for (int c = 0; c < 3; c++) {
        trace += vor_dot(a->turn[c], b->turn[c]);
        shifted2 += (a->shift[c] - b->shift[c]) * (a->shift[c] - b->shift[c]);
    }
    return 3 - trace + grown * grown + shifted2;
}

/** Whether two poses are one to a few samples that are so far apart. */
static inline int vor_poses_are_alike(const struct vor_pose *a, const struct vor_pose *b,
                                      double apart)
{
    return vor_pose_apart2(a, b) < 4 * apart * apart;
}

#endif
