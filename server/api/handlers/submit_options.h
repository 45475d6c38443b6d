/** What a request to start a job says besides the parameters of its process: a name for the job, a
 *  job whose input it wants again, and the key that makes one job of a request sent twice. */
#ifndef VOR_SERVER_API_HANDLERS_SUBMIT_OPTIONS_H
#define VOR_SERVER_API_HANDLERS_SUBMIT_OPTIONS_H

#include "server/api/app.h"
#include "server/work/admit.h"

struct vor_submit_options {
    char name[VOR_JOB_NAME_SIZE]; /**< "" for none */
    struct vor_uuid input;        /**< the job whose input it is; "" when the body has it */
    struct vor_job_key
        key; /**< text is "" for none; the fingerprint is vor_submit_options_find's */
};

/** Takes the pair name=value if it is one of these and no parameter of a process: name (1 to 200
 *  characters of UTF-8 without control characters) and input (job:ID).
 *
 *  @param[out] taken  0 when the pair is something else; *out is then untouched
 *
 *  @retval VOR_E_PARAM the value is wrong; the message says it and what it may be */
VOR_NODISCARD vor_status vor_submit_options_take(struct vor_submit_options *out, const char *name,
                                                 const char *value, int *taken,
                                                 struct vor_error *err);

/** Sets whose the job and its key are, and reads the header Idempotency-Key: 1 to 255 visible
 * characters of ASCII but the quote, the comma and the backslash, between quotes, as
 * draft-ietf-httpapi-idempotency-key-header-07 has it, or without.
 *
 *  @retval VOR_E_PARAM it is something else, or is given twice */
VOR_NODISCARD vor_status vor_submit_options_read_key(struct vor_submit_options *out,
                                                     const struct vor_request *request,
                                                     struct vor_error *err);

/** True for the names of such pairs. */
bool vor_submit_options_has(const char *name);

/** Opens the main input of the job that `input` names, as it came.
 *
 *  @return the bytes as a new upload, to be discarded by the caller; NULL after a problem has been
 *          replied: no-such-job, job-expired or input-not-kept */
struct vor_blob_writer *vor_submit_options_open(struct vor_app *app, struct vor_request *request,
                                                const struct vor_submit_options *options);

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
 *  @retval as vor_worker_find_key */
VOR_NODISCARD enum vor_job_outcome
vor_submit_options_find(struct vor_submit_options *options, const struct vor_app *app,
                        const struct vor_spec *spec, const struct vor_submit_inputs *inputs,
                        struct vor_job_view *out, struct vor_error *err);

#endif
