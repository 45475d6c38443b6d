#include "server/api/route_table.h"

#include "core/base/vector.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/base/build.h"
#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/metrics.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

/* --- what is asked for when somebody looks ---------------------------------------------------- */

static void put(struct vor_text *text, const char *name, const char *kind, const char *sentence,
                double value)
{
    vor_text_printf(text, "# HELP %s %s\n# TYPE %s %s\n%s %.15g\n", name, sentence, name, kind,
                    name, value);
}

static double seconds(const struct timeval *time)
{
    return (double)time->tv_sec + (double)time->tv_usec / 1e6;
}

/* Fields 20, 22, 23 and 24 of proc(5)'s stat; the name before them may hold blanks. */
static void put_stat(struct vor_text *text)
{
    FILE *file = fopen("/proc/self/stat", "re");
    char line[1024];
    const char *at = NULL;
    unsigned long long start = 0, size = 0;
    long threads = 0, pages = 0;
    struct timespec now, up;

    if (file != NULL) {
        at = fgets(line, sizeof line, file) != NULL ? strrchr(line, ')') : NULL;
        (void)fclose(file);
    }
    if (at == NULL || sscanf(at + 1,
                             " %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %*u %*u %*d %*d %*d %*d "
                             "%ld %*d %llu %llu %ld",
                             &threads, &start, &size, &pages) != 4)
        return;
    put(text, "process_threads", "gauge", "Threads", (double)threads);
    put(text, "process_virtual_memory_bytes", "gauge", "Size of the address space", (double)size);
    put(text, "process_resident_memory_bytes", "gauge", "Resident memory",
        (double)pages * (double)sysconf(_SC_PAGESIZE));
    if (clock_gettime(CLOCK_REALTIME, &now) == 0 && clock_gettime(CLOCK_BOOTTIME, &up) == 0)
        put(text, "process_start_time_seconds", "gauge",
            "Start of the process, in seconds "
            "since 1970",
            (double)now.tv_sec - (double)up.tv_sec + (double)start / (double)sysconf(_SC_CLK_TCK));
}

/* What the kernel says of this process, as Prometheus's client libraries name it; those that /proc
 * does not tell are left out. */
static void put_process(struct vor_text *text)
{
    struct rusage usage;
    DIR *directory;
    struct rlimit limit;
    double count = -3; /* ".", ".." and the directory itself */

    if (getrusage(RUSAGE_SELF, &usage) == 0)
        put(text, "process_cpu_seconds_total", "counter",
            "CPU time of the process, user and "
            "system",
            seconds(&usage.ru_utime) + seconds(&usage.ru_stime));
    directory = opendir("/proc/self/fd");
    if (directory != NULL) {
        while (readdir(directory) != NULL)
            count++;
        (void)closedir(directory);
        put(text, "process_open_fds", "gauge", "Open file descriptors", count);
    }
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0)
        put(text, "process_max_fds", "gauge", "Largest number of open file descriptors",
            (double)limit.rlim_cur);
    put_stat(text);
}

static enum vor_next reply_metrics(struct vor_request *request)
{
    struct vor_app *app = request->app;
    struct vor_text text;
    const struct vor_build build = vor_build_own();
    struct vor_job_service_load load;
    uint64_t available, total;
    double waited = 0;
    static const enum vor_metric counters[] = {VOR_METRIC_STREAM_EVENTS, VOR_METRIC_STREAM_DROPPED,
                                               VOR_METRIC_UPLOADS,       VOR_METRIC_WORKER_RESTARTS,
                                               VOR_METRIC_UPLOAD_BYTES,  VOR_METRIC_POINTS};

    vor_metric_set(VOR_METRIC_BUILD, 1, VOR_LABELS(VOR_VERSION, build.engine, vor_vector_name()));
    /* A counter that has counted nothing yet says 0, so that its first step is seen. */
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++)
        vor_metric_add(counters[i], 0, NULL);
    vor_metric_set(VOR_METRIC_HTTP_IN_FLIGHT, vor_http_busy(app->http), NULL);
    vor_metric_set(VOR_METRIC_HTTP_STUCK, vor_http_stuck(app->http), NULL);
    vor_metric_set(VOR_METRIC_CONNECTIONS, vor_http_connections(app->http), NULL);
    vor_metric_set(VOR_METRIC_CONNECTIONS_MOST, app->config->number[VOR_SET_CONNECTIONS], NULL);
    vor_metric_set(VOR_METRIC_STREAMS, atomic_load(&app->streams), NULL);
    vor_metric_set(VOR_METRIC_LOG_DROPPED, (double)vor_log_dropped(), NULL);
    vor_job_service_load(app->service, &load);
    if (load.oldest_ms > 0)
        waited = (double)(vor_clock_wall_ms() - load.oldest_ms) / 1000;
    vor_metric_set(VOR_METRIC_QUEUE, (double)load.waiting, VOR_LABELS("waiting"));
    vor_metric_set(VOR_METRIC_QUEUE, (double)load.running, VOR_LABELS("running"));
    vor_metric_set(VOR_METRIC_QUEUE_MOST, app->config->number[VOR_SET_QUEUE], NULL);
    vor_metric_set(VOR_METRIC_QUEUE_AGE, waited > 0 ? waited : 0, NULL);
    vor_metric_set(VOR_METRIC_WORKER_BUSY, (double)load.running, NULL);
    vor_metric_set(VOR_METRIC_WORKER_SLOTS, app->config->number[VOR_SET_JOBS], NULL);
    vor_metric_set(VOR_METRIC_BLOB_BYTES, (double)vor_blobs_bytes(app->blobs),
                   VOR_LABELS(vor_blobs_scheme(app->blobs)));
    if (vor_blobs_space(app->blobs, &available, &total, NULL) == VOR_OK) {
        vor_metric_set(VOR_METRIC_STORAGE_FREE, (double)available, NULL);
        vor_metric_set(VOR_METRIC_STORAGE_SIZE, (double)total, NULL);
    }
    vor_text_init(&text, 0);
    vor_metrics_write(&text);
    put_process(&text);
    vor_reply_header(request, "Cache-Control", "no-store");
    return vor_app_reply(request, 200, "text/plain; version=0.0.4; charset=utf-8", &text);
}

/* --- the listener ----------------------------------------------------------------------------- */

/* Pages in a browser on this machine may not read the numbers by a name that leads here. */
static bool is_foreign_host(const struct vor_config *config, const struct vor_request *request)
{
    const char *host = vor_request_header(request, "Host");
    const char *const own[] = {"localhost", "127.0.0.1", "[::1]", config->admin.host};
    size_t length;

    if (!config->admin.loopback || host == NULL)
        return false;
    length = vor_host_is_sound(host) ? vor_host_name_length(host) : 0;
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++)
        if (length == strlen(own[i]) && strncasecmp(host, own[i], length) == 0)
            return false;
    return true;
}

enum vor_next vor_admin_dispatch(struct vor_request *request, enum vor_step step)
{
    static const char want[] = "want GET of /livez, /readyz or /metrics";
    enum vor_method method = request->method;
    const char *path = request->path;

    if (is_foreign_host(request->app->config, request))
        return vor_problem_say(request, "forbidden",
                               "Host is %.100s, want localhost, 127.0.0.1 or [::1]",
                               vor_request_header(request, "Host"));
    if (method != VOR_GET && method != VOR_HEAD)
        return vor_problem_reply(
            request, &VOR_PROBLEM("method-not-allowed", .allow = "GET, HEAD", .detail = want));
    if (strcmp(path, "/livez") == 0) {
        double stuck = vor_http_stuck(request->app->http);

        /* The first listener's threads may hang while this one's does not. */
        if (stuck < VOR_STUCK_SECONDS)
            return vor_handle_livez(request, step);
        return vor_problem_say(
            request, "not-alive",
            "an HTTP thread has spent %.0f seconds on one step of a request, want less than %d "
            "seconds",
            stuck, VOR_STUCK_SECONDS);
    }
    if (strcmp(path, "/readyz") == 0)
        return vor_handle_readyz(request, step);
    if (strcmp(path, "/metrics") == 0)
        return reply_metrics(request);
    return vor_problem_say(request, "no-such-resource", "there is nothing at %.200s, %s", path,
                           want);
}

void vor_admin_done(const struct vor_request *request)
{
    vor_log(VOR_LOG_DEBUG, "admin request", VOR_TEXT("request_id", request->id),
            VOR_TEXT("path", request->path), VOR_TEXT("client", request->via.client),
            VOR_COUNT("status", request->reply.http));
}
