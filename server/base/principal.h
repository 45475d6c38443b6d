/** Who sends requests, and what he may do. */
#ifndef VOR_SERVER_BASE_PRINCIPAL_H
#define VOR_SERVER_BASE_PRINCIPAL_H

#include <stdbool.h>

enum { VOR_KEY_NAME_MAX = 64 }; /**< bytes of the name of a key: [A-Za-z0-9._-] */

/** What a route asks of a key: identifier, word. A key with admin may do everything, and sees the
 *  jobs of all. */
#define VOR_SCOPE_TABLE(X)                                                                         \
    X(READ, "read")                                                                                \
    X(SUBMIT, "submit")                                                                            \
    X(ADMIN, "admin")

enum vor_scope {
    VOR_SCOPE_OPEN, /**< no key is asked for */
#define VOR_SCOPE_ENUM(id, word) VOR_SCOPE_##id,
    VOR_SCOPE_TABLE(VOR_SCOPE_ENUM)
#undef VOR_SCOPE_ENUM
        VOR_SCOPES
};

/** All of them, as a caller has them. */
#define VOR_EVERY_SCOPE ((1u << VOR_SCOPES) - 1)

/** "open", or the scope's word. */
const char *vor_scope_word(enum vor_scope scope);

/** Bounds of a caller; 0 is none. */
struct vor_quota {
    double jobs;   /**< that wait or run */
    double rate;   /**< requests for a job a second on average; twice as many at once */
    double bytes;  /**< of uploads that are kept and of results, when another upload begins */
    double points; /**< of an upload */
};

/** Who sent a request. */
struct vor_principal {
    char name[VOR_KEY_NAME_MAX + 1]; /**< of the key: whose the jobs are; "" for anybody */
    unsigned scopes;                 /**< bit 1 << VOR_SCOPE_... */
    bool sees_all;                   /**< the jobs of every name */
    struct vor_quota quota;
};

/** A caller who needs no key. */
extern const struct vor_principal vor_principal_anybody;

/** True when the caller may use a route of this scope. */
bool vor_principal_may(const struct vor_principal *caller, enum vor_scope scope);

#endif
