/** Options of every command line, and the settings of the daemon: a row of a table, how its value
 * is read and how the help shows it. The tables are VOR_SETTING_TABLE (config.h) and
 * VOR_OPTION_TABLE (server/cli/command.h); --help, the manual, completions and messages are made of
 * them. */
#ifndef VOR_SERVER_BASE_OPTION_H
#define VOR_SERVER_BASE_OPTION_H

#include "core/base/status.h"

#include <getopt.h>
#include <stddef.h>

enum vor_option_type {
    VOR_TYPE_TEXT,
    VOR_TYPE_LIST,     /**< text with commas between entries; flags given again add to it */
    VOR_TYPE_COUNT_OF, /**< whole number */
    VOR_TYPE_BYTES,    /**< whole number, with K, M, G or T (1024) behind it or not */
    VOR_TYPE_TIME,     /**< seconds */
    VOR_TYPE_FLAG,     /**< given or not; 1 or 0 in the environment */
    VOR_TYPE_CHOICE    /**< one word of those in the unit */
};

/** One of them. */
struct vor_option_row {
    const char *name;
    enum vor_option_type type;
    const char *unit; /**< of a text, what stands for it: "FILE"; of a choice its words */
    double min, max;
    const char *fallback, *sentence; /**< the default as text, "" for none */
    const char *variable;            /**< of the environment, "" for none */
    unsigned commands;               /**< that take it: server/cli/command.h */
    char letter;                     /**< 0 for none */
};

/** What stands for the value in a help: "N", "FILE"; "" for a flag. */
const char *vor_option_value(const struct vor_option_row *info);

/** Writes "1 to 64 jobs, default 2", "" where there is neither, and returns it. */
#define VOR_OPTION_RANGE_SIZE 160
const char *vor_option_range(const struct vor_option_row *info, char out[VOR_OPTION_RANGE_SIZE]);

/** Reads a number or a flag; of a choice the index of its word.
 *
 *  @retval VOR_E_PARAM it is none, or out of range (message: option, value and range) */
VOR_NODISCARD vor_status vor_option_read(double *out, const struct vor_option_row *info,
                                         const char *text, struct vor_error *err);

/** The number that a text is: decimal, without a sign, with K, M, G or T (1024 each) behind it if
 *  may_scale. NAN for anything else. */
double vor_number_read(const char *text, size_t length, int may_scale);

/** Cuts blanks and line breaks off both ends of a text, which is changed; returns its new
 * beginning.
 */
char *vor_trim(char *text);

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
