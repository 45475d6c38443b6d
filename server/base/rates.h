/** How often each of many names may do something: a bucket of tokens a name. */
#ifndef VOR_SERVER_BASE_RATES_H
#define VOR_SERVER_BASE_RATES_H

/** Thread-safe. */
struct vor_rates;

/** NULL when memory is out. */
struct vor_rates *vor_rates_create(void);

/** rates may be NULL. */
void vor_rates_destroy(struct vor_rates *rates);

/** Takes a token of a name, whose bucket gets `rate` (more than 0) of them a second and holds twice
 *  as many, at least one, which it has at first.
 *
 *  @param[in] now  vor_clock_seconds
 *
 *  @return 0 when there was one; else the seconds until there is one. Without memory for another
 *          bucket there is always one.
 *
 *  Full buckets are dropped, so memory is bounded by the callers of the last two seconds. */
double vor_rates_take(struct vor_rates *rates, const char *name, double rate, double now);

/** The tokens that a name with that rate has left. */
double vor_rates_left(struct vor_rates *rates, const char *name, double rate, double now);

/** As many tokens as a bucket of that rate holds. */
double vor_rates_burst(double rate);

#endif
