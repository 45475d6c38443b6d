/** Tables of ours as text in the form of server/base/markup.h: what a help topic names with
 *  "%table NAME". */
#ifndef VOR_SERVER_BASE_REFERENCE_H
#define VOR_SERVER_BASE_REFERENCE_H

#include "core/spec.h"
#include "core/spec/kinds.h"
#include "proto/text.h"

/** Bytes of what vor_reference_values writes, with the NUL. */
#define VOR_REFERENCE_VALUES_SIZE (VOR_KIND_WORDS_SIZE + VOR_SPEC_VALUE_SIZE + 64)

/** Bytes of a parameter's name as an option, with the NUL. */
#define VOR_REFERENCE_NAME_SIZE 32

/** Writes the option that a parameter is on the command line, "max-aspect" of maxAspect, and
 *  returns it. */
const char *vor_reference_option(char out[VOR_REFERENCE_NAME_SIZE], enum vor_parameter parameter);

/** Writes what a process takes for a parameter: "1 to 10000000 points, default 100" or "keep |
 *  free, default keep"; behind that its name over HTTP where the option has another. */
void vor_reference_values(char out[VOR_REFERENCE_VALUES_SIZE],
                          const struct vor_process_info *process, enum vor_parameter parameter);

/** Appends the table of that name: "parameters", "presets", "settings" or "metrics". A table that
 *  we do not have fails the text. */
void vor_reference_write(struct vor_text *text, const char *name, size_t length);

#endif
