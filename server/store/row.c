#include "server/store/row.h"

#include <string.h>

static const char *const status_words[VOR_JOB_STATUSES] = {
#define STATUS_ROW(name, word) word,
    VOR_JOB_STATUS_TABLE(STATUS_ROW)
#undef STATUS_ROW
};

static const char *const stage_words[VOR_STAGES] = {
#define STAGE_ROW(name, word) word,
    VOR_STAGE_TABLE(STAGE_ROW)
#undef STAGE_ROW
};

const char *vor_job_status_word(enum vor_job_status status)
{
    return status_words[status];
}

const char *vor_stage_word(enum vor_stage stage)
{
    return stage_words[stage];
}

enum vor_job_status vor_job_status_find(const char *word)
{
    int i = 0;

    while (i < VOR_JOB_STATUSES && strcmp(status_words[i], word) != 0)
        i++;
    return (enum vor_job_status)i;
}

int vor_output_in_row(const struct vor_artefact_info *output)
{
    return output->kind == VOR_ARTEFACT_DOCUMENT && strcmp(output->name, "report") == 0;
}

int vor_job_status_over(enum vor_job_status status)
{
    return status != VOR_JOB_ACCEPTED && status != VOR_JOB_RUNNING;
}
