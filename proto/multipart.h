/** Takes a form apart while it arrives: multipart/form-data as in RFC 7578, within RFC 2046, 5.1.1.
 *  Bytes in, events out; the scanner keeps a line of a part's head and nothing of its data, so it
 *  needs the same few kilobytes for a body of any length.
 *
 *  Stricter than the RFCs, because two readers of one body must not disagree about it: there is no
 *  text before the first boundary but one line end, and none behind the last one; lines of a head
 *  end with CRLF and are not folded; what follows a boundary is a line end or "--". */
#ifndef VOR_PROTO_MULTIPART_H
#define VOR_PROTO_MULTIPART_H

#include "core/base/status.h"

#include <stddef.h>
#include <stdint.h>

enum {
    VOR_MULTIPART_BOUNDARY_MAX = 70, /**< bytes (RFC 2046, 5.1.1) */
    VOR_MULTIPART_PARTS_MAX = 32,
    VOR_MULTIPART_HEAD_MAX = 4096, /**< bytes of a part's header lines */
    VOR_MULTIPART_NAME_MAX = 64,   /**< bytes of a part's name, and of its coding */
};

/** What a part's head says. Strings are valid during the call. The file's name is not among it: no
 *  one may take it for a path or repeat it in a header. */
struct vor_multipart_part {
    const char *name;   /**< 1 .. VOR_MULTIPART_NAME_MAX bytes, none of them a control character */
    int is_file;        /**< it has a filename */
    int is_unnamed;     /**< that filename is empty: a browser's field without a file */
    const char *coding; /**< its Content-Encoding; "" without one */
};

/** Called in the order of the body: part, data any number of times, end; then the next part. The
 *  first one that fails ends the feed with its failure. */
struct vor_multipart_events {
    void *ctx;
    vor_status (*part)(void *ctx, const struct vor_multipart_part *part, struct vor_error *err);
    vor_status (*data)(void *ctx, const void *bytes, size_t size, struct vor_error *err);
    vor_status (*end)(void *ctx, struct vor_error *err);
};

enum vor_multipart_state {
    VOR_MULTIPART_START,   /**< before the first boundary */
    VOR_MULTIPART_DATA,    /**< of a part */
    VOR_MULTIPART_MARK,    /**< behind a boundary */
    VOR_MULTIPART_DASH,    /**< behind a boundary and "-" */
    VOR_MULTIPART_BREAK,   /**< behind a boundary and CR */
    VOR_MULTIPART_LINE,    /**< in a line of a head */
    VOR_MULTIPART_LINE_CR, /**< behind its CR */
    VOR_MULTIPART_CLOSED   /**< behind the last boundary */
};

/** The scanner. Its members are its own. */
struct vor_multipart {
    struct vor_multipart_events events;
    enum vor_multipart_state state;
    char delimiter[4 + VOR_MULTIPART_BOUNDARY_MAX + 1]; /* CR LF "--" boundary */
    size_t delimiter_size;
    size_t matched;  /* bytes of the delimiter that the last ones seen are */
    size_t implied;  /* of those, how many were a head's line end */
    uint64_t offset; /* of the next byte in the body */
    unsigned parts;
    size_t head_size, line_size;
    char line[VOR_MULTIPART_HEAD_MAX + 1];
    int has_disposition, is_file, is_unnamed;
    char name[VOR_MULTIPART_NAME_MAX + 1];
    char coding[VOR_MULTIPART_NAME_MAX + 1];
};

/** True when the media type is multipart/form-data, whatever its parameters. */
int vor_multipart_is_form(const char *content_type);

/** Begins with the boundary that a Content-Type names.
 *
 *  @param[in] content_type  one for which vor_multipart_is_form is true
 *  @param[in] events        copied
 *
 *  @retval VOR_E_REQUEST  there is no boundary, more than one, or none that RFC 2046 allows */
VOR_NODISCARD vor_status vor_multipart_begin(struct vor_multipart *scanner,
                                             const char *content_type,
                                             const struct vor_multipart_events *events,
                                             struct vor_error *err);

/** Takes the next bytes, in pieces of any size: the events are the same, but for where data is cut,
 *  and so is the failure. After a failure there is no next call.
 *
 *  @retval VOR_E_REQUEST  the body is no form, or beyond a limit above; byte_offset says where
 *  @retval others         those of the events
 *
 *  O(size) time, no memory. */
VOR_NODISCARD vor_status vor_multipart_feed(struct vor_multipart *scanner, const void *bytes,
                                            size_t size, struct vor_error *err);

/** The body is over.
 *
 *  @retval VOR_E_REQUEST  its last boundary did not come */
VOR_NODISCARD vor_status vor_multipart_finish(const struct vor_multipart *scanner,
                                              struct vor_error *err);

#endif
