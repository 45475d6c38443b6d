/** Descriptions of processes. */
#ifndef VOR_PROTO_JSON_PROCESS_H
#define VOR_PROTO_JSON_PROCESS_H

#include "core/spec.h"
#include "proto/json/json_values.h"
#include "proto/text.h"

#include <stddef.h>

/** Writes the summary of a process for a list, or its whole description: inputs from the parameter
 *  table, outputs cloud and report, and "x-record", the schema of its progress records. Links as in
 *  vor_json_links. */
void vor_json_process_summary(struct vor_text *text, const struct vor_process_info *process,
                              const struct vor_link *links, size_t link_count);
void vor_json_process(struct vor_text *text, const struct vor_process_info *process,
                      const struct vor_link *links, size_t link_count);

#endif
