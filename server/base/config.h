/** The settings of `voronoid serve`: one table for --help, parsing and messages. */
#ifndef VOR_SERVER_BASE_CONFIG_H
#define VOR_SERVER_BASE_CONFIG_H

#include "core/base/status.h"
#include "server/base/address.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum vor_setting_kind {
    VOR_SETTING_TEXT,
    VOR_SETTING_LIST,     /**< text with commas between entries; flags given again add to it */
    VOR_SETTING_COUNT_OF, /**< whole number */
    VOR_SETTING_BYTES,    /**< whole number, with K, M, G or T (1024) behind it or not */
    VOR_SETTING_TIME,     /**< seconds */
    VOR_SETTING_FLAG,     /**< given or not; 1 or 0 in the environment */
    VOR_SETTING_CHOICE    /**< one word of those in the unit column */
};

/** Settings: identifier, flag, kind, unit, min, max, default, sentence. The environment variable of
 *  "http-threads" is VORONOID_HTTP_THREADS; a flag wins over it. */
#define VOR_SETTING_TABLE(X)                                                                       \
    X(LISTEN, "listen", TEXT, "HOST:PORT", 0, 0, "127.0.0.1:8080",                                 \
      "Where to listen; port 0 takes a free one, which the log names")                             \
    X(DATA, "data", TEXT, "DIR", 0, 0, "",                                                         \
      "Where jobs and their bytes are kept; else $STATE_DIRECTORY, $XDG_STATE_HOME/voronoid or "   \
      "~/.local/state/voronoid")                                                                   \
    X(STORE, "store", TEXT, "sqlite:PATH", 0, 0, "", "Table of jobs; else jobs.sqlite in --data")  \
    X(BLOBS, "blobs", TEXT, "dir:PATH", 0, 0, "", "Bytes of jobs; else blobs in --data")           \
    X(THREADS, "threads", COUNT_OF, "threads", 0, 256, "0",                                        \
      "Threads of the engine, shared by all jobs; 0 is one for each core")                         \
    X(JOBS, "jobs", COUNT_OF, "jobs", 1, 64, "2", "Jobs that run at the same time")                \
    X(QUEUE, "queue", COUNT_OF, "jobs", 1, 100000, "256", "Jobs that may wait")                    \
    X(MEMORY, "memory", BYTES, "bytes", 0, 1e15, "0",                                              \
      "Memory that running jobs may take together, as estimated; others wait; 0 is 70 % of the "   \
      "machine's")                                                                                 \
    X(JOB_MEMORY, "job-memory", BYTES, "bytes", 0, 1e15, "0",                                      \
      "Memory a job may take; 0 is --memory divided by --jobs")                                    \
    X(JOB_SECONDS, "job-seconds", TIME, "seconds", 0, 31536000, "1800",                            \
      "Time a job may run; one that would take four times as long is refused; 0 is any")           \
    X(BODY_LIMIT, "body-limit", BYTES, "bytes", 1, 1e15, "1G",                                     \
      "Largest upload, and what gzip may inflate to")                                              \
    X(POINTS_LIMIT, "points-limit", COUNT_OF, "points", 1, 2147483646, "50000000",                 \
      "Most points an upload may declare")                                                         \
    X(RESULT_TTL, "result-ttl", TIME, "seconds", 1, 31536000, "86400",                             \
      "How long results are kept")                                                                 \
    X(KEEP_INPUTS, "keep-inputs", BYTES, "bytes", 0, 1e15, "1G",                                   \
      "Uploads that are kept as long as results, in all; those of jobs that ended first go "       \
      "first; "                                                                                    \
      "0 keeps none")                                                                              \
    X(PUBLIC_URL, "public-url", TEXT, "URL", 0, 0, "",                                             \
      "How clients reach this daemon, for absolute links; else the scheme, Host and path that a "  \
      "trusted proxy names; else http:// and the Host they sent")                                  \
    X(TRUSTED_PROXY, "trusted-proxy", LIST, "LIST", 0, 0, "",                                      \
      "Proxies whose --proxy-headers are believed: addresses and networks such as 10.0.0.0/8 or "  \
      "fd00::/8, separated by commas, or several flags")                                           \
    X(PROXY_HEADERS, "proxy-headers", CHOICE, "x-forwarded forwarded", 0, 0, "x-forwarded",        \
      "Which they set: X-Forwarded-For, -Proto, -Host, -Prefix, or Forwarded (RFC 7239); the "     \
      "others are ignored")                                                                        \
    X(ALLOWED_HOSTS, "allowed-hosts", LIST, "LIST", 0, 0, "",                                      \
      "Names that Host may have besides this machine's and that of --public-url, separated by "    \
      "commas, or several flags; else any that a trusted proxy names")                             \
    X(CORS_ORIGIN, "cors-origin", TEXT, "LIST", 0, 0, "",                                          \
      "Origins whose pages may use this daemon, separated by commas")                              \
    X(NO_AUTH, "no-auth", FLAG, "", 0, 1, "0",                                                     \
      "Listen beyond this machine although anybody may then submit jobs")                          \
    X(HTTP_THREADS, "http-threads", COUNT_OF, "threads", 1, 64, "2", "Threads that speak HTTP")    \
    X(CONNECTIONS, "connections", COUNT_OF, "connections", 1, 100000, "1024",                      \
      "Open connections; 32 more are kept for health checks")                                      \
    X(STREAMS, "streams", COUNT_OF, "streams", 1, 100000, "512", "Event streams at the same time") \
    X(HEADER_TIMEOUT, "header-timeout", TIME, "seconds", 0.1, 3600, "10",                          \
      "Time for a request's head, however slowly its bytes come")                                  \
    X(KEEP_TIMEOUT, "keep-timeout", TIME, "seconds", 0.1, 3600, "20",                              \
      "Time a kept connection may wait for its next request")                                      \
    X(BODY_TIMEOUT, "body-timeout", TIME, "seconds", 0.1, 86400, "3600", "Time for an upload")     \
    X(BODY_IDLE, "body-idle", TIME, "seconds", 0.1, 3600, "30", "Longest pause in an upload")      \
    X(BODY_RATE, "body-rate", BYTES, "bytes/s", 0, 1e12, "16K",                                    \
      "Slowest upload on average, measured once it is older than --body-idle")                     \
    X(HEARTBEAT, "heartbeat", TIME, "seconds", 0.1, 3600, "15",                                    \
      "Pause after which an event "                                                                \
      "stream shows that it lives")                                                                \
    X(DRAIN_TIMEOUT, "drain-timeout", TIME, "seconds", 0, 3600, "20",                              \
      "Time for running jobs to end after SIGTERM; the others wait for the next start")            \
    X(LOG_LEVEL, "log-level", CHOICE, "debug info warn error off", 0, 0, "info",                   \
      "What is logged, as one JSON object a line, on standard error")

enum vor_setting {
#define VOR_SETTING_ENUM(id, flag, kind, unit, min, max, def, sentence) VOR_SET_##id,
    VOR_SETTING_TABLE(VOR_SETTING_ENUM)
#undef VOR_SETTING_ENUM
        VOR_SETTING_COUNT
};

enum { VOR_CONFIG_TEXT_MAX = 1024 };

/** Every setting: texts in text, all others (a choice's index) in number. */
struct vor_config {
    double number[VOR_SETTING_COUNT];
    char text[VOR_SETTING_COUNT][VOR_CONFIG_TEXT_MAX];
    int given[VOR_SETTING_COUNT]; /**< by flag or environment */
    char host[256];               /**< of LISTEN, without brackets */
    unsigned port;
    int loopback;                /**< host is this machine only */
    struct vor_networks trusted; /**< of TRUSTED_PROXY */
};

/** --flag VALUE and --flag=VALUE of argv[1 .. argc - 1], by getopt_long, so that an unambiguous
 *  beginning of a flag stands for it; for the others the environment, then the default; then DATA,
 *  STORE, BLOBS, host, port and trusted are worked out. getenv is the environment to read.
 *
 *  @retval VOR_E_PARAM an unknown or ambiguous flag, a value missing or out of range (message:
 *                      flag, value and range), LISTEN not HOST:PORT, not a loopback address without
 *                      NO_AUTH, PUBLIC_URL no URL, CORS_ORIGIN no list of origins, TRUSTED_PROXY
 *                      none of networks, ALLOWED_HOSTS none of names, or no directory for DATA
 */
VOR_NODISCARD vor_status vor_config_read(struct vor_config *out, int argc, char **argv,
                                         char *(*getenv)(const char *name), struct vor_error *err);

/** Bytes of the name of a setting's variable, with the NUL. */
#define VOR_VARIABLE_MAX 64

/** A setting as the help, the manual and completions tell it. */
struct vor_setting_text {
    const char *flag, *sentence;
    const char *value; /**< what stands behind the flag: "N"; "" for nothing */
    const char *words; /**< of a choice, with blanks between; else "" */
    char variable[VOR_VARIABLE_MAX];
    char range[160]; /**< "1 to 64 jobs, default 2 "; "" where there is none */
};

/** Describes setting number `index`; false past the last. */
int vor_config_describe(struct vor_setting_text *out, unsigned index);

/** The table for people, one setting after another. */
void vor_config_help(FILE *out);

/** True when LIST (separated by commas, blanks ignored) holds item of that length, byte for byte.
 */
int vor_config_list_has(const char *list, const char *item, size_t length);

#endif
