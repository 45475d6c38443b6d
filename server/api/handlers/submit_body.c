#include "server/api/handlers/submit_body.h"

#include "core/base/quote.h"
#include "proto/multipart.h"
#include "server/api/problem.h"

#include <string.h>
#include <strings.h>

enum { SHOWN_SIZE = 48 }; /* of a header in a message */

int vor_submit_coding(const char *coding)
{
    if (strcasecmp(coding, "gzip") == 0 || strcasecmp(coding, "x-gzip") == 0)
        return 1; /* RFC 9110, 8.4.1.3: the two are the same */
    return coding[0] == '\0' || strcasecmp(coding, "identity") == 0 ? 0 : -1;
}

static bool read_coding(struct vor_app *app, struct vor_request *request,
                        struct vor_submit_body *out)
{
    unsigned index = 0;
    const char *value = vor_request_header_next(request, "Content-Encoding", &index);
    const char *more = vor_request_header_next(request, "Content-Encoding", &index);
    char shown[SHOWN_SIZE];
    int coding;

    if (value == NULL)
        return true;
    coding = vor_submit_coding(value);
    out->is_gzip = coding > 0;
    if (coding >= 0 && more == NULL)
        return true;
    vor_reply_header(request, "Accept-Encoding", "gzip");
    vor_problem_say(
        app, request, "unsupported-format", "Content-Encoding is %s%s, want gzip, once, or none",
        vor_quote(shown, sizeof shown, value, strlen(value)), more != NULL ? " and more" : "");
    return false;
}

bool vor_submit_body_read(struct vor_app *app, struct vor_request *request,
                          struct vor_submit_body *out)
{
    const char *type = vor_request_header(request, "Content-Type");

    *out = (struct vor_submit_body){.is_form = type != NULL && vor_multipart_is_form(type)};
    if (!read_coding(app, request, out))
        return false;
    if (!out->is_form || !out->is_gzip)
        return true;
    vor_problem_say(app, request, "unsupported-format",
                    "Content-Encoding is gzip for the whole form, want it in the headers of a part "
                    "with a file");
    return false;
}

bool vor_submit_body_is_json(const struct vor_request *request)
{
    const char *type = vor_request_header(request, "Content-Type");
    size_t length = type != NULL ? strcspn(type, "; \t") : 0;

    return (length == 16 && strncasecmp(type, "application/json", 16) == 0) ||
           (length > 5 && strncasecmp(type + length - 5, "+json", 5) == 0);
}
