#include "server/base/principal.h"

static const char *const scope_words[VOR_SCOPES] = {
#define SCOPE_ROW(id, word) [VOR_SCOPE_##id] = word,
    VOR_SCOPE_TABLE(SCOPE_ROW)
#undef SCOPE_ROW
        [VOR_SCOPE_OPEN] = "open",
};

const struct vor_principal vor_principal_anybody = {.scopes = VOR_EVERY_SCOPE, .sees_all = true};

const char *vor_scope_word(enum vor_scope scope)
{
    return scope_words[scope];
}

bool vor_principal_may(const struct vor_principal *caller, enum vor_scope scope)
{
    return scope == VOR_SCOPE_OPEN || (caller->scopes >> scope & 1) != 0;
}
