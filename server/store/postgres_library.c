#include "server/store/postgres_library.h"

#include "server/base/library.h"

static struct vor_pg functions;
static const char *const names[] = {
#define VOR_PG_NAME(name, result, parameters) "PQ" #name,
    VOR_PG_TABLE(VOR_PG_NAME)
#undef VOR_PG_NAME
};

vor_status vor_pg_load(const struct vor_pg **out, struct vor_error *err)
{
    static struct vor_library library = {
        "libpq.so.5", "libpq5", names, sizeof names / sizeof names[0], &functions, false};

    *out = &functions;
    return vor_library_load(&library, err);
}
