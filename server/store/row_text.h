/** The parts of a job's row that a store keeps as JSON text. Only drivers of stores include this.
 */
#ifndef VOR_SERVER_STORE_ROW_TEXT_H
#define VOR_SERVER_STORE_ROW_TEXT_H

#include "proto/json/json.h"
#include "server/store/row.h"

/** request: vor_json_spec; metrics: vor_json_record, empty without a record; problem: {"status",
 *  "parameter", "message", "byteOffset", "limit", "got"}, empty without one.
 *
 *  inputs: those beside the main one, {NAME: {"format", "points", "bytes", "sha256", "seconds"}},
 *  empty without any. outputs: those beside the main one that are blobs, {NAME: {"format",
 *  "points", "bytes", "sha256", "origin"}}, and of the main one {NAME: {"origin"}}; an origin is an
 *  array of three numbers, left out where there is none. Empty without any and unless the job is
 *  successful. Whatever else is known of the main ones is in columns of numbers, as it was when a
 *  job had no others. */
struct vor_row_text {
    struct vor_text request, metrics, problem, inputs, outputs;
};

/** The same as they come out of the store; each may be NULL. */
struct vor_row_columns {
    const char *request, *metrics, *problem, *inputs, *outputs;
};

/** Writes them all; the caller frees them, also after a failure.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_row_write(struct vor_row_text *out, const struct vor_job_view *row,
                                       struct vor_error *err);
void vor_row_text_free(struct vor_row_text *text);

/** Reads them back into a row whose process and status are set already. A text that another version
 *  wrote and this one cannot read gives the default instead; of a request, request_lost says so. An
 *  input or output that this version's process does not have is left out. */
void vor_row_read(struct vor_job_view *row, const struct vor_row_columns *columns);

#endif
