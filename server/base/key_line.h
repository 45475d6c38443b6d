/** A line of the file of keys (server/base/keys.h, which the others include instead). */
#ifndef VOR_SERVER_BASE_KEY_LINE_H
#define VOR_SERVER_BASE_KEY_LINE_H

#include "core/base/status.h"
#include "server/base/digest.h"
#include "server/base/principal.h"

enum {
    VOR_QUOTA_JOBS_DEFAULT = 16, /**< jobs that wait or run, where the line says nothing */
    VOR_QUOTA_RATE_DEFAULT = 10  /**< requests for a job a second, likewise */
};

struct vor_key_line {
    struct vor_principal principal;
    uint8_t digest[VOR_DIGEST_BYTES]; /**< of the key */
};

/** Reads NAME:SCOPES:SHA256[:QUOTAS], without blanks around it. No message holds what may be a key.
 *
 *  @retval VOR_E_PARAM the message says which part is wrong, and what it may be */
VOR_NODISCARD vor_status vor_key_line_read(struct vor_key_line *out, const char *line,
                                           struct vor_error *err);

#endif
