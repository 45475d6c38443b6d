/** Shuts a process in for good: limits of the kernel, and a list of the system calls that it may
 *  make, any other of which kills it. The one door to libseccomp, which knows the numbers of calls
 * on each architecture. */
#ifndef VOR_SERVER_PROC_SANDBOX_H
#define VOR_SERVER_PROC_SANDBOX_H

#include "core/base/status.h"

#include <stddef.h>

/** The descriptors of a process that is shut in: the one that it may send to and receive from, and
 * the one that it may map to be shared. Others it can only map for reading. */
enum { VOR_SANDBOX_CHANNEL = 3, VOR_SANDBOX_SHARED = 4 };

/** What a process needs. */
struct vor_sandbox {
    size_t memory; /**< bytes of address space beside what it has mapped already; 0: no limit */
    unsigned cpu_seconds; /**< then SIGXCPU */
};

/** What holds, in words of the log and of /readyz. */
enum vor_sandbox_kind {
    VOR_SANDBOX_FULL,
    VOR_SANDBOX_PARTIAL /**< limits, but no list of system calls: the kernel has none, or forbids
                           one; or a sanitizer is built in, which needs calls and memory of its own
                         */
};

/** "full" or "partial". */
const char *vor_sandbox_word(enum vor_sandbox_kind kind);

/** Makes the list of system calls for this process and those that will be forked from it, and finds
 *  out by trying, in a child, if it holds. To be called once, while this process has one thread.
 *
 *  @param[out] why  of VOR_SANDBOX_PARTIAL: a sentence; else unchanged
 *
 *  Cost: some 3 ms. */
enum vor_sandbox_kind vor_sandbox_probe(struct vor_error *why);

/** True in a build with a sanitizer, which is never shut in fully. */
int vor_sandbox_is_sanitizer(void);

/** Shuts this process in, which has one thread. From here it can compute, allocate up to the limit,
 *  read and write through its maps, and talk on the channel: it can open nothing, make no process,
 *  thread or socket, signal nobody, run nothing, map nothing that can be run, and write to no file
 *  but the shared map. No core is dumped of it.
 *
 *  @param[in] kind  what vor_sandbox_probe found; VOR_SANDBOX_PARTIAL sets the limits alone
 *
 *  @retval VOR_E_INTERNAL something of it does not hold; the process must end
 *
 *  Cost: 0.1 ms. */
VOR_NODISCARD vor_status vor_sandbox_enter(const struct vor_sandbox *sandbox,
                                           enum vor_sandbox_kind kind, struct vor_error *err);

#endif
