/** What came with a request, input by input, before anybody has looked into it. */
#ifndef VOR_SERVER_WORK_UPLOAD_H
#define VOR_SERVER_WORK_UPLOAD_H

#include "server/blob/blob.h"
#include "server/work/codec_run.h"

#include <stdint.h>

/** The bytes of an input as they were sent. */
struct vor_upload {
    const char *name;              /**< of the input, out of the process's row */
    struct vor_blob_writer *bytes; /**< owned; NULL before vor_upload_cut */
    int is_gzip;                   /**< they are to be inflated first */
    /** What they are a piece of, which may still grow behind it; borrowed. NULL: nothing. */
    const struct vor_blob_writer *whole;
    uint64_t offset, size; /**< of the piece */
};

/** Those of a request, each name once. All zero: none. */
struct vor_uploads {
    struct vor_upload item[VOR_INPUTS_MAX];
    unsigned count;
};

/** Adds one, with its file. Its bytes count as an upload under way until they are discarded. */
void vor_uploads_add(struct vor_uploads *uploads, const struct vor_upload *upload);

/** Adds one whose bytes are to come (vor_blob_append to that of the last item).
 *
 *  @retval VOR_E_IO, VOR_E_NOMEM nothing is added */
VOR_NODISCARD vor_status vor_uploads_begin(struct vor_uploads *uploads, const char *name,
                                           int is_gzip, struct vor_blobs *blobs,
                                           struct vor_error *err);

/** Discards the bytes of the one added last, and forgets it. */
void vor_uploads_drop_last(struct vor_uploads *uploads);

/** Discards the bytes of all and leaves none. */
void vor_uploads_discard(struct vor_uploads *uploads);

/** Gives an upload that is a piece of something bytes of its own; leaves others alone.
 *
 *  @retval VOR_E_IO  the disk refuses (vor_error_storage_full tells a full one apart)
 *
 *  Cost: that of writing them; not for HTTP threads. */
VOR_NODISCARD vor_status vor_upload_cut(struct vor_upload *upload, struct vor_blobs *blobs,
                                        struct vor_error *err);

/** Inflates an upload that is gzip; leaves others alone. Its bytes are then those that were
 *  compressed, with their own size and SHA-256.
 *
 *  @param[in]     place  where that is done
 *  @param[in,out] most      bytes that may come of it; less by what came
 *
 *  @retval VOR_E_IO  the disk refuses (vor_error_storage_full tells a full one apart)
 *  @retval others    as vor_codec_run; the upload is unchanged
 *
 *  Cost: that of writing what comes of it; not for HTTP threads. */
VOR_NODISCARD vor_status vor_upload_inflate(struct vor_upload *upload, struct vor_blobs *blobs,
                                            const struct vor_codec_place *place, uint64_t *most,
                                            struct vor_error *err);

#endif
