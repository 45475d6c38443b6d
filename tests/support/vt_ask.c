#include "tests/support/vt_ask.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void vt_ask_set(struct vt_engine *engine, const char *options)
{
    char text[256], *next = NULL;

    ck_assert_uint_lt(strlen(options), sizeof text);
    (void)snprintf(text, sizeof text, "%s", options);
    for (char *word = strtok_r(text, " ", &next); word != NULL; word = strtok_r(NULL, " ", &next)) {
        char *value = strchr(word, '=');

        ck_assert_msg(value != NULL, "%s has no value", word);
        *value = '\0';
        vt_engine_set(engine, word, value + 1);
    }
}

vor_status vt_ask_try(struct vor_cloud *out, struct vor_report *report,
                      const struct vt_ask *request)
{
    struct vt_engine engine;
    vor_status status;

    vt_engine_open(&engine, request->threads);
    vt_ask_set(&engine, request->options);
    status = vt_engine_try(&engine, out, report, request->in);
    vt_engine_close(&engine);
    return status;
}

void vt_ask(struct vor_cloud *out, struct vor_report *report, const struct vt_ask *request)
{
    vt_assert_ok(vt_ask_try(out, report, request));
}

void vt_resample(struct vor_cloud *out, struct vor_report *report, const struct vor_cloud *in,
                 const char *format, ...)
{
    char options[256];
    va_list rest;

    va_start(rest, format);
    ck_assert_int_lt(vsnprintf(options, sizeof options, format, rest), (int)sizeof options);
    va_end(rest);
    vt_ask(out, report, &(struct vt_ask){in, options, 2});
}
