/* The order of life: settings, store, blobs, socket, pool, jobs, admission, HTTP; then wait for a
 * signal; then the same backwards. */
#include "server/serve.h"

#include "server/api/app.h"
#include "server/api/routes.h"
#include "server/base/clock.h"
#include "server/base/descriptors.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/cli/say.h"
#include "server/work/admit.h"
#include "server/work/conversion.h"

#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    ADMIT_WAITING_MAX = 64,
    CRASHES_MAX = 2,
    SETTLE_SECONDS = 2, /* for what was handed to other threads, and for answers, after the drain */
    LAST_SECONDS = 1    /* for connections that were cut to be closed */
};
static const double farewell_seconds =
    0.2; /* so long kept connections are told Connection: close */

/* The parts, in the order in which they start. */
struct daemon {
    struct vor_config config;
    struct vor_app app;
    struct vor_pool *pool;
    sigset_t signals;
    pthread_t drainer;
    long holder;
    int argc; /* of the command line, for a reload */
    char **argv;
};

static size_t job_memory(const struct vor_config *config)
{
    double asked = config->number[VOR_SET_JOB_MEMORY];

    if (asked > 0)
        return (size_t)asked;
    return (size_t)((double)vor_machine_memory() * 0.7 / config->number[VOR_SET_JOBS]);
}

static unsigned thread_count(const struct vor_config *config)
{
    unsigned asked = (unsigned)config->number[VOR_SET_THREADS];

    return asked > 0 ? asked : vor_machine_cores();
}

static vor_status open_storage(struct daemon *daemon, struct vor_error *err)
{
    struct vor_config *config = &daemon->config;
    vor_status status =
        vor_store_open(&daemon->app.store, config->text[VOR_SET_STORE], &daemon->holder, err);

    if (status == VOR_OK)
        status =
            vor_blobs_open(&daemon->app.blobs, config->text[VOR_SET_BLOBS], &daemon->holder, err);
    return status;
}

/* Results are converted where uploads are decoded, as many at a time as there are cores. */
static vor_status start_conversions(struct daemon *daemon, struct vor_error *err)
{
    struct vor_conversions_config conversions = {.blobs = daemon->app.blobs,
                                                 .worker = daemon->app.worker,
                                                 .crew = vor_admit_crew(daemon->app.admit),
                                                 .memory = job_memory(&daemon->config),
                                                 .most = vor_machine_cores()};

    return vor_conversions_create(&daemon->app.conversions, &conversions, err);
}

static vor_status start_jobs(struct daemon *daemon, struct vor_error *err)
{
    const struct vor_config *config = &daemon->config;
    struct vor_worker_config worker = {
        .store = daemon->app.store,
        .blobs = daemon->app.blobs,
        .jobs = (unsigned)config->number[VOR_SET_JOBS],
        .queue = (size_t)config->number[VOR_SET_QUEUE],
        .memory = job_memory(config),
        .ttl_seconds = config->number[VOR_SET_RESULT_TTL],
        .crashes_max = CRASHES_MAX,
        .keep = (uint64_t)config->number[VOR_SET_KEEP_INPUTS],
    };
    struct vor_admit_limits limits = {
        .codec = VOR_LIMITS_DEFAULT, .memory = job_memory(config), .keep = worker.keep};
    vor_status status = vor_pool_create(&daemon->pool, thread_count(config), err);

    limits.codec.points = (size_t)config->number[VOR_SET_POINTS_LIMIT];
    limits.inflated = (uint64_t)config->number[VOR_SET_BODY_LIMIT];
    worker.pool = daemon->pool;
    daemon->app.inflight = vor_inflight_create();
    if (daemon->app.inflight == NULL && status == VOR_OK)
        status = vor_fail(err, VOR_E_NOMEM, "the keys of requests");
    if (status == VOR_OK)
        status = vor_worker_create(&daemon->app.worker, &worker, err);
    if (status == VOR_OK)
        status = vor_admit_create(&daemon->app.admit, daemon->app.blobs, &limits, worker.jobs,
                                  ADMIT_WAITING_MAX, err);
    return status == VOR_OK ? start_conversions(daemon, err) : status;
}

static void library_line(void *ctx, const char *line)
{
    (void)ctx;
    vor_log(VOR_LOG_DEBUG, "http library", VOR_TEXT("detail", line));
}

static vor_status open_http(struct daemon *daemon, struct vor_error *err)
{
    const struct vor_config *config = &daemon->config;
    const struct vor_http_options options = {
        .host = config->host,
        .port = config->port,
        .threads = (unsigned)config->number[VOR_SET_HTTP_THREADS],
        .connections = (unsigned)config->number[VOR_SET_CONNECTIONS],
        .streams = (unsigned)config->number[VOR_SET_STREAMS],
        .each = (unsigned)config->number[VOR_SET_ADDRESS_CONNECTIONS],
        .header_seconds = config->number[VOR_SET_HEADER_TIMEOUT],
        .keep_seconds = config->number[VOR_SET_KEEP_TIMEOUT],
        .body_seconds = config->number[VOR_SET_BODY_TIMEOUT],
        .body_idle_seconds = config->number[VOR_SET_BODY_IDLE],
        .body_rate = config->number[VOR_SET_BODY_RATE],
        .reply_rate = config->number[VOR_SET_REPLY_RATE],
        .beat_seconds = config->number[VOR_SET_HEARTBEAT],
        .trusted = &config->trusted,
        .proxy_headers = (enum vor_proxy_headers)config->number[VOR_SET_PROXY_HEADERS],
        .handler = vor_route_dispatch,
        .ctx = &daemon->app,
        .refuse = vor_route_refuse,
        .done = vor_route_done,
        .log = library_line,
    };

    return vor_http_open(&daemon->app.http, &options, err);
}

/* The address comes before the jobs, so that a daemon whose address is taken touches none. Who
 * connects meanwhile is answered once every job of a former life is back in line: the threads come
 * last. */
static vor_status start(struct daemon *daemon, struct vor_error *err)
{
    vor_status status = vor_descriptors_raise(&daemon->config, err);

    if (status == VOR_OK)
        status = open_storage(daemon, err);
    if (status == VOR_OK)
        status = open_http(daemon, err);
    if (status == VOR_OK)
        status = start_jobs(daemon, err);
    if (status == VOR_OK)
        status = vor_http_start(daemon->app.http, err);
    return status;
}

static void stop(struct daemon *daemon)
{
    vor_http_stop(daemon->app.http);
    vor_admit_destroy(daemon->app.admit);
    vor_conversions_destroy(daemon->app.conversions);
    vor_worker_destroy(daemon->app.worker);
    vor_inflight_destroy(daemon->app.inflight);
    vor_pool_destroy(daemon->pool);
    vor_blobs_close(daemon->app.blobs);
    vor_store_close(daemon->app.store);
}

/* Waits until no request is under way, or until then. */
static void wait_quiet(struct daemon *daemon, double until)
{
    const struct timespec pause = {0, 10 * 1000 * 1000};

    while (vor_http_busy(daemon->app.http) > 0 && vor_clock_seconds() < until)
        (void)nanosleep(&pause, NULL);
}

/* Drains the daemon on a thread of its own, while the main thread waits for a second signal. Ends
 * by sending that signal itself. Jobs, uploads and answers have the same time to end in; who is
 * slower is cut. */
static void *drain(void *ctx)
{
    const struct timespec farewell = {0, (long)(farewell_seconds * 1e9)};
    struct daemon *daemon = ctx;
    double seconds = daemon->config.number[VOR_SET_DRAIN_TIMEOUT];
    double until = vor_clock_seconds() + seconds;

    atomic_store(&daemon->app.draining, true);
    vor_http_wake_all(daemon->app.http);
    vor_worker_drain(daemon->app.worker, seconds);
    vor_http_quiesce(daemon->app.http);
    vor_worker_settle(daemon->app.worker, SETTLE_SECONDS);
    vor_http_close_waiting(daemon->app.http);
    (void)nanosleep(&farewell, NULL);
    if (until < vor_clock_seconds() + SETTLE_SECONDS)
        until = vor_clock_seconds() + SETTLE_SECONDS;
    wait_quiet(daemon, until);
    if (vor_http_busy(daemon->app.http) > 0)
        vor_log(VOR_LOG_WARN, "slow clients are cut",
                VOR_COUNT("requests", vor_http_busy(daemon->app.http)));
    vor_http_cut_slow(daemon->app.http);
    wait_quiet(daemon, vor_clock_seconds() + LAST_SECONDS);
    (void)kill(getpid(), SIGUSR2);
    return NULL;
}

static int wait_signal(const struct daemon *daemon)
{
    int number = 0;

    while (sigwait(&daemon->signals, &number) != 0)
        number = 0;
    return number;
}

/* SIGUSR2 comes from drain. Before a signal that ends it is ignored. */
static void block_signals(struct daemon *daemon)
{
    static const int numbers[] = {SIGTERM, SIGINT, SIGQUIT, SIGUSR1, SIGHUP, SIGUSR2};

    (void)signal(SIGPIPE, SIG_IGN);
    (void)sigemptyset(&daemon->signals);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        (void)sigaddset(&daemon->signals, numbers[i]);
    (void)pthread_sigmask(SIG_BLOCK, &daemon->signals, NULL);
}

static const char *signal_word(int number)
{
    switch (number) {
    case SIGINT:
        return "INT";
    case SIGQUIT:
        return "QUIT";
    case SIGUSR1:
        return "USR1";
    default:
        return "TERM";
    }
}

/* SIGHUP: reads the settings again and takes those that may change while the daemon runs. All of
 * them must be sound, or none is taken. */
static void reload(struct daemon *daemon)
{
    struct vor_config *fresh = calloc(1, sizeof *fresh);
    struct vor_error err = {.status = VOR_E_NOMEM, .message = "no memory"};

    if (fresh == NULL ||
        vor_config_read(fresh, daemon->argc, daemon->argv, getenv, &err) != VOR_OK) {
        vor_log(VOR_LOG_ERROR, "settings not reloaded", VOR_TEXT("error", err.message));
        free(fresh);
        return;
    }
    daemon->config.number[VOR_SET_LOG_LEVEL] = fresh->number[VOR_SET_LOG_LEVEL];
    vor_log_open(STDERR_FILENO, (enum vor_log_level)fresh->number[VOR_SET_LOG_LEVEL]);
    /* Keys are read again here, once there are any. */
    vor_log(VOR_LOG_INFO, "settings reloaded");
    free(fresh);
}

/* The signal that ends the daemon. */
static int wait_end(struct daemon *daemon)
{
    for (;;) {
        int number = wait_signal(daemon);

        if (number == SIGHUP)
            reload(daemon);
        else if (number != SIGUSR2)
            return number;
    }
}

/* SIGHUP while the daemon drains changes nothing any more. */
static int wait_drained(struct daemon *daemon)
{
    int number;

    do
        number = wait_signal(daemon);
    while (number == SIGHUP);
    return number;
}

static int run(struct daemon *daemon)
{
    int number = wait_end(daemon);

    vor_log(VOR_LOG_INFO, "draining", VOR_TEXT("signal", signal_word(number)));
    if (pthread_create(&daemon->drainer, NULL, drain, daemon) != 0)
        _exit(VOR_EXIT_FAILED);
    number = wait_drained(daemon);
    if (number != SIGUSR2) {
        /* Running jobs are still in the store as such; the next start takes them up again. */
        vor_log(VOR_LOG_WARN, "stopped at once", VOR_COUNT("signal", number));
        _exit(VOR_EXIT_FAILED);
    }
    (void)pthread_join(daemon->drainer, NULL);
    return VOR_EXIT_OK;
}

static int failed_start(const struct daemon *daemon, const struct vor_error *err)
{
    (void)fprintf(stderr, "voronoid: %s\n", err->message);
    if (daemon->holder != 0)
        return VOR_EXIT_IN_USE;
    return err->status == VOR_E_PARAM ? VOR_EXIT_USAGE : VOR_EXIT_FAILED;
}

static int serve(struct daemon *daemon)
{
    struct vor_error err;
    int result;

    block_signals(daemon);
    vor_log_open(STDERR_FILENO, (enum vor_log_level)daemon->config.number[VOR_SET_LOG_LEVEL]);
    daemon->app.config = &daemon->config;
    if (start(daemon, &err) != VOR_OK) {
        result = failed_start(daemon, &err);
    } else {
        vor_log(VOR_LOG_INFO, "listening", VOR_TEXT("address", vor_http_address(daemon->app.http)),
                VOR_TEXT("data", daemon->config.text[VOR_SET_DATA]),
                VOR_COUNT("threads", vor_pool_threads(daemon->pool)),
                VOR_COUNT("job_memory", job_memory(&daemon->config)));
        result = run(daemon);
        vor_log(VOR_LOG_INFO, "stopped", VOR_COUNT("exit", result));
    }
    stop(daemon);
    return result;
}

int vor_serve_main(int argc, char **argv)
{
    struct daemon *daemon;
    struct vor_error err;
    int result;

    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--print-routes") == 0) {
            vor_routes_print(stdout);
            return VOR_EXIT_OK;
        }
    }
    daemon = calloc(1, sizeof *daemon);
    if (daemon == NULL)
        return VOR_EXIT_FAILED;
    daemon->argc = argc;
    daemon->argv = argv;
    if (vor_config_read(&daemon->config, argc, argv, getenv, &err) != VOR_OK) {
        (void)fprintf(stderr, "voronoid: %s\n", err.message);
        result = VOR_EXIT_USAGE;
    } else {
        result = serve(daemon);
    }
    free(daemon);
    return result;
}
