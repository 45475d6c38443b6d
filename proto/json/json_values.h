/** Records, problems, links and the status of a job, each written by one function, so that they
 * have the same shape everywhere. */
#ifndef VOR_PROTO_JSON_VALUES_H
#define VOR_PROTO_JSON_VALUES_H

#include "core/base/status.h"
#include "core/report.h"
#include "core/spec.h"
#include "proto/json/json_read.h"
#include "proto/text.h"

#include <stddef.h>
#include <stdint.h>

/** Writes a progress record as an object, the same in SSE, NDJSON and traces. */
void vor_json_record(struct vor_text *text, const struct vor_record *record);

/** Reads a record from an object, which may have other members, as vor_json_members_read does.
 *  Returns 0 and leaves *out alone when the object has no iteration. */
int vor_json_record_read(struct vor_record *out, const struct vor_json *object);

/** One entry of a problem's errors[]: exactly one of pointer and parameter is set. */
struct vor_problem_error {
    const char *pointer, *parameter, *detail;
};

/** A problem (RFC 9457). Strings are borrowed; NULL ones and the numbers' "none" are left out.
 *  Begin with VOR_PROBLEM_DOC_INIT. */
struct vor_problem_doc {
    const char *type, *title;
    int status; /**< HTTP */
    const char *detail, *instance;
    int retryable;
    const char *request_id;
    const char *job_id;
    const struct vor_problem_error *errors;
    size_t error_count;
    int has_limit;       /**< limit and got are written */
    uint64_t limit, got; /**< the limit and what exceeded it */
    int64_t byte_offset; /**< -1 none */
    int64_t queue_depth; /**< -1 none */
    unsigned attempt;    /**< 0 none */
};

#define VOR_PROBLEM_DOC_INIT                                                                       \
    {                                                                                              \
        .byte_offset = -1, .queue_depth = -1                                                       \
    }

/** {"type","title","status","detail","instance","retryable","requestId", "jobID", "attempt",
 *  "limit", "got", "byteOffset", "queueDepth", "errors":[{"pointer"|"parameter","detail"}]}. */
void vor_json_problem(struct vor_text *text, const struct vor_problem_doc *problem);

/** A link; NULL members and a length of -1 are left out. */
struct vor_link {
    const char *rel, *type, *title, *href;
    int64_t length;
};

/** [{"rel","type","title","href","length"}, ...] */
void vor_json_link(struct vor_text *text, const struct vor_link *link);
void vor_json_links(struct vor_text *text, const struct vor_link *links, size_t count);

/** An input of a job. Strings are borrowed; sha256 may be NULL. */
struct vor_input_info {
    const char *name;   /**< "cloud" */
    const char *format; /**< "ply" or "draco" */
    uint64_t points, bytes;
    const char *sha256; /**< hex; NULL: left out */
};

/** A job as the service shows it (OGC API - Processes statusInfo, both drafts, with our own members
 *  under "voronoid"). Strings are borrowed; begin with VOR_STATUS_INFO_INIT. */
struct vor_status_info {
    const char *job_id;     /**< written as jobID and as id */
    const char *process_id; /**< "resample" */
    const char *name;       /**< that its caller gave it; NULL or "": left out */
    const char *status;     /**< accepted, running, successful, failed, dismissed */
    const char *message;    /**< NULL: left out */
    int progress;           /**< 0 .. 100; -1: left out */
    const char *created, *started, *updated, *finished; /**< RFC 3339; NULL or "": left out */

    unsigned attempt;       /**< 0 before the first */
    const char *stage;      /**< NULL: null */
    int64_t queue_position; /**< -1: null */
    double eta;             /**< seconds; negative: null */
    /** The first is the member input; where there are more, all are in the member inputs. */
    const struct vor_input_info *inputs;
    size_t input_count;
    const struct vor_spec *parameters; /**< those that are not at their defaults; NULL: left out */
    uint64_t target_points;            /**< 0: left out (not known before the area is) */
    const char *target_format;         /**< NULL: left out */
    const double *origin;              /**< three, of the main output; NULL: left out */
    const struct vor_record *metrics;  /**< NULL: null */
    const struct vor_problem_doc *exception; /**< of a failed job; NULL: left out */
    const char *exception_json;              /**< the same, already JSON; wins when not NULL */
    const struct vor_link *links;
    size_t link_count;
};

#define VOR_STATUS_INFO_INIT                                                                       \
    {                                                                                              \
        .progress = -1, .queue_position = -1, .eta = -1                                            \
    }

void vor_json_status_info(struct vor_text *text, const struct vor_status_info *info);

#endif
