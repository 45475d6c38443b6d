/* What a child is shut in by that reads strangers' bytes: each thing that it may not do is stopped,
 * and the cause is told; what it says is not believed before it was checked. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* memfd_create */
#endif
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/serve.h"
#include "server/work/codec_child.h"
#include "server/work/codec_run.h"
#include "server/work/ipc_codec.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_serve.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

/* --- children that misbehave ------------------------------------------------------------------ */

/* What order.format stands for in the child below. */
enum deed {
    OPEN,
    SOCKET,
    EXECVE,
    FORK,
    KILL,
    PTRACE,
    WRITE_FILE,
    WRITE_PAST_RING,
    LOOP,
    ALLOCATE,
    THREAD,
    RUN_MEMORY,
    MAP_INPUT_SHARED,
    SLEEP,
    EXIT_WITHOUT_A_WORD,
    LIE_POINTS,
    LIE_BOX,
    LIE_STATUS,
    LIE_WORDS,
    LIE_SIZE,
    LIE_KIND,
    FLOOD,
    DEEDS
};

enum { CHANNEL = VOR_SANDBOX_CHANNEL, RING = VOR_SANDBOX_SHARED, INPUT };

static void *no_thread(void *ctx)
{
    return ctx;
}

static void say(enum vor_said what, const void *of, size_t size)
{
    if (vor_say(CHANNEL, what, of, size) != VOR_OK)
        _exit(1);
}

/* Allocates until there is no more, as a decoder of a bomb does. */
static void allocate_all(void)
{
    enum { PIECE = 1 << 20, PIECES = 4096 };
    struct vor_error error = {0};
    int count = 0;
    char *piece;

    while (count < PIECES && (piece = malloc(PIECE)) != NULL) {
        memset(piece, count, PIECE);
        count++;
    }
    (void)vor_fail(&error, VOR_E_NOMEM, "%s", count < PIECES ? "stopped" : "never");
    say(VOR_SAID_FAILED, &error, sizeof error);
}

static void flood(void)
{
    const uint32_t part = VOR_RING_PART;
    char told;
    struct vor_message message = {.bytes = &told, .capacity = 1};

    for (;;) {
        say(VOR_SAID_PART, &part, sizeof part);
        if (vor_channel_receive(CHANNEL, &message, -1) != VOR_CHANNEL_MESSAGE)
            _exit(1);
    }
}

static void lie(enum deed deed)
{
    struct vor_codec_facts facts = {.points = 1,
                                    .extent = {.n = 1, .low = {0, 0, 0}, .high = {1, 1, 1}}};
    struct vor_error error = {.status = (vor_status)12345};
    const uint32_t part = VOR_RING_PART + 1;

    if (deed == LIE_POINTS)
        facts.points = facts.extent.n = 100000000;
    if (deed == LIE_BOX)
        facts.extent.high[1] = -1;
    if (deed == LIE_WORDS)
        (void)vor_fail(&error, VOR_E_FORMAT, "two\nlines");
    if (deed == LIE_SIZE)
        say(VOR_SAID_PART, &part, sizeof part);
    else if (deed == LIE_STATUS || deed == LIE_WORDS)
        say(VOR_SAID_FAILED, &error, sizeof error);
    else
        say(deed == LIE_KIND ? VOR_SAID_STAGE : VOR_SAID_FOUND, &facts,
            deed == LIE_KIND ? sizeof(enum vor_stage) : sizeof facts);
    (void)poll(NULL, 0, -1);
}

/* The system calls that nothing in the library makes by itself. */
static void call(enum deed deed)
{
    char *const none[] = {NULL};
    pthread_t thread;

    if (deed == OPEN)
        (void)open("/etc/passwd", O_RDONLY);
    if (deed == SOCKET)
        (void)socket(AF_INET, SOCK_STREAM, 0);
    if (deed == EXECVE)
        (void)execve("/bin/true", none, none);
    if (deed == FORK && fork() == 0)
        _exit(0);
    if (deed == KILL)
        (void)kill(getppid(), 0);
    if (deed == PTRACE)
        (void)ptrace(PTRACE_TRACEME, 0, NULL, NULL);
    if (deed == WRITE_FILE && write(INPUT, "x", 1) < 0)
        _exit(2);
    if (deed == THREAD)
        (void)pthread_create(&thread, NULL, no_thread, NULL);
    if (deed == RUN_MEMORY)
        (void)mmap(NULL, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (deed == MAP_INPUT_SHARED)
        (void)mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, INPUT, 0);
}

static void write_past_ring(void)
{
    char *ring = mmap(NULL, VOR_RING_SIZE + 4096, PROT_READ | PROT_WRITE, MAP_SHARED, RING, 0);

    if (ring != MAP_FAILED)
        memset(ring, 1, VOR_RING_SIZE + 4096);
}

static int misbehave(int channel, const int *fds, unsigned fd_count)
{
    static struct vor_codec_start start;
    struct vor_message message = {.bytes = &start, .capacity = sizeof start};
    enum deed deed;
    struct vor_error err;

    (void)fds;
    if (fd_count != 2 || vor_channel_receive(channel, &message, -1) != VOR_CHANNEL_MESSAGE)
        return 1;
    deed = (enum deed)start.order.format;
    start.sandbox.cpu_seconds = deed == LOOP ? 1 : start.sandbox.cpu_seconds;
    if (vor_sandbox_enter(&start.sandbox, start.kind, &err) != VOR_OK)
        return 1;
    if (deed == LOOP)
        for (volatile unsigned long turns = 0;; turns++)
            continue;
    if (deed == ALLOCATE)
        allocate_all();
    if (deed == WRITE_PAST_RING)
        write_past_ring();
    if (deed == SLEEP)
        (void)poll(NULL, 0, -1);
    if (deed == FLOOD)
        flood();
    if (deed >= LIE_POINTS)
        lie(deed);
    call(deed);
    return 0;
}

static const struct vor_child_kind kinds[] = {{"t-rogue", misbehave}, {"t-codec", vor_codec_child}};
enum { ROGUE, CODEC };

/* --- how they are stopped --------------------------------------------------------------------- */

struct fixture {
    struct vor_zygote zygote;
    struct vor_codec_place place;
};

/* Where there can be no list of system calls. */
static int is_spared(void)
{
    return vor_sandbox_is_sanitizer() || getenv("VT_EMULATED") != NULL;
}

static void start(struct fixture *fixture, unsigned kind)
{
    struct vor_error why;

    fixture->place = (struct vor_codec_place){
        .zygote = &fixture->zygote, .kind = kind, .sandbox = vor_sandbox_probe(&why)};
    ck_assert(fixture->place.sandbox == VOR_SANDBOX_FULL || is_spared());
    vt_assert_ok(vor_zygote_start(&fixture->zygote, kinds, 2, &vt_err));
}

static int file_of(const void *bytes, size_t size)
{
    int fd = memfd_create("input", MFD_CLOEXEC);

    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq(write(fd, bytes, size), (ssize_t)size);
    return fd;
}

static vor_status run(const struct fixture *fixture, enum deed deed)
{
    const struct vor_codec_order order = {.op = VOR_CODEC_DECODE,
                                          .size = 16,
                                          .memory = 1 << 20,
                                          .most = 1 << 20,
                                          .format = deed,
                                          .limits = VOR_LIMITS_DEFAULT};
    struct vt_bytes bytes = {0};
    const struct vor_sink sink = {.ctx = &bytes, .write = vt_bytes_write};
    struct vor_codec_facts facts;
    int input = file_of("sixteen bytes...", 16);
    vor_status status = vor_codec_run(&facts, &fixture->place, &order, input, &sink, &vt_err);

    free(bytes.data);
    close(input);
    return status;
}

static const struct {
    enum deed deed;
    vor_status status;
    const char *cause; /* a part of what is told */
} ends[] = {
    {OPEN, VOR_E_FORMAT, "made a system call that is not allowed"},
    {SOCKET, VOR_E_FORMAT, "made a system call that is not allowed"},
    {EXECVE, VOR_E_FORMAT, "made a system call that is not allowed"},
    {FORK, VOR_E_FORMAT, "made a system call that is not allowed"},
    {KILL, VOR_E_FORMAT, "made a system call that is not allowed"},
    {PTRACE, VOR_E_FORMAT, "made a system call that is not allowed"},
    {WRITE_FILE, VOR_E_FORMAT, "made a system call that is not allowed"},
    {WRITE_PAST_RING, VOR_E_FORMAT, "crashed (signal 7"},
    {LOOP, VOR_E_FORMAT, "seconds of CPU time"},
    {ALLOCATE, VOR_E_NOMEM, "stopped"},
    {THREAD, VOR_E_FORMAT, "made a system call that is not allowed"},
    {RUN_MEMORY, VOR_E_FORMAT, "made a system call that is not allowed"},
    {MAP_INPUT_SHARED, VOR_E_FORMAT, "made a system call that is not allowed"},
    {EXIT_WITHOUT_A_WORD, VOR_E_FORMAT, "crashed (signal 0, exit status 0)"},
};
enum { END_COUNT = sizeof ends / sizeof ends[0] };

/* _i: 0 as whoever runs the test, 1 as nobody. */
START_TEST(whatever_a_child_may_not_do_is_stopped_and_the_cause_is_told)
{
    struct fixture fixture;

    if (_i == 1 && getuid() == 0) {
        ck_assert_int_eq(setgid(65534), 0);
        ck_assert_int_eq(setuid(65534), 0);
    }
    start(&fixture, ROGUE);
    for (int i = 0; i < END_COUNT; i++) {
        if (_i == 1 && ends[i].deed == LOOP)
            continue; /* a second of computing */
        vt_assert_fails(ends[i].status, run(&fixture, ends[i].deed));
        ck_assert_msg(strstr(vt_err.message, ends[i].cause) != NULL, "%d: %s", i, vt_err.message);
    }
    vor_zygote_stop(&fixture.zygote);
}
END_TEST

VT_TEST(what_a_child_says_is_not_believed)
{
    struct fixture fixture;

    start(&fixture, ROGUE);
    for (int deed = LIE_POINTS; deed < DEEDS; deed++) {
        vt_assert_fails(VOR_E_FORMAT, run(&fixture, (enum deed)deed));
        ck_assert_msg(strstr(vt_err.message, "invalid message") != NULL, "%d: %s", deed,
                      vt_err.message);
    }
    vor_zygote_stop(&fixture.zygote);
}

static int after_a_moment(void *ctx)
{
    return vor_clock_seconds() > *(double *)ctx;
}

VT_TEST(a_child_that_sleeps_ends_with_its_time_or_its_caller)
{
    struct fixture fixture;
    double began = vor_clock_seconds(), leaves = began + 0.1;

    start(&fixture, ROGUE);
    fixture.place.patience = 0.001;
    vt_assert_fails(VOR_E_FORMAT, run(&fixture, SLEEP));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "seconds of CPU time"));
    fixture.place.patience = 0;
    fixture.place.has_left = after_a_moment;
    fixture.place.ctx = &leaves;
    vt_assert_fails(VOR_E_CANCELLED, run(&fixture, SLEEP));
    ck_assert_double_lt(vor_clock_seconds() - began, 10);
    vor_zygote_stop(&fixture.zygote);
}

/* --- where the kernel takes no list ------------------------------------------------------------
 */

/* From here on this process is told that it may not have a list of system calls, but for this one.
 */
static void forbid_lists(void)
{
    static struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_prctl, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, args[0])),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PR_SET_SECCOMP, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EINVAL),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const struct sock_fprog list = {.len = sizeof filter / sizeof filter[0], .filter = filter};

    ck_assert_int_eq(prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), 0);
    ck_assert_int_eq(prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &list), 0);
}

START_TEST(without_a_list_of_system_calls_no_daemon_starts_unless_that_is_allowed)
{
    static const char post[] = "Content-Type: application/ply\r\n";
    char name[] = "serve", listen[] = "--listen=127.0.0.1:0", data[300];
    char *arguments[] = {name, listen, data, NULL};
    const char *dir = vt_dir_make(), *text;
    struct vt_serve serve;
    int fd;

    (void)snprintf(data, sizeof data, "--data=%s", dir);
    forbid_lists();
    ck_assert_int_eq(vor_sandbox_probe(&vt_err), VOR_SANDBOX_PARTIAL);
    ck_assert_ptr_nonnull(strstr(vt_err.message, "seccomp"));
    ck_assert_int_eq(vor_serve_main(3, arguments), 1);
    ck_assert_int_eq(setenv("VORONOID_ALLOW_WEAK_SANDBOX", "1", 1), 0);
    vt_serve_start(&serve, dir);
    ck_assert_ptr_nonnull(strstr(vt_serve_log(&serve), "sandbox: partial"));
    ck_assert_int_eq(vt_serve_call(&serve, "GET /readyz", "", &text), 200);
    ck_assert_ptr_nonnull(strstr(text, "\"sandbox\":\"partial\""));
    fd = vt_serve_ask(&serve, "POST /v1/convert", post,
                      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                      "property float y\nproperty float z\nend_header\n1 2 3\n");
    ck_assert_int_eq(vt_serve_answer(fd, NULL), 200);
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
}
END_TEST

/* --- real work -------------------------------------------------------------------------------- */

#define PLY_HEAD(n)                                                                                \
    "ply\nformat ascii 1.0\nelement vertex " n                                                     \
    "\nproperty float x\nproperty float y\nproperty float z\nend_header\n"

static const char *const payloads[] = {PLY_HEAD("3") "0 0 0\n1 0 0\n0 1 0\n",
                                       PLY_HEAD("3") "0 0 0\n1 0 0\n",
                                       PLY_HEAD("2") "0 0 0\n1 x 0\n",
                                       PLY_HEAD("4294967295") "0 0 0\n",
                                       PLY_HEAD("1") "0 nan 0\n",
                                       PLY_HEAD("0"),
                                       "DRACO\2\3\1\1",
                                       "no cloud at all",
                                       "ply\nformat nonsense 1.0\n"};
enum { PAYLOADS = sizeof payloads / sizeof payloads[0] };

struct answer {
    vor_status status;
    struct vor_error error;
    struct vor_codec_facts facts;
    struct vt_bytes bytes;
};

static void ask(struct answer *out, const struct vor_codec_place *place,
                const struct vor_codec_order *order, int input)
{
    const struct vor_sink sink = {.ctx = &out->bytes, .write = vt_bytes_write};

    *out = (struct answer){0};
    out->status = vor_codec_run(&out->facts, place, order, input, &sink, &out->error);
}

static void same_answers(const struct fixture *fixture, const struct vor_codec_order *order,
                         int input)
{
    const struct vor_codec_place here = {0};
    struct answer a, b;

    ask(&a, &here, order, input);
    ask(&b, &fixture->place, order, input);
    ck_assert_msg(a.status == b.status, "%s and %s", a.error.message, b.error.message);
    if (a.status == VOR_OK) {
        ck_assert_uint_eq(a.facts.points, b.facts.points);
        ck_assert_uint_eq(a.bytes.size, b.bytes.size);
        ck_assert_mem_eq(a.bytes.data, b.bytes.data, a.bytes.size);
        ck_assert_mem_eq(&a.facts.extent, &b.facts.extent, sizeof a.facts.extent);
    } else {
        ck_assert_str_eq(a.error.message, b.error.message);
        ck_assert_int_eq(a.error.byte_offset, b.error.byte_offset);
        ck_assert_uint_eq(a.error.limit, b.error.limit);
        ck_assert_uint_eq(a.error.got, b.error.got);
    }
    free(a.bytes.data);
    free(b.bytes.data);
}

VT_TEST(a_child_decodes_and_refuses_as_the_calling_thread_does)
{
    struct fixture fixture;

    start(&fixture, CODEC);
    for (int i = 0; i < PAYLOADS; i++) {
        struct vor_codec_order order = {.op = VOR_CODEC_DECODE,
                                        .size = strlen(payloads[i]),
                                        .memory = 1 << 24,
                                        .most = UINT64_MAX,
                                        .limits = VOR_LIMITS_DEFAULT};
        int input = file_of(payloads[i], strlen(payloads[i]));

        same_answers(&fixture, &order, input);
        order.op = VOR_CODEC_INFLATE; /* none of them is gzip */
        same_answers(&fixture, &order, input);
        close(input);
    }
    vor_zygote_stop(&fixture.zygote);
}

/* Several times as many bytes as the ring has. */
VT_TEST(a_large_cloud_comes_whole_through_the_ring)
{
    enum { POINTS = 300000 };
    static const char head[] = "ply\nformat binary_little_endian 1.0\nelement vertex 300000\n"
                               "property float x\nproperty float y\nproperty float z\nend_header\n";
    size_t size = sizeof head - 1 + POINTS * 3 * sizeof(float);
    struct vor_codec_order order = {.op = VOR_CODEC_DECODE,
                                    .size = size,
                                    .memory = 1 << 26,
                                    .most = UINT64_MAX,
                                    .limits = VOR_LIMITS_DEFAULT};
    uint8_t *bytes = malloc(size);
    struct fixture fixture;
    int input;

    ck_assert_ptr_nonnull(bytes);
    memcpy(bytes, head, sizeof head - 1);
    for (size_t i = 0; i < 3 * (size_t)POINTS; i++) {
        float value = (float)vt_unit(1, i);

        memcpy(bytes + sizeof head - 1 + i * sizeof value, &value, sizeof value);
    }
    input = file_of(bytes, size);
    start(&fixture, CODEC);
    same_answers(&fixture, &order, input);
    vor_zygote_stop(&fixture.zygote);
    close(input);
    free(bytes);
}

void vt_suite(Suite *suite)
{
    vor_log_open(STDERR_FILENO, VOR_LOG_OFF);
    if (!is_spared()) {
        vt_add_loop(suite, whatever_a_child_may_not_do_is_stopped_and_the_cause_is_told, 2);
        vt_add(suite, without_a_list_of_system_calls_no_daemon_starts_unless_that_is_allowed);
    }
}
