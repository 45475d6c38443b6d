#define _GNU_SOURCE /* prlimit */

/* A daemon with one HTTP thread on a disk that does not answer: whoever asks for something that has
 * to be on the disk waits, and nobody else does. */
#include "server/base/uuid.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_serve.h"
#include "tests/support/vt_sync.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static int status_of(const struct vt_serve *serve, const char *method, const struct vor_uuid *id,
                     const char *suffix)
{
    char line[128];

    (void)snprintf(line, sizeof line, "%s /v1/jobs/%s%s", method, id->text, suffix);
    return vt_serve_call(serve, line, "", NULL);
}

/* --- jobs ------------------------------------------------------------------------------------- */

static const char *sphere(void)
{
    enum { POINTS = 300 };
    static char text[64 * POINTS];
    int at = snprintf(text, sizeof text,
                      "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\n"
                      "property float y\nproperty float z\nend_header\n",
                      POINTS);
    struct vor_cloud cloud;

    vt_cloud_sphere(&cloud, 1, POINTS);
    for (size_t i = 0; i < 3 * (size_t)POINTS; i += 3)
        at += snprintf(text + at, sizeof text - (size_t)at, "%g %g %g\n", (double)cloud.xyz[i],
                       (double)cloud.xyz[i + 1], (double)cloud.xyz[i + 2]);
    vor_cloud_free(&cloud);
    return text;
}

static struct vor_uuid submit(const struct vt_serve *serve, const char *query)
{
    struct vor_uuid id;
    const char *text, *at;
    char line[128];

    (void)snprintf(line, sizeof line, "POST /v1/resample?%s", query);
    ck_assert_int_eq(
        vt_serve_answer(vt_serve_ask(serve, line, "Prefer: respond-async\r\n", sphere()), &text),
        201);
    at = strstr(text, "\"jobID\":\"");
    ck_assert_ptr_nonnull(at);
    ck_assert(vor_uuid_parse(&id, at + strlen("\"jobID\":\""), 36));
    return id;
}

/* Waits until statusInfo holds a word. */
static void wait_for(const struct vt_serve *serve, const struct vor_uuid *id, const char *word)
{
    char line[128], want[64];
    const char *text;

    (void)snprintf(line, sizeof line, "GET /v1/jobs/%s", id->text);
    (void)snprintf(want, sizeof want, "\"status\":\"%s\"", word);
    for (;;) {
        ck_assert_int_eq(vt_serve_call(serve, line, "", &text), 200);
        if (strstr(text, want) != NULL)
            return;
        vt_nap();
    }
}

static struct vor_uuid finished(const struct vt_serve *serve)
{
    struct vor_uuid id = submit(serve, "points=50&iterations=2");

    wait_for(serve, &id, "successful");
    return id;
}

/* A job that runs until it is told to end. It notes its progress in the store every two seconds,
 * and then waits at the gate as well. */
static struct vor_uuid running(const struct vt_serve *serve)
{
    struct vor_uuid id = submit(serve, "points=300&iterations=10000&polish=0");

    wait_for(serve, &id, "running");
    return id;
}

/* Closes the gate, asks to dismiss a job, returns once that waits at the gate. */
static int dismiss_slowly(const struct vt_serve *serve, const struct vor_uuid *id)
{
    char line[128];
    int fd;

    (void)snprintf(line, sizeof line, "DELETE /v1/jobs/%s", id->text);
    vt_sync_close_after(0);
    fd = vt_serve_ask(serve, line, "", "");
    while (vt_sync_waiting() == 0)
        vt_nap();
    return fd;
}

/* --- tests ------------------------------------------------------------------------------------ */

/* Regression: the one HTTP thread waited for the disk, and with it everybody. */
VT_TEST(nobody_waits_for_the_disk_of_somebody_else_s_dismissal)
{
    static const char *const others[] = {"GET /livez", "GET /readyz", "GET /v1/jobs", "GET /"};
    static const char *const suffixes[] = {
        "", "/results", "/results/cloud", "/results/report", "/trace", "/events"};
    struct vt_serve serve;
    struct vor_uuid done, other;
    const char *text;
    int fd;

    vt_serve_start(&serve, vt_dir_make());
    done = finished(&serve);
    other = finished(&serve);
    fd = dismiss_slowly(&serve, &done);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        ck_assert_int_eq(vt_serve_call(&serve, others[i], "", NULL), 200);
    for (size_t i = 0; i < sizeof suffixes / sizeof suffixes[0]; i++)
        ck_assert_int_eq(status_of(&serve, "GET", &other, suffixes[i]), 200);
    ck_assert_int_eq(status_of(&serve, "POST", &other, "/stop"), 409);
    ck_assert_int_eq(
        vt_serve_answer(vt_serve_ask(&serve, "POST /v1/resample?points=0", "", "x"), NULL), 400);
    ck_assert(!vt_serve_answered(fd));
    ck_assert(vt_sync_open());
    ck_assert_int_eq(vt_serve_answer(fd, &text), 200);
    ck_assert_ptr_nonnull(strstr(text, "\"status\":\"dismissed\""));
    ck_assert_int_eq(status_of(&serve, "GET", &done, ""), 404);
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
}

VT_TEST(nobody_waits_for_the_disk_when_a_caller_leaves)
{
    struct vt_serve serve;
    const char *text;
    int fd;

    vt_serve_start(&serve, vt_dir_make());
    fd = vt_serve_ask(&serve, "POST /v1/resample?points=300&iterations=10000&polish=0", "",
                      sphere());
    do {
        vt_nap();
        ck_assert_int_eq(vt_serve_call(&serve, "GET /v1/jobs?status=running", "", &text), 200);
    } while (strstr(text, "\"jobID\"") == NULL);
    vt_sync_close_after(0);
    close(fd);
    while (strstr(vt_serve_log(&serve), "\"status\":499") == NULL)
        vt_nap();
    ck_assert_int_eq(vt_serve_call(&serve, "GET /livez", "", NULL), 200);
    ck_assert(vt_sync_open());
    do {
        vt_nap();
        ck_assert_int_eq(vt_serve_call(&serve, "GET /v1/jobs?status=dismissed", "", &text), 200);
    } while (strstr(text, "the client disconnected") == NULL);
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
}

/* The first one ends the job, the second one removes it, the others find none. */
VT_TEST_LOOP(dismissals_at_the_same_time_are_answered_as_one_after_another, 2)
{
    enum { MANY = 6 };
    struct vt_serve serve;
    struct vor_uuid id;
    char line[128];
    int fds[MANY], statuses[600] = {0};

    vt_serve_start(&serve, vt_dir_make());
    id = _i == 0 ? running(&serve) : finished(&serve);
    fds[0] = dismiss_slowly(&serve, &id);
    (void)snprintf(line, sizeof line, "DELETE /v1/jobs/%s", id.text);
    for (int i = 1; i < MANY; i++)
        fds[i] = vt_serve_ask(&serve, line, "", "");
    ck_assert_int_eq(vt_serve_call(&serve, "GET /livez", "", NULL), 200);
    ck_assert(vt_sync_open());
    for (int i = 0; i < MANY; i++)
        statuses[vt_serve_answer(fds[i], NULL)]++;
    ck_assert_int_eq(statuses[200], _i == 0 ? 2 : 1);
    ck_assert_int_eq(statuses[404], _i == 0 ? MANY - 2 : MANY - 1);
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
}

VT_TEST(who_closes_his_side_behind_a_dismissal_still_gets_the_answer)
{
    struct vt_serve serve;
    struct vor_uuid id;
    int fd;

    vt_serve_start(&serve, vt_dir_make());
    id = finished(&serve);
    fd = dismiss_slowly(&serve, &id);
    ck_assert_int_eq(shutdown(fd, SHUT_WR), 0);
    ck_assert_int_eq(vt_serve_call(&serve, "GET /livez", "", NULL), 200);
    vt_nap();
    ck_assert(vt_sync_open());
    ck_assert_int_eq(vt_serve_answer(fd, NULL), 200);
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
}

VT_TEST(a_dismissal_whose_caller_left_is_done_all_the_same)
{
    struct vt_serve serve;
    struct vor_uuid id;

    vt_serve_start(&serve, vt_dir_make());
    id = running(&serve);
    close(dismiss_slowly(&serve, &id));
    ck_assert_int_eq(vt_serve_call(&serve, "GET /livez", "", NULL), 200);
    ck_assert(vt_sync_open());
    wait_for(&serve, &id, "dismissed");
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
}

VT_TEST(a_dismissal_with_a_body_is_answered)
{
    struct vt_serve serve;
    struct vor_uuid id;
    char line[128];
    int fd;

    vt_serve_start(&serve, vt_dir_make());
    id = finished(&serve);
    (void)snprintf(line, sizeof line, "DELETE /v1/jobs/%s", id.text);
    vt_sync_close_after(0);
    fd = vt_serve_ask(&serve, line, "", "a body that nobody wants");
    while (vt_sync_waiting() == 0)
        vt_nap();
    ck_assert(vt_sync_open());
    ck_assert_int_eq(vt_serve_answer(fd, NULL), 200);
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
}

VT_TEST(a_dismissal_under_way_is_answered_before_the_daemon_ends)
{
    struct timespec pause = {.tv_nsec = 300000000};
    struct vt_serve serve;
    struct vor_uuid id;
    int fd, status;

    vt_serve_start(&serve, vt_dir_make());
    id = finished(&serve);
    fd = dismiss_slowly(&serve, &id);
    ck_assert_int_eq(kill(serve.pid, SIGTERM), 0);
    nanosleep(&pause, NULL);
    ck_assert(!vt_serve_answered(fd));
    ck_assert(vt_sync_open());
    ck_assert_int_eq(vt_serve_answer(fd, NULL), 200);
    ck_assert_int_eq(waitpid(serve.pid, &status, 0), serve.pid);
    ck_assert(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

/* Regression: reads and dismissals for which no thread could be started were told as the daemon's
 * end. */
VT_TEST(who_gets_no_thread_is_told_so)
{
    struct rlimit limit = {RLIM_INFINITY, RLIM_INFINITY}, tight = limit;
    unsigned long pages = 0;
    struct vt_serve serve;
    struct vor_uuid id;
    const char *text;
    char path[64];
    FILE *file;

    vt_serve_start(&serve, vt_dir_make());
    id = finished(&serve);
    (void)snprintf(path, sizeof path, "/proc/%d/statm", (int)serve.pid);
    file = fopen(path, "r");
    ck_assert_ptr_nonnull(file);
    ck_assert_int_eq(fscanf(file, "%lu", &pages), 1);
    ck_assert_int_eq(fclose(file), 0);
    tight.rlim_cur = pages * (unsigned long)sysconf(_SC_PAGESIZE) + ((rlim_t)1 << 20);
    ck_assert_int_eq(prlimit(serve.pid, RLIMIT_AS, &tight, &limit), 0);
    for (int i = 0; i < 3; i++) {
        static const char *const calls[][2] = {
            {"GET", "/trace"}, {"GET", "/events"}, {"DELETE", ""}};
        char line[128];

        (void)snprintf(line, sizeof line, "%s /v1/jobs/%s%s", calls[i][0], id.text, calls[i][1]);
        ck_assert_int_eq(vt_serve_call(&serve, line, "", &text), 503);
        ck_assert_ptr_nonnull(strstr(text, "/problems/store-unavailable"));
        ck_assert_ptr_nonnull(strstr(text, "no thread can be started"));
    }
    ck_assert_int_eq(prlimit(serve.pid, RLIMIT_AS, &limit, NULL), 0);
    ck_assert_int_eq(status_of(&serve, "GET", &id, "/trace"), 200);
    ck_assert_int_eq(status_of(&serve, "DELETE", &id, ""), 200);
    ck_assert_int_eq(vt_serve_stop(&serve), 0);
}
