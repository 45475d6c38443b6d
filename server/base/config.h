/** The settings of `voronoid serve`: one table for --help, parsing and messages. */
#ifndef VOR_SERVER_BASE_CONFIG_H
#define VOR_SERVER_BASE_CONFIG_H

#include "core/base/status.h"
#include "server/base/address.h"
#include "server/base/option.h"

#include <stddef.h>
#include <stdio.h>

/** The file of settings that is read unless CONFIG names another. */
#define VOR_CONFIG_PLACE "/etc/voronoid/voronoid.conf"

/** Settings: identifier, flag, type, unit, min, max, default, sentence. The environment variable of
 *  "http-threads" is VORONOID_HTTP_THREADS, or VORONOID_HTTP_THREADS_FILE for a file that holds the
 *  value; in the file of settings it is http-threads. A flag wins over the environment, and that
 *  over the file. */
#define VOR_SETTING_TABLE(X)                                                                       \
    X(CONFIG, "config", TEXT, "FILE", 0, 0, "",                                                    \
      "File with settings, one \"name = value\" per line. Flags and environment variables "        \
      "override the file. Default: " VOR_CONFIG_PLACE " if it exists")                             \
    X(CHECK_CONFIG, "check-config", FLAG, "", 0, 1, "0",                                           \
      "Check the settings and report every error, then exit")                                      \
    X(LISTEN, "listen", TEXT, "HOST:PORT", 0, 0, "127.0.0.1:8080",                                 \
      "Address to listen on. With port 0 the daemon picks a free port and logs it; unix:/PATH "    \
      "is a Unix socket")                                                                          \
    X(SOCKET_MODE, "socket-mode", CHOICE, "0600 0660 0666", 0, 0, "0660",                          \
      "Which users may connect to the Unix socket of --listen: its owner (0600), its group "       \
      "(0660) or all users (0666)")                                                                \
    X(ADMIN_LISTEN, "admin-listen", TEXT, "HOST:PORT", 0, 0, "",                                   \
      "Separate address that serves only /livez, /readyz and /metrics. A thread of its own "       \
      "serves this address, so the daemon responds here even while the main address is "           \
      "overloaded. Default: none")                                                                 \
    X(ADMIN_ANYWHERE, "admin-anywhere", FLAG, "", 0, 1, "0",                                       \
      "Allow an --admin-listen address that other machines can reach")                             \
    X(DATA, "data", TEXT, "DIR", 0, 0, "",                                                         \
      "Folder for jobs and their files. Default: $STATE_DIRECTORY, $XDG_STATE_HOME/voronoid or "   \
      "~/.local/state/voronoid")                                                                   \
    X(STORE, "store", TEXT, "SCHEME:PLACE", 0, 0, "",                                              \
      "Database of jobs: sqlite:PATH, or postgresql://USER@HOST/DATABASE. Default: jobs.sqlite "   \
      "in --data")                                                                                 \
    X(STORE_LISTEN, "store-listen", TEXT, "URI", 0, 0, "",                                         \
      "Direct connection to the database of --store postgresql://..., by which daemons that "      \
      "share it inform each other of changes at once: postgresql://USER@HOST/DATABASE, not "       \
      "through a pooler in transaction mode. Default: none; each daemon only asks the database "   \
      "for changes twice a second")                                                                \
    X(BLOBS, "blobs", TEXT, "SCHEME:PLACE", 0, 0, "",                                              \
      "Uploads and results: dir:PATH for a folder (with --store postgresql://...: of a file "      \
      "system that all daemons share), s3:https://HOST/BUCKET/PREFIX, or "                         \
      "postgresql://USER@HOST/DATABASE, which may be that of --store. With jobs.sqlite and dir:, " \
      "those of up to 64 KiB are in jobs.sqlite. Default: folder blobs in --data")                 \
    X(BLOBS_PUBLIC_URL, "blobs-public-url", TEXT, "URL", 0, 0, "",                                 \
      "URL at which clients reach the bucket of --blobs s3:..., such as https://HOST/BUCKET. "     \
      "Requests for results then get a redirect to a link that is valid for two minutes. "         \
      "Default: the daemon sends the results itself")                                              \
    X(ROLE, "role", CHOICE, "all api worker", 0, 0, "all",                                         \
      "What the daemon does. api: it answers requests and runs no jobs; worker: it runs jobs and " \
      "answers only /livez, /readyz and /metrics; all: both. api and worker need --store "         \
      "postgresql://... and --blobs that all daemons share")                                       \
    X(EXIT_WHEN_IDLE, "exit-when-idle", TIME, "seconds", 0, 31536000, "0",                         \
      "Exit with status 0 after this time without a waiting or running job. 0: never")             \
    X(BLOBS_CACHE, "blobs-cache", BYTES, "bytes", 0, 1e15, "1G",                                   \
      "Disk space in --data for copies of files that are in S3 or PostgreSQL")                     \
    X(THREADS, "threads", COUNT_OF, "threads", 0, 256, "0",                                        \
      "Number of threads for computations, shared by all jobs. 0: one thread per core")            \
    X(JOBS, "jobs", COUNT_OF, "jobs", 1, 64, "2", "Number of jobs that may run at the same time")  \
    X(QUEUE, "queue", COUNT_OF, "jobs", 1, 100000, "256", "Largest number of waiting jobs")        \
    X(MEMORY, "memory", BYTES, "bytes", 0, 1e15, "0",                                              \
      "Estimated memory that all running jobs together may use; other jobs wait. 0: 70 % of the "  \
      "machine's memory, or of the memory limit of the daemon's control group")                    \
    X(QUEUE_BYTES, "queue-bytes", BYTES, "bytes", 1, 1e15, "8G",                                   \
      "Largest total size of the decoded inputs of all waiting jobs")                              \
    X(JOB_MEMORY, "job-memory", BYTES, "bytes", 0, 1e15, "0",                                      \
      "Largest amount of memory that one job may use. 0: --memory divided by --jobs")              \
    X(JOB_SECONDS, "job-seconds", TIME, "seconds", 0, 31536000, "1800",                            \
      "Longest time that a job may run. A job is refused if it would take four times as long as "  \
      "this setting. 0: no limit")                                                                 \
    X(BODY_LIMIT, "body-limit", BYTES, "bytes", 1, 1e15, "1G",                                     \
      "Largest size of an upload, before and after decompression")                                 \
    X(POINTS_LIMIT, "points-limit", COUNT_OF, "points", 1, 2147483646, "50000000",                 \
      "Largest number of points that an upload may declare")                                       \
    X(RESULT_TTL, "result-ttl", TIME, "seconds", 1, 31536000, "86400",                             \
      "Time after which the results of a job are deleted")                                         \
    X(KEEP_INPUTS, "keep-inputs", BYTES, "bytes", 0, 1e15, "1G",                                   \
      "Largest total size of the uploads that the daemon keeps until the results of their jobs "   \
      "expire. If all of them together exceed this size, they are deleted, starting with those "   \
      "of the job that ended first. 0: no upload is kept")                                         \
    X(RESULTS_BYTES, "results-bytes", BYTES, "bytes", 0, 1e15, "0",                                \
      "Largest total size of results that are kept. If the total exceeds this size, results of "   \
      "the jobs that ended first are deleted first. 0: half the size of the disk that holds the "  \
      "folder --blobs")                                                                            \
    X(DISK_RESERVE, "disk-reserve", BYTES, "bytes", 0, 1e15, "16M",                                \
      "Size of the reserve file, which keeps disk space free in the folder of the job store. "     \
      "When the disk is full, the daemon gives this space up, so that jobs can still be "          \
      "finished and deleted. One part is kept for the next start of the daemon: a sixteenth, but " \
      "at least 64 KiB, and never more than half. An upload is refused if it would leave less "    \
      "free space than this size")                                                                 \
    X(PUBLIC_URL, "public-url", TEXT, "URL", 0, 0, "",                                             \
      "URL at which clients reach the daemon; links in responses begin with it. Default: the "     \
      "scheme, host and path that a trusted proxy sends, else http:// and the Host header")        \
    X(TRUSTED_PROXY, "trusted-proxy", LIST, "LIST", 0, 0, "",                                      \
      "Proxies that the daemon trusts: addresses or networks such as 10.0.0.0/8 or fd00::/8. "     \
      "Separate them with commas, or repeat the flag")                                             \
    X(PROXY_HEADERS, "proxy-headers", CHOICE, "x-forwarded forwarded", 0, 0, "x-forwarded",        \
      "Headers of trusted proxies that the daemon reads. x-forwarded: X-Forwarded-For, -Proto, "   \
      "-Host and -Prefix; forwarded: Forwarded (RFC 7239)")                                        \
    X(ALLOWED_HOSTS, "allowed-hosts", LIST, "LIST", 0, 0, "",                                      \
      "Host names that requests may have in the Host header, besides localhost and the host of "   \
      "--public-url. Separate them with commas, or repeat the flag. Default: any host that a "     \
      "trusted proxy sends")                                                                       \
    X(CORS_ORIGIN, "cors-origin", TEXT, "LIST", 0, 0, "",                                          \
      "Origins of web pages that may use the daemon, separated by commas")                         \
    X(API_KEYS, "api-keys", TEXT, "FILE", 0, 0, "",                                                \
      "File with API keys, one in each line. To get a line for a new key, run: voronoid key "      \
      "NAME. With this setting, all requests under /v1 need a key. SIGHUP reloads the file")       \
    X(NO_AUTH, "no-auth", FLAG, "", 0, 1, "0",                                                     \
      "Allow requests without a key, even if other machines can reach the daemon directly or "     \
      "through a proxy")                                                                           \
    X(HTTP_THREADS, "http-threads", COUNT_OF, "threads", 1, 64, "2", "HTTP threads")               \
    X(CONNECTIONS, "connections", COUNT_OF, "connections", 1, 100000, "1024",                      \
      "Largest number of open connections, event streams not included. Above this number, the "    \
      "daemon closes the connections that have been idle longest. 32 more are reserved for "       \
      "health checks")                                                                             \
    X(ADDRESS_CONNECTIONS, "address-connections", COUNT_OF, "connections", 0, 100000, "128",       \
      "Largest number of open connections per client (a client is one IPv4 address or one IPv6 "   \
      "/64 network). Clients on this machine and proxies in --trusted-proxy have no such limit. "  \
      "0: no limit for any client")                                                                \
    X(STREAMS, "streams", COUNT_OF, "streams", 1, 100000, "512",                                   \
      "Largest number of open event streams")                                                      \
    X(HEADER_TIMEOUT, "header-timeout", TIME, "seconds", 0.1, 3600, "10",                          \
      "Time limit for the headers of a request")                                                   \
    X(KEEP_TIMEOUT, "keep-timeout", TIME, "seconds", 0.1, 3600, "20",                              \
      "Time after which an idle connection is closed")                                             \
    X(BODY_TIMEOUT, "body-timeout", TIME, "seconds", 0.1, 86400, "3600",                           \
      "Time limit for an upload")                                                                  \
    X(BODY_IDLE, "body-idle", TIME, "seconds", 0.1, 3600, "30", "Longest pause in an upload")      \
    X(BODY_RATE, "body-rate", BYTES, "bytes/s", 0, 1e12, "16K",                                    \
      "Lowest average speed allowed for an upload that takes longer than --body-idle")             \
    X(REPLY_RATE, "reply-rate", BYTES, "bytes/s", 0, 1e12, "4K",                                   \
      "If a client reads a response for longer than --body-idle, it must read at least at this "   \
      "average speed. Event streams have no such limit")                                           \
    X(HEARTBEAT, "heartbeat", TIME, "seconds", 0.1, 3600, "15",                                    \
      "Interval at which a keep-alive line is sent on an event stream that has no events to send") \
    X(DRAIN_DELAY, "drain-delay", TIME, "seconds", 0, 3600, "0",                                   \
      "Time after SIGTERM during which /readyz fails but requests are still served, so that load " \
      "balancers can stop sending new ones")                                                       \
    X(DRAIN_TIMEOUT, "drain-timeout", TIME, "seconds", 0, 3600, "20",                              \
      "How long running jobs may continue after SIGTERM, counted from the end of --drain-delay. "  \
      "Jobs that are not finished by then run again after the next start")                         \
    X(DRACO, "draco", CHOICE, "any strict", 0, 0, "any",                                           \
      "Draco files that the daemon accepts. any: all files that the Draco library can read; "      \
      "strict: only point clouds of bitstream 2.3 without metadata, which need less code of the "  \
      "library")                                                                                   \
    X(ALLOW_WEAK_SANDBOX, "allow-weak-sandbox", FLAG, "", 0, 1, "0",                               \
      "Start even if the kernel does not support seccomp. Uploads are then decoded in a sandbox "  \
      "that has only limits on memory and time")                                                   \
    X(LOG_LEVEL, "log-level", CHOICE, "debug info warn error off", 0, 0, "info",                   \
      "Lowest level of messages in the log. The log has one JSON object per line and goes to "     \
      "standard error")

enum vor_setting {
#define VOR_SETTING_ENUM(id, flag, kind, unit, min, max, def, sentence) VOR_SET_##id,
    VOR_SETTING_TABLE(VOR_SETTING_ENUM)
#undef VOR_SETTING_ENUM
        VOR_SETTING_COUNT
};

extern const struct vor_option_row vor_setting_infos[VOR_SETTING_COUNT];

enum { VOR_CONFIG_TEXT_MAX = 1024, VOR_CONFIG_FAULTS_SIZE = 16384 };

/** Values of VOR_SET_ROLE. */
enum vor_role { VOR_ROLE_ALL, VOR_ROLE_API, VOR_ROLE_WORKER };

/** Every setting: texts in text, all others (a choice's index) in number. */
struct vor_config {
    double number[VOR_SETTING_COUNT];
    char text[VOR_SETTING_COUNT][VOR_CONFIG_TEXT_MAX];
    int given[VOR_SETTING_COUNT]; /**< by flag, environment or file */
    int is_shared; /**< other daemons may have the same jobs and files, by STORE and BLOBS */
    unsigned line[VOR_SETTING_COUNT];    /**< of the file of settings; 0 for elsewhere */
    struct vor_endpoint endpoint, admin; /**< of LISTEN, of ADMIN_LISTEN */
    struct vor_networks trusted;         /**< of TRUSTED_PROXY */
    char faults[VOR_CONFIG_FAULTS_SIZE]; /**< every message, each with a NUL, as many as fit */
    size_t faults_size;
};

/** --flag VALUE and --flag=VALUE of argv[1 .. argc - 1], by getopt_long, so that an unambiguous
 *  beginning of a flag stands for it; for the others the environment, then the file CONFIG, then
 *  the default; then DATA, STORE, BLOBS, host, port and trusted are worked out. getenv is the
 *  environment to read. A message about a value of the file begins with file and line. A value that
 *  is refused does not end the reading: out->faults has every message, err the first.
 *
 *  @retval VOR_E_PARAM an unknown or ambiguous flag, a value missing or out of range (message:
 *                      flag, value and range), LISTEN not HOST:PORT, neither API_KEYS nor NO_AUTH
 *                      where others than this machine's users may call (LISTEN no loopback address,
 *                      TRUSTED_PROXY or PUBLIC_URL given), or both, PUBLIC_URL no URL, CORS_ORIGIN
 * no list of origins, TRUSTED_PROXY none of networks, ALLOWED_HOSTS none of names, no directory
 * for DATA, or a file that cannot be read
 */
VOR_NODISCARD vor_status vor_config_read(struct vor_config *out, int argc, char **argv,
                                         char *(*getenv)(const char *name), struct vor_error *err);

/** True when LIST (separated by commas, blanks ignored) holds item of that length: byte for byte,
 * or in letters of any case (strncasecmp). */
int vor_config_list_has(const char *list, const char *item, size_t length,
                        int (*compare)(const char *a, const char *b, size_t length));

/** By the role: how many jobs run here at a time, and whether callers are answered. */
static inline unsigned vor_config_runners(const struct vor_config *config)
{
    return (enum vor_role)config->number[VOR_SET_ROLE] == VOR_ROLE_API
               ? 0
               : (unsigned)config->number[VOR_SET_JOBS];
}

static inline int vor_config_answers(const struct vor_config *config)
{
    return (enum vor_role)config->number[VOR_SET_ROLE] != VOR_ROLE_WORKER;
}

#endif
