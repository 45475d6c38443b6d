/** A job at a daemon, from this side: asked for, followed to its end, its report shown. What goes
 *  wrong is said in one line, and the exit code returned. */
#ifndef VOR_CLI_FOLLOW_H
#define VOR_CLI_FOLLOW_H

#include "proto/sse.h"
#include "server/base/uuid.h"
#include "server/cli/options.h"
#include "server/cli/progress.h"
#include "server/cli/remote.h"

/** Seconds for a short answer; without a byte of a long one; and for a last word after a signal. */
#define VOR_FOLLOW_ANSWER_SECONDS 30
#define VOR_FOLLOW_STALL_SECONDS 120
#define VOR_FOLLOW_LAST_SECONDS 5

struct vor_follow {
    const struct vor_cli *cli;
    const char *subject;   /**< what messages are about: the input of the job, or its ID */
    struct vor_uuid id;    /**< of the job, where the command names it */
    const char *on_signal; /**< what is said when a signal ends it */
    struct vor_remote *remote;
    struct vor_progress progress;
    struct vor_sse_parser parser;
    char server[VOR_REMOTE_URL_MAX];
    char job[VOR_REMOTE_URL_MAX]; /**< URL of the job; "" before there is one */
    char status[32];              /**< of the job, as far as known */
    int told_to_stop;             /**< the daemon, by us */
    struct vor_error err;
};

/** Begins; cli and subject are borrowed. End with vor_follow_close, also after a failure. */
int vor_follow_open(struct vor_follow *follow, const struct vor_cli *cli, const char *subject);
void vor_follow_close(struct vor_follow *follow);

/** Makes a call. Says that it got no answer, or that a signal came; and, of an answer that has none
 *  of the two status codes (0: none), the refusal. */
int vor_follow_perform(struct vor_follow *follow, struct vor_remote_call *call, int http, int also);

/** Makes a call and reads its answer, 200 or 202 and JSON. *json is to be freed; NULL unless
 * VOR_EXIT_OK is returned. */
int vor_follow_call(struct vor_follow *follow, const char *method, const char *url,
                    struct vor_json **json);

/** Asks how the job is doing. *json is its statusInfo, to be freed; NULL unless VOR_EXIT_OK is
 *  returned. */
int vor_follow_ask(struct vor_follow *follow, struct vor_json **json);

/** True when the job is known to be over. */
int vor_follow_is_over(const struct vor_follow *follow);

/** Shows the job's progress until it is over. A stream that breaks off is taken up where it ended,
 *  and a server that goes away is tried a few times.
 *
 *  @return VOR_EXIT_OK when it was successful; why it was not is said */
int vor_follow_end(struct vor_follow *follow);

/** Shows the report, if the process of cli->spec has one. */
int vor_follow_report(struct vor_follow *follow);

/** A string member of an object; "" where there is none. */
const char *vor_follow_text(const struct vor_json *json, const char *name);

/* The jobs of a daemon: its list, and the one job that a word stands for. */

/** Calls visit with the statusInfo of each job, the newest first, at most `limit` of them.
 *
 *  @param[in] statuses  only jobs with one of these, with commas between; NULL for all
 *  @return VOR_EXIT_OK; what went wrong is said */
int vor_job_list(struct vor_follow *follow, const char *statuses, unsigned limit,
                 void (*visit)(void *ctx, const struct vor_json *job), void *ctx);

/** Makes follow about one job: sets its ID, its URL and the subject of messages. A word that is not
 *  a whole ID is looked up in the list.
 *
 *  @param[in] word  an ID or its beginning, as vor_uuid_begins has it; borrowed until the end
 *  @return VOR_EXIT_OK; VOR_EXIT_USAGE for the beginning of several IDs, VOR_EXIT_FAILED for that
 *          of none, both after it was said */
int vor_job_choose(struct vor_follow *follow, const char *word);

#endif
