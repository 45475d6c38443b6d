/** One driver each for threads, failed allocations and interruptions: what every stage of the
 * engine and every request promises of them, tried on a table with a row for each. */
#ifndef VT_DRIVE_H
#define VT_DRIVE_H

#include "tests/support/vt_engine.h"

/** One call of a row. */
struct vt_call {
    const struct vor_cloud *in;
    const struct vor_run *run; /**< with vt_memory */
    const char *options;       /**< of the row */
    size_t points; /**< set by the row: of the result; 0: none, or corners of polygons */
    uint64_t hash; /**< set by the row on success: of all that came out */
    _Alignas(64) unsigned char out[65536]; /**< for what comes out: a call that fails leaves it */
};

/** What is called, and with which input. */
struct vt_row {
    const char *name;
    /** Makes something of call->in, hashes it and frees it. */
    vor_status (*call)(struct vt_call *call);
    void (*make)(struct vor_cloud *cloud, uint64_t seed, size_t n);
    size_t many;         /**< points of the input for vt_drive_threads, so that there are blocks; 0:
                             not tried */
    size_t few;          /**< for the others, which call it again and again; 0: not tried */
    const char *options; /**< of a request (vt_call_request) */
    int silent;          /**< it asks nobody whether to go on */
};

/** Runs a request: options are NAME=VALUE with blanks between, a process's id before them. A
 *  measure or register has a second cloud as reference, one with a coherence below 1 as previous.
 * All that comes out is hashed: positions, attributes, triangles, and the members of documents but
 * times and bytes. */
vor_status vt_call_request(struct vt_call *call);

/** Appends bytes to the hash of a call. */
void vt_call_hash(struct vt_call *call, const void *data, size_t size);

/** The same bytes, and the same records of progress, at one thread and at three. */
void vt_drive_threads(const struct vt_row *row);

/** Each allocation fails once, of a request those from places that no row before it has tried (all
 * in `make soak`): VOR_E_NOMEM and a message, nothing written to call->out, as many bytes in use as
 *  before. */
void vt_drive_failures(const struct vt_row *row);

/** The answer to the first, the last and up to three questions between, or to a record of progress,
 * is VOR_CANCEL: VOR_E_CANCELLED, nothing written to call->out, as many bytes in use as before. A
 * request whose answer is VOR_STOP ends with VOR_OK and as many points as else; one that gives none
 * is not stopped. */
void vt_drive_answers(const struct vt_row *row);

#endif
