#include "core/base/status.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

struct status_row {
    const char *slug;
    int http;
};

static const struct status_row rows[VOR_STATUS_COUNT] = {
#define STATUS_ROW(name, http, slug, retryable, sentence) {slug, http},
    VOR_STATUS_TABLE(STATUS_ROW)
#undef STATUS_ROW
};

static const struct status_row *row_of(vor_status status)
{
    assert((unsigned)status < VOR_STATUS_COUNT);
    return &rows[status];
}

int vor_status_http(vor_status status)
{
    return row_of(status)->http;
}

const char *vor_status_slug(vor_status status)
{
    return row_of(status)->slug;
}

static void begin(struct vor_error *err, vor_status status, const char *parameter)
{
    memset(err, 0, sizeof *err);
    err->status = status;
    err->byte_offset = -1;
    (void)snprintf(err->parameter, sizeof err->parameter, "%s", parameter);
}

/* Where memory ran out, the words are what it was for, or a sentence about memory. */
static void say(struct vor_error *err, const char *format, va_list args)
{
    static const char lacks[] = "not enough memory for ";
    size_t size = sizeof lacks - 1;

    (void)vsnprintf(err->message, sizeof err->message, format, args);
    if (err->status != VOR_E_NOMEM || strstr(err->message, "memory") != NULL)
        return;
    memmove(err->message + size, err->message, sizeof err->message - size);
    memcpy(err->message, lacks, size);
    err->message[sizeof err->message - 1] = '\0';
}

vor_status vor_fail(struct vor_error *err, vor_status status, const char *format, ...)
{
    va_list args;

    if (err == NULL)
        return status;
    begin(err, status, "");
    va_start(args, format);
    say(err, format, args);
    va_end(args);
    return status;
}

vor_status vor_fail_param(struct vor_error *err, vor_status status, const char *parameter,
                          const char *format, ...)
{
    va_list args;

    if (err == NULL)
        return status;
    begin(err, status, parameter);
    va_start(args, format);
    say(err, format, args);
    va_end(args);
    return status;
}

vor_status vor_fail_over(struct vor_error *err, vor_status status, uint64_t limit, uint64_t got)
{
    if (err != NULL) {
        err->limit = limit;
        err->got = got;
    }
    return status;
}

vor_status vor_fail_at(struct vor_error *err, vor_status status, uint64_t offset)
{
    if (err != NULL)
        err->byte_offset = (int64_t)offset;
    return status;
}
