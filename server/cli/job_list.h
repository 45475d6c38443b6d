/** The jobs of a daemon: its list, and the one job that a word stands for. */
#ifndef VOR_CLI_JOB_LIST_H
#define VOR_CLI_JOB_LIST_H

#include "server/cli/follow.h"

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
