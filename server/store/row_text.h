/** The parts of a job's row that a store keeps as JSON text. Only drivers of stores include this.
 */
#ifndef VOR_SERVER_STORE_ROW_TEXT_H
#define VOR_SERVER_STORE_ROW_TEXT_H

#include "proto/json/json.h"
#include "server/store/row.h"

/** request: vor_json_spec; metrics: vor_json_record, empty without a record; problem: {"status",
 *  "parameter", "message", "byteOffset", "limit", "got"}, empty without one. */
struct vor_row_text {
    struct vor_text request, metrics, problem;
};

/** Writes the three; the caller frees them, also after a failure.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_row_write(struct vor_row_text *out, const struct vor_job_view *row,
                                       struct vor_error *err);
void vor_row_text_free(struct vor_row_text *text);

/** Reads the three (each may be NULL) back into a row whose process is set already. A text that
 *  another version wrote and this one cannot read gives the default instead: a request without
 *  points then fails vor_spec_check. */
void vor_row_read(struct vor_job_view *row, const char *request, const char *metrics,
                  const char *problem);

#endif
