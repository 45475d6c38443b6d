#include "server/api/limits.h"

#include "server/api/problem.h"
#include "server/base/clock.h"
#include "server/base/rates.h"

#include <math.h>
#include <stdio.h>

bool vor_limits_rate(struct vor_request *request)
{
    const struct vor_principal *caller = &request->principal;
    char detail[192];
    double wait, burst, left, now = vor_clock_seconds();

    if (caller->quota.rate <= 0)
        return true;
    wait = vor_rates_take(request->app->rates, caller->name, caller->quota.rate, now);
    /* Both count jobs asked for: at most q in w seconds, r of them now, all of them in t seconds.
     */
    burst = vor_rates_burst(caller->quota.rate);
    left = vor_rates_left(request->app->rates, caller->name, caller->quota.rate, now);
    (void)snprintf(detail, sizeof detail, "\"jobs\";q=%.0f;w=%.0f", floor(burst),
                   ceil(burst / caller->quota.rate));
    vor_reply_header(request, "RateLimit-Policy", detail);
    (void)snprintf(detail, sizeof detail, "\"jobs\";r=%.0f;t=%.0f", floor(left),
                   ceil((burst - left) / caller->quota.rate));
    vor_reply_header(request, "RateLimit", detail);
    if (wait <= 0)
        return true;
    (void)snprintf(detail, sizeof detail,
                   "the key %s starts jobs too fast: it may start %.10g per second, and twice "
                   "as many at once",
                   caller->name, caller->quota.rate);
    return vor_problem_reply(request, &VOR_PROBLEM("rate-limited", .detail = detail,
                                                   .retry_seconds = (unsigned)ceil(wait)));
}
