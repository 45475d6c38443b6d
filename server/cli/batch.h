/** One command on several operands: each in its turn, and what fails does not stop the rest. */
#ifndef VOR_CLI_BATCH_H
#define VOR_CLI_BATCH_H

#include "server/cli/options.h"

/** Calls one for each operand, in their order, until all are done or a signal came.
 *
 *  @return the first exit code that is not VOR_EXIT_OK; else that */
int vor_cli_each(const struct vor_cli *cli,
                 int (*one)(const struct vor_cli *cli, const char *operand, void *ctx), void *ctx);

/** Runs a process on each input and puts the results into the folder of -o, which is made if it is
 *  not there. A result has the name of its input; with the parameter format, or for a document,
 *  that of a format at its end gives way to the suffix of the result. Names are checked before any
 *  work is done. With --json, a line {"input": ..., "output": ...} precedes those of an input.
 *  Of the frames of a sequence each gets the last result before it as the input `previous`, and
 *  none keeps an attribute that not all have.
 *
 *  @param[in] run  runs the process on the one input of its command line
 *  @return VOR_EXIT_USAGE when two results would have one name, or an input has none to give;
 *          VOR_EXIT_FAILED when the folder cannot be made; else as vor_cli_each */
int vor_cli_batch(const struct vor_cli *cli, int (*run)(const struct vor_cli *cli));

#endif
