/** Takes a tar archive apart while it arrives, and writes the headers of one: ustar (POSIX.1-1988)
 *  with the names and sizes of pax (POSIX.1-2001) and of GNU tar. Bytes in, events out; the scanner
 *  keeps a header, and nothing of a file, so it needs the same few kilobytes for an archive of any
 *  length. Only regular files are told of; nothing is opened by its name.
 *
 *  Not libarchive (3.6): its reader asks for bytes and waits for them, which a thread of HTTP must
 *  not, and it reads two dozen formats that no frame comes in.
 *
 *  Source: POSIX.1-2017, pax, "pax Interchange Format" and "ustar Interchange Format"; the manual
 *  of GNU tar, "Basic Tar Format". */
#ifndef VOR_PROTO_TAR_H
#define VOR_PROTO_TAR_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

enum {
    VOR_TAR_BLOCK = 512,        /**< bytes: of a header, and what files are filled up to */
    VOR_TAR_NAME_MAX = 255,     /**< bytes of a path that is read */
    VOR_TAR_BASE_MAX = 99,      /**< bytes of a name that is written */
    VOR_TAR_EXTENDED_MAX = 8192 /**< bytes of a header of pax, or of a name of GNU tar */
};

/** Called in the order of the archive: file, data any number of times, end; then the next file. The
 *  first one that fails ends the feed with its failure. */
struct vor_tar_events {
    void *ctx;
    /** path: valid during the call, 1 .. VOR_TAR_NAME_MAX bytes, not yet checked in any way */
    vor_status (*file)(void *ctx, const char *path, uint64_t size, struct vor_error *err);
    vor_status (*data)(void *ctx, const void *bytes, size_t size, struct vor_error *err);
    vor_status (*end)(void *ctx, struct vor_error *err);
};

enum vor_tar_state {
    VOR_TAR_HEADER,   /**< before or in a header */
    VOR_TAR_FILE,     /**< in a file that is told of */
    VOR_TAR_EXTENDED, /**< in what a header of pax or of GNU tar says of the next one */
    VOR_TAR_SKIP,     /**< in something else, or in what fills up a block */
    VOR_TAR_CLOSED    /**< behind the block of zeros that ends an archive */
};

/** The scanner. Its members are its own. */
struct vor_tar {
    struct vor_tar_events events;
    enum vor_tar_state state;
    uint64_t offset;       /* of the next byte in the archive */
    uint64_t header_at;    /* of the last header */
    uint64_t left, filler; /* bytes of what the state says; and that fill up its last block */
    size_t have;           /* bytes of the header, or of what is extended */
    int is_gnu;            /* what is extended is a name of GNU tar */
    int has_size;          /* as has path, from a header of pax */
    uint64_t size;
    char path[VOR_TAR_NAME_MAX + 1]; /* "" for none */
    uint8_t header[VOR_TAR_BLOCK];
    char extended[VOR_TAR_EXTENDED_MAX + 1];
};

/** @param[in] events  copied */
void vor_tar_begin(struct vor_tar *scanner, const struct vor_tar_events *events);

/** Takes the next bytes, in pieces of any size: the events are the same, but for where data is cut,
 *  and so is the failure. After a failure there is no next call. What comes after the end of the
 *  archive is not looked at.
 *
 *  @retval VOR_E_REQUEST  the bytes are no such archive, or a name or header is longer than above;
 *                         byte_offset is that of the header at fault
 *  @retval others         those of the events
 *
 *  O(size) time, no memory. */
VOR_NODISCARD vor_status vor_tar_feed(struct vor_tar *scanner, const void *bytes, size_t size,
                                      struct vor_error *err);

/** There are no more bytes.
 *
 *  @retval VOR_E_REQUEST  they end within a header or a file */
VOR_NODISCARD vor_status vor_tar_finish(const struct vor_tar *scanner, struct vor_error *err);

/** Writes the header of a regular file that anybody may read, with no time and no owner.
 *
 *  @param[in] name  1 .. VOR_TAR_BASE_MAX bytes
 *  @param[in] size  less than 8 GiB */
void vor_tar_header(uint8_t out[VOR_TAR_BLOCK], const char *name, uint64_t size);

/** Bytes of zero that follow a file of that size. */
size_t vor_tar_filler(uint64_t size);

#endif
