/** Numbers as the command line and the query write them. For core/spec/kinds.c and core/spec.c. */
#ifndef VOR_SPEC_DECIMAL_H
#define VOR_SPEC_DECIMAL_H

#include <stddef.h>

/** Reads a decimal number and nothing else: no hexadecimal, blanks, "inf", nor a locale's comma.
 *
 *  @param[out] out     finite or infinite ("1e999"), never NaN; unchanged when false is returned
 *  @param[in]  text    any bytes; the first `length` of them are the number, at most 40 */
int vor_decimal_read(double *out, const char *text, size_t length);

/** The same for a whole text that may end in k or M, for thousands and millions, instead of an
 *  exponent: rounded once, so that 1.001k is 1001, where 1.001 * 1000 is not. */
int vor_decimal_read_count(double *out, const char *text);

/** Reads "X,Y,Z", three such numbers; the whole text counts. */
int vor_decimal_read_vector(double out[3], const char *text);

/** True when text is at most 256 whole numbers from min to max with commas between, each at most
 *  once. O(length). */
int vor_decimal_are_counts(const char *text, double min, double max);

/** Reads number `index` of a text with commas between them; false if it is none, or past the last.
 */
int vor_decimal_read_at(double *out, const char *text, unsigned index);

#endif
