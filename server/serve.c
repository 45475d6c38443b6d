/* The order of life: settings, processes, store, blobs, socket, worker, jobs, admission, HTTP; then
 * wait for a signal; then the same backwards. */
#include "server/serve.h"

#include "server/api/app.h"
#include "server/api/routes.h"
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/cli/say.h"
#include "server/work/admit.h"
#include "server/work/conversion.h"
#include "server/work/station.h"
#include "server/work/supervisor.h"

#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { ADMIT_WAITING_MAX = 64, QUIET_SECONDS = 10 };

/* A job that crashed the daemon twice with nothing beside it will do so again. Whoever kills the
 * daemon means the daemon, unless it is the kernel, out of memory, because of the job. */
enum { FAULTS_MAX = 2, KILLS_MAX = 12 };

/* The kinds of processes that the zygote forks. */
enum { CHILD_WORKER };

static const struct vor_child_kind child_kinds[] = {
    [CHILD_WORKER] = {.name = "vor-worker", .run = vor_station_run},
};

/* Before children, when the kernel is out of memory, and after what can wait for it. */
enum { OOM_SCORE = -100 };

/* The parts, in the order in which they start. */
struct daemon {
    struct vor_config config;
    struct vor_app app;
    struct vor_zygote zygote;
    struct vor_supervisor *supervisor;
    sigset_t signals;
    pthread_t drainer;
    long holder;
    char fault_mark[VOR_CONFIG_TEXT_MAX + 16]; /* beside jobs and blobs */
};

static double all_memory(const struct vor_config *config)
{
    double asked = config->number[VOR_SET_MEMORY];

    return asked > 0 ? asked : (double)vor_machine_memory() * 0.7;
}

static size_t job_memory(const struct vor_config *config)
{
    double asked = config->number[VOR_SET_JOB_MEMORY];

    return (size_t)(asked > 0 ? asked : all_memory(config) / config->number[VOR_SET_JOBS]);
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
        .budget = (uint64_t)all_memory(config),
        .job_seconds = config->number[VOR_SET_JOB_SECONDS],
        .ttl_seconds = config->number[VOR_SET_RESULT_TTL],
        .faults_max = FAULTS_MAX,
        .kills_max = KILLS_MAX,
        .fault_mark = daemon->fault_mark,
        .keep = (uint64_t)config->number[VOR_SET_KEEP_INPUTS],
    };
    struct vor_admit_limits limits = {
        .codec = VOR_LIMITS_DEFAULT, .memory = job_memory(config), .keep = worker.keep};
    const struct vor_supervisor_config runs = {.zygote = &daemon->zygote,
                                               .kind = CHILD_WORKER,
                                               .threads = thread_count(config),
                                               .memory = worker.jobs * worker.memory};
    vor_status status = vor_supervisor_create(&daemon->supervisor, &runs, err);

    (void)snprintf(daemon->fault_mark, sizeof daemon->fault_mark, "%s/crashed",
                   config->text[VOR_SET_DATA]);
    limits.codec.points = (size_t)config->number[VOR_SET_POINTS_LIMIT];
    limits.inflated = (uint64_t)config->number[VOR_SET_BODY_LIMIT];
    daemon->app.inflight = vor_inflight_create();
    if (daemon->app.inflight == NULL && status == VOR_OK)
        status = vor_fail(err, VOR_E_NOMEM, "the keys of requests");
    if (status == VOR_OK) {
        worker.executor = vor_supervisor_executor(daemon->supervisor);
        status = vor_worker_create(&daemon->app.worker, &worker, err);
    }
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
        .connections = (unsigned)config->number[VOR_SET_CONNECTIONS] + 32,
        .header_seconds = config->number[VOR_SET_HEADER_TIMEOUT],
        .keep_seconds = config->number[VOR_SET_KEEP_TIMEOUT],
        .body_seconds = config->number[VOR_SET_BODY_TIMEOUT],
        .body_idle_seconds = config->number[VOR_SET_BODY_IDLE],
        .body_rate = config->number[VOR_SET_BODY_RATE],
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

/* The process that others are forked from comes first: while there is one thread, and nothing is
 * open that they must not have. */
static vor_status start_processes(struct daemon *daemon, struct vor_error *err)
{
    vor_status status = vor_zygote_start(&daemon->zygote, child_kinds,
                                         sizeof child_kinds / sizeof child_kinds[0], err);

    vor_machine_set_oom_score(OOM_SCORE);
    return status;
}

/* The address comes before the jobs, so that a daemon whose address is taken touches none. Who
 * connects meanwhile is answered once every job of a former life is back in line: the threads come
 * last. */
static vor_status start(struct daemon *daemon, struct vor_error *err)
{
    vor_status status = start_processes(daemon, err);

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
    vor_supervisor_destroy(daemon->supervisor);
    vor_zygote_stop(&daemon->zygote);
    vor_blobs_close(daemon->app.blobs);
    vor_store_close(daemon->app.store);
}

/* Waits until no request is under way, QUIET_SECONDS at most. */
static void wait_quiet(struct daemon *daemon)
{
    double until = vor_clock_seconds() + QUIET_SECONDS;
    const struct timespec pause = {0, 10 * 1000 * 1000};

    while (vor_http_busy(daemon->app.http) > 0 && vor_clock_seconds() < until)
        (void)nanosleep(&pause, NULL);
}

/* Drains the daemon on a thread of its own, while the main thread waits for a second signal. Ends
 * by sending that signal itself. */
static void *drain(void *ctx)
{
    struct daemon *daemon = ctx;

    atomic_store(&daemon->app.draining, true);
    vor_http_wake_all(daemon->app.http);
    vor_worker_drain(daemon->app.worker, daemon->config.number[VOR_SET_DRAIN_TIMEOUT]);
    vor_http_quiesce(daemon->app.http);
    vor_worker_settle(daemon->app.worker, QUIET_SECONDS);
    vor_http_close_waiting(daemon->app.http);
    wait_quiet(daemon);
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

/* SIGUSR2 comes from drain. Before the first SIGTERM it is ignored. */
static void block_signals(struct daemon *daemon)
{
    static const int numbers[] = {SIGTERM, SIGINT, SIGUSR2};

    (void)signal(SIGPIPE, SIG_IGN);
    (void)sigemptyset(&daemon->signals);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        (void)sigaddset(&daemon->signals, numbers[i]);
    (void)pthread_sigmask(SIG_BLOCK, &daemon->signals, NULL);
}

static int run(struct daemon *daemon)
{
    int number;

    do
        number = wait_signal(daemon);
    while (number == SIGUSR2);
    vor_log(VOR_LOG_INFO, "draining", VOR_TEXT("signal", number == SIGINT ? "INT" : "TERM"));
    if (pthread_create(&daemon->drainer, NULL, drain, daemon) != 0)
        _exit(VOR_EXIT_FAILED);
    number = wait_signal(daemon);
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
                VOR_COUNT("threads", thread_count(&daemon->config)),
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
    if (vor_config_read(&daemon->config, argc, argv, getenv, &err) != VOR_OK) {
        (void)fprintf(stderr, "voronoid: %s\n", err.message);
        result = VOR_EXIT_USAGE;
    } else {
        result = serve(daemon);
    }
    free(daemon);
    return result;
}
