/** Who may call: the file of --api-keys, a line a key, and what each key may do. The file has the
 *  digests of the keys, never the keys.
 *
 *      # comment
 *      NAME:SCOPES:SHA256[:QUOTAS]
 *      render:submit,read:9f86d081...:jobs=4,rate=2,bytes=10G,points=1000000
 *
 *  A name may stand in several lines, while one key takes the place of another: its jobs are the
 *  name's. */
#ifndef VOR_SERVER_BASE_KEYS_H
#define VOR_SERVER_BASE_KEYS_H

#include "core/base/status.h"
#include "server/base/digest.h"
#include "server/base/principal.h"

#include <stdbool.h>

enum {
    VOR_KEY_SIZE = 37,      /**< bytes of a key that is made here, with the NUL */
    VOR_KEY_SENT_MAX = 512, /**< bytes of a key that is looked at */
    VOR_KEYS_MAX = 4096,    /**< lines with a key */
    VOR_KEY_LINE_SIZE = 512 /**< bytes of a line with its end and a NUL */
};

/** What every key that is made begins with, so that scanners of sources find it. */
#define VOR_KEY_PREFIX "vor_"

/** The keys. Thread-safe. */
struct vor_keys;

/** Reads the file. One that others may read is taken, with a warning in the log.
 *
 *  @param[in] path  kept for vor_keys_reload; copied
 *
 *  @retval VOR_E_PARAM a line is wrong (the message names file, line and reason), no line has a
 *                      key, two have the same, or there are too many
 *  @retval VOR_E_IO    the file cannot be read
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_keys_open(struct vor_keys **out, const char *path,
                                       struct vor_error *err);

/** keys may be NULL. */
void vor_keys_close(struct vor_keys *keys);

/** Reads the file again. Where that fails, the keys stay as they were. Requests under way go on,
 *  also those of a key that is no more. keys may be NULL: then there is nothing to do.
 *
 *  @retval as vor_keys_open */
VOR_NODISCARD vor_status vor_keys_reload(struct vor_keys *keys, struct vor_error *err);

/** Finds the caller of a key: every key is compared, each in constant time.
 *
 *  @return false, and *out stays as it is, when it is none */
bool vor_keys_find(struct vor_keys *keys, const char *key, struct vor_principal *out);

/** Makes a key of 192 random bits, and its line.
 *
 *  @param[in] scopes  "submit,read"
 *  @param[in] quotas  "jobs=4,rate=2", or NULL
 *
 *  @retval VOR_E_PARAM a name, scope or quota that the file could not have
 *  @retval VOR_E_IO    the kernel gives no random numbers */
VOR_NODISCARD vor_status vor_key_make(const char *name, const char *scopes, const char *quotas,
                                      char key[VOR_KEY_SIZE], char line[VOR_KEY_LINE_SIZE],
                                      struct vor_error *err);

enum {
    VOR_QUOTA_JOBS_DEFAULT = 16, /**< jobs that wait or run, where the line says nothing */
    VOR_QUOTA_RATE_DEFAULT = 10  /**< requests for a job a second, likewise */
};

#endif
