/** What this process may use of the machine. */
#ifndef VOR_SERVER_BASE_MACHINE_H
#define VOR_SERVER_BASE_MACHINE_H

#include <pthread.h>
#include <stddef.h>

/** Cores, 1 .. VOR_THREADS_MAX: those of the affinity set, which in a container may be fewer than
 *  there are. */
unsigned vor_machine_cores(void);

/** Bytes of memory: the machine's, or what the control group of this process, or one around it, may
 *  take if that is less: in a container, or of a unit with MemoryMax=. */
size_t vor_machine_memory(void);

/** The least limit of memory, in bytes, of the groups that a file as /proc/self/cgroup names and of
 *  those around them, read below root as below /sys/fs/cgroup, of either version; 0 for none. */
size_t vor_machine_group_memory(const char *groups, const char *root);

/** Starts a thread with a name of up to 15 bytes, for those who look at the process from outside.
 *
 *  @return 0, or the error of pthread_create */
int vor_machine_thread(pthread_t *thread, const char *name, void *(*run)(void *arg), void *arg);

/** How soon the kernel, out of memory, ends this process: -1000 never, 1000 first, 0 as any other.
 *  Less than it was is for privileged users; for others nothing changes. */
void vor_machine_set_oom_score(int score);

/** From now on memory that is freed in pieces of 256 KiB and more goes back to the system at once,
 *  in any thread. By default glibc raises its mmap threshold after a large free, and keeps later
 *  pieces in each of its arenas; this fixes the threshold. */
void vor_machine_give_back(void);

#endif
