#define _GNU_SOURCE /* memfd_create */
#include "server/proc/sandbox.h"

#include <errno.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <seccomp.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define HAS_SANITIZER 1
#endif
#endif
#ifndef HAS_SANITIZER
#define HAS_SANITIZER 0
#endif

/* Beside the three standard ones: input, shared file, channel, and room for what the C library may
 * hold for a moment. */
enum { FDS = 8 };

/* Most instructions of the list, of which the kernel takes 4096; it has some 100. */
enum { PROGRAM_MAX = 1024 };

const char *vor_sandbox_word(enum vor_sandbox_kind kind)
{
    return kind == VOR_SANDBOX_FULL ? "full" : "partial";
}

int vor_sandbox_is_sanitizer(void)
{
    return HAS_SANITIZER;
}

/* --- limits ----------------------------------------------------------------------------------- */

/* Bytes of address space that this process has, and those forked from it begin with. A binary with
 * its libraries has 33 MB; where /proc does not tell, four times as much is taken for it. */
static const size_t MAPPED_GUESS = (size_t)128 << 20;
static size_t mapped;

static size_t mapped_bytes(void)
{
    FILE *file = fopen("/proc/self/statm", "re");
    unsigned long pages = 0;

    if (file == NULL)
        return MAPPED_GUESS;
    if (fscanf(file, "%lu", &pages) != 1)
        pages = 0;
    (void)fclose(file);
    return pages > 0 ? pages * (size_t)sysconf(_SC_PAGESIZE) : MAPPED_GUESS;
}

/* spare: how much further the hard limit is. */
static vor_status limit(int what, rlim_t most, rlim_t spare, const char *name,
                        struct vor_error *err)
{
    struct rlimit now, wanted = {.rlim_cur = most, .rlim_max = most + spare};

    /* One that is lower already stays so. */
    if (getrlimit((__rlimit_resource_t)what, &now) == 0 && now.rlim_max < wanted.rlim_max)
        wanted.rlim_max = now.rlim_max;
    if (wanted.rlim_cur > wanted.rlim_max)
        wanted.rlim_cur = wanted.rlim_max;
    if (setrlimit((__rlimit_resource_t)what, &wanted) == 0)
        return VOR_OK;
    return vor_fail(err, VOR_E_INTERNAL, "cannot set the limit of %s: error %d", name, errno);
}

static vor_status set_limits(const struct vor_sandbox *sandbox, struct vor_error *err)
{
    vor_status status = limit(RLIMIT_CORE, 0, 0, "core files", err);

    VOR_THEN(status, limit(RLIMIT_FSIZE, 0, 0, "file sizes", err));
    VOR_THEN(status, limit(RLIMIT_NOFILE, FDS, 0, "descriptors", err));
    VOR_THEN(status, limit(RLIMIT_NPROC, 0, 0, "processes", err));
    if (status == VOR_OK)
        /* The soft one is told apart from being killed for want of memory. */
        status = limit(RLIMIT_CPU, sandbox->cpu_seconds, 1, "CPU time", err);
    if (status == VOR_OK && sandbox->memory > 0 && mapped > 0)
        status = limit(RLIMIT_AS, mapped + sandbox->memory, 0, "memory", err);
    return status;
}

/* --- system calls ----------------------------------------------------------------------------- */

/* Whatever its arguments: memory given back, waiting, clocks, the end. */
static const int free_calls[] = {
    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(brk),
    SCMP_SYS(madvise),
    SCMP_SYS(futex),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
    SCMP_SYS(poll),
    SCMP_SYS(ppoll),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(restart_syscall),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sysinfo) /* qsort asks how much memory there is */
};

/* Nothing that can be run is mapped, and only one file to be shared, where writing would reach it;
 * the others for reading. */
static int allow_calls(scmp_filter_ctx filter)
{
    const struct scmp_arg_cmp not_run = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0);
    const struct scmp_arg_cmp there = SCMP_A0(SCMP_CMP_EQ, VOR_SANDBOX_CHANNEL);
    int failed =
        seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 2, not_run,
                         SCMP_A3(SCMP_CMP_MASKED_EQ, MAP_SHARED | MAP_PRIVATE, MAP_PRIVATE));

    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 3, not_run,
                               SCMP_A3(SCMP_CMP_MASKED_EQ, MAP_SHARED | MAP_PRIVATE, MAP_SHARED),
                               SCMP_A4(SCMP_CMP_EQ, VOR_SANDBOX_SHARED));
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 1, not_run);
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(sendmsg), 1, there);
    failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(recvmsg), 1, there);
    for (size_t i = 0; i < sizeof free_calls / sizeof free_calls[0]; i++)
        failed |= seccomp_rule_add(filter, SCMP_ACT_ALLOW, free_calls[i], 0);
    return failed;
}

/* The list as the kernel takes it, made once: libseccomp takes 1.5 ms for it, children begin by the
 * hundred. */
static struct sock_filter program[PROGRAM_MAX];
static unsigned short program_length;

static vor_status make_program(struct vor_error *err)
{
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_KILL_PROCESS);
    int fd = memfd_create("filter", MFD_CLOEXEC); /* libseccomp writes programs to files only */
    ssize_t size = -1;

    if (filter != NULL && allow_calls(filter) == 0 && fd >= 0 &&
        seccomp_export_bpf(filter, fd) == 0)
        size = pread(fd, program, sizeof program, 0);
    if (fd >= 0)
        (void)close(fd);
    seccomp_release(filter);
    if (size <= 0 || size == (ssize_t)sizeof program)
        return vor_fail(err, VOR_E_INTERNAL, "libseccomp cannot create a filter for system calls");
    program_length = (unsigned short)((size_t)size / sizeof program[0]);
    return VOR_OK;
}

vor_status vor_sandbox_enter(const struct vor_sandbox *sandbox, enum vor_sandbox_kind kind,
                             struct vor_error *err)
{
    const struct sock_fprog list = {.len = program_length, .filter = program};
    vor_status status = set_limits(sandbox, err);

    if (status != VOR_OK)
        return status;
    (void)prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return vor_fail(err, VOR_E_INTERNAL, "cannot set no_new_privs: error %d", errno);
    if (kind != VOR_SANDBOX_FULL ||
        (program_length > 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &list) == 0))
        return VOR_OK;
    return vor_fail(err, VOR_E_INTERNAL,
                    "the kernel does not accept a filter for system calls: error %d", errno);
}

/* --- what holds ------------------------------------------------------------------------------- */

enum vor_sandbox_kind vor_sandbox_probe(struct vor_error *why)
{
    const struct vor_sandbox tried = {.cpu_seconds = 10};
    struct vor_error err;
    int status = -1;
    pid_t pid;

    mapped = HAS_SANITIZER ? 0 : mapped_bytes(); /* 0: no limit */
    if (HAS_SANITIZER) {
        (void)vor_fail(why, VOR_E_INTERNAL,
                       "this build has a sanitizer, which needs more system calls");
        return VOR_SANDBOX_PARTIAL;
    }
    if (make_program(why) != VOR_OK)
        return VOR_SANDBOX_PARTIAL;
    pid = fork();
    if (pid == 0)
        _exit(vor_sandbox_enter(&tried, VOR_SANDBOX_FULL, &err) == VOR_OK ? EXIT_SUCCESS
                                                                          : EXIT_FAILURE);
    while (pid > 0 && waitpid(pid, &status, 0) < 0 && errno == EINTR)
        continue;
    if (pid > 0 && WIFEXITED(status) && WEXITSTATUS(status) == EXIT_SUCCESS)
        return VOR_SANDBOX_FULL;
    (void)vor_fail(
        why, VOR_E_INTERNAL,
        "this kernel or its container does not support filters of system calls (seccomp)");
    return VOR_SANDBOX_PARTIAL;
}
