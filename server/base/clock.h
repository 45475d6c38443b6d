/** The daemon's clocks: core has none of its own. */
#ifndef VOR_SERVER_BASE_CLOCK_H
#define VOR_SERVER_BASE_CLOCK_H

#include <pthread.h>
#include <stdint.h>

/** Milliseconds since 1970 UTC: for timestamps and expiry. */
int64_t vor_clock_wall_ms(void);

/** Seconds that never jump: for durations, deadlines and budgets. */
double vor_clock_seconds(void);

/** Makes a condition for vor_clock_wait. */
void vor_clock_condition(pthread_cond_t *condition);

/** Waits for the condition, whose mutex is held, until it is told or vor_clock_seconds reaches
 *  `until`: then 1. */
int vor_clock_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, double until);

/** Milliseconds that never jump and go on while the machine sleeps. */
int64_t vor_clock_boot_ms(void);

/** "2026-11-21T03:15:34.537Z" and its NUL. */
#define VOR_CLOCK_TEXT_SIZE 32

/** Writes RFC 3339 UTC with milliseconds; returns out. */
const char *vor_clock_text(int64_t wall_ms, char out[VOR_CLOCK_TEXT_SIZE]);

/** Reads the first 19 characters of such a text, or of any that has digits in their places, as
 *  seconds since 1970. Returns 0, and *seconds is unchanged, for what is no such time, or one
 *  before. */
int vor_clock_read(const char *text, int64_t *seconds);

/** The time now as HTTP has it (RFC 9110, 5.6.7): "Thu, 26 Nov 2026 09:52:10 GMT", always of this
 *  length; the daemon runs in the C locale. */
enum { VOR_HTTP_DATE_SIZE = 30 };
void vor_clock_http_date(char out[VOR_HTTP_DATE_SIZE]);

#endif
