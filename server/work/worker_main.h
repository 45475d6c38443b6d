/** The worker process: the pool of threads, and a thread for each run that the front orders. It is
 *  forked by the zygote, opens no store and has no credentials; it may crash. */
#ifndef VOR_SERVER_WORK_WORKER_MAIN_H
#define VOR_SERVER_WORK_WORKER_MAIN_H

/** Exit statuses of its own: the pool could not be started, the memory of all runs together is used
 *  up though none of them is over its own. */
enum { VOR_WORKER_NO_POOL = 3, VOR_WORKER_NO_MEMORY = 4 };

/** Runs in the child (struct vor_child_kind): serves the front until it has gone.
 *
 *  @param[in] channel  gives one byte once it is ready, or a struct vor_error instead where the
 *                      engine fails its test of itself (self_test.h); takes struct vor_run_request
 *  @param[in] fds      that of the shared state (ipc_codec.h); and where that says that children
 * encode results, the socket of the zygote. It has no more with it than what the zygote offers: a
 * child that is shut in, or another like itself */
int vor_worker_main(int channel, const int *fds, unsigned fd_count);

#endif
