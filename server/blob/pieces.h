/** The digests of the pieces of a blob on another machine, in an object beside it: so any piece can
 *  be checked, and sent, before the others have come. It has 64 digits, those of the digest of the
 *  whole; 32 bytes for each piece; 32 for what stands before them. Those of another whole are none.
 */
#ifndef VOR_SERVER_BLOB_PIECES_H
#define VOR_SERVER_BLOB_PIECES_H

#include "server/blob/objects.h"

/** Whether blobs of that name have them, if they are longer than a piece: those that are sent to
 *  clients as they are. */
int vor_pieces_are_for(const char *file);

/** Reads bytes of a file.
 *
 *  @retval VOR_E_IO there are not so many, or they cannot be read */
VOR_NODISCARD vor_status vor_piece_read(int fd, uint64_t at, void *out, size_t size,
                                        struct vor_error *err);

/** Writes the digests of a file to an empty text.
 *
 *  @param[in] sha256  of the file
 *
 *  @retval VOR_E_DAMAGED it has another one
 *  @retval VOR_E_IO, VOR_E_NOMEM
 *
 *  Cost: reads the file once, two passes of SHA-256. */
VOR_NODISCARD vor_status vor_pieces_write(struct vor_text *out, int fd, uint64_t size,
                                          const char *sha256, struct vor_error *err);

/** The digests in the bytes of such an object; NULL unless they are those of that blob. Borrowed.
 */
const uint8_t *vor_pieces_of(const struct vor_text *text, const struct vor_blob_part *part);

/** Bytes of a blob on their way into a file: those from the first one that is wanted on. */
struct vor_arrival {
    char name[VOR_OBJECT_KEY_MAX + 1]; /**< for messages */
    int fd;                            /**< they stand there from its beginning on */
    const uint8_t *digest;             /**< of each piece of the blob; NULL: they are not checked */
    uint8_t *piece;                    /**< room for one, where there are digests */
    size_t have;                       /**< bytes of it */
    uint64_t at, end; /**< what is checked and in the file ends here, and what is wanted */
    const struct vor_blob_watch *watch; /**< told of what is checked */
    struct vor_error failure;
};

/** They are checked, and do not come to the blob's end or begin later. */
int vor_arrival_is_part(const struct vor_arrival *arrival);

/** What takes the bytes of an object (struct vor_object_reader). */
int vor_arrival_take(void *arrival, uint64_t at, const void *bytes, size_t size);

/** All have come that will: VOR_E_DAMAGED where they are too few. */
VOR_NODISCARD vor_status vor_arrival_end(struct vor_arrival *arrival);

#endif
