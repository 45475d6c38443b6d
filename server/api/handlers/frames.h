/** The frames of a sequence in one request, from the bytes that arrive to the jobs that they become
 *  (sequence.c). All on the thread of the request, but where admission works for it. */
#ifndef VOR_SERVER_API_HANDLERS_FRAMES_H
#define VOR_SERVER_API_HANDLERS_FRAMES_H

#include "proto/multipart.h"
#include "proto/tar.h"
#include "server/api/handlers/submission.h"
#include "server/http/deferred.h"
#include "server/work/fetch.h"

/** Frames on their way at a time, that do not depend on each other. */
enum { VOR_FLIGHTS = 4 };

/** Suffix of what is told of a frame. */
#define VOR_TOLD_SUFFIX ".json"

struct vor_frame {
    char name[VOR_TAR_BASE_MAX + 1]; /* of its file */
    size_t stem;                     /* bytes of it without the suffix */
    uint64_t offset, size;           /* of its bytes, in the body */
    bool is_accepted;                /* told has the statusInfo of its job, as it was then */
    bool is_over;
    struct vor_text told; /* then: the statusInfo of its job, or why there is none */
    struct vor_uuid id;   /* then: of the job that has its result; "" for none */
    uint32_t attempt;     /* that wrote it */
    unsigned format;      /* of that */
};

/* A frame on its way. */
struct vor_flight {
    struct vor_sequence *sequence; /* NULL: none */
    size_t frame;
    char name[VOR_TAR_BASE_MAX + 1];
    atomic_bool is_admitted; /* or refused: what follows up to view is the request's again */
    struct vor_admission admission;
    enum vor_job_outcome outcome;
    struct vor_error error;
    struct vor_job_view view; /* of its job */
    bool is_followed;         /* to the end of the job; NULL: it is over */
    struct vor_job *job;
    struct vor_subscriber subscriber;
};

struct vor_sequence {
    struct vor_deferred deferred; /* first; held by each flight that is being admitted */
    struct vor_app *app;
    struct vor_request *request;
    struct vor_submit_head head;
    struct vor_quota quota; /* of the key */
    struct vor_span span;
    struct vor_fairness_key caller;
    bool is_linked;       /* each frame starts from the last result */
    struct vor_uuid last; /* whose result that is; "" for none */
    uint32_t last_attempt;
    struct vor_uploads body; /* one: all files that came, one after the other, or the archive */
    union {
        struct vor_tar tar;
        struct vor_multipart form;
    } scanner;
    struct vor_error error; /* of a body that is refused; else its status is VOR_OK */
    uint64_t wasted;        /* bytes since then */
    struct vor_frame *frames;
    size_t count, capacity;
    bool is_open;   /* the last frame is not whole yet */
    bool is_passed; /* the file at hand is none */
    size_t begun;   /* frames that were */
    struct vor_flight flights[VOR_FLIGHTS];
    bool is_events; /* the reply tells of the frames, and has no results */
    bool is_early;  /* the reply begins before the body is in */
    bool is_stream; /* it is on its way */
    double sent_at; /* the last event */
    size_t sent;    /* frames */
    bool is_closed; /* the end of the archive is written */
    struct vor_text text;
    size_t taken; /* of it */
    int fd;       /* of the result that follows it; -1 for none */
    uint64_t at, size;
};

/* --- sequence_body.c -------------------------------------------------------------------------- */

/** Begins with the body, whose file is there.
 *
 *  @retval VOR_E_REQUEST  as vor_multipart_begin */
VOR_NODISCARD vor_status vor_sequence_begin_body(struct vor_sequence *sequence,
                                                 struct vor_error *err);

/** Takes the next bytes, or learns that there are no more; the frames are those that came.
 *
 *  @retval VOR_E_REQUEST  the body is damaged, or a name or the number of frames is refused
 *  @retval VOR_E_PARAM    a part of a form is no file
 *  @retval VOR_E_EMPTY    there is no frame
 *  @retval VOR_E_IO, VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_sequence_feed(struct vor_sequence *sequence, const void *bytes,
                                           size_t size, struct vor_error *err);
VOR_NODISCARD vor_status vor_sequence_finish(const struct vor_sequence *sequence,
                                             struct vor_error *err);

/* --- sequence_jobs.c -------------------------------------------------------------------------- */

/** Goes on with every frame as far as that is possible now. Wakes the request when there is more to
 *  do. */
void vor_sequence_advance(struct vor_sequence *sequence);

/** Says of a frame why nothing comes of it. err is read unless the outcome says all. */
void vor_sequence_tell_problem(struct vor_sequence *sequence, size_t index,
                               enum vor_job_outcome outcome, const struct vor_error *err);

/** Brings the result of a job, of this attempt, here from another machine. False when it is on its
 * way: the request is woken then. err says why it failed. */
bool vor_sequence_fetch(struct vor_sequence *sequence, const struct vor_uuid *id, uint32_t attempt,
                        enum vor_fetched *fetched, struct vor_error *err);

/** Ends following the job of a frame, if there is one. */
void vor_flight_leave(struct vor_flight *flight);

#endif
