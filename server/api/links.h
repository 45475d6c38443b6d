/** Addresses: tells ours from others, writes ours, cuts a path into segments. */
#ifndef VOR_SERVER_API_LINKS_H
#define VOR_SERVER_API_LINKS_H

#include "server/api/app.h"

enum {
    VOR_URL_MAX = 512 /**< scheme, VOR_HOST_MAX, VOR_PREFIX_MAX and the longest path of ours */
};

/** The Host that keeps a request from being answered, or NULL when it may be: every name in it, and
 *  in what a trusted proxy says the client sent, is this machine's, that of --public-url or one of
 *  --allowed-hosts; or other machines may call as well and there is no list. A trusted proxy
 * answers for the names it gives where neither --public-url nor --allowed-hosts says which they
 * are.
 *
 *  A web page that re-binds its own name to this machine still sends that name as Host. */
const char *vor_host_refused(const struct vor_request *request);

/** "http://HOST" or "https://HOST": by which the client of this request reached us, as far as it
 *  and the trusted proxies tell. Its Host must not be refused. Returns out. */
const char *vor_app_origin(const struct vor_request *request, char out[VOR_URL_MAX]);

/** Absolute address of path ("/v1/jobs/..."): behind --public-url; else behind what trusted proxies
 *  say, their scheme, Host and prefix; else behind http:// and the Host of the request; else, when
 *  that is none or refused, behind the address that is listened on. Returns out. */
const char *vor_app_url(const struct vor_request *request, const char *path, char out[VOR_URL_MAX]);

/** The same for a job: "/v1/jobs/{id}" and suffix ("", "/events" ...). */
const char *vor_app_job_url(const struct vor_request *request, const struct vor_uuid *id,
                            const char *suffix, char out[VOR_URL_MAX]);

/** The same for an output of a job. */
const char *vor_app_result_url(const struct vor_request *request, const struct vor_uuid *id,
                               const char *output, char out[VOR_URL_MAX]);

/** Segment number `index` (from 0) of a path; its length, 0 past the last. */
size_t vor_path_segment(const char *path, unsigned index, const char **out);

#endif
