/** What every handler works with: the running daemon's parts, none of them owned here. */
#ifndef VOR_SERVER_API_APP_H
#define VOR_SERVER_API_APP_H

#include "proto/json/json.h"
#include "server/base/config.h"
#include "server/http/http.h"
#include "server/work/worker.h"

#include <stdatomic.h>
#include <stdbool.h>

struct vor_admit;

struct vor_app {
    const struct vor_config *config;
    struct vor_store *store;
    struct vor_blobs *blobs;
    struct vor_worker *worker;
    struct vor_admit *admit;
    struct vor_http *http;
    atomic_bool draining; /**< SIGTERM came: /readyz says no, streams end */
    atomic_uint streams;  /**< event streams open */
};

enum { VOR_URL_MAX = 512 };

/** True for NAME, NAME:PORT and [ADDRESS]:PORT as far as their bytes go. */
bool vor_host_is_sound(const char *host);

/** May a request for this Host be answered? Behind a page's name that was re-bound to this machine
 *  the Host is still the page's. Always true when other machines may call. */
bool vor_host_is_ours(const struct vor_app *app, const char *host);

/** Absolute address of path ("/v1/jobs/..."): --public-url, else http:// and the Host of the
 *  request if it is ours, else the address that is listened on. Returns out. */
const char *vor_app_url(const struct vor_app *app, const struct vor_request *request,
                        const char *path, char out[VOR_URL_MAX]);

/** The same for a job: "/v1/jobs/{id}" and suffix ("", "/events" ...). */
const char *vor_app_job_url(const struct vor_app *app, const struct vor_request *request,
                            const struct vor_uuid *id, const char *suffix, char out[VOR_URL_MAX]);

/** Segment number `index` (from 0) of a path; its length, 0 past the last. */
size_t vor_path_segment(const char *path, unsigned index, const char **out);

/** Replies with a text built so far and frees it; a text that failed becomes a problem. */
enum vor_next vor_app_reply(struct vor_app *app, struct vor_request *request, int http,
                            const char *media_type, struct vor_text *text);

/** True when an Accept header names this media type, or none was sent and `absent` is true. Ranges
 *  with a star do not count. */
bool vor_accepts(const struct vor_request *request, const char *media_type, bool absent);

#endif
