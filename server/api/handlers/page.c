/* The page and the files that it loads. They hold no secret and are the same for everybody, so they
 * need no key; what the page asks for does. */
#include "core/base/quote.h"
#include "proto/gzip.h"
#include "server/api/accept.h"
#include "server/api/assets.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Nothing but the page's own files, and no request beyond the origin. A worker goes by the headers
 * of its own script, so every file has them. */
#define CONTENT_POLICY                                                                             \
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "                \
    "img-src 'self' blob:; worker-src 'self'; frame-ancestors 'none'; base-uri 'none'; "           \
    "form-action 'none'"

/* Bytes that a file may have once inflated; three.js has 1.2 MB before it is made smaller. */
enum { PLAIN_MAX = 16 << 20 };

/* True when the client reads gzip: it is named with a q above 0, or a star is and gzip is not. */
static bool takes_gzip(const struct vor_request *request)
{
    struct vor_accept_walk walk = {.header = "Accept-Encoding"};
    struct vor_accept_range range;
    double named = -1, any = -1;

    while (vor_accept_next(request, &walk, &range)) {
        if (named < 0 && strcasecmp(range.type, "gzip") == 0)
            named = range.quality;
        if (any < 0 && strcmp(range.type, "*") == 0)
            any = range.quality;
    }
    return named >= 0 ? named > 0 : any > 0;
}

void vor_page_headers(struct vor_request *request)
{
    vor_reply_header(request, "Cache-Control", "no-cache");
    vor_reply_header(request, "Content-Security-Policy", CONTENT_POLICY);
    vor_reply_header(request, "Referrer-Policy", "no-referrer");
}

/* Both codings have a tag of their own: their bytes differ. A tag changes with the bytes alone, so
 * asking again, every time, costs an answer without a body. */
static enum vor_next reply_asset(struct vor_request *request, const struct vor_asset *asset,
                                 const char *vary)
{
    bool is_gzip = takes_gzip(request);
    char etag[VOR_ETAG_SIZE + sizeof "-plain"];

    (void)snprintf(etag, sizeof etag, "\"%s%s\"", asset->digest, is_gzip ? "" : "-plain");
    vor_reply_header(request, "ETag", etag);
    vor_reply_header(request, "Vary", vary);
    vor_page_headers(request);
    if (!is_gzip) {
        struct vor_text text;
        struct vor_sink sink = {&text, vor_text_take};
        struct vor_error err;

        /* The same bytes for a client that does not read gzip. */
        vor_text_init(&text, PLAIN_MAX);
        if (vor_gzip_inflate(&sink, asset->bytes, asset->size, PLAIN_MAX, &err) != VOR_OK) {
            vor_text_free(&text);
            return vor_problem_error(request, &err, NULL);
        }
        return vor_app_reply(request, 200, asset->media_type, &text);
    }
    vor_reply_header(request, "Content-Encoding", "gzip");
    vor_reply_bytes(request, 200, asset->media_type, asset->bytes, asset->size);
    return VOR_NEXT_REPLY;
}

enum vor_next vor_handle_root(struct vor_request *request, enum vor_step step)
{
    double wanted = vor_accept_named(request, "text/html");
    struct vor_asset page;

    /* The page has to be asked for by its name, and JSON not more so. Stars stand for no page:
     * programs send them as well. */
    if (wanted > 0 && wanted >= vor_accept_named(request, "application/json") &&
        vor_asset_find(&page, VOR_ASSET_PAGE, strlen(VOR_ASSET_PAGE)))
        return reply_asset(request, &page, "Accept, Accept-Encoding");
    vor_reply_header(request, "Vary", "Accept");
    return vor_handle_landing(request, step);
}

enum vor_next vor_handle_asset(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    const char *segment;
    size_t length = vor_path_segment(request->path, 1, &segment);
    struct vor_asset asset;

    if (vor_asset_find(&asset, segment, length))
        return reply_asset(request, &asset, "Accept-Encoding");
    return vor_problem_say(request, "no-such-resource", "the page has no file %s",
                           VOR_QUOTED(64, segment, length));
}

enum vor_next vor_handle_openapi(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    const char *name = request->path + 1; /* openapi.json or openapi.yaml */
    struct vor_asset asset;

    if (vor_asset_find(&asset, name, strlen(name)))
        return reply_asset(request, &asset, "Accept-Encoding");
    return vor_problem_say(request, "no-such-resource", "there is no %s", name);
}
