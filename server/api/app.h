/** What every handler works with: the running daemon's parts, none of them owned here. */
#ifndef VOR_SERVER_API_APP_H
#define VOR_SERVER_API_APP_H

#include "proto/json/json.h"
#include "server/base/config.h"
#include "server/http/http.h"
#include "server/jobs/inflight.h"
#include "server/work/job_service.h"

#include <stdatomic.h>

struct vor_admit;
struct vor_conversions;
struct vor_verify;
struct vor_tickets;
struct vor_rates;

struct vor_app {
    const struct vor_config *config;
    struct vor_store *store;
    struct vor_blobs *blobs;
    struct vor_job_service *service;
    struct vor_admit *admit;
    struct vor_inflight *inflight;
    struct vor_keys *keys;       /**< NULL: anybody may call */
    struct vor_tickets *tickets; /**< to results */
    struct vor_rates *rates;     /**< of requests for jobs, by the name of the key */
    struct vor_conversions *conversions;
    struct vor_verify *verify;
    struct vor_http *http;
    const char *sandbox;  /**< of what reads uploads: "full" or "partial" */
    atomic_bool leaving;  /**< SIGTERM came: /readyz says no */
    atomic_bool draining; /**< and --drain-delay is over: streams end */
    atomic_uint streams;  /**< event streams open */
};

#endif
