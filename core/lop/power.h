/** Real powers whose bits do not differ between machines, as those of pow do. */
#ifndef VOR_LOP_POWER_H
#define VOR_LOP_POWER_H

/** x^y for x > 0 and 0 <= y < 2^31, y rounded down to a multiple of 2^-20: by squares, and square
 *  roots for what is left of y. */
double vor_lop_power(double x, double y);

#endif
