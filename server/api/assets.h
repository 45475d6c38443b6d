/** The files of the page, as they were when this binary was built: each gzipped by the Makefile,
 *  which writes the table of them too (build/web/assets.inc). */
#ifndef VOR_SERVER_API_ASSETS_H
#define VOR_SERVER_API_ASSETS_H

#include <stddef.h>
#include <stdint.h>

/** The page itself; what it loads are the others. */
#define VOR_ASSET_PAGE "index.html"

/** One file. */
struct vor_asset {
    const char *name;       /**< "page.js": the last segment of its path */
    const char *media_type; /**< by the end of its name */
    const char *digest;     /**< SHA-256 of its gzipped bytes, 64 hexadecimal digits */
    const uint8_t *bytes;   /**< gzipped */
    size_t size;            /**< of them */
};

/** The file of that name (length bytes); false when there is none. */
int vor_asset_find(struct vor_asset *out, const char *name, size_t length);

#endif
