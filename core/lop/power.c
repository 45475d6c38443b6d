#include "core/lop/power.h"

#include "core/base/linalg.h"

#include <math.h>

enum { ROOTS = 20 };

double vor_lop_power(double x, double y)
{
    unsigned whole = (unsigned)y;
    double left = y - whole, root = x, result = vor_power(x, whole);

    for (int k = 0; k < ROOTS && left > 0; k++) {
        root = sqrt(root);
        left *= 2;
        if (left >= 1) {
            result *= root;
            left -= 1;
        }
    }
    return result;
}
