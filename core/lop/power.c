#include "core/lop/power.h"

#include "core/base/linalg.h"

#include <float.h>
#include <math.h>

double vor_lop_power(double x, double y)
{
    unsigned whole = (unsigned)y;
    double left = y - whole, root = x, result = vor_power(x, whole);

    for (int k = 0; k < FLT_MANT_DIG && left > 0; k++) {
        root = sqrt(root);
        left *= 2;
        if (left >= 1) {
            result *= root;
            left -= 1;
        }
    }
    return result;
}
