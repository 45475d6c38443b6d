/** Numbers as the command line and the query write them. For core/spec/kinds.c and core/spec.c. */
#ifndef VOR_SPEC_DECIMAL_H
#define VOR_SPEC_DECIMAL_H

#include <stddef.h>

/** Reads a decimal number and nothing else: no hexadecimal, blanks, "inf", nor a locale's comma.
 *
 *  @param[out] out     finite or infinite ("1e999"), never NaN; unchanged when false is returned
 *  @param[in]  text    any bytes; the first `length` of them are the number, at most 40 */
int vor_decimal_read(double *out, const char *text, size_t length);

/** Reads "X,Y,Z", three such numbers; the whole text counts. */
int vor_decimal_read_vector(double out[3], const char *text);

#endif
