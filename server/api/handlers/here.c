#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/base/digest.h"
#include "server/work/fetch.h"
#include "server/work/verify.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void wake(void *ctx)
{
    vor_waker_wake(ctx);
    vor_waker_drop(ctx);
}

struct vor_asker vor_asker_of(struct vor_request *request)
{
    return (struct vor_asker){.wake = wake,
                              .ctx = vor_waker_hold(request->waker),
                              .caller = vor_auth_fairness_key(request)};
}

bool vor_blob_is_here(struct vor_request *request, const struct vor_uuid *id, const char *name,
                      struct vor_here *here, enum vor_next *next)
{
    struct vor_asker asker = vor_asker_of(request);
    struct vor_error err;
    enum vor_fetched fetched;

    fetched = vor_fetch(vor_verify_fetcher(request->app->verify), id, name, &asker,
                        here->may_flow ? &here->flow : NULL, &err);
    if (fetched != VOR_FETCH_WAIT)
        vor_waker_drop(asker.ctx);
    if (fetched == VOR_FETCH_WAIT)
        *next = vor_problem_or_wait(request);
    else if (fetched == VOR_FETCH_FAILED)
        *next = vor_problem_error(request, &err, id->text);
    here->exists = fetched == VOR_FETCH_NEAR || fetched == VOR_FETCH_FLOWS;
    return here->exists || fetched == VOR_FETCH_NONE;
}

/* --- bytes that are sent while they come ------------------------------------------------------ */

enum { HELD = 1 << 14 }; /* of the last bytes: sent once all are known to be right */

/* A reply under way: the state of its request. */
struct flowing {
    struct vor_flow *flow;
    struct vor_digest *digest;
    uint64_t at, size;
    char sha256[VOR_DIGEST_SIZE];
    uint8_t last[HELD];
    size_t held, sent; /* bytes of last */
};

static void release(void *ctx)
{
    struct flowing *flowing = ctx;

    vor_flow_drop(flowing->flow);
    vor_digest_destroy(flowing->digest);
    free(flowing);
}

/* As vor_flow_read, where the bytes are digested. */
static long take(struct flowing *flowing, struct vor_request *request, void *out, size_t size,
                 int *whole)
{
    struct vor_asker asker = vor_asker_of(request);
    long got = vor_flow_read(flowing->flow, flowing->at, out, size, &asker, whole);

    if (got != 0 || *whole)
        vor_waker_drop(asker.ctx);
    if (got > 0) {
        vor_digest_update(flowing->digest, out, (size_t)got);
        flowing->at += (uint64_t)got;
    }
    return got;
}

static long read_flow(struct vor_request *request, char *out, size_t size)
{
    struct flowing *flowing = request->state;
    uint64_t first_held = flowing->size > HELD ? flowing->size - HELD : 0;
    char sha256[VOR_DIGEST_SIZE];
    int whole = 0;
    long got;

    if (flowing->at < first_held) {
        got = take(flowing, request, out,
                   size < first_held - flowing->at ? size : (size_t)(first_held - flowing->at),
                   &whole);
        return got == 0 && whole ? -1 : got;
    }
    for (; flowing->at < flowing->size; flowing->held += (size_t)got) {
        got = take(flowing, request, flowing->last + flowing->held,
                   (size_t)(flowing->size - flowing->at), &whole);
        if (got <= 0)
            return whole ? -1 : got;
    }
    vor_digest_hex(flowing->digest, sha256);
    if (strcmp(sha256, flowing->sha256) != 0)
        return -1;
    if (size > flowing->held - flowing->sent)
        size = flowing->held - flowing->sent;
    memcpy(out, flowing->last + flowing->sent, size);
    flowing->sent += size;
    return (long)size;
}

enum vor_next vor_reply_flow(struct vor_request *request, struct vor_flow *flow,
                             const char *media_type, uint64_t size, const char *sha256)
{
    struct flowing *flowing = calloc(1, sizeof *flowing);

    if (flowing == NULL || (flowing->digest = vor_digest_create()) == NULL) {
        free(flowing);
        vor_flow_drop(flow);
        return vor_problem_no_memory(request);
    }
    flowing->flow = flow;
    flowing->size = size;
    (void)snprintf(flowing->sha256, sizeof flowing->sha256, "%s", sha256);
    vor_request_set_state(request, flowing, release);
    vor_reply_stream(request, 200, media_type, size, read_flow);
    return VOR_NEXT_REPLY;
}
