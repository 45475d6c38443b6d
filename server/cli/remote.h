/** HTTP calls to a daemon. remote.c is the only file that includes curl. */
#ifndef VOR_CLI_REMOTE_H
#define VOR_CLI_REMOTE_H

#include "core/base/status.h"
#include "proto/json/json.h"
#include "server/cli/options.h"

#include <stdint.h>
#include <stdio.h>

#define VOR_REMOTE_URL_MAX 2048

/** A connection that is kept from call to call. */
struct vor_remote;

/** Most files that one call sends. */
#define VOR_REMOTE_FILES_MAX 4

/** A file that is sent, from where it stands. */
struct vor_remote_file {
    const char *name; /**< of the part, where the call is a form */
    FILE *bytes;      /**< that can be sought in */
    int64_t size;
};

/** One call: what is asked, and what came. */
struct vor_remote_call {
    const char *method, *url;
    const char *const *headers; /**< "Name: value", ended by NULL; may be NULL */
    /** One file is the body; several are the parts of a form (multipart/form-data). */
    struct vor_remote_file file[VOR_REMOTE_FILES_MAX];
    unsigned files;
    /** Takes the body of a 2xx answer; anything but 0 ends the call. NULL: it goes to text. */
    int (*take)(void *ctx, const void *bytes, size_t size);
    void *ctx;
    unsigned timeout_seconds; /**< for the whole call; 0 for none */
    unsigned stall_seconds;   /**< without a byte; 0 for none */
    int is_last_word;         /**< a signal does not end the call */
    int ends_to_stop;         /**< a ^C that asks for the best result ends it too */
    int goes_there;           /**< an answer of 307 is followed once; what comes from there has to
                               *  have the SHA-256 that is its ETag */

    int http;                          /**< status */
    int was_stopped;                   /**< take ended the call */
    char location[VOR_REMOTE_URL_MAX]; /**< absolute; "" when there is none */
    char etag[80];                     /**< without quotes; likewise */
    struct vor_text text; /**< the answer where take does not get it; the caller frees it */
};

/** Every call of this process goes through the Unix socket at that path, whatever host its URL
 * names.
 *
 *  @retval VOR_E_PARAM the path is longer than a socket's may be, or does not begin with a slash */
VOR_NODISCARD vor_status vor_remote_use_socket(const char *path, struct vor_error *err);

/** @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_remote_open(struct vor_remote **out, struct vor_error *err);
void vor_remote_close(struct vor_remote *remote);

/** Sends a key ("" for none) with every call from now on that goes to the scheme, host and port of
 *  this URL, and with no other: what a daemon answers may lead elsewhere.
 *
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_remote_authorize(struct vor_remote *remote, const char *url,
                                              const char *key, struct vor_error *err);

/** Makes a call and waits for the answer, whatever its status.
 *
 *  @retval VOR_E_IO        no answer, or not all of it (the message says why)
 *  @retval VOR_E_DAMAGED   other bytes than were meant came from elsewhere
 *  @retval VOR_E_LIMIT     more text than VOR_JSON_SIZE_MAX
 *  @retval VOR_E_CANCELLED a signal came */
VOR_NODISCARD vor_status vor_remote_perform(struct vor_remote *remote, struct vor_remote_call *call,
                                            struct vor_error *err);

/** The text of an answer as JSON, to be freed with vor_json_free; NULL when it is none. */
struct vor_json *vor_remote_json(const struct vor_remote_call *call);

/* Which daemon a command asks. */

/** Writes the URL of the daemon without a slash at its end: that of --server or its variable, else
 *  of the daemon that VORONOID_LISTEN has listen on this machine (an address that stands for all of
 *  them is asked at its loopback one), else http://127.0.0.1:8080.
 *
 *  @retval VOR_E_PARAM the URL is too long, or VORONOID_LISTEN names no port that can be asked */
VOR_NODISCARD vor_status vor_cli_server(char out[VOR_REMOTE_URL_MAX], const struct vor_cli *cli,
                                        struct vor_error *err);

#endif
