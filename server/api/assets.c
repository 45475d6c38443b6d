#include "server/api/assets.h"

#include <string.h>

/* The assembler takes each file in; its path is seen from the root of the tree, where make runs. */
#define ASSET(symbol, name, digest)                                                                \
    __asm__(".pushsection .rodata, \"a\"\n"                                                        \
            ".global vor_asset_" #symbol "_begin\n"                                                \
            ".global vor_asset_" #symbol "_length\n"                                               \
            "vor_asset_" #symbol "_begin:\n"                                                       \
            ".incbin \"build/web/" name ".gz\"\n"                                                  \
            "vor_asset_" #symbol "_end:\n"                                                         \
            ".balign 8\n"                                                                          \
            "vor_asset_" #symbol "_length:\n"                                                      \
            ".quad vor_asset_" #symbol "_end - vor_asset_" #symbol "_begin\n"                      \
            ".popsection\n");                                                                      \
    extern const uint8_t vor_asset_##symbol##_begin[];                                             \
    extern const uint64_t vor_asset_##symbol##_length;
#include "build/web/assets.inc"
#undef ASSET

struct embedded {
    const char *name;
    const char *digest;
    const uint8_t *bytes;
    const uint64_t *size;
};

static const struct embedded embedded[] = {
#define ASSET(symbol, name, digest)                                                                \
    {name, digest, vor_asset_##symbol##_begin, &vor_asset_##symbol##_length},
#include "build/web/assets.inc"
#undef ASSET
};

enum { EMBEDDED_COUNT = sizeof embedded / sizeof embedded[0] };

/* Media types by the end of a name. */
static const char *const types[][2] = {
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".json", "application/json"},
    {".yaml", "application/yaml"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".txt", "text/plain; charset=utf-8"},
};

int vor_asset_find(struct vor_asset *out, const char *name, size_t length)
{
    const char *suffix;
    for (unsigned i = 0; i < EMBEDDED_COUNT; i++) {
        const struct embedded *file = &embedded[i];

        if (strlen(file->name) != length || memcmp(file->name, name, length) != 0)
            continue;
        suffix = strrchr(file->name, '.');
        *out = (struct vor_asset){file->name, "application/octet-stream", file->digest, file->bytes,
                                  (size_t)*file->size};
        for (size_t k = 0; suffix != NULL && k < sizeof types / sizeof types[0]; k++)
            if (strcmp(suffix, types[k][0]) == 0)
                out->media_type = types[k][1];
        return 1;
    }
    return 0;
}
