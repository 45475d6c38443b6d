/** Addresses: tells ours from others, writes ours, cuts a path into segments. */
#ifndef VOR_SERVER_API_LINKS_H
#define VOR_SERVER_API_LINKS_H

#include "server/api/app.h"

enum { VOR_URL_MAX = 512 };

/** True for NAME, NAME:PORT and [ADDRESS]:PORT as far as their bytes go. */
bool vor_host_is_sound(const char *host);

/** True when a request for this Host may be answered: it names this machine or --public-url, or
 *  other machines may call as well. A web page that re-binds its own name to this machine still
 *  sends that name as Host. */
bool vor_host_is_ours(const struct vor_app *app, const char *host);

/** Absolute address of path ("/v1/jobs/..."): --public-url, else http:// and the Host of the
 *  request if it is ours, else the address that is listened on. Returns out. */
const char *vor_app_url(const struct vor_app *app, const struct vor_request *request,
                        const char *path, char out[VOR_URL_MAX]);

/** The same for a job: "/v1/jobs/{id}" and suffix ("", "/events" ...). */
const char *vor_app_job_url(const struct vor_app *app, const struct vor_request *request,
                            const struct vor_uuid *id, const char *suffix, char out[VOR_URL_MAX]);

/** The same for an output of a job. */
const char *vor_app_result_url(const struct vor_app *app, const struct vor_request *request,
                               const struct vor_uuid *id, const char *output,
                               char out[VOR_URL_MAX]);

/** Segment number `index` (from 0) of a path; its length, 0 past the last. */
size_t vor_path_segment(const char *path, unsigned index, const char **out);

#endif
