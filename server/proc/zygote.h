/** The process that others are forked from. It is forked itself at the very start of `voronoid
 *  serve`: before a thread runs, before the store and its lock are open, while it is small. So a
 *  fork costs it 0.2 ms, a child begins with nothing of the daemon's, and no child can keep a lock.
 *
 *  What a child does is a function out of a table given before the fork (struct vor_child_kind). A
 * child gets one end of a channel (channel.h) and some file descriptors of the front's choice; all
 * other descriptors but standard error are closed, standard input and output read and write
 * nothing.
 *
 *  Who ends whom: each child, and the zygote, is killed by the kernel when its parent dies
 *  (PR_SET_PDEATHSIG), whatever it does. The zygote ends when the front, and the children that it
 *  has given its socket to, have closed that, and kills a child when the front lets go of it
 *  (vor_child_kill, vor_child_free). So SIGKILL of the front leaves no process. SIGINT, SIGTERM,
 *  SIGHUP, SIGQUIT, SIGUSR1 and SIGUSR2 are ignored by all of them, as a terminal or a supervisor
 *  sends these to whole groups: the front decides.
 *
 *  The functions for the front may be called from any thread, each struct vor_child by one thread
 * at a time. None is for HTTP threads: they wait for another process. */
#ifndef VOR_SERVER_PROC_ZYGOTE_H
#define VOR_SERVER_PROC_ZYGOTE_H

#include "core/base/status.h"
#include "server/proc/channel.h"

#include <stdint.h>
#include <sys/types.h>

/** Most file descriptors that a child is given beside its channel, and most children at a time. */
enum { VOR_CHILD_FDS = VOR_CHANNEL_FDS - 2, VOR_CHILDREN = 256 };

/** A kind of child. Its index in the table given to vor_zygote_start is its number. */
struct vor_child_kind {
    const char *name; /**< of the process, as ps and the log show it; at most 15 bytes */
    /** Runs in the child, alone, with one thread; the process ends with what this returns as its
     *  exit status, without what atexit() has been told. It may start threads.
     *
     *  @param[in] channel  descriptor 3, to the front; VOR_CHANNEL_GONE there is the order to end
     *  @param[in] fds      descriptors 4 and up: fd_count of them, in the order in which
     *                      vor_zygote_spawn was given them */
    int (*run)(int channel, const int *fds, unsigned fd_count);
};

struct vor_zygote {
    int socket; /**< to the zygote; readable once it has died, as it sends nothing here */
    pid_t pid;
};

/** Forks the zygote. To be called by the main thread, while it is the only one and has opened
 *  nothing that children must not have.
 *
 *  @param[in] kinds  kind_count of them; must outlive this process, as is the case of a static
 * table
 *
 *  @retval VOR_E_IO */
VOR_NODISCARD vor_status vor_zygote_start(struct vor_zygote *out,
                                          const struct vor_child_kind *kinds, unsigned kind_count,
                                          struct vor_error *err);

/** Ends the zygote, which kills what children there are, and waits for that. A zygote with a pid of
 *  0 is none. */
void vor_zygote_stop(struct vor_zygote *zygote);

/** True once the zygote has died by itself, and all children with it: no more can be had. Its
 * parent gets SIGCHLD then, and only then. */
int vor_zygote_died(struct vor_zygote *zygote);

/** A child as the front sees it. */
struct vor_child {
    int channel; /**< to its function; VOR_CHANNEL_GONE there means that it has ended, or is about
                    to */
    int watch;   /**< to the zygote; readable once the child has ended */
    pid_t pid;   /**< for logs; not for kill(): the number may be somebody else's by then */
};

/** How a child ended. */
struct vor_child_end {
    int signal;         /**< that killed it; 0 when it ended by itself */
    int status;         /**< then: its exit status */
    double cpu_seconds; /**< user and system */
    uint64_t peak;      /**< bytes of memory, at the most */
};

/** Forks a child of that kind from the zygote; returns once it is there.
 *
 *  @param[in] kind      index in the table
 *  @param[in] fds       copied into the child, and still the caller's; at most VOR_CHILD_FDS
 *
 *  @retval VOR_E_IO  no child: the zygote has died, has VOR_CHILDREN already, or the machine gives
 *                    no process */
VOR_NODISCARD vor_status vor_zygote_spawn(struct vor_child *out, struct vor_zygote *zygote,
                                          unsigned kind, const int *fds, unsigned fd_count,
                                          struct vor_error *err);

/** Waits until a child has ended, `seconds` at most (0 only looks, below 0 is for ever).
 *
 *  @retval true   *end says how; to be asked once. A zygote that has died counts as SIGKILL of the
 *                 child, which it is
 *  @retval false  it still runs */
int vor_child_wait(struct vor_child *child, struct vor_child_end *end, double seconds);

/** Gives a child so many seconds to end (as vor_child_wait), then kills it, and waits until it has
 *  gone, which takes a moment; of one that does not even then *end is all zero. */
enum vor_child_reaped { VOR_CHILD_ENDED, VOR_CHILD_KILLED, VOR_CHILD_STUCK };
enum vor_child_reaped vor_child_reap(struct vor_child *child, struct vor_child_end *end,
                                     double seconds);

/** Kills a child (SIGKILL), unless it has ended; vor_child_wait then tells so, soon. */
void vor_child_kill(struct vor_child *child);

/** Closes both descriptors. A child that still runs is killed. */
void vor_child_free(struct vor_child *child);

#endif
