/** A job as a plain value: what its row in the store says, what a live job says of itself, what
 *  statusInfo shows. The words of its states are the store's and the API's alike. */
#ifndef VOR_SERVER_STORE_ROW_H
#define VOR_SERVER_STORE_ROW_H

#include "core/report.h"
#include "core/spec.h"
#include "server/base/build.h"
#include "server/base/digest.h"
#include "server/base/span.h"
#include "server/base/uuid.h"

#include <stdint.h>

/** The states of a job: identifier, word of statusInfo. A store keeps the word. */
#define VOR_JOB_STATUS_TABLE(X)                                                                    \
    X(ACCEPTED, "accepted")                                                                        \
    X(RUNNING, "running")                                                                          \
    X(SUCCESSFUL, "successful")                                                                    \
    X(FAILED, "failed")                                                                            \
    X(DISMISSED, "dismissed")

enum vor_job_status {
#define VOR_JOB_STATUS_ENUM(name, word) VOR_JOB_##name,
    VOR_JOB_STATUS_TABLE(VOR_JOB_STATUS_ENUM)
#undef VOR_JOB_STATUS_ENUM
        VOR_JOB_STATUSES
};

/** The stages of a job: identifier, word of statusInfo. A trace keeps the number. */
#define VOR_STAGE_TABLE(X)                                                                         \
    X(QUEUED, "queued")                                                                            \
    X(PREPARE, "prepare")                                                                          \
    X(OPTIMIZE, "optimize")                                                                        \
    X(ENCODE, "encode")

enum vor_stage {
#define VOR_STAGE_ENUM(name, word) VOR_STAGE_##name,
    VOR_STAGE_TABLE(VOR_STAGE_ENUM)
#undef VOR_STAGE_ENUM
        VOR_STAGES
};

/** What every line of the log about a job has of its view: VOR_OF_JOB(view), further fields. */
#define VOR_OF_JOB(view)                                                                           \
    VOR_TEXT("job", (view)->id.text), VOR_KNOWN("trace_id", (view)->span.trace),                   \
        VOR_KNOWN("span_id", (view)->span.id)

const char *vor_job_status_word(enum vor_job_status status);
const char *vor_stage_word(enum vor_stage stage);

/** The status of that word; VOR_JOB_STATUSES when there is none. */
enum vor_job_status vor_job_status_find(const char *word);

/** True for successful, failed and dismissed. */
int vor_job_status_over(enum vor_job_status status);

/** An input of a job, as the admission found it. */
struct vor_job_input {
    unsigned format;              /**< index of vor_format */
    uint64_t points;              /**< decoded */
    uint64_t bytes;               /**< of the upload */
    char sha256[VOR_DIGEST_SIZE]; /**< of the upload */
    double seconds;               /**< decoding took */
};

/** An output of a job that was successful. */
struct vor_job_output {
    unsigned format;              /**< of a cloud: index of vor_format; else 0 */
    uint64_t points;              /**< of a cloud; else 0 */
    uint64_t bytes;               /**< of the file, or of the document as JSON */
    char sha256[VOR_DIGEST_SIZE]; /**< likewise; "" of one that is kept in the row */
    int has_origin;               /**< of a cloud in a format that takes one; rows of before have
                                       none */
    double origin[3];             /**< that the positions in the file count from */
};

/** True for an output that is kept in the row of its job, as text, and not among the blobs: the
 *  document "report". Stores of all versions have it there. */
int vor_output_in_row(const struct vor_artefact_info *output);

/** The name that a caller gives a job: so many characters at most, which in UTF-8 take up to four
 *  bytes each, and a NUL. */
enum { VOR_JOB_NAME_CHARACTERS = 200, VOR_JOB_NAME_SIZE = 4 * VOR_JOB_NAME_CHARACTERS + 1 };

/** Sizes of a key and of who sent it, each with a NUL. */
enum { VOR_JOB_KEY_SIZE = 256, VOR_JOB_PRINCIPAL_SIZE = 65 };

/** What makes one job of a request that is sent again (the header Idempotency-Key): a key is that
 * of one job, among the keys of its principal. */
struct vor_job_key {
    char principal[VOR_JOB_PRINCIPAL_SIZE]; /**< whose job it is: the name of the API key that it
                                                 came with, "" for none; set without a key too */
    char text[VOR_JOB_KEY_SIZE];            /**< "" for no key */
    char fingerprint[VOR_DIGEST_SIZE];      /**< of what was asked for, inputs included */
};

/** Everything that statusInfo says: a row of the store, or a snapshot of a live job. A plain value
 *  that owns nothing. Times are wall-clock milliseconds, 0 for not yet. */
struct vor_job_view {
    struct vor_uuid id;
    int64_t seq;                  /**< order of acceptance, from 1 */
    char process[32];             /**< "resample" */
    char name[VOR_JOB_NAME_SIZE]; /**< UTF-8, or "" */
    struct vor_span span;         /**< the step of a trace that asked for it, or none */
    struct vor_job_key key;
    enum vor_job_status status;
    enum vor_stage stage;
    int progress;         /**< 0 .. 100, never decreases; 100 only when successful */
    uint32_t attempt;     /**< from 1; the next one while the job waits */
    long queue_position;  /**< 0 is next; -1 when not waiting */
    double eta_seconds;   /**< until the last stage of the run ends; -1 when not known */
    struct vor_spec spec; /**< FORMAT is given where the process takes it */
    int request_lost;     /**< this version cannot read the request: spec is the default, or one of
                               another process, and must not be run */
    unsigned inputs;      /**< bit i: input i of the process came along; the main one always does */
    struct vor_job_input input[VOR_INPUTS_MAX];    /**< in the order of the process's inputs */
    struct vor_job_output output[VOR_OUTPUTS_MAX]; /**< likewise of its outputs; successful */
    uint64_t kept;    /**< bytes of its uploads that are kept; 0 when they are not, or no more */
    uint64_t memory;  /**< bytes that a run takes, as estimated */
    uint64_t decoded; /**< bytes of its decoded inputs */
    int has_record;
    struct vor_record record; /**< the latest */
    struct vor_error problem; /**< failed; status VOR_OK otherwise */
    char message[128];        /**< a sentence for people: what it does, or why it ended */
    struct vor_build build;   /**< of the daemon that accepted it */
    int expired;              /**< result and report are gone: 410 */
    int alone; /**< nothing may run beside it: it was running when the program crashed */
    int64_t created, started, updated, finished, expires;
};

/** A time for a row that is changed now: now, or where the wall clock was set back, the latest of
 *  the times that the row has, so that nothing ends before it began. */
static inline int64_t vor_job_now(const struct vor_job_view *row, int64_t now_ms)
{
    int64_t began = row->started > row->created ? row->started : row->created;
    int64_t last = row->updated > began ? row->updated : began;

    return now_ms > last ? now_ms : last;
}

#endif
