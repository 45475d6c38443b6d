/* A daemon with one HTTP thread on a disk that does not answer: whoever asks for something that has
 * to be on the disk waits, and nobody else does. */
#include "server/serve.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"
#include "tests/support/vt_sync.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { PATIENCE_MS = 25000, ANSWER_SIZE = 1 << 20 }; /* less than the gate's */

struct serve {
    char dir[256];
    pid_t pid;
    uint16_t port;
};

/* --- the daemon and its clients --------------------------------------------------------------- */

static void nap(void)
{
    struct timespec pause = {.tv_nsec = 2000000};

    nanosleep(&pause, NULL);
}

static void run_daemon(const char *dir)
{
    char name[] = "serve", listen[] = "--listen=127.0.0.1:0", one[] = "--http-threads=1",
         jobs[] = "--jobs=1", threads[] = "--threads=2", data[300], log[300];
    char *arguments[] = {name, listen, one, jobs, threads, data, NULL};
    int fd;

    (void)snprintf(data, sizeof data, "--data=%s", dir);
    (void)snprintf(log, sizeof log, "%s/log", dir);
    fd = open(log, O_CREAT | O_WRONLY | O_APPEND, 0600);
    (void)dup2(fd, STDERR_FILENO);
    exit(vor_serve_main(6, arguments));
}

/* What the daemon has logged (static). */
static const char *log_of(const char *dir)
{
    static char text[1 << 16];
    char path[300];
    ssize_t size;
    int fd;

    (void)snprintf(path, sizeof path, "%s/log", dir);
    fd = open(path, O_RDONLY);
    size = fd >= 0 ? read(fd, text, sizeof text - 1) : 0;
    if (fd >= 0)
        close(fd);
    text[size > 0 ? size : 0] = '\0';
    return text;
}

/* The port that the log tells, 0 as long as it does not. */
static uint16_t port_of(const char *dir)
{
    static const char mark[] = "\"address\":\"127.0.0.1:";
    const char *at = strstr(log_of(dir), mark);

    return at != NULL ? (uint16_t)strtol(at + strlen(mark), NULL, 10) : 0;
}

static void start(struct serve *serve)
{
    (void)snprintf(serve->dir, sizeof serve->dir, "%s", vt_dir_make());
    fflush(NULL);
    serve->pid = fork();
    if (serve->pid == 0)
        run_daemon(serve->dir);
    while ((serve->port = port_of(serve->dir)) == 0)
        nap();
}

static int stop(struct serve *serve)
{
    int status = -1;

    ck_assert_int_eq(kill(serve->pid, SIGTERM), 0);
    ck_assert_int_eq(waitpid(serve->pid, &status, 0), serve->pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

/* Sends a request whose answer ends the connection; the socket. */
static int ask(const struct serve *serve, const char *line, const char *headers, const char *body)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons(serve->port)};
    char head[1024];
    int size, fd = socket(AF_INET, SOCK_STREAM, 0);

    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ck_assert_int_eq(connect(fd, (struct sockaddr *)&at, sizeof at), 0);
    size = snprintf(head, sizeof head,
                    "%s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n%s"
                    "Content-Length: %zu\r\n\r\n",
                    line, headers, strlen(body));
    ck_assert_int_eq(send(fd, head, (size_t)size, MSG_NOSIGNAL), size);
    ck_assert_int_eq(send(fd, body, strlen(body), MSG_NOSIGNAL), (ssize_t)strlen(body));
    return fd;
}

/* The status of the answer, 0 when none comes in time; *text gets all of it (static). */
static int answer(int fd, const char **text)
{
    static char bytes[ANSWER_SIZE];
    size_t size = 0;
    ssize_t got = 1;

    while (got > 0 && size < sizeof bytes - 1) {
        struct pollfd wait = {.fd = fd, .events = POLLIN};

        if (poll(&wait, 1, PATIENCE_MS) <= 0)
            break;
        got = recv(fd, bytes + size, sizeof bytes - 1 - size, 0);
        size += got > 0 ? (size_t)got : 0;
    }
    close(fd);
    bytes[size] = '\0';
    if (text != NULL)
        *text = bytes;
    return strncmp(bytes, "HTTP/1.1 ", 9) == 0 ? (int)strtol(bytes + 9, NULL, 10) : 0;
}

static int status_of(const struct serve *serve, const char *method, const struct vor_uuid *id,
                     const char *suffix)
{
    char line[128];

    (void)snprintf(line, sizeof line, "%s /v1/jobs/%s%s", method, id->text, suffix);
    return answer(ask(serve, line, "", ""), NULL);
}

static int has_answered(int fd)
{
    struct pollfd now = {.fd = fd, .events = POLLIN};

    return poll(&now, 1, 0) > 0;
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

static struct vor_uuid submit(const struct serve *serve, const char *query)
{
    struct vor_uuid id;
    const char *text, *at;
    char line[128];

    (void)snprintf(line, sizeof line, "POST /v1/resample?%s", query);
    ck_assert_int_eq(answer(ask(serve, line, "Prefer: respond-async\r\n", sphere()), &text), 201);
    at = strstr(text, "\"jobID\":\"");
    ck_assert_ptr_nonnull(at);
    ck_assert(vor_uuid_parse(&id, at + strlen("\"jobID\":\""), 36));
    return id;
}

/* Waits until statusInfo holds a word. */
static void wait_for(const struct serve *serve, const struct vor_uuid *id, const char *word)
{
    char line[128], want[64];
    const char *text;

    (void)snprintf(line, sizeof line, "GET /v1/jobs/%s", id->text);
    (void)snprintf(want, sizeof want, "\"status\":\"%s\"", word);
    for (;;) {
        ck_assert_int_eq(answer(ask(serve, line, "", ""), &text), 200);
        if (strstr(text, want) != NULL)
            return;
        nap();
    }
}

static struct vor_uuid finished(const struct serve *serve)
{
    struct vor_uuid id = submit(serve, "points=50&iterations=2");

    wait_for(serve, &id, "successful");
    return id;
}

/* A job that runs until it is told to end. It notes its progress in the store every two seconds,
 * and then waits at the gate as well. */
static struct vor_uuid running(const struct serve *serve)
{
    struct vor_uuid id = submit(serve, "points=300&iterations=10000&polish=0");

    wait_for(serve, &id, "running");
    return id;
}

/* Closes the gate, asks to dismiss a job, returns once that waits at the gate. */
static int dismiss_slowly(const struct serve *serve, const struct vor_uuid *id)
{
    char line[128];
    int fd;

    (void)snprintf(line, sizeof line, "DELETE /v1/jobs/%s", id->text);
    vt_sync_close_after(0);
    fd = ask(serve, line, "", "");
    while (vt_sync_waiting() == 0)
        nap();
    return fd;
}

/* --- tests ------------------------------------------------------------------------------------ */

/* Regression: the one HTTP thread waited for the disk, and with it everybody. */
START_TEST(nobody_waits_for_the_disk_of_somebody_else_s_dismissal)
{
    static const char *const others[] = {"GET /livez", "GET /readyz", "GET /v1/jobs", "GET /"};
    static const char *const suffixes[] = {
        "", "/results", "/results/cloud", "/results/report", "/trace", "/events"};
    struct serve serve;
    struct vor_uuid done, other;
    const char *text;
    int fd;

    start(&serve);
    done = finished(&serve);
    other = finished(&serve);
    fd = dismiss_slowly(&serve, &done);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        ck_assert_int_eq(answer(ask(&serve, others[i], "", ""), NULL), 200);
    for (size_t i = 0; i < sizeof suffixes / sizeof suffixes[0]; i++)
        ck_assert_int_eq(status_of(&serve, "GET", &other, suffixes[i]), 200);
    ck_assert_int_eq(status_of(&serve, "POST", &other, "/stop"), 409);
    ck_assert_int_eq(answer(ask(&serve, "POST /v1/resample?points=0", "", "x"), NULL), 400);
    ck_assert(!has_answered(fd));
    ck_assert(vt_sync_open());
    ck_assert_int_eq(answer(fd, &text), 200);
    ck_assert_ptr_nonnull(strstr(text, "\"status\":\"dismissed\""));
    ck_assert_int_eq(status_of(&serve, "GET", &done, ""), 404);
    ck_assert_int_eq(stop(&serve), 0);
    vt_dir_remove(serve.dir);
}
END_TEST

START_TEST(nobody_waits_for_the_disk_when_a_caller_leaves)
{
    struct serve serve;
    const char *text;
    int fd;

    start(&serve);
    fd = ask(&serve, "POST /v1/resample?points=300&iterations=10000&polish=0", "", sphere());
    do {
        nap();
        ck_assert_int_eq(answer(ask(&serve, "GET /v1/jobs?status=running", "", ""), &text), 200);
    } while (strstr(text, "\"jobID\"") == NULL);
    vt_sync_close_after(0);
    close(fd);
    while (strstr(log_of(serve.dir), "\"status\":499") == NULL)
        nap();
    ck_assert_int_eq(answer(ask(&serve, "GET /livez", "", ""), NULL), 200);
    ck_assert(vt_sync_open());
    do {
        nap();
        ck_assert_int_eq(answer(ask(&serve, "GET /v1/jobs?status=dismissed", "", ""), &text), 200);
    } while (strstr(text, "the caller left") == NULL);
    ck_assert_int_eq(stop(&serve), 0);
    vt_dir_remove(serve.dir);
}
END_TEST

/* The first one ends the job, the second one removes it, the others find none. */
START_TEST(dismissals_at_the_same_time_are_answered_as_one_after_another)
{
    enum { MANY = 6 };
    struct serve serve;
    struct vor_uuid id;
    char line[128];
    int fds[MANY], statuses[600] = {0};

    start(&serve);
    id = _i == 0 ? running(&serve) : finished(&serve);
    fds[0] = dismiss_slowly(&serve, &id);
    (void)snprintf(line, sizeof line, "DELETE /v1/jobs/%s", id.text);
    for (int i = 1; i < MANY; i++)
        fds[i] = ask(&serve, line, "", "");
    ck_assert_int_eq(answer(ask(&serve, "GET /livez", "", ""), NULL), 200);
    ck_assert(vt_sync_open());
    for (int i = 0; i < MANY; i++)
        statuses[answer(fds[i], NULL)]++;
    ck_assert_int_eq(statuses[200], _i == 0 ? 2 : 1);
    ck_assert_int_eq(statuses[404], _i == 0 ? MANY - 2 : MANY - 1);
    ck_assert_int_eq(stop(&serve), 0);
    vt_dir_remove(serve.dir);
}
END_TEST

START_TEST(who_closes_his_side_behind_a_dismissal_still_gets_the_answer)
{
    struct serve serve;
    struct vor_uuid id;
    int fd;

    start(&serve);
    id = finished(&serve);
    fd = dismiss_slowly(&serve, &id);
    ck_assert_int_eq(shutdown(fd, SHUT_WR), 0);
    ck_assert_int_eq(answer(ask(&serve, "GET /livez", "", ""), NULL), 200);
    nap();
    ck_assert(vt_sync_open());
    ck_assert_int_eq(answer(fd, NULL), 200);
    ck_assert_int_eq(stop(&serve), 0);
    vt_dir_remove(serve.dir);
}
END_TEST

START_TEST(a_dismissal_whose_caller_left_is_done_all_the_same)
{
    struct serve serve;
    struct vor_uuid id;

    start(&serve);
    id = running(&serve);
    close(dismiss_slowly(&serve, &id));
    ck_assert_int_eq(answer(ask(&serve, "GET /livez", "", ""), NULL), 200);
    ck_assert(vt_sync_open());
    wait_for(&serve, &id, "dismissed");
    ck_assert_int_eq(stop(&serve), 0);
    vt_dir_remove(serve.dir);
}
END_TEST

START_TEST(a_dismissal_with_a_body_is_answered)
{
    struct serve serve;
    struct vor_uuid id;
    char line[128];
    int fd;

    start(&serve);
    id = finished(&serve);
    (void)snprintf(line, sizeof line, "DELETE /v1/jobs/%s", id.text);
    vt_sync_close_after(0);
    fd = ask(&serve, line, "", "a body that nobody wants");
    while (vt_sync_waiting() == 0)
        nap();
    ck_assert(vt_sync_open());
    ck_assert_int_eq(answer(fd, NULL), 200);
    ck_assert_int_eq(stop(&serve), 0);
    vt_dir_remove(serve.dir);
}
END_TEST

START_TEST(a_dismissal_under_way_is_answered_before_the_daemon_ends)
{
    struct timespec pause = {.tv_nsec = 300000000};
    struct serve serve;
    struct vor_uuid id;
    int fd, status;

    start(&serve);
    id = finished(&serve);
    fd = dismiss_slowly(&serve, &id);
    ck_assert_int_eq(kill(serve.pid, SIGTERM), 0);
    nanosleep(&pause, NULL);
    ck_assert(!has_answered(fd));
    ck_assert(vt_sync_open());
    ck_assert_int_eq(answer(fd, NULL), 200);
    ck_assert_int_eq(waitpid(serve.pid, &status, 0), serve.pid);
    ck_assert(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    vt_dir_remove(serve.dir);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("serve_disk");

    vt_add(suite, nobody_waits_for_the_disk_of_somebody_else_s_dismissal);
    vt_add(suite, nobody_waits_for_the_disk_when_a_caller_leaves);
    vt_add_loop(suite, dismissals_at_the_same_time_are_answered_as_one_after_another, 2);
    vt_add(suite, who_closes_his_side_behind_a_dismissal_still_gets_the_answer);
    vt_add(suite, a_dismissal_whose_caller_left_is_done_all_the_same);
    vt_add(suite, a_dismissal_with_a_body_is_answered);
    vt_add(suite, a_dismissal_under_way_is_answered_before_the_daemon_ends);
    return vt_run(suite);
}
