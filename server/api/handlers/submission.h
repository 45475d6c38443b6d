/** A request to start a job, from its head to its inputs: whether its body is a cloud, a form or
 *  JSON, submit.c takes it the same way. */
#ifndef VOR_SERVER_API_HANDLERS_SUBMISSION_H
#define VOR_SERVER_API_HANDLERS_SUBMISSION_H

#include "server/api/app.h"
#include "server/work/admit.h"

#include <stdbool.h>

/* --- submit_options.c ------------------------------------------------------------------------- */

/** What a request says besides the parameters of its process: a name for the job, a job whose input
 * it wants again, one whose result it goes on from, and the key that makes one job of a request
 * sent twice. */
struct vor_submit_options {
    char name[VOR_JOB_NAME_SIZE]; /**< "" for none */
    struct vor_uuid input;        /**< the job whose input it is; "" when the body has it */
    struct vor_uuid previous;     /**< the job whose result it is; "" when there is none, or a form
                                       has it */
    struct vor_job_key
        key; /**< text is "" for none; the fingerprint is vor_submit_options_find's */
};

/** Takes the pair name=value if it is one of these and no parameter of a process: name (1 to 200
 *  characters of UTF-8 without control characters), input and, if the process has an input of that
 *  name, previous (job:ID both).
 *
 *  @param[out] taken  0 when the pair is something else; *out is then untouched
 *
 *  @retval VOR_E_PARAM the value is wrong; the message says it and what it may be */
VOR_NODISCARD vor_status vor_submit_options_take(struct vor_submit_options *out,
                                                 const struct vor_process_info *process,
                                                 const char *name, const char *value, int *taken,
                                                 struct vor_error *err);

/** Sets whose the job and its key are, and reads the header Idempotency-Key: 1 to 255 visible
 * characters of ASCII but the quote, the comma and the backslash, between quotes, as
 * draft-ietf-httpapi-idempotency-key-header-07 has it, or without.
 *
 *  @retval VOR_E_PARAM it is something else, or is given twice */
VOR_NODISCARD vor_status vor_submit_options_read_key(struct vor_submit_options *out,
                                                     const struct vor_request *request,
                                                     struct vor_error *err);

/** True for the names of such pairs of a process. */
bool vor_submit_options_has(const struct vor_process_info *process, const char *name);

/** Adds the inputs that are other jobs' as uploads: the main input of the job that `input` names,
 *  as it came, and the cloud that is the result of the one that `previous` names.
 *
 *  @param[in]  uploads  NULL: whether the jobs are such is all that is looked for
 *  @param[out] next     what the handler returns after false: a problem has been replied
 * (no-such-job, job-expired, input-not-kept, those of vor_result_missing), or the request waits for
 * files that come from another machine, and asks again once woken */
bool vor_submit_options_open(struct vor_request *request, const struct vor_submit_options *options,
                             const struct vor_process_info *process, struct vor_uploads *uploads,
                             enum vor_next *next);

/** The inputs of a request, by the SHA-256 of their bytes. */
struct vor_submit_inputs {
    unsigned count;
    struct {
        const char *name; /**< borrowed */
        char sha256[VOR_DIGEST_SIZE];
    } item[VOR_INPUTS_MAX];
};

/** Those that came, as they came. */
void vor_submit_inputs_of_uploads(struct vor_submit_inputs *out, const struct vor_uploads *uploads);

/** Those that were admitted, as they are once inflated. */
void vor_submit_inputs_of_admitted(struct vor_submit_inputs *out,
                                   const struct vor_admitted *admitted);

/** Sets the fingerprint of the key and finds its job. The fingerprint is the SHA-256 of process,
 *  parameters as JSON in the order of their table, the job's name, and the digests of the inputs.
 *  Where one came as gzip they must be those of what was admitted, so that the same request without
 *  gzip is the same.
 *
 *  @retval as vor_job_service_find_key */
VOR_NODISCARD enum vor_job_outcome
vor_submit_options_find(struct vor_submit_options *options, const struct vor_app *app,
                        const struct vor_spec *spec, const struct vor_submit_inputs *inputs,
                        struct vor_job_view *out, struct vor_error *err);

/* --- submit_head.c ---------------------------------------------------------------------------- */

enum vor_submit_mode {
    VOR_SUBMIT_SYNC,  /**< wait for the result */
    VOR_SUBMIT_ASYNC, /**< 201 as soon as the job is accepted */
    VOR_SUBMIT_STREAM /**< the job as an event stream */
};

/** A body is a cloud unless it says otherwise: curl calls what it sends a form of the other kind
 *  (application/x-www-form-urlencoded), so only what cannot be a cloud counts. */
enum vor_submit_body {
    VOR_SUBMIT_CLOUD, /**< the main input, or nothing where that of another job is named */
    VOR_SUBMIT_FORM,  /**< multipart/form-data: texts are parameters, files are inputs by name */
    VOR_SUBMIT_JSON   /**< refused: a cloud does not come that way */
};

struct vor_submit_head {
    struct vor_spec spec; /**< checked (vor_spec_check) once complete */
    struct vor_submit_options options;
    enum vor_submit_body body;
    bool is_gzip; /**< of a cloud: Content-Encoding */
    enum vor_submit_mode mode;
    double wait_seconds; /**< SYNC: then 201 after all; negative: for as long as it takes */
    bool is_async;       /**< respond-async was asked for (perhaps with wait) */
};

/** Reads the part of a head that says what is asked for: the process, the body, parameters, options
 *  and a key. Of one whose body is JSON nothing but the process is read.
 *
 *  @return true, or false after a problem has been replied, as below */
bool vor_submit_read_spec(struct vor_request *request, struct vor_submit_head *out);

/** Reads a head; it is complete, but for that of a form, whose parameters are still to come, and of
 *  a body of JSON.
 *
 *  @return true, or false after a problem has been replied: no-such-process, a coding that is not
 *          taken, a parameter unknown, given twice or out of range, a key that is none, no
 *          acceptable format */
bool vor_submit_read(struct vor_request *request, struct vor_submit_head *out);

/** Completes a head whose parameters are all set, and chooses the format.
 *
 *  @return true, or false after a problem has been replied, as above */
bool vor_submit_complete(struct vor_request *request, struct vor_submit_head *head);

/** Whether one coding (a token, not a list) says gzip.
 *
 *  @retval 1 gzip, 0 "" or identity, -1 something else */
int vor_submit_coding(const char *coding);

/** Whether there is room for a job and its inputs, and for a stream if the head asks for one.
 *
 *  @return true, or false after a problem has been replied */
bool vor_submit_has_room(struct vor_request *request, const struct vor_submit_head *head);

/* --- submit_form.c ---------------------------------------------------------------------------- */

/** A form on its way in. */
struct vor_submit_form;

/** Begins with the Content-Type of the request.
 *
 *  @param[in,out] head     gets the parameters; outlives the form, as do the next
 *  @param[in,out] uploads  none yet; gets the files, those of a form that is refused as well
 *
 *  @return NULL after a problem has been replied */
struct vor_submit_form *vor_submit_form_begin(struct vor_request *request,
                                              struct vor_submit_head *head,
                                              struct vor_uploads *uploads);

/** form may be NULL. */
void vor_submit_form_free(struct vor_submit_form *form);

/** Takes the next bytes: a body sink's write (server/http/http.h), whose ctx is the form. A form
 *  that is refused is read on for a while, so that its sender can read the refusal, then cut off
 *  with it. */
int vor_submit_form_take(void *form, const void *bytes, size_t size);

/** The body is over: checks that the form is whole, and that the process has the inputs it needs.
 *
 *  @return true, or false after a problem has been replied */
bool vor_submit_form_end(struct vor_submit_form *form);

/* --- submit_json.c ---------------------------------------------------------------------------- */

/** Refuses a body of JSON, as clients of OGC API - Processes send it. Parameters in it are named,
 *  each with the place where it stands and the query that it belongs into (invalid-parameter); a
 *  body without any is no format that is read (unsupported-format), and one that is no JSON
 *  malformed-request. */
void vor_submit_json_refuse(struct vor_request *request, const struct vor_process_info *process,
                            const struct vor_text *body);

#endif
