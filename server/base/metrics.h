/** What the daemon counts of itself, for /metrics: one table, numbers that any room may add to, and
 *  the text that Prometheus reads (exposition format 0.0.4).
 *
 *  Values of labels are words of our own tables (routes, processes, problems, formats): never a
 *  job, a caller or a tenant, of which there is no end. Thread-safe. Adding takes some 100 ns and
 *  no lock; the first use of a set of labels allocates. */
#ifndef VOR_SERVER_BASE_METRICS_H
#define VOR_SERVER_BASE_METRICS_H

#include "proto/text.h"

/** Metrics: identifier, name without "voronoid_", kind, unit that the name ends in before _total
 *  ("" for a count of things), labels in their order with blanks between, sentence. */
#define VOR_METRIC_TABLE(X)                                                                        \
    X(BUILD, "build_info", GAUGE, "", "version engine simd",                                       \
      "Always 1; which build this is: engine digests the engine's sources, simd is its vectors")   \
    X(HTTP_REQUESTS, "http_requests_total", COUNTER, "", "route method code",                      \
      "Requests that are over, with the status they were answered with (499: the caller left)")    \
    X(HTTP_SECONDS, "http_request_duration_seconds", TIMES, "seconds", "route",                    \
      "From the request line to the end of the answer; streams last as long as they are read")     \
    X(HTTP_IN_FLIGHT, "http_in_flight_requests", GAUGE, "", "", "Requests under way")              \
    X(HTTP_STUCK, "http_thread_busy_seconds", GAUGE, "seconds", "",                                \
      "How long a thread has been at one step of a request, the longest; 10 are an alarm")         \
    X(HTTP_BYTES_IN, "http_request_bytes_total", COUNTER, "bytes", "", "Bytes of bodies taken")    \
    X(HTTP_BYTES_OUT, "http_response_bytes_total", COUNTER, "bytes", "", "Bytes of bodies sent")   \
    X(REJECTED, "rejected_total", COUNTER, "", "reason",                                           \
      "Requests answered with a problem, by the last word of its type")                            \
    X(CONNECTIONS, "connections", GAUGE, "", "", "Open connections")                               \
    X(CONNECTIONS_MOST, "connections_limit", GAUGE, "", "",                                        \
      "Open connections from which on requests are refused")                                       \
    X(STREAMS, "sse_streams", GAUGE, "", "", "Event streams that are read")                        \
    X(STREAM_EVENTS, "sse_events_total", COUNTER, "", "", "Events sent on these")                  \
    X(STREAM_DROPPED, "sse_dropped_total", COUNTER, "", "",                                        \
      "Events of progress not sent, as a newer one came before the client took them")              \
    X(JOBS_ACCEPTED, "jobs_submitted_total", COUNTER, "", "process", "Jobs accepted")              \
    X(JOBS_ENDED, "jobs_finished_total", COUNTER, "", "process status", "Jobs that are over")      \
    X(JOBS_AGAIN, "job_retries_total", COUNTER, "", "reason",                                      \
      "Jobs put back into the queue: the daemon ended while they ran (restart), or their process " \
      "did (worker)")                                                                              \
    X(QUEUE, "queue_jobs", GAUGE, "", "state", "Jobs that wait, and that run")                     \
    X(QUEUE_MOST, "queue_limit_jobs", GAUGE, "", "", "Jobs that may wait")                         \
    X(QUEUE_AGE, "queue_oldest_age_seconds", GAUGE, "seconds", "",                                 \
      "How long the job that is next has waited; 0 when none waits")                               \
    X(QUEUE_WAIT, "job_queue_wait_seconds", TIMES, "seconds", "",                                  \
      "From the acceptance of a job to its first start")                                           \
    X(JOB_SECONDS, "job_duration_seconds", TIMES, "seconds", "process stage",                      \
      "Stages of runs that were successful; all: from the claim to the last row, of any run")      \
    X(JOB_POINTS, "job_points", SIZES, "", "direction", "Points of inputs and of results")         \
    X(JOB_ITERATIONS, "job_iterations", STEPS, "", "", "Iterations of runs that were successful")  \
    X(JOB_DELTA, "job_final_delta_ratio", RATIOS, "ratio", "",                                     \
      "Uniformity delta of results; lower is better")                                              \
    X(JOB_MEMORY, "job_memory_peak_bytes", BYTES, "bytes", "",                                     \
      "Most memory that a successful run held at a time")                                          \
    X(POINTS, "engine_points_processed_total", COUNTER, "", "",                                    \
      "Points of the inputs of successful runs")                                                   \
    X(WORKER_BUSY, "worker_busy", GAUGE, "", "", "Jobs that run")                                  \
    X(WORKER_SLOTS, "worker_slots", GAUGE, "", "", "Jobs that may run at the same time")           \
    X(WORKER_RESTARTS, "worker_restarts_total", COUNTER, "", "",                                   \
      "Processes of jobs that ended while they were not told to, or had to be ended")              \
    X(MEMORY_RESERVED, "memory_reserved_bytes", GAUGE, "bytes", "",                                \
      "Memory that running jobs may take")                                                         \
    X(UPLOADS, "uploads_active", GAUGE, "", "", "Uploads that arrive, wait to be read, or are")    \
    X(UPLOAD_BYTES, "upload_bytes_total", COUNTER, "bytes", "", "Bytes of uploads that arrived")   \
    X(DECODE_ERRORS, "decode_errors_total", COUNTER, "", "format reason",                          \
      "Uploads that could not be decoded")                                                         \
    X(STORAGE_FREE, "storage_available_bytes", GAUGE, "bytes", "",                                 \
      "Bytes that can still be written where blobs are")                                           \
    X(STORAGE_SIZE, "storage_size_bytes", GAUGE, "bytes", "", "Size of that file system")          \
    X(BLOB_BYTES, "blob_bytes", GAUGE, "bytes", "store",                                           \
      "Bytes of uploads and results that are kept; what jobs share counts for each")               \
    X(STORE_SECONDS, "store_operation_duration_seconds", TIMES, "seconds", "driver op",            \
      "Statements of the store, with the wait for their turn and for the disk")                    \
    X(STORE_ERRORS, "store_errors_total", COUNTER, "", "", "Statements of the store that failed")  \
    X(LOG_DROPPED, "log_lines_dropped_total", COUNTER, "", "",                                     \
      "Log lines lost because nobody read them")

enum vor_metric {
#define VOR_METRIC_ENUM(id, name, kind, unit, labels, sentence) VOR_METRIC_##id,
    VOR_METRIC_TABLE(VOR_METRIC_ENUM)
#undef VOR_METRIC_ENUM
        VOR_METRICS
};

/** Kinds: identifier, word of the format; a histogram's bounds are in metrics.c. */
#define VOR_METRIC_KIND_TABLE(X)                                                                   \
    X(COUNTER, "counter")                                                                          \
    X(GAUGE, "gauge")                                                                              \
    X(TIMES, "histogram")                                                                          \
    X(SIZES, "histogram")                                                                          \
    X(STEPS, "histogram")                                                                          \
    X(RATIOS, "histogram")                                                                         \
    X(BYTES, "histogram")

/** The values of a metric's labels, as many as its row names: VOR_LABELS("/v1/jobs", "GET", "200").
 *  A metric without labels takes NULL. Copied, up to VOR_LABEL_MAX - 1 bytes of each. */
#define VOR_LABELS(...) ((const char *const[]){__VA_ARGS__, NULL})
enum { VOR_LABEL_MAX = 64, VOR_LABELS_MAX = 3 };

/** Adds to a counter (by >= 0) or a gauge. */
void vor_metric_add(enum vor_metric metric, double by, const char *const *labels);

/** Sets a gauge, or a counter that is kept elsewhere. */
void vor_metric_set(enum vor_metric metric, double value, const char *const *labels);

/** Counts a value in a histogram. */
void vor_metric_observe(enum vor_metric metric, double value, const char *const *labels);

/** Appends every metric that was used, in the order of the table. Sets of labels come in no
 *  particular order. */
void vor_metrics_write(struct vor_text *text);

/** Forgets all values: for tests, while no other thread uses them. */
void vor_metrics_reset(void);

#endif
