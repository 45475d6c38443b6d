/** What the kinds of parameters have in common: each is one or two forms, and each form is one row
 *  of functions. For core/spec.c, which keeps the values, and for the help. */
#ifndef VOR_SPEC_KINDS_H
#define VOR_SPEC_KINDS_H

#include "core/spec/tables.h"

/** "a number", "a boolean", "a string", "an array"; shape is not ANY. */
const char *vor_shape_word(enum vor_shape shape);

/** A value that was read. */
struct vor_value {
    double number;
    const char *text; /**< of a text or a name: lies in what was read; else NULL */
};

/** Bytes that what vor_kind_want and vor_kind_values write need at most, with the NUL; core/spec.c
 *  checks it against every row. */
#define VOR_KIND_WORDS_SIZE 640

/** True when the kind has a form of that shape. */
int vor_kind_has_shape(enum vor_kind kind, enum vor_shape shape);

/** The form that a value has; VOR_FORM_NONE when it is not given. */
enum vor_form vor_kind_form_of(const struct vor_parameter_info *info, double value);

/** Reads text that stands for a value of a shape.
 *
 *  @return true; false when it is in none of the kind's forms of this shape, or out of range */
int vor_kind_read(const struct vor_parameter_info *info, enum vor_shape shape, const char *text,
                  struct vor_value *out);

/** Writes a value so that reading it gives it back, "" where it is not given; cut at size. name is
 *  that of a text or a name, else not looked at. */
void vor_kind_write(const struct vor_parameter_info *info, double value, const char *name,
                    char *out, size_t size);

/** What may be given, for a message: "a whole number from 6 to 500 or auto". */
void vor_kind_want(const struct vor_parameter_info *info, char out[VOR_KIND_WORDS_SIZE]);

/** The same for a list: "6 to 500 points | auto". */
void vor_kind_values(const struct vor_parameter_info *info, char out[VOR_KIND_WORDS_SIZE]);

#endif
