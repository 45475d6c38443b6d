#include "tests/support/vt_sync.h"

#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

enum { WAIT_MS = 30000 };

struct gate {
    atomic_int closed, passing, waiting, overdue;
};

static struct gate *gate;
static atomic_int rows_fail, bytes_fail; /* of this process alone */

__attribute__((constructor)) static void make_gate(void)
{
    void *shared =
        mmap(NULL, sizeof *gate, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);

    gate = shared != MAP_FAILED ? shared : NULL;
}

static void pass_gate(void)
{
    static const struct timespec nap = {.tv_nsec = 1000000};

    if (gate == NULL || !atomic_load(&gate->closed) || atomic_fetch_sub(&gate->passing, 1) > 0)
        return;
    atomic_fetch_add(&gate->waiting, 1);
    for (int i = 0; i < WAIT_MS && atomic_load(&gate->closed); i++)
        nanosleep(&nap, NULL);
    if (atomic_load(&gate->closed)) {
        atomic_store(&gate->overdue, 1);
        atomic_store(&gate->closed, 0);
    }
    atomic_fetch_sub(&gate->waiting, 1);
}

static int fail(void)
{
    errno = EIO;
    return -1;
}

/* The program's own definitions come before those of the C library, for shared libraries, too. */
int fsync(int fd)
{
    pass_gate();
    return atomic_load(&bytes_fail) ? fail() : (int)syscall(SYS_fsync, fd);
}

int fdatasync(int fd)
{
    pass_gate();
    return atomic_load(&rows_fail) ? fail() : (int)syscall(SYS_fdatasync, fd);
}

void vt_sync_fail(int rows, int bytes)
{
    atomic_store(&rows_fail, rows);
    atomic_store(&bytes_fail, bytes);
}

void vt_sync_close_after(int passing)
{
    atomic_store(&gate->passing, passing);
    atomic_store(&gate->overdue, 0);
    atomic_store(&gate->closed, 1);
}

int vt_sync_left(void)
{
    return atomic_load(&gate->passing);
}

int vt_sync_open(void)
{
    atomic_store(&gate->closed, 0);
    return !atomic_load(&gate->overdue);
}

int vt_sync_waiting(void)
{
    return atomic_load(&gate->waiting);
}
