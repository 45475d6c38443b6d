/** JSON: writing text, reading strangers' text, and the values this product speaks. The only door
 * to cJSON, which only reads; what is written here is written by ourselves. */
#ifndef VOR_PROTO_JSON_H
#define VOR_PROTO_JSON_H

#include "core/base/status.h"
#include "core/report.h"
#include "core/spec.h"

#include <stddef.h>
#include <stdint.h>

/** Text that grows up to a cap. A failure sticks: what is added after it is dropped, so that a
 *  writer is checked once, at its end. Not thread-safe. */
struct vor_text {
    char *data;  /**< size bytes and a NUL after them; NULL as long as nothing was added */
    size_t size; /**< without the NUL */
    size_t capacity;
    size_t cap; /**< most bytes, without the NUL */
    int comma;  /**< the writer's: a value stands before the next one */
    int failed; /**< out of memory, or beyond the cap */
};

#define VOR_TEXT_CAP_DEFAULT ((size_t)64 << 20)

/** An empty text of at most cap bytes; 0 is VOR_TEXT_CAP_DEFAULT. No clean-up until it grows. */
void vor_text_init(struct vor_text *text, size_t cap);

/** Frees the bytes and leaves the text empty, with its cap. */
void vor_text_free(struct vor_text *text);

/** Empties the text but keeps its memory; forgets a failure. */
void vor_text_clear(struct vor_text *text);

/** Appends bytes as they are, and starts a new JSON document behind them. */
void vor_text_add(struct vor_text *text, const void *bytes, size_t size);
void vor_text_puts(struct vor_text *text, const char *string);
void vor_text_printf(struct vor_text *text, const char *format, ...) VOR_PRINTF(2, 3);

/** @retval VOR_E_NOMEM something was dropped: no memory, or beyond the cap */
VOR_NODISCARD vor_status vor_text_status(const struct vor_text *text, struct vor_error *err);

/** The streaming writer: values in the order in which they stand. Commas are put in; that keys and
 *  values alternate and brackets match is the caller's duty.
 *
 *  Strings may hold any bytes: control characters (C0, DEL) are escaped, what is not UTF-8 becomes
 *  U+FFFD, so the text is valid JSON whatever comes in. A NULL string is null. Doubles are written
 *  with the fewest of 15, 16 or 17 digits that read back as the same value; NaN and infinities are
 *  null. Nothing depends on the locale. */
void vor_json_begin_object(struct vor_text *text);
void vor_json_end_object(struct vor_text *text);
void vor_json_begin_array(struct vor_text *text);
void vor_json_end_array(struct vor_text *text);
void vor_json_key(struct vor_text *text, const char *key);
void vor_json_string(struct vor_text *text, const char *value);
void vor_json_bytes(struct vor_text *text, const char *value, size_t size);
void vor_json_double(struct vor_text *text, double value);
void vor_json_u64(struct vor_text *text, uint64_t value);
void vor_json_i64(struct vor_text *text, int64_t value);
void vor_json_bool(struct vor_text *text, int value);
void vor_json_null(struct vor_text *text);

/** A value that is JSON already: size bytes, valid by the caller's word. */
void vor_json_raw(struct vor_text *text, const char *json, size_t size);

/** Key and value in one call. */
void vor_json_put_string(struct vor_text *text, const char *key, const char *value);
void vor_json_put_double(struct vor_text *text, const char *key, double value);
void vor_json_put_u64(struct vor_text *text, const char *key, uint64_t value);
void vor_json_put_i64(struct vor_text *text, const char *key, int64_t value);
void vor_json_put_bool(struct vor_text *text, const char *key, int value);

/** The shortest of "%.15g", "%.16g", "%.17g" that reads back as value (which must be finite), with
 *  a point whatever the locale. out has room for VOR_JSON_NUMBER_MAX. Returns its length. */
#define VOR_JSON_NUMBER_MAX 32
size_t vor_json_format_double(char out[VOR_JSON_NUMBER_MAX], double value);

/** What a text must keep to before cJSON sees it. */
#define VOR_JSON_SIZE_MAX ((size_t)1 << 20)
#define VOR_JSON_DEPTH_MAX 32
#define VOR_JSON_TOKENS_MAX 20000 /**< values, keys and opening brackets */
#define VOR_JSON_NUMBER_LENGTH_MAX 63

/** A value read. The one vor_json_parse yields owns all others and their strings. */
struct vor_json;

enum vor_json_kind {
    VOR_JSON_NULL,
    VOR_JSON_BOOL,
    VOR_JSON_NUMBER,
    VOR_JSON_STRING,
    VOR_JSON_ARRAY,
    VOR_JSON_OBJECT
};

/** Checks a text without reading it: RFC 8259 to the letter, within the limits above, valid UTF-8,
 *  no NUL and no \u0000, numbers that fit a double, and nothing after the value. Does not look for
 *  duplicate keys.
 *
 *  @retval VOR_E_REQUEST byte_offset says where and the message why; limit and got are set when a
 *                        limit was exceeded
 *
 *  O(size) time, no memory. */
VOR_NODISCARD vor_status vor_json_scan(const char *bytes, size_t size, struct vor_error *err);

/** Reads a stranger's text: vor_json_scan, then cJSON, then no two members of an object with the
 *  same name. bytes need no NUL at the end.
 *
 *  @param[out] out to be freed with vor_json_free; NULL on failure
 *  @retval VOR_E_REQUEST as vor_json_scan; a duplicate key (byte_offset of the second one)
 *  @retval VOR_E_NOMEM
 *
 *  O(size log size) time, under 4 MiB of memory. */
VOR_NODISCARD vor_status vor_json_parse(struct vor_json **out, const char *bytes, size_t size,
                                        struct vor_error *err);
void vor_json_free(struct vor_json *json);

enum vor_json_kind vor_json_kind(const struct vor_json *value);

/** "null", "a boolean", "a number", "a string", "an array", "an object": for messages. */
const char *vor_json_kind_word(const struct vor_json *value);

/** Getters. value may be NULL, so that they chain. Names are compared byte for byte. */

/** Member of an object; NULL when there is none or value is no object. */
const struct vor_json *vor_json_get(const struct vor_json *value, const char *name);

/** The string's text, without NUL inside; NULL when value is no string. */
const char *vor_json_get_string(const struct vor_json *value);

/** True and *out set when value is a number, or a boolean (0, 1). *out is finite. */
int vor_json_get_number(const struct vor_json *value, double *out);
int vor_json_get_bool(const struct vor_json *value, int *out);

/** First element or member of an array or object, the one after it, and a member's name; NULL past
 *  the last. Cost: O(1) each. */
const struct vor_json *vor_json_first(const struct vor_json *value);
const struct vor_json *vor_json_next(const struct vor_json *element);
const char *vor_json_name(const struct vor_json *member);

/** Elements or members. O(their number). */
size_t vor_json_count(const struct vor_json *value);

/** Writes a value that was read, in one line. */
void vor_json_copy(struct vor_text *text, const struct vor_json *value);

/** The one progress record of SSE, NDJSON and trace: {"iteration","polish","delta","sigma",
 *  "epsilon","energy","max_move","held","seconds"}. The second form writes the members into an open
 *  object. */
void vor_json_record(struct vor_text *text, const struct vor_record *record);
void vor_json_record_members(struct vor_text *text, const struct vor_record *record);

/** Reads a record out of an object that may hold more; what is missing or no number is 0. False
 *  when there is no iteration. */
int vor_json_record_read(struct vor_record *out, const struct vor_json *object);

/** The report of a run: points {in, out}, delta, sigma, epsilon, iterations, polish_steps, stopped,
 * seconds {read, index, init, iterate, polish, write}, memory_peak_bytes, outliers, lattice
 * {x, y, z, moved}, in_to_out and out_to_in {mean, rms, max, points}, boundary_points,
 * neighbors_histogram [{neighbors, points}], held, held_ever, fallbacks {plane, left}, area,
 * spacing, min_over_mean, max_over_mean, six_share, bisectors_per_cell, triangles_per_cell,
 * queries, list_rebuilds, parameters. The steps done have a name of their own, because "polish"
 * among the parameters is how many were allowed. */
void vor_json_report(struct vor_text *text, const struct vor_report *report);

/** A measure: n, delta, sigma, epsilon, mean_nn, min_over_mean, max_over_mean, coincident and, with
 *  a reference, "input" {far_over_knn6_mean, far_over_knn6_p999, out_to_ref_mean, out_to_ref_rms,
 *  out_to_ref_max, ref_to_out_mean, ref_to_out_rms, ref_to_out_max, hausdorff, chamfer, d1_mse,
 *  d1_psnr, d2_mse, d2_psnr, peak}. An infinite psnr is null. */
void vor_json_measure(struct vor_text *text, const struct vor_measure *measure);

/** A request as an object: numbers as numbers, choices and auto as strings, unset ones left out. */
void vor_json_spec(struct vor_text *text, const struct vor_spec *spec);

/** Sets what an object's members name; the others keep what spec has.
 *
 *  @param[in,out] spec     unchanged on failure
 *  @param[out]    pointer  JSON pointer to the member at fault below object, "" on success or when
 *                          object itself is at fault; cut at its size
 *  @retval VOR_E_PARAM object is no object, a member is unknown (parameter names it), of the wrong
 *                      type or out of range. vor_spec_check is the caller's to call. */
#define VOR_JSON_POINTER_MAX 80
VOR_NODISCARD vor_status vor_json_spec_read(struct vor_spec *spec, const struct vor_json *object,
                                            char pointer[VOR_JSON_POINTER_MAX],
                                            struct vor_error *err);

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
void vor_json_links(struct vor_text *text, const struct vor_link *links, size_t count);

/** A job as the service shows it (OGC API - Processes statusInfo, both drafts, with our own members
 *  under "voronoid"). Strings are borrowed; begin with VOR_STATUS_INFO_INIT. */
struct vor_status_info {
    const char *job_id;     /**< written as jobID and as id */
    const char *process_id; /**< "resample" */
    const char *status;     /**< accepted, running, successful, failed, dismissed */
    const char *message;    /**< NULL: left out */
    int progress;           /**< 0 .. 100; -1: left out */
    const char *created, *started, *updated, *finished; /**< RFC 3339; NULL or "": left out */

    unsigned attempt;         /**< 0 before the first */
    const char *stage;        /**< NULL: null */
    int64_t queue_position;   /**< -1: null */
    double eta;               /**< seconds; negative: null */
    const char *input_format; /**< NULL: no input member */
    uint64_t input_points, input_bytes;
    const char *input_sha256;                /**< hex; NULL: left out */
    uint64_t target_points;                  /**< 0: left out (not known before the area is) */
    const char *target_format;               /**< NULL: left out */
    const struct vor_record *metrics;        /**< NULL: null */
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

/** A process: the summary of a list, or the whole description with inputs from the parameter table
 *  and outputs cloud and report. Links as vor_json_links. */
void vor_json_process_summary(struct vor_text *text, const struct vor_process_info *process,
                              const struct vor_link *links, size_t link_count);
void vor_json_process(struct vor_text *text, const struct vor_process_info *process,
                      const struct vor_link *links, size_t link_count);

#endif
