/** How much points count for each other, by distance and by normal. Polynomials stand for the
 *  exponentials of the papers, whose bits differ between machines; beyond their reach they are 0.
 */
#ifndef VOR_LOP_WEIGHTS_H
#define VOR_LOP_WEIGHTS_H

#include "core/base/vector.h"

/** (1 - d2 / r2)^4 up to the reach r, for exp(-4 d2 / r2): theta, as CGAL and the authors' WLOP
 * have it. */
VOR_INLINE double vor_lop_near(double d2, double inverse_r2)
{
    double t = 1 - d2 * inverse_r2;

    t = t > 0 ? t : 0; /* no branch, for vectors */
    t *= t;
    return t * t;
}

/** Of two normals by their cosine, for exp(-((1 - cosine) / (1 - cos(sigma_n)))^2): psi of Huang
 *  2013, Eq. 1.
 *
 *  @param[in] scale  vor_lop_scale(sigma_n) */
VOR_INLINE double vor_lop_alike(double cosine, double scale)
{
    double x = (1 - cosine) * scale;

    return vor_lop_near(x * x, 0.25);
}

/** 1 / (1 - cos(sigma)) for an angle of 0 < sigma <= pi / 2, by 2 sin^2(sigma / 2) and six terms of
 *  the sine, which are exact to 1e-15. */
static inline double vor_lop_scale(double sigma)
{
    double x = sigma / 2, x2 = x * x, sine = 1;

    for (int i = 13; i > 1; i -= 2)
        sine = 1 - x2 / (i * (i - 1)) * sine;
    sine *= x;
    return 1 / (2 * sine * sine);
}

#endif
