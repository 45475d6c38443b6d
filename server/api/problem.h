/** The only place that turns a failure into an error answer (RFC 9457). */
#ifndef VOR_SERVER_API_PROBLEM_H
#define VOR_SERVER_API_PROBLEM_H

#include "proto/json/json.h"
#include "server/api/links.h"

/** Problems besides those of VOR_STATUS_TABLE: slug, HTTP status, retryable, whether the type is
 *  OGC's, title. */
#define VOR_PROBLEM_TABLE(X)                                                                       \
    X("smuggled-framing", 400, 0, 0, "The length or the headers of the request are ambiguous")     \
    X("invalid-query-parameter-value", 400, 0, 1, "A query parameter is invalid")                  \
    X("unauthorized", 401, 0, 0, "The request needs a key")                                        \
    X("forbidden", 403, 0, 0, "The request is not allowed")                                        \
    X("no-such-resource", 404, 0, 0, "There is nothing at this path")                              \
    X("no-such-process", 404, 0, 1, "There is no such process")                                    \
    X("no-such-job", 404, 0, 1, "There is no such job")                                            \
    X("input-not-kept", 404, 0, 0, "The job's input is no longer stored")                          \
    X("no-such-output", 404, 0, 1, "The job has no such output")                                   \
    X("result-not-ready", 404, 1, 1, "The result is not ready")                                    \
    X("result-not-available", 404, 0, 1, "The job has no result")                                  \
    X("method-not-allowed", 405, 0, 0, "The resource does not support this method")                \
    X("not-acceptable", 406, 0, 0,                                                                 \
      "The response is not available in a format that the client accepts")                         \
    X("upload-timeout", 408, 1, 0, "The upload was too slow")                                      \
    X("not-running", 409, 0, 0, "The job is not running")                                          \
    X("idempotency-in-flight", 409, 1, 0,                                                          \
      "Another request with this Idempotency-Key is in progress")                                  \
    X("job-expired", 410, 0, 0, "The results of the job have been deleted")                        \
    X("precondition-failed", 412, 0, 0, "The ETag does not match")                                 \
    X("range-not-satisfiable", 416, 0, 0, "The range is outside the result")                       \
    X("idempotency-key-reused", 422, 0, 0, "The Idempotency-Key belongs to another request")       \
    X("queue-full", 429, 1, 0, "The queue is full")                                                \
    X("rate-limited", 429, 1, 0, "The key starts jobs too fast")                                   \
    X("too-many-jobs", 429, 1, 0, "The key has too many jobs")                                     \
    X("too-much-stored", 429, 1, 0, "The key has too many bytes stored")                           \
    X("too-many-streams", 429, 1, 0, "Too many event streams are open")                            \
    X("too-many-conversions", 429, 1, 0, "Too many results are being converted")                   \
    X("client-closed", 499, 0, 0, "The client disconnected")                                       \
    X("storage-refused", 500, 0, 0, "The storage of files refuses the keys of the daemon")         \
    X("draining", 503, 1, 0, "The daemon is shutting down")                                        \
    X("not-alive", 503, 1, 0, "An HTTP thread is stuck")                                           \
    X("too-many-connections", 503, 1, 0, "Too many connections are open")                          \
    X("store-unavailable", 503, 1, 0,                                                              \
      "The database of jobs or the storage of files cannot be used")                               \
    X("storage-full", 507, 1, 0, "The disk is full")

/** One entry of a problem's errors[]: exactly one of pointer and parameter is set; detail may be
 *  NULL. */
struct vor_problem_error {
    const char *pointer, *parameter, *detail;
};

/** What to say; 0, NULL and (for byte_offset and queue_depth) -1 leave out. Strings are borrowed.
 *  Begin with VOR_PROBLEM(slug), or VOR_PROBLEM(slug, .detail = ...). */
struct vor_problem {
    const char *slug;
    const char *detail;
    const char *parameter;                  /**< the one at fault */
    const struct vor_problem_error *errors; /**< instead, if there are several */
    size_t error_count;
    const char *job_id;
    unsigned attempt; /**< of a job: the one that failed; 0 for none */
    bool is_of_job;   /**< part of what is told of it: without the identifier of this request */
    uint64_t limit, got;
    int64_t byte_offset, queue_depth;
    const char *allow;     /**< for the Allow header */
    const char *challenge; /**< for the WWW-Authenticate header */
    unsigned
        retry_seconds; /**< for Retry-After of one that is retryable; 0 for as long as always */
};

#define VOR_PROBLEM(...)                                                                           \
    ((struct vor_problem){.byte_offset = -1, .queue_depth = -1, .slug = __VA_ARGS__})

/** Replies with a problem. Returns VOR_NEXT_REPLY, so that a handler can return the call; it is 0,
 *  so that what is false after a problem has been replied can, too. */
_Static_assert(VOR_NEXT_REPLY == 0, "a problem that was replied is false");
enum vor_next vor_problem_reply(struct vor_request *request, const struct vor_problem *problem);

/** Replies with a problem of this slug and one sentence. */
enum vor_next vor_problem_say(struct vor_request *request, const char *slug, const char *format,
                              ...) VOR_PRINTF(3, 4);

/** Appends a problem as JSON: {"type","title","status","detail","instance","retryable",
 *  "requestId","jobID","attempt","limit","got","byteOffset","queueDepth",
 *  "errors":[{"pointer"|"parameter","detail"}]}. */
void vor_problem_write(const struct vor_request *request, const struct vor_problem *problem,
                       struct vor_text *text);

/** The problem of an error of the engine, a codec or the store, which is borrowed, as is job_id
 *  (may be NULL). */
void vor_problem_of_error(const struct vor_error *err, const char *job_id,
                          struct vor_problem *problem);

/** Replies with the problem of an error of the engine, a codec or the store. job_id may be NULL. */
enum vor_next vor_problem_error(struct vor_request *request, const struct vor_error *err,
                                const char *job_id);

/** The same where memory for a request is out. */
enum vor_next vor_problem_no_memory(struct vor_request *request);

/** What a request does that waits for another thread: waits on, or replies why that is in vain, as
 *  its client has left or the daemon goes down. */
enum vor_next vor_problem_or_wait(struct vor_request *request);

/** Replies with a document and frees it; one that could not be built becomes a problem. */
enum vor_next vor_app_reply(struct vor_request *request, int http, const char *media_type,
                            struct vor_text *text);

/** The same with JSON, which ends with a line feed. */
enum vor_next vor_reply_json(struct vor_request *request, int http, struct vor_text *text);

/** Begins a document that is a JSON object; replies 200 with one, once its members are there. */
void vor_document_begin(struct vor_text *text);
enum vor_next vor_document_reply(struct vor_request *request, struct vor_text *text);

/** The problem of a job that failed; row is borrowed. */
void vor_problem_of_job(const struct vor_job_view *row, struct vor_problem *problem);

#endif
