#include "server/api/auth.h"
#include "server/api/handlers/handlers.h"
#include "server/api/problem.h"
#include "server/work/fetch.h"
#include "server/work/verify.h"

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

    fetched = vor_fetch(vor_verify_fetcher(request->app->verify), id, name,
                        here->part.to > 0 ? &here->part : NULL, &asker, &here->flow, &err);
    if (fetched != VOR_FETCH_WAIT)
        vor_waker_drop(asker.ctx);
    if (fetched == VOR_FETCH_WAIT)
        *next = vor_problem_or_wait(request);
    else if (fetched == VOR_FETCH_FAILED)
        *next = vor_problem_error(request, &err, id->text);
    here->exists = fetched == VOR_FETCH_NEAR || fetched == VOR_FETCH_FLOWS;
    return here->exists || fetched == VOR_FETCH_NONE;
}
