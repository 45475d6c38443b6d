#include "server/http/mhd_library.h"

#include "server/base/library.h"

static struct vor_mhd functions;
static const char *const names[] = {
#define VOR_MHD_NAME(name) "MHD_" #name,
    VOR_MHD_TABLE(VOR_MHD_NAME)
#undef VOR_MHD_NAME
};

const struct vor_mhd *const vor_mhd = &functions;

vor_status vor_mhd_load(struct vor_error *err)
{
    static struct vor_library library = {"libmicrohttpd.so.12",          "libmicrohttpd12", names,
                                         sizeof names / sizeof names[0], &functions,        false};

    return vor_library_load(&library, err);
}
