/** The kinds of parameters: a kind is one or two forms, a form is one row of functions
 *  (core/spec/kinds.c). For core/spec.c and for the help of the command line. */
#ifndef VOR_SPEC_KINDS_H
#define VOR_SPEC_KINDS_H

#include "core/spec/tables.h"

/** A value that was read. */
struct vor_value {
    double number;
    const char *text; /**< of a text, a name or a vector; points into the text that was read. Else
                           NULL */
};

/** Most bytes that vor_kind_want and vor_kind_values write, with the NUL; core/spec.c asserts it
 * for every row. */
#define VOR_KIND_WORDS_SIZE 640

/** The form of a value; VOR_FORM_NONE if it is not given. */
enum vor_form vor_kind_form_of(const struct vor_parameter_info *info, double value);

/** Reads text as a value.
 *
 *  @param[out] out  unchanged when false is returned
 *  @return true; false if it is in none of the kind's forms, or out of range */
int vor_kind_read(const struct vor_parameter_info *info, const char *text, struct vor_value *out);

/** Bytes of a number that vor_kind_expand writes, with the NUL. */
#define VOR_KIND_NUMBER_SIZE 32

/** Writes what a count with k (thousand) or M (million) at its end stands for, whole or not and in
 *  range or not: "1234.5" for "1.2345k".
 *
 *  @param[out] out  unchanged when false is returned
 *  @return false if the kind has no whole numbers, or text is none that ends in k or M */
int vor_kind_expand(const struct vor_parameter_info *info, const char *text,
                    char out[VOR_KIND_NUMBER_SIZE]);

/** True if the kind is a list, and text one of words, none of them empty, and some of them not
 *  among the parameter's. */
int vor_kind_has_unknown_word(const struct vor_parameter_info *info, const char *text);

/** Writes a value as text from which vor_kind_read reads the same value; "" if it is not given.
 *  Cuts the text at size. name is the text or the name of a value that has one, else ignored. */
void vor_kind_write(const struct vor_parameter_info *info, double value, const char *name,
                    char *out, size_t size);

/** Writes what may be given as part of a sentence: "a whole number from 6 to 500 or auto". */
void vor_kind_want(const struct vor_parameter_info *info, char out[VOR_KIND_WORDS_SIZE]);

/** Writes it as a list of alternatives: "6 to 500 points | auto". */
void vor_kind_values(const struct vor_parameter_info *info, char out[VOR_KIND_WORDS_SIZE]);

#endif
