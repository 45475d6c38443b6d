/* The order of life: settings, processes, store, blobs, socket, job service, jobs, admission, HTTP;
 * then wait for a signal; then the same backwards. */
#include "server/serve.h"

#include "server/api/app.h"
#include "server/api/route_table.h"
#include "server/api/tickets.h"
#include "server/base/clock.h"
#include "server/base/flann_library.h"
#include "server/base/keys.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/base/notify.h"
#include "server/base/rates.h"
#include "server/cli/cli_log.h"
#include "server/work/admit.h"
#include "server/work/codec_child.h"
#include "server/work/conversion.h"
#include "server/work/supervisor.h"
#include "server/work/verify.h"
#include "server/work/worker_main.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

/* A quarter of the uploads that wait may be one caller's. */
enum {
    ADMIT_WAITING_MAX = 256,
    SETTLE_SECONDS = 2, /* for what was handed to other threads, and for answers, after the drain */
    LAST_SECONDS = 1    /* for connections that were cut to be closed */
};

/* A job that crashed its worker twice with nothing beside it will do so again. */
enum { FAULTS_MAX = 2 };

/* Of the second listener. A scraper asks every 15 seconds as a rule, on a connection it keeps. */
enum { ADMIN_CONNECTIONS = 16, ADMIN_SECONDS = 5, ADMIN_KEEP_SECONDS = 60 };

static const double farewell_seconds = 0.2; /* kept connections are told Connection: close */

/* Before children, when the kernel is out of memory, and after what can wait for it. */
enum { OOM_SCORE = -100 };

/* What the zygote forks: children for work with strangers' bytes, and for runs of jobs. */
enum { CHILD_CODEC, CHILD_WORKER, CHILD_KINDS };

static const struct vor_child_kind child_kinds[CHILD_KINDS] = {
    [CHILD_CODEC] = {"vor-codec", vor_codec_child},
    [CHILD_WORKER] = {"vor-worker", vor_worker_main},
};

/* The parts, in the order in which they start. */
struct daemon {
    struct vor_config config;
    struct vor_app app;
    struct vor_http *admin; /* the second listener; NULL when there is none */
    struct vor_zygote zygote;
    enum vor_sandbox_kind sandbox;
    struct vor_supervisor *supervisor;
    sigset_t signals;
    pthread_t drainer;
    int argc; /* of the command line, for a reload */
    char **argv;
    long holder;
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

static void pause_for(double seconds)
{
    const struct timespec pause = {(time_t)seconds, (long)(fmod(seconds, 1) * 1e9)};

    (void)nanosleep(&pause, NULL); /* signals wait for the main thread */
}

/* A disk has failed: only a start finds out what is on it; or the store is another daemon's. Called
 * on a thread of the job service. Answers under way get a moment, jobs none: rows cannot change. */
static void fail(void *ctx, const struct vor_error *why)
{
    struct daemon *daemon = ctx;

    vor_log(VOR_LOG_ERROR,
            "a disk failed, or another daemon has the store: the daemon exits and recovers when it "
            "starts again",
            VOR_TEXT("error", why->message), VOR_COUNT("exit", VOR_EXIT_FAILED));
    if (daemon->app.http != NULL && !atomic_exchange(&daemon->app.draining, true))
        vor_http_quiesce(daemon->app.http);
    pause_for(farewell_seconds);
    _exit(VOR_EXIT_FAILED);
}

static vor_status open_storage(struct daemon *daemon, struct vor_error *err)
{
    const struct vor_config *config = &daemon->config;
    struct vor_app *app = &daemon->app;
    struct vor_blob_cache cache = {config->text[VOR_SET_DATA],
                                   (uint64_t)config->number[VOR_SET_BLOBS_CACHE],
                                   config->is_shared};
    int64_t daemons = 0;
    vor_status status = vor_store_open(&app->store, config->text[VOR_SET_STORE], config->is_shared,
                                       &daemon->holder, err);

    VOR_THEN(status, vor_blobs_open(&app->blobs, config->text[VOR_SET_BLOBS], &cache,
                                    &daemon->holder, err));
    VOR_THEN(status, vor_store_daemons(app->store, &daemons, err));
    VOR_THEN(status, vor_blobs_claim(app->blobs, vor_store_secret(app->store),
                                     config->is_shared && daemons > 0, err));
    VOR_THEN(status, vor_blobs_keep_small(app->blobs, vor_store_small_files(app->store), err));
    if (status != VOR_OK)
        return status;
    vor_tickets_share(app->tickets, vor_store_secret(app->store));
    vor_store_set_reserve(app->store, (uint64_t)config->number[VOR_SET_DISK_RESERVE]);
    vor_blobs_set_reserve(app->blobs, (uint64_t)config->number[VOR_SET_DISK_RESERVE]);
    vor_blobs_set_public_url(app->blobs, config->text[VOR_SET_BLOBS_PUBLIC_URL]);
    return VOR_OK;
}

static struct vor_codec_place place_of(struct daemon *daemon)
{
    return (struct vor_codec_place){
        .zygote = &daemon->zygote, .kind = CHILD_CODEC, .sandbox = daemon->sandbox};
}

/* Half of the disk unless somebody says; all of it when nobody can tell its size. */
static uint64_t results_bytes(const struct daemon *daemon)
{
    double asked = daemon->config.number[VOR_SET_RESULTS_BYTES];
    uint64_t available, total;

    if (asked > 0)
        return (uint64_t)asked;
    if (vor_blobs_space(daemon->app.blobs, &available, &total, NULL) != VOR_OK)
        return INT64_MAX;
    return total / 2;
}

static vor_status start_jobs(struct daemon *daemon, struct vor_error *err)
{
    const struct vor_config *config = &daemon->config;
    struct vor_job_service_config service = {
        .store = daemon->app.store,
        .blobs = daemon->app.blobs,
        .jobs = vor_config_runners(config),
        .listen = config->text[VOR_SET_STORE_LISTEN],
        .idle_seconds = config->number[VOR_SET_EXIT_WHEN_IDLE],
        .queue = (size_t)config->number[VOR_SET_QUEUE],
        .queue_bytes = (uint64_t)config->number[VOR_SET_QUEUE_BYTES],
        .memory = job_memory(config),
        .budget = (uint64_t)all_memory(config),
        .job_seconds = config->number[VOR_SET_JOB_SECONDS],
        .ttl_seconds = config->number[VOR_SET_RESULT_TTL],
        .faults_max = FAULTS_MAX,
        .keep = (uint64_t)config->number[VOR_SET_KEEP_INPUTS],
        .results = results_bytes(daemon),
        .failed = fail,
        .failed_ctx = daemon,
    };
    struct vor_admit_limits limits = {.place = place_of(daemon),
                                      .codec = VOR_LIMITS_DEFAULT,
                                      .memory = job_memory(config),
                                      .keep = service.keep};
    const struct vor_supervisor_config runs = {.zygote = &daemon->zygote,
                                               .kind = CHILD_WORKER,
                                               .codec = place_of(daemon),
                                               .threads = thread_count(config),
                                               .memory = (size_t)config->number[VOR_SET_JOBS] *
                                                         service.memory};
    /* Uploads read at a time: two on a machine with one core, so that a caller leaves one. */
    const unsigned readers = vor_machine_cores() > 2 ? vor_machine_cores() : 2;
    vor_status status = vor_supervisor_create(&daemon->supervisor, &runs, err);

    limits.codec.points = (size_t)config->number[VOR_SET_POINTS_LIMIT];
    limits.codec.strict_draco = config->number[VOR_SET_DRACO] > 0;
    limits.inflated = (uint64_t)config->number[VOR_SET_BODY_LIMIT];
    daemon->app.inflight = vor_inflight_create();
    if (daemon->app.inflight == NULL && status == VOR_OK)
        status = vor_fail(err, VOR_E_NOMEM, "the Idempotency-Keys");
    if (status == VOR_OK) {
        service.executor = vor_supervisor_executor(daemon->supervisor);
        status = vor_job_service_create(&daemon->app.service, &service, err);
    }
    VOR_THEN(status, vor_admit_create(&daemon->app.admit, daemon->app.blobs, &limits, readers,
                                      ADMIT_WAITING_MAX, err));
    VOR_THEN(status, vor_verify_create(&daemon->app.verify, daemon->app.blobs, err));
    if (status == VOR_OK) { /* results are converted where uploads are decoded */
        const struct vor_conversions_config conversions = {
            .store = daemon->app.store,
            .blobs = daemon->app.blobs,
            .service = daemon->app.service,
            .pool = vor_admit_thread_pool(daemon->app.admit),
            .place = limits.place,
            .memory = limits.memory};

        status = vor_conversions_create(&daemon->app.conversions, &conversions, err);
    }
    return status;
}

static void library_line(const char *line)
{
    vor_log(VOR_LOG_DEBUG, "http library", VOR_TEXT("detail", line));
}

/* In the order of the setting's words. */
static const unsigned socket_modes[] = {0600, 0660, 0666};

/* Opens the listener of requests, and that of --admin-listen. Few look at the numbers there, and
 * nobody for long: what is silent is soon cut. */
static vor_status open_http(struct daemon *daemon, struct vor_error *err)
{
    const struct vor_config *config = &daemon->config;
    struct vor_http_options options = {
        .host = config->endpoint.host,
        .port = config->endpoint.port,
        .path = config->endpoint.path,
        .mode = socket_modes[(int)config->number[VOR_SET_SOCKET_MODE]],
        .threads = (unsigned)config->number[VOR_SET_HTTP_THREADS],
        .limits = {.connections = (unsigned)config->number[VOR_SET_CONNECTIONS],
                   .each = (unsigned)config->number[VOR_SET_ADDRESS_CONNECTIONS],
                   .header_seconds = config->number[VOR_SET_HEADER_TIMEOUT],
                   .keep_seconds = config->number[VOR_SET_KEEP_TIMEOUT],
                   .body_seconds = config->number[VOR_SET_BODY_TIMEOUT],
                   .body_idle_seconds = config->number[VOR_SET_BODY_IDLE],
                   .body_rate = config->number[VOR_SET_BODY_RATE],
                   .reply_rate = config->number[VOR_SET_REPLY_RATE],
                   .beat_seconds = config->number[VOR_SET_HEARTBEAT],
                   .trusted = &config->trusted},
        .streams = (unsigned)config->number[VOR_SET_STREAMS],
        .proxy_headers = (enum vor_proxy_headers)config->number[VOR_SET_PROXY_HEADERS],
        .handler = vor_config_answers(config) ? vor_route_dispatch : vor_admin_dispatch,
        .app = &daemon->app,
        .refuse = vor_route_refuse,
        .done = vor_route_done,
        .log = library_line,
    };
    vor_status status = vor_http_open(&daemon->app.http, &options, err);

    if (status != VOR_OK || config->text[VOR_SET_ADMIN_LISTEN][0] == '\0')
        return status;
    options.host = config->admin.host;
    options.port = config->admin.port;
    options.path = config->admin.path;
    options.threads = 1;
    options.streams = 0;
    options.limits = (struct vor_conn_limits){.connections = ADMIN_CONNECTIONS,
                                              .header_seconds = ADMIN_SECONDS,
                                              .body_seconds = ADMIN_SECONDS,
                                              .body_idle_seconds = ADMIN_SECONDS,
                                              .keep_seconds = ADMIN_KEEP_SECONDS,
                                              .trusted = &config->trusted};
    options.proxy_headers = VOR_PROXY_X_FORWARDED;
    options.handler = vor_admin_dispatch;
    options.done = vor_admin_done;
    return vor_http_open(&daemon->admin, &options, err);
}

/* Files of the store, blobs, jobs, sockets that are being closed, the reserve for health checks;
 * and connections, below which it is no use to start. */
enum { OPEN_FILES = 256, CONNECTIONS_LEAST = 16 };

/* Lowers connections and streams alike, so that they fit. */
static vor_status lower_connections(struct vor_config *config, double hard, struct vor_error *err)
{
    double *connections = &config->number[VOR_SET_CONNECTIONS];
    double *streams = &config->number[VOR_SET_STREAMS];
    double asked = 2 * *connections + *streams;
    double share = (hard - OPEN_FILES) / asked;

    if (config->given[VOR_SET_CONNECTIONS] || config->given[VOR_SET_STREAMS] ||
        share * *connections < CONNECTIONS_LEAST)
        return vor_fail_param(
            err, VOR_E_PARAM, "connections",
            "--connections %.0f and --streams %.0f need %.0f open files, but this machine's limit "
            "is %.0f (ulimit -Hn): allow fewer connections or streams, or raise the limit",
            *connections, *streams, asked + OPEN_FILES, hard);
    *connections = (double)(unsigned)(*connections * share);
    *streams = (double)(unsigned)(*streams * share);
    vor_log(VOR_LOG_WARN,
            "fewer connections are allowed, because the limit of open files is too low",
            VOR_COUNT("connections", *connections), VOR_COUNT("streams", *streams),
            VOR_COUNT("files", hard), VOR_COUNT("wanted", asked + OPEN_FILES));
    return VOR_OK;
}

/* Raises the limit of open files so that it is enough for --connections, each with a file of its
 * own (an upload, a result), --streams, and what the daemon itself has open. Where the hard limit
 * is too small, both are lowered to what fits, unless one of them was asked for. */
static vor_status raise_open_files(struct vor_config *config, struct vor_error *err)
{
    double wanted =
        2 * config->number[VOR_SET_CONNECTIONS] + config->number[VOR_SET_STREAMS] + OPEN_FILES;
    struct rlimit limit;

    if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ||
        (double)limit.rlim_cur >= wanted)
        return VOR_OK;
    if (limit.rlim_max == RLIM_INFINITY || (double)limit.rlim_max > wanted)
        limit.rlim_cur = (rlim_t)wanted;
    else
        limit.rlim_cur = limit.rlim_max;
    if (setrlimit(RLIMIT_NOFILE, &limit) != 0)
        (void)getrlimit(RLIMIT_NOFILE, &limit);
    return (double)limit.rlim_cur >= wanted
               ? VOR_OK
               : lower_connections(config, (double)limit.rlim_cur, err);
}

/* The address comes before the jobs, so that a daemon whose address is taken touches none. Who
 * connects meanwhile is answered once every job of a former life is back in line: the threads come
 * last. */
static vor_status start(struct daemon *daemon, struct vor_error *err)
{
    const char *keys = daemon->config.text[VOR_SET_API_KEYS];
    vor_status status = raise_open_files(&daemon->config, err);

    daemon->app.rates = vor_rates_create();
    VOR_THEN(status, vor_tickets_create(&daemon->app.tickets, err));
    if (status == VOR_OK && daemon->app.rates == NULL)
        status = vor_fail(err, VOR_E_NOMEM, "the request rates of keys");
    if (status == VOR_OK && keys[0] != '\0')
        status = vor_keys_open(&daemon->app.keys, keys, err);
    VOR_THEN(status, open_storage(daemon, err));
    VOR_THEN(status, open_http(daemon, err));
    VOR_THEN(status, start_jobs(daemon, err));
    VOR_THEN(status, vor_http_start(daemon->app.http, err));
    if (status == VOR_OK && daemon->admin != NULL)
        status = vor_http_start(daemon->admin, err);
    return status;
}

static void stop(struct daemon *daemon)
{
    if (daemon->app.blobs != NULL)
        vor_blobs_hurry(daemon->app.blobs);
    vor_http_stop(daemon->admin);
    vor_http_stop(daemon->app.http);
    vor_verify_destroy(daemon->app.verify);
    vor_admit_destroy(daemon->app.admit);
    vor_conversions_destroy(daemon->app.conversions);
    vor_job_service_destroy(daemon->app.service);
    vor_inflight_destroy(daemon->app.inflight);
    vor_supervisor_destroy(daemon->supervisor);
    vor_zygote_stop(&daemon->zygote);
    vor_blobs_close(daemon->app.blobs);
    vor_store_close(daemon->app.store);
    vor_keys_close(daemon->app.keys);
    vor_tickets_destroy(daemon->app.tickets);
    vor_rates_destroy(daemon->app.rates);
}

/* Waits until no request is under way, or until then. */
static void wait_quiet(struct daemon *daemon, double until)
{
    while (vor_http_busy(daemon->app.http) > 0 && vor_clock_seconds() < until)
        pause_for(0.01);
}

/* Drains the daemon on a thread of its own, while the main thread waits for a second signal. Ends
 * by sending that signal itself. Jobs, uploads and answers have the same time to end in; who is
 * slower is cut. */
static void *drain(void *ctx)
{
    struct daemon *daemon = ctx;
    double seconds = daemon->config.number[VOR_SET_DRAIN_TIMEOUT], until;

    atomic_store(&daemon->app.leaving, true);
    pause_for(daemon->config.number[VOR_SET_DRAIN_DELAY]);
    until = vor_clock_seconds() + seconds;
    atomic_store(&daemon->app.draining, true);
    vor_http_wake_all(daemon->app.http);
    vor_job_service_drain(daemon->app.service, seconds);
    vor_http_quiesce(daemon->app.http);
    vor_job_service_settle(daemon->app.service, SETTLE_SECONDS);
    vor_http_close_waiting(daemon->app.http);
    pause_for(farewell_seconds);
    if (until < vor_clock_seconds() + SETTLE_SECONDS)
        until = vor_clock_seconds() + SETTLE_SECONDS;
    wait_quiet(daemon, until);
    if (vor_http_busy(daemon->app.http) > 0)
        vor_log(VOR_LOG_WARN, "slow clients are disconnected",
                VOR_COUNT("requests", vor_http_busy(daemon->app.http)));
    vor_http_cut_slow(daemon->app.http);
    wait_quiet(daemon, vor_clock_seconds() + LAST_SECONDS);
    (void)kill(getpid(), SIGUSR2);
    return NULL;
}

/* Waits for a signal, and meanwhile tells systemd's watchdog that the daemon lives. */
static int wait_signal(const struct daemon *daemon)
{
    double seconds = vor_notify_watchdog();
    struct timespec pause = {(time_t)seconds, (long)((seconds - (double)(time_t)seconds) * 1e9)};

    for (;;) {
        int number = seconds > 0 ? sigtimedwait(&daemon->signals, NULL, &pause)
                                 : sigwaitinfo(&daemon->signals, NULL);

        if (number > 0)
            return number;
        if (errno == EAGAIN && vor_http_stuck(daemon->app.http) < VOR_STUCK_SECONDS)
            vor_notify("WATCHDOG=1");
    }
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
    case SIGCHLD:
        return "CHLD";
    default:
        return "TERM";
    }
}

/* SIGHUP: reads the settings again and takes those that may change while the daemon runs, all of
 * which must be sound, or none is taken; then the keys. */
static void reload(struct daemon *daemon)
{
    struct vor_config *fresh = calloc(1, sizeof *fresh);
    struct vor_error err = {.status = VOR_E_NOMEM, .message = "not enough memory for the settings"};

    if (fresh == NULL ||
        vor_config_read(fresh, daemon->argc, daemon->argv, getenv, &err) != VOR_OK) {
        vor_log(VOR_LOG_ERROR, "settings not reloaded", VOR_TEXT("error", err.message));
        free(fresh);
        return;
    }
    daemon->config.number[VOR_SET_LOG_LEVEL] = fresh->number[VOR_SET_LOG_LEVEL];
    vor_log_set_level((enum vor_log_level)fresh->number[VOR_SET_LOG_LEVEL]);
    vor_log(VOR_LOG_INFO, "settings reloaded");
    free(fresh);
    if (vor_keys_reload(daemon->app.keys, &err) != VOR_OK)
        vor_log(VOR_LOG_ERROR, "the keys cannot be read; the previous ones stay valid",
                VOR_TEXT("error", err.message));
}

static int run(struct daemon *daemon)
{
    int number, died;

    for (;;) { /* until a signal ends the daemon */
        number = wait_signal(daemon);
        if (number == SIGHUP) {
            vor_notify_reloading();
            reload(daemon);
            vor_notify("READY=1");
        } else if (number == SIGCHLD ? vor_zygote_died(&daemon->zygote) : number != SIGUSR2) {
            break;
        }
    }
    died = number == SIGCHLD;
    if (died)
        vor_log(VOR_LOG_ERROR, "the process that starts the decoders of uploads has ended");
    vor_notify("STOPPING=1");
    vor_log(VOR_LOG_INFO, "draining", VOR_TEXT("signal", signal_word(number)));
    if (vor_machine_thread(&daemon->drainer, "vor-drain", drain, daemon) != 0)
        _exit(VOR_EXIT_FAILED);
    do /* SIGHUP and SIGCHLD change nothing any more */
        number = wait_signal(daemon);
    while (number == SIGHUP || number == SIGCHLD);
    if (number != SIGUSR2) {
        /* Running jobs are still in the store as such; the next start takes them up again. */
        vor_log(VOR_LOG_WARN, "stopped at once", VOR_COUNT("signal", number));
        _exit(VOR_EXIT_FAILED);
    }
    (void)pthread_join(daemon->drainer, NULL);
    return died ? VOR_EXIT_FAILED : VOR_EXIT_OK;
}

static int failed_start(const struct daemon *daemon, const struct vor_error *err)
{
    char line[sizeof err->message + 16];

    (void)snprintf(line, sizeof line, "voronoid: %s", err->message);
    vor_log_plain(line);
    if (daemon->holder != 0)
        return VOR_EXIT_IN_USE;
    return err->status == VOR_E_PARAM ? VOR_EXIT_USAGE : VOR_EXIT_FAILED;
}

/* Everything but FLANN comes after: children have nothing of what is opened later. */
static vor_status start_zygote(struct daemon *daemon, struct vor_error *err)
{
    struct vor_error why = {.message = ""};

    (void)signal(SIGCHLD,
                 SIG_DFL); /* a parent that ignores it hands that down, and then no child is told */
    daemon->sandbox = vor_sandbox_probe(&why);
    daemon->app.sandbox = vor_sandbox_word(daemon->sandbox);
    if (daemon->sandbox != VOR_SANDBOX_FULL && !vor_sandbox_is_sanitizer() &&
        daemon->config.number[VOR_SET_ALLOW_WEAK_SANDBOX] == 0)
        return vor_fail(err, VOR_E_IO,
                        "%.300s; with --allow-weak-sandbox, the processes that decode uploads run "
                        "with only limits of memory and time",
                        why.message);
    if (vor_zygote_start(&daemon->zygote, child_kinds, CHILD_KINDS, err) != VOR_OK)
        return err->status;
    vor_machine_set_oom_score(OOM_SCORE);
    vor_machine_give_back();
    return VOR_OK;
}

static int serve(struct daemon *daemon)
{
    struct vor_error err;
    int result;
    static const int numbers[] = {SIGTERM, SIGINT, SIGQUIT, SIGUSR1, SIGHUP, SIGCHLD, SIGUSR2};

    if (vor_flann_load(&err) != VOR_OK || start_zygote(daemon, &err) != VOR_OK)
        return failed_start(daemon, &err);
    /* SIGUSR2 comes from drain. Before a signal that ends it is ignored. SIGCHLD comes when the
     * zygote dies, without which no upload can be read: the daemon ends as after SIGTERM, but as
     * failed. */
    (void)signal(SIGPIPE, SIG_IGN);
    (void)sigemptyset(&daemon->signals);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        (void)sigaddset(&daemon->signals, numbers[i]);
    (void)pthread_sigmask(SIG_BLOCK, &daemon->signals, NULL);
    vor_log_open(STDERR_FILENO, (enum vor_log_level)daemon->config.number[VOR_SET_LOG_LEVEL]);
    daemon->app.config = &daemon->config;
    if (start(daemon, &err) != VOR_OK) {
        result = failed_start(daemon, &err);
    } else {
        vor_log(VOR_LOG_INFO, "listening", VOR_TEXT("address", vor_http_address(daemon->app.http)),
                VOR_TEXT("admin", daemon->admin != NULL ? vor_http_address(daemon->admin) : NULL),
                VOR_TEXT("data", daemon->config.text[VOR_SET_DATA]),
                VOR_COUNT("threads", thread_count(&daemon->config)),
                VOR_COUNT("job_memory", job_memory(&daemon->config)));
        if (daemon->sandbox != VOR_SANDBOX_FULL)
            vor_log(VOR_LOG_WARN, "sandbox: partial");
        vor_notify("READY=1");
        result = run(daemon);
        vor_log(VOR_LOG_INFO, "stopped", VOR_COUNT("exit", result));
    }
    stop(daemon);
    return result;
}

int vor_serve_main(int argc, char **argv)
{
    struct daemon *daemon;
    int result;

    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], "--print-routes") == 0) {
            vor_routes_print(stdout);
            return VOR_EXIT_OK;
        }
    daemon = calloc(1, sizeof *daemon);
    if (daemon == NULL)
        return VOR_EXIT_FAILED;
    daemon->argc = argc;
    daemon->argv = argv;
    if (vor_config_read(&daemon->config, argc, argv, getenv, NULL) != VOR_OK) {
        for (size_t at = 0; at < daemon->config.faults_size;
             at += strlen(daemon->config.faults + at) + 1)
            vor_cli_say(NULL, daemon->config.faults + at);
        result = VOR_EXIT_USAGE;
    } else if (daemon->config.number[VOR_SET_CHECK_CONFIG] != 0) {
        (void)puts("voronoid: the settings are valid");
        result = VOR_EXIT_OK;
    } else {
        result = serve(daemon);
    }
    free(daemon);
    return result;
}
