#include "core/lop/power.h"

#include <math.h>

enum { ROOTS = 20 };

double vor_lop_power(double x, double y)
{
    unsigned whole = (unsigned)y;
    double left = y - whole, root = x, result = 1;

    for (double square = x; whole > 0; whole >>= 1) {
        if (whole & 1)
            result *= square;
        square *= square;
    }
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
