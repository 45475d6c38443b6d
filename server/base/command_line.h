/** What the command lines of all commands share: numbers, and options that are none. */
#ifndef VOR_SERVER_BASE_COMMAND_LINE_H
#define VOR_SERVER_BASE_COMMAND_LINE_H

#include "core/base/status.h"

#include <getopt.h>
#include <stddef.h>

/** The number that a text is: decimal, without a sign, with K, M, G or T (1024 each) behind it if
 *  may_scale. NAN for anything else. */
double vor_number_read(const char *text, size_t length, int may_scale);

/** True when a text is a whole number from least to most, in digits alone; *out is untouched else.
 */
int vor_whole_read(unsigned *out, const char *text, unsigned least, unsigned most);

/** Refuses a word of the command line that begins with a dash: it may be several of the long
 *  options, or is none of them; then with those that it may be meant for.
 *
 *  @param[in] longs    as getopt_long wants them; of those of one value only the first is named
 *  @param[in] command  whose help has them all
 *
 *  @retval VOR_E_PARAM always */
vor_status vor_option_refuse(const struct option *longs, const char *word, const char *command,
                             struct vor_error *err);

#endif
