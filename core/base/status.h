/** Status codes, and the one function that every failure passes through. */
#ifndef VOR_BASE_STATUS_H
#define VOR_BASE_STATUS_H

#include <stdint.h>

#define VOR_NODISCARD __attribute__((warn_unused_result))
#define VOR_PRINTF(at, first) __attribute__((format(printf, at, first)))
#define VOR_UNUSED __attribute__((unused)) /* before a parameter that a callback must have */

/** Assigns the call to status if nothing has failed yet, else does not call: one of several steps.
 */
#define VOR_THEN(status, call)                                                                     \
    do {                                                                                           \
        if ((status) == VOR_OK)                                                                    \
            (status) = (call);                                                                     \
    } while (0)

/** Every way the engine and the codecs can fail: name, HTTP status, problem slug, whether the same
 *  call may succeed later, sentence. The server's problems and the command line's exit codes are
 *  read off this table. */
#define VOR_STATUS_TABLE(X)                                                                        \
    X(OK, 200, "ok", 0, "Done")                                                                    \
    X(E_PARAM, 400, "invalid-parameter", 0, "A parameter is invalid")                              \
    X(E_WORD, 422, "unknown-word", 0, "A list has an unknown word")                                \
    X(E_REQUEST, 400, "malformed-request", 0, "The request cannot be read")                        \
    X(E_LIMIT, 413, "too-many-points", 0, "The cloud exceeds a limit")                             \
    X(E_BYTES, 413, "too-many-bytes", 0, "The body exceeds a limit")                               \
    X(E_NOMEM, 413, "too-much-memory", 0, "The job needs more memory than is allowed")             \
    X(E_UNSUPPORTED, 415, "unsupported-format", 0, "The format of the data is not supported")      \
    X(E_FORMAT, 422, "undecodable-cloud", 0, "The cloud cannot be decoded")                        \
    X(E_EMPTY, 422, "empty-cloud", 0, "The cloud has no points")                                   \
    X(E_NONFINITE, 422, "non-finite-points", 0, "A coordinate is not a finite number")             \
    X(E_DEGENERATE, 422, "degenerate-cloud", 0, "The cloud has no surface to resample")            \
    X(E_NORMALS, 422, "unusable-normals", 0, "The normals of the cloud cannot be used")            \
    X(E_FACES, 422, "unusable-faces", 0, "The faces of the cloud cannot be used")                  \
    X(E_SPLATS, 422, "gaussian-splats", 0, "The cloud is a 3D Gaussian splat")                     \
    X(E_HOLES, 422, "unknown-hole", 0, "The cloud has no hole with the requested number")          \
    X(E_DENSITY, 422, "unusable-density", 0,                                                       \
      "The requested density cannot be computed from the input")                                   \
    X(E_METRIC, 422, "unusable-metric", 0, "The requested attribute cannot be used as a metric")   \
    X(E_TARGET, 422, "target-out-of-range", 0, "The requested number of points is out of range")   \
    X(E_ORIGIN, 422, "frame-too-coarse", 0, "float32 is too coarse for the requested origin")      \
    X(E_WORK, 422, "too-much-work", 0, "The job would take far longer than is allowed")            \
    X(E_CANCELLED, 499, "cancelled", 0, "The caller cancelled the run")                            \
    X(E_STOPPED, 499, "stopped", 0, "The caller stopped the run")                                  \
    X(E_DEADLINE, 500, "job-deadline-exceeded", 0, "The job ran longer than is allowed")           \
    X(E_IO, 500, "io-error", 1, "Reading or writing failed")                                       \
    X(E_DAMAGED, 500, "damaged-bytes", 0, "Stored bytes are damaged")                              \
    X(E_INTERNAL, 500, "engine-error", 0, "The computation failed")

typedef enum vor_status {
#define VOR_STATUS_ENUM(name, http, slug, retryable, sentence) VOR_##name,
    VOR_STATUS_TABLE(VOR_STATUS_ENUM)
#undef VOR_STATUS_ENUM
        VOR_STATUS_COUNT
} vor_status;

/** What went wrong, for a person and for a program. */
struct vor_error {
    vor_status status;
    char parameter[32];  /**< name of the offending parameter, or "" */
    char message[1024];  /**< one sentence with the value and the allowed range, no newline; holds
                              whatever the tables of requests can say (core/spec.c) */
    int64_t byte_offset; /**< where in the input, or -1 */
    uint64_t limit, got; /**< E_LIMIT, E_BYTES, and of a job E_NOMEM, E_WORK (seconds): the
                              limit and what was declared or is estimated; else 0 */
};

/** HTTP status and problem slug of a row of the table; status must be one. */
int vor_status_http(vor_status status);
const char *vor_status_slug(vor_status status);

/** Fills *err (which may be NULL) and returns status: every failure passes through here. Sets
 *  parameter to "", byte_offset to -1, limit and got to 0. */
vor_status vor_fail(struct vor_error *err, vor_status status, const char *format, ...)
    VOR_PRINTF(3, 4);

/** vor_fail that also names the parameter at fault. */
vor_status vor_fail_param(struct vor_error *err, vor_status status, const char *parameter,
                          const char *format, ...) VOR_PRINTF(4, 5);

/** Adds to a failure which limit was exceeded, and by what; returns status. */
vor_status vor_fail_over(struct vor_error *err, vor_status status, uint64_t limit, uint64_t got);

/** Adds to a failure where in the bytes it is; returns status. */
vor_status vor_fail_at(struct vor_error *err, vor_status status, uint64_t offset);

#endif
