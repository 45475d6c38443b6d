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
      "Always 1. The labels identify the build: the label engine is a digest of the source code "  \
      "of the computation, and the label simd says which vector instructions are used")            \
    X(HTTP_REQUESTS, "http_requests_total", COUNTER, "", "route method code",                      \
      "Requests that have ended, by status of the response (499: the client disconnected)")        \
    X(HTTP_SECONDS, "http_request_duration_seconds", TIMES, "seconds", "route",                    \
      "Time from the request line to the end of the response. The response of an event stream "    \
      "ends when the stream closes")                                                               \
    X(HTTP_IN_FLIGHT, "http_in_flight_requests", GAUGE, "", "", "Requests in progress")            \
    X(HTTP_STUCK, "http_thread_busy_seconds", GAUGE, "seconds", "",                                \
      "Longest time that an HTTP thread has spent on its current step of a request. Set an "       \
      "alert for values above 10")                                                                 \
    X(HTTP_BYTES_IN, "http_request_bytes_total", COUNTER, "bytes", "",                             \
      "Bytes of request bodies received")                                                          \
    X(HTTP_BYTES_OUT, "http_response_bytes_total", COUNTER, "bytes", "",                           \
      "Number of bytes sent in response bodies")                                                   \
    X(REJECTED, "rejected_total", COUNTER, "", "reason",                                           \
      "Error responses, by type of the problem (the last part of its URL)")                        \
    X(CONNECTIONS, "connections", GAUGE, "", "", "Open connections")                               \
    X(CONNECTIONS_MOST, "connections_limit", GAUGE, "", "",                                        \
      "Number of open connections above which new requests are refused")                           \
    X(STREAMS, "sse_streams", GAUGE, "", "", "Open event streams")                                 \
    X(STREAM_EVENTS, "sse_events_total", COUNTER, "", "", "Events sent on event streams")          \
    X(STREAM_DROPPED, "sse_dropped_total", COUNTER, "", "",                                        \
      "Progress events that were not sent, because the client was slow and a newer event "         \
      "replaced them")                                                                             \
    X(JOBS_ACCEPTED, "jobs_submitted_total", COUNTER, "", "process", "Jobs accepted")              \
    X(JOBS_ENDED, "jobs_finished_total", COUNTER, "", "process status", "Jobs that have ended")    \
    X(JOBS_AGAIN, "job_retries_total", COUNTER, "", "reason",                                      \
      "Running jobs that returned to the queue, because the daemon ended (reason restart), the "   \
      "worker process ended (reason worker), or the lease of another daemon ended (reason lease)") \
    X(QUEUE, "queue_jobs", GAUGE, "", "state", "Waiting and running jobs")                         \
    X(QUEUE_MOST, "queue_limit_jobs", GAUGE, "", "", "Largest number of waiting jobs")             \
    X(QUEUE_AGE, "queue_oldest_age_seconds", GAUGE, "seconds", "",                                 \
      "Time that the next job in the queue has waited (0 if no job waits)")                        \
    X(QUEUE_WAIT, "job_queue_wait_seconds", TIMES, "seconds", "",                                  \
      "Time from the acceptance of a job to its first start")                                      \
    X(JOB_SECONDS, "job_duration_seconds", TIMES, "seconds", "process stage",                      \
      "Time of each stage of successful runs. With the label stage=all: time of every run, "       \
      "successful or failed, from its start to the last write")                                    \
    X(JOB_POINTS, "job_points", SIZES, "", "direction", "Points of inputs and of results")         \
    X(JOB_ITERATIONS, "job_iterations", STEPS, "", "", "Iterations of successful runs")            \
    X(JOB_DELTA, "job_final_delta_ratio", RATIOS, "ratio", "",                                     \
      "delta of results: standard deviation of the distances to the nearest neighbour, divided "   \
      "by their mean")                                                                             \
    X(JOB_MEMORY, "job_memory_peak_bytes", BYTES, "bytes", "", "Peak memory of a successful run")  \
    X(POINTS, "engine_points_processed_total", COUNTER, "", "",                                    \
      "Points of the inputs of successful runs")                                                   \
    X(WORKER_BUSY, "worker_busy", GAUGE, "", "", "Running jobs")                                   \
    X(WORKER_SLOTS, "worker_slots", GAUGE, "", "", "Jobs that may run at the same time (--jobs)")  \
    X(WORKER_RESTARTS, "worker_restarts_total", COUNTER, "", "",                                   \
      "Processes that worked on a job and ended unexpectedly or were killed")                      \
    X(MEMORY_RESERVED, "memory_reserved_bytes", GAUGE, "bytes", "",                                \
      "Sum of the memory limits of running jobs")                                                  \
    X(UPLOADS, "uploads_active", GAUGE, "", "",                                                    \
      "Uploads that are arriving, waiting to be decoded or being decoded")                         \
    X(UPLOAD_BYTES, "upload_bytes_total", COUNTER, "bytes", "", "Bytes of uploads received")       \
    X(DECODE_ERRORS, "decode_errors_total", COUNTER, "", "format reason",                          \
      "Uploads that could not be decoded")                                                         \
    X(STORAGE_FREE, "storage_available_bytes", GAUGE, "bytes", "",                                 \
      "Free bytes on the file system of --blobs")                                                  \
    X(STORAGE_SIZE, "storage_size_bytes", GAUGE, "bytes", "",                                      \
      "Size of the file system of --blobs")                                                        \
    X(BLOB_BYTES, "blob_bytes", GAUGE, "bytes", "store",                                           \
      "Bytes of stored uploads and results. A file that several jobs share counts once for each "  \
      "of these jobs")                                                                             \
    X(STORE_SECONDS, "store_operation_duration_seconds", TIMES, "seconds", "driver op",            \
      "Time that statements of the job database take, including waits for the database lock and "  \
      "for the disk")                                                                              \
    X(STORE_ERRORS, "store_errors_total", COUNTER, "", "",                                         \
      "SQL statements that failed in the job database")                                            \
    X(STORE_HINTS, "store_hints_total", COUNTER, "", "direction",                                  \
      "With --store-listen: hints that jobs have changed. direction=sent: to the other daemons; "  \
      "direction=received: from them, after which this daemon looked for the changes")             \
    X(BLOB_SECONDS, "blob_operation_duration_seconds", TIMES, "seconds", "driver op",              \
      "Duration of each attempt at a request to S3, or to PostgreSQL for a file")                  \
    X(BLOB_RETRIES, "blob_retries_total", COUNTER, "", "",                                         \
      "Requests to S3, or to PostgreSQL for files, that were sent again")                          \
    X(BLOB_ERRORS, "blob_errors_total", COUNTER, "", "reason",                                     \
      "Requests to S3, or to PostgreSQL for files, that failed after all tries. Values of the "    \
      "label reason: away (no answer), refused (wrong keys or rights, no such bucket or table), "  \
      "damaged (bytes that are not those that were written) and other (any other error)")          \
    X(STORAGE_UP, "storage_up", GAUGE, "", "part",                                                 \
      "1 while the job database (label part=store) and the storage of files (label part=blobs) "   \
      "can be reached, else 0")                                                                    \
    X(LOG_DROPPED, "log_lines_dropped_total", COUNTER, "", "",                                     \
      "Log lines dropped because their reader was too slow")

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

#endif
