/* The page and the files that it loads. They hold no secret and are the same for everybody, so they
 * need no key; what the page asks for does. */
#include "core/base/quote.h"
#include "proto/gzip.h"
#include "server/api/accept.h"
#include "server/api/handlers/handlers.h"
#include "server/api/links.h"
#include "server/api/problem.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/* The files of the page, as they were when this binary was built: each gzipped by the Makefile,
 * which writes the table of them too (build/web/assets.inc). */

/* One file. */
struct asset {
    const char *name;       /* "page.js": the last segment of its path */
    const char *media_type; /* by the end of its name */
    const char *digest;     /* SHA-256 of its gzipped bytes, 64 hexadecimal digits */
    const uint8_t *bytes;   /* gzipped */
    size_t size;            /* of them */
};

/* The assembler takes each file in; its path is seen from the root of the tree, where make runs. */
#define ASSET(symbol, name, digest)                                                                \
    __asm__(".pushsection .rodata, \"a\"\n"                                                        \
            ".global vor_asset_" #symbol "_begin\n"                                                \
            ".global vor_asset_" #symbol "_length\n"                                               \
            "vor_asset_" #symbol "_begin:\n"                                                       \
            ".incbin \"build/web/" name ".gz\"\n"                                                  \
            "vor_asset_" #symbol "_end:\n"                                                         \
            ".balign 8\n"                                                                          \
            "vor_asset_" #symbol "_length:\n"                                                      \
            ".quad vor_asset_" #symbol "_end - vor_asset_" #symbol "_begin\n"                      \
            ".popsection\n");                                                                      \
    extern const uint8_t vor_asset_##symbol##_begin[];                                             \
    extern const uint64_t vor_asset_##symbol##_length;
#include "build/web/assets.inc"
#undef ASSET

struct embedded {
    const char *name;
    const char *digest;
    const uint8_t *bytes;
    const uint64_t *size;
};

static const struct embedded embedded[] = {
#define ASSET(symbol, name, digest)                                                                \
    {name, digest, vor_asset_##symbol##_begin, &vor_asset_##symbol##_length},
#include "build/web/assets.inc"
#undef ASSET
};

enum { EMBEDDED_COUNT = sizeof embedded / sizeof embedded[0] };

/* Media types by the end of a name. */
static const char *const types[][2] = {
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".json", "application/json"},
    {".yaml", "application/yaml"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".txt", "text/plain; charset=utf-8"},
};

/* The file of that name (length bytes); false when there is none. */
static int find_asset(struct asset *out, const char *name, size_t length)
{
    const char *suffix;
    for (unsigned i = 0; i < EMBEDDED_COUNT; i++) {
        const struct embedded *file = &embedded[i];

        if (strlen(file->name) != length || memcmp(file->name, name, length) != 0)
            continue;
        suffix = strrchr(file->name, '.');
        *out = (struct asset){file->name, "application/octet-stream", file->digest, file->bytes,
                              (size_t)*file->size};
        for (size_t k = 0; suffix != NULL && k < sizeof types / sizeof types[0]; k++)
            if (strcmp(suffix, types[k][0]) == 0)
                out->media_type = types[k][1];
        return 1;
    }
    return 0;
}

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
static enum vor_next reply_asset(struct vor_request *request, const struct asset *asset,
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

static const char page_name[] = "index.html"; /* what it loads are the others */

enum vor_next vor_handle_root(struct vor_request *request, enum vor_step step)
{
    double wanted = vor_accept_named(request, "text/html");
    struct asset page;

    /* The page has to be asked for by its name, and JSON not more so. Stars stand for no page:
     * programs send them as well. */
    if (wanted > 0 && wanted >= vor_accept_named(request, "application/json") &&
        find_asset(&page, page_name, strlen(page_name)))
        return reply_asset(request, &page, "Accept, Accept-Encoding");
    vor_reply_header(request, "Vary", "Accept");
    return vor_handle_landing(request, step);
}

enum vor_next vor_handle_asset(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    const char *segment;
    size_t length = vor_path_segment(request->path, 1, &segment);
    struct asset asset;

    if (find_asset(&asset, segment, length))
        return reply_asset(request, &asset, "Accept-Encoding");
    return vor_problem_say(request, "no-such-resource", "the page has no file %s",
                           VOR_QUOTED(64, segment, length));
}

enum vor_next vor_handle_openapi(struct vor_request *request, VOR_UNUSED enum vor_step step)
{
    const char *name = request->path + 1; /* openapi.json or openapi.yaml */
    struct asset asset;

    if (find_asset(&asset, name, strlen(name)))
        return reply_asset(request, &asset, "Accept-Encoding");
    return vor_problem_say(request, "no-such-resource", "there is no %s", name);
}
