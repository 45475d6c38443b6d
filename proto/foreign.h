/** Names files of other formats by their bytes, for refusals that help. */
#ifndef VOR_PROTO_FOREIGN_H
#define VOR_PROTO_FOREIGN_H

#include <stddef.h>
#include <stdint.h>

/** A format that is not read. */
struct vor_foreign {
    const char *name; /**< "LAS" */
    const char *hint; /**< how to make a PLY file of it, or what probably happened */
};

/** What a whole file is, or NULL if no format that is known begins like that. */
const struct vor_foreign *vor_foreign_sniff(const uint8_t *bytes, size_t size);

#endif
