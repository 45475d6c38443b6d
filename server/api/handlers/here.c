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

bool vor_blob_is_here(struct vor_app *app, struct vor_request *request, const struct vor_uuid *id,
                      const char *name, bool *exists, enum vor_next *next)
{
    struct vor_asker asker = {.wake = wake, .caller = vor_auth_fairness_key(request)};
    struct vor_error err;
    enum vor_fetched fetched;

    asker.ctx = vor_request_waker(request);
    fetched = vor_fetch(vor_verify_fetcher(app->verify), id, name, &asker, &err);
    if (fetched != VOR_FETCH_WAIT)
        vor_waker_drop(asker.ctx);
    if (fetched == VOR_FETCH_WAIT)
        *next = vor_problem_or_wait(app, request);
    else if (fetched == VOR_FETCH_FAILED)
        *next = vor_problem_error(app, request, &err, id->text);
    *exists = fetched == VOR_FETCH_NEAR;
    return fetched == VOR_FETCH_NEAR || fetched == VOR_FETCH_NONE;
}
