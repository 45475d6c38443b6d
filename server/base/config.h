/** The settings of `voronoid serve`: one table for --help, parsing and messages. */
#ifndef VOR_SERVER_BASE_CONFIG_H
#define VOR_SERVER_BASE_CONFIG_H

#include "core/base/status.h"
#include "server/base/address.h"
#include "server/base/endpoint.h"

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

/** The file of settings that is read unless CONFIG names another. */
#define VOR_CONFIG_PLACE "/etc/voronoid/voronoid.conf"

/** Settings: identifier, flag, kind, unit, min, max, default, sentence. The environment variable of
 *  "http-threads" is VORONOID_HTTP_THREADS, or VORONOID_HTTP_THREADS_FILE for a file that holds the
 *  value; in the file of settings it is http-threads. A flag wins over the environment, and that
 *  over the file. */
#define VOR_SETTING_TABLE(X)                                                                       \
    X(CONFIG, "config", TEXT, "FILE", 0, 0, "",                                                    \
      "Settings, a line \"name = value\" each, for what neither flags nor the environment give; "  \
      "else " VOR_CONFIG_PLACE " where there is one")                                              \
    X(CHECK_CONFIG, "check-config", FLAG, "", 0, 1, "0",                                           \
      "Read the settings, say what is wrong with them, and end")                                   \
    X(LISTEN, "listen", TEXT, "HOST:PORT", 0, 0, "127.0.0.1:8080",                                 \
      "Where to listen; port 0 takes a free one, which the log names; unix:/PATH is a socket in "  \
      "the file system")                                                                           \
    X(SOCKET_MODE, "socket-mode", CHOICE, "0600 0660 0666", 0, 0, "0660",                          \
      "Who may connect to a Unix socket of --listen: its owner, its group, anybody")               \
    X(ADMIN_LISTEN, "admin-listen", TEXT, "HOST:PORT", 0, 0, "",                                   \
      "Where /livez, /readyz and /metrics, and nothing else, are answered by a thread of their "   \
      "own, also while --listen is overrun; nowhere unless given")                                 \
    X(ADMIN_ANYWHERE, "admin-anywhere", FLAG, "", 0, 1, "0",                                       \
      "Let --admin-listen be an address that other machines reach")                                \
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
      "machine's, or of what the control group may take")                                          \
    X(QUEUE_BYTES, "queue-bytes", BYTES, "bytes", 1, 1e15, "8G",                                   \
      "Decoded inputs of jobs that wait, in all")                                                  \
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
    X(RESULTS_BYTES, "results-bytes", BYTES, "bytes", 0, 1e15, "0",                                \
      "Results that are kept, in all; those of jobs that ended first go first; 0 is half of the "  \
      "disk of --blobs")                                                                           \
    X(LOST_TTL, "lost-ttl", TIME, "seconds", 0, 31536000, "604800",                                \
      "How long bytes of jobs that a damaged --store has lost are kept, in the folder lost of "    \
      "--blobs")                                                                                   \
    X(LOST_BYTES, "lost-bytes", BYTES, "bytes", 0, 1e15, "1G",                                     \
      "How much of that is kept; the oldest goes first")                                           \
    X(DISK_RESERVE, "disk-reserve", BYTES, "bytes", 0, 1e15, "16M",                                \
      "Kept in a file beside --store, which a full disk is given back to end and remove jobs, "    \
      "and "                                                                                       \
      "as much free beside it, which uploads leave alone")                                         \
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
    X(API_KEYS, "api-keys", TEXT, "FILE", 0, 0, "",                                                \
      "Keys, one of which every request under /v1 then needs: lines of voronoid key NAME; SIGHUP " \
      "reads it again")                                                                            \
    X(NO_AUTH, "no-auth", FLAG, "", 0, 1, "0",                                                     \
      "Let anybody in without a key, although the daemon listens beyond this machine, or behind "  \
      "a proxy (--trusted-proxy, --public-url)")                                                   \
    X(HTTP_THREADS, "http-threads", COUNT_OF, "threads", 1, 64, "2", "Threads that speak HTTP")    \
    X(CONNECTIONS, "connections", COUNT_OF, "connections", 1, 100000, "1024",                      \
      "Open connections besides streams; when they are more, the oldest silent ones are cut, and " \
      "32 are kept for health checks")                                                             \
    X(ADDRESS_CONNECTIONS, "address-connections", COUNT_OF, "connections", 0, 100000, "128",       \
      "Open connections of one client (an IPv4 address, an IPv6 /64), this machine and "           \
      "--trusted-proxy excepted; 0 for no limit")                                                  \
    X(STREAMS, "streams", COUNT_OF, "streams", 1, 100000, "512", "Event streams at the same time") \
    X(HEADER_TIMEOUT, "header-timeout", TIME, "seconds", 0.1, 3600, "10",                          \
      "Time for a request's head, however slowly its bytes come")                                  \
    X(KEEP_TIMEOUT, "keep-timeout", TIME, "seconds", 0.1, 3600, "20",                              \
      "Time a kept connection may wait for its next request")                                      \
    X(BODY_TIMEOUT, "body-timeout", TIME, "seconds", 0.1, 86400, "3600", "Time for an upload")     \
    X(BODY_IDLE, "body-idle", TIME, "seconds", 0.1, 3600, "30", "Longest pause in an upload")      \
    X(BODY_RATE, "body-rate", BYTES, "bytes/s", 0, 1e12, "16K",                                    \
      "Slowest upload on average, measured once it is older than --body-idle")                     \
    X(REPLY_RATE, "reply-rate", BYTES, "bytes/s", 0, 1e12, "4K",                                   \
      "Slowest reader of a reply on average, measured once it is older than --body-idle; streams " \
      "of events excepted")                                                                        \
    X(HEARTBEAT, "heartbeat", TIME, "seconds", 0.1, 3600, "15",                                    \
      "Pause after which an event "                                                                \
      "stream shows that it lives")                                                                \
    X(DRAIN_DELAY, "drain-delay", TIME, "seconds", 0, 3600, "0",                                   \
      "Time after SIGTERM in which /readyz says no and all goes on, so that a balancer sends no "  \
      "more before requests are refused")                                                          \
    X(DRAIN_TIMEOUT, "drain-timeout", TIME, "seconds", 0, 3600, "20",                              \
      "Time for running jobs to end after SIGTERM and --drain-delay; the others wait for the "     \
      "next start")                                                                                \
    X(DRACO, "draco", CHOICE, "any strict", 0, 0, "any",                                           \
      "Draco files that are read: any that the library reads, or only point clouds of bitstream "  \
      "2.3 without metadata, for which it needs less of its code")                                 \
    X(ALLOW_WEAK_SANDBOX, "allow-weak-sandbox", FLAG, "", 0, 1, "0",                               \
      "Run although the kernel takes no list of system calls: uploads are then read in processes " \
      "with limits of memory and time alone")                                                      \
    X(LOG_LEVEL, "log-level", CHOICE, "debug info warn error off", 0, 0, "info",                   \
      "What is logged, as one JSON object a line, on standard error")

enum vor_setting {
#define VOR_SETTING_ENUM(id, flag, kind, unit, min, max, def, sentence) VOR_SET_##id,
    VOR_SETTING_TABLE(VOR_SETTING_ENUM)
#undef VOR_SETTING_ENUM
        VOR_SETTING_COUNT
};

/** A row of the table. */
struct vor_setting_info {
    const char *flag;
    enum vor_setting_kind kind;
    const char *unit;
    double min, max;
    const char *fallback, *sentence;
};

extern const struct vor_setting_info vor_setting_infos[VOR_SETTING_COUNT];

enum { VOR_CONFIG_TEXT_MAX = 1024 };

/** Every setting: texts in text, all others (a choice's index) in number. */
struct vor_config {
    double number[VOR_SETTING_COUNT];
    char text[VOR_SETTING_COUNT][VOR_CONFIG_TEXT_MAX];
    int given[VOR_SETTING_COUNT];     /**< by flag, environment or file */
    unsigned line[VOR_SETTING_COUNT]; /**< of the file of settings; 0 for elsewhere */
    char host[256];                   /**< of LISTEN, without brackets */
    unsigned port;
    int loopback;                        /**< host is this machine only */
    struct vor_endpoint endpoint, admin; /**< of LISTEN, of ADMIN_LISTEN */
    struct vor_networks trusted;         /**< of TRUSTED_PROXY */
};

/** --flag VALUE and --flag=VALUE of argv[1 .. argc - 1], by getopt_long, so that an unambiguous
 *  beginning of a flag stands for it; for the others the environment, then the file CONFIG, then
 *  the default; then DATA, STORE, BLOBS, host, port and trusted are worked out. getenv is the
 *  environment to read. A message about a value of the file begins with file and line.
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

/** Bytes of the name of a setting's variable, with the NUL. */
#define VOR_VARIABLE_MAX 64

/** VORONOID_ and the flag in capitals. */
void vor_config_variable(const char *flag, char out[VOR_VARIABLE_MAX]);

/** True when LIST (separated by commas, blanks ignored) holds item of that length, byte for byte.
 */
int vor_config_list_has(const char *list, const char *item, size_t length);

#endif
