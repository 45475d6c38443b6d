/** The table of settings as help, manual and completions tell it. */
#ifndef VOR_SERVER_BASE_CONFIG_HELP_H
#define VOR_SERVER_BASE_CONFIG_HELP_H

#include "server/base/config.h"

/** A setting as the help, the manual and completions tell it. */
struct vor_setting_text {
    const char *flag, *sentence;
    const char *value; /**< what stands behind the flag: "N"; "" for nothing */
    const char *words; /**< of a choice, with blanks between; else "" */
    char variable[VOR_VARIABLE_MAX];
    char range[160]; /**< "1 to 64 jobs, default 2 "; "" where there is none */
};

/** Describes setting number `index`; false past the last. */
int vor_config_describe(struct vor_setting_text *out, unsigned index);

/** The table for people, one setting after another. */
void vor_config_help(FILE *out);

#endif
