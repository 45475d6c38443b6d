/** What is shown while a job runs, here or far away: a bar on a terminal, or one JSON object a
 * line; and what is said at its end. */
#ifndef VOR_CLI_PROGRESS_H
#define VOR_CLI_PROGRESS_H

#include "core/report.h"
#include "proto/json/json.h"
#include "server/cli/options.h"
#include "server/jobs/eta.h"

#include <stdio.h>

struct vor_progress {
    const struct vor_cli *cli;
    const char *name; /**< whose summary it is; NULL for the output */
    FILE *lines;      /**< NDJSON; NULL for none */
    FILE *bar;        /**< stderr when it is a terminal; NULL for none */
    int columns;
    double drawn_at;    /**< seconds of vor_clock; a bar is drawn ten times a second at most */
    struct vor_eta eta; /**< what the time left is reckoned from */
};

/** Sets up what the command's options, its output and the terminal ask for. cli is borrowed. */
void vor_progress_start(struct vor_progress *progress, const struct vor_cli *cli);

/** A word about what is going on, on the bar only. */
void vor_progress_note(struct vor_progress *progress, const char *note);

/** Shows a record: a line of JSON, or the bar, ten times a second at most. */
void vor_progress_record(struct vor_progress *progress, const struct vor_record *record);

/** Shows the record in the data of a daemon's progress event. Ignores data without a record. */
void vor_progress_event(struct vor_progress *progress, const struct vor_json *event);

/** Takes the bar off the terminal, so that a line can be printed. */
void vor_progress_clear(struct vor_progress *progress);

/** The end of a job that went well: the report as the last line, or one sentence on stderr.
 *
 *  @param[in] report JSON as vor_json_document writes it, size bytes
 *  @retval VOR_E_REQUEST report is none
 *  @retval VOR_E_IO      the lines cannot be written */
VOR_NODISCARD vor_status vor_progress_finish(struct vor_progress *progress, const char *report,
                                             size_t size, struct vor_error *err);

#endif
