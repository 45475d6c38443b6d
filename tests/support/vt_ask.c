#include "tests/support/vt_ask.h"

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
