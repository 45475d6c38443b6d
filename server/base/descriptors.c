#include "server/base/descriptors.h"

#include "server/base/log.h"

#include <sys/resource.h>

enum {
    OWN =
        256, /* store, blobs, jobs, sockets that are being closed, the reserve for health checks */
    FEWEST = 16 /* connections, below which it is no use to start */
};

/* Lowers connections and streams alike, so that they fit. */
static vor_status lower(struct vor_config *config, double hard, struct vor_error *err)
{
    double *connections = &config->number[VOR_SET_CONNECTIONS];
    double *streams = &config->number[VOR_SET_STREAMS];
    double asked = 2 * *connections + *streams;
    double share = (hard - OWN) / asked;

    if (config->given[VOR_SET_CONNECTIONS] || config->given[VOR_SET_STREAMS] ||
        share * *connections < FEWEST)
        return vor_fail_param(
            err, VOR_E_PARAM, "connections",
            "--connections %.0f and --streams %.0f need %.0f open files, but this machine's "
            "limit is %.0f (ulimit -Hn): allow fewer connections or streams, or raise the "
            "limit",
            *connections, *streams, asked + OWN, hard);
    *connections = (double)(unsigned)(*connections * share);
    *streams = (double)(unsigned)(*streams * share);
    vor_log(VOR_LOG_WARN,
            "fewer connections are allowed, because the limit of open files is "
            "too low",
            VOR_COUNT("connections", *connections), VOR_COUNT("streams", *streams),
            VOR_COUNT("files", hard), VOR_COUNT("wanted", asked + OWN));
    return VOR_OK;
}

vor_status vor_descriptors_raise(struct vor_config *config, struct vor_error *err)
{
    double wanted = 2 * config->number[VOR_SET_CONNECTIONS] + config->number[VOR_SET_STREAMS] + OWN;
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
    return (double)limit.rlim_cur >= wanted ? VOR_OK : lower(config, (double)limit.rlim_cur, err);
}
