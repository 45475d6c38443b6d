/** Messages between two processes of ours, with file descriptors beside them: one end of a pair of
 *  SOCK_SEQPACKET sockets. A message arrives whole or not at all, so any thread may send beside any
 *  other; one at a time receives.
 *
 *  An end is a file descriptor: poll it beside others (POLLIN: a message, or the other side has
 *  gone), close() it. Once every copy of the other end is closed, and what it sent was received,
 *  receiving tells so. Whatever is larger than a message goes through a file whose descriptor is
 *  sent. */
#ifndef VOR_SERVER_PROC_CHANNEL_H
#define VOR_SERVER_PROC_CHANNEL_H

#include "core/base/status.h"

#include <stddef.h>

/** Most bytes of a message (a socket of Linux takes 208 KiB at a time unless told otherwise), and
 *  file descriptors beside it. */
enum { VOR_CHANNEL_BYTES = 65536, VOR_CHANNEL_FDS = 9 };

/** Makes the two ends, both closed by exec.
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_channel_pair(int out[2], struct vor_error *err);

/** Sends a message; waits while the other side's queue is full.
 *
 *  @param[in] size      1 .. VOR_CHANNEL_BYTES
 *  @param[in] fds       copied into the other process, and still the caller's; NULL for none
 *  @param[in] fd_count  0 .. VOR_CHANNEL_FDS
 *
 *  @retval VOR_E_IO  nothing was sent: mostly that nobody is there any more. Raises no SIGPIPE */
VOR_NODISCARD vor_status vor_channel_send(int channel, const void *bytes, size_t size,
                                          const int *fds, unsigned fd_count, struct vor_error *err);

/** What vor_channel_receive returned. */
enum vor_channel_event {
    VOR_CHANNEL_MESSAGE,
    VOR_CHANNEL_GONE, /**< the other side has closed its end, or the channel is broken */
    VOR_CHANNEL_LATE  /**< the time has passed */
};

/** A message as it was received. The caller fills in bytes and capacity. */
struct vor_message {
    void *bytes;     /**< room for what comes */
    size_t capacity; /**< of it; a longer message counts as a broken channel */
    size_t size;
    int fds[VOR_CHANNEL_FDS]; /**< closed by exec; the caller's to close */
    unsigned fd_count;        /**< 0 where this process could not open all of them */
};

/** Receives the next message.
 *
 *  @param[in]  seconds  to wait at most; 0 only looks, below 0 is for ever
 *  @param[out] message  size and fd_count are 0 unless VOR_CHANNEL_MESSAGE is returned
 *
 *  Does not trust the other side: whatever it sends, nothing is written past the capacity, and no
 *  descriptor stays open that the caller does not see. */
enum vor_channel_event vor_channel_receive(int channel, struct vor_message *message,
                                           double seconds);

/** Closes the descriptors of a message and leaves it none. */
void vor_message_close(struct vor_message *message);

#endif
