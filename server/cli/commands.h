/** What each command does; each returns an exit code (cli_log.h), and says in a line what went
 * wrong. */
#ifndef VOR_CLI_COMMANDS_H
#define VOR_CLI_COMMANDS_H

#include "core/cloud/cloud.h"
#include "server/base/keys.h"
#include "server/cli/options.h"

/** Reads the clouds, runs the process and writes its main output. Returns the exit code. */
int vor_cli_run_local(const struct vor_cli *cli);

/** Sends the cloud to the daemon of --server, follows the job and fetches its main output; ^C
 *  dismisses the job. Returns the exit code. */
int vor_cli_run_remote(const struct vor_cli *cli);

/** Hands each input to the daemon as a job and prints the jobs' IDs, a line each. Waits for none.
 *  Returns the exit code. */
int vor_cli_submit(const struct vor_cli *cli);

/** Lists the jobs named, else the newest of the daemon, a line each. Returns the exit code. */
int vor_cli_jobs(const struct vor_cli *cli);

/** Shows the progress of each job until it is over, then what came of it. A signal ends the waiting
 *  and leaves the job alone. Returns the exit code that running the job here would have. */
int vor_cli_wait(const struct vor_cli *cli);

/** Dismisses each job. One that is over keeps its results, and counts as a failure. Returns the
 * exit code. */
int vor_cli_cancel(const struct vor_cli *cli);

/** Stops each running job with the best so far as its result. One that is over counts as a failure.
 *  Returns the exit code. */
int vor_cli_stop(const struct vor_cli *cli);

/** Writes results of each job where -o says: the main one, or that of --result, into a file; all of
 *  them, or that one, into a folder, as JOB-RESULT.SUFFIX. Returns the exit code. */
int vor_cli_fetch(const struct vor_cli *cli);

/** Asks the daemon (server/cli/remote.h) and prints one line. Returns the exit code. */
int vor_cli_health(const struct vor_cli *cli);

/** Copies DATA/jobs.sqlite and DATA/blobs to --store and --blobs; returns an exit code. */
int vor_cli_migrate(const struct vor_cli *cli);

/* One command on several operands: each in its turn, and what fails does not stop the rest. */

/** Calls one for each operand, by its number and in their order, until all are done or a signal
 *  came.
 *
 *  @return the first exit code that is not VOR_EXIT_OK; else that */
int vor_cli_each(const struct vor_cli *cli,
                 int (*one)(const struct vor_cli *cli, int index, void *ctx), void *ctx);

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

/* Frames of a sequence: clouds of which each is resampled from the result for the one before. */

/** Names of attributes. */
struct vor_attribute_names {
    unsigned count;
    char name[VOR_ATTRIBUTES_MAX][sizeof((struct vor_attribute *)NULL)->name];
};

/** Finds the attributes that all operands have, and names the others on stderr. The attribute track
 *  is none of either: results have one of their own. Operands that cannot be read do not count:
 *  their run says why.
 *
 *  @retval VOR_E_NOMEM
 *
 *  Reads each file, one after the other. */
VOR_NODISCARD vor_status vor_sequence_common(struct vor_attribute_names *out,
                                             const struct vor_cli *cli, struct vor_error *err);

/* Keys on the command line: one is made for a daemon, or read for a call to one. */

/** voronoid key NAME: prints a new key on stderr, this once, and its line for --api-keys on stdout.
 *  Returns an exit code. */
int vor_cli_key(const struct vor_cli *cli);

/** The key to send: the first line of --api-key-file, else VORONOID_KEY; "" when there is neither.
 *  It never stands on a command line, which every user of the machine may read.
 *
 *  @retval VOR_E_PARAM it is longer than VOR_KEY_SENT_MAX, or holds a blank or a control character;
 *                      the message does not show it
 *  @retval VOR_E_IO    the file cannot be read */
VOR_NODISCARD vor_status vor_cli_key_read(char out[VOR_KEY_SENT_MAX + 1], const struct vor_cli *cli,
                                          struct vor_error *err);

#endif
