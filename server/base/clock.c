#define _GNU_SOURCE /* CLOCK_BOOTTIME, strptime */

#include "server/base/clock.h"

#include <errno.h>
#include <stdio.h>
#include <time.h>

int64_t vor_clock_wall_ms(void)
{
    struct timespec now;

    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

double vor_clock_seconds(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

void vor_clock_condition(pthread_cond_t *condition)
{
    pthread_condattr_t monotonic;

    (void)pthread_condattr_init(&monotonic);
    (void)pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    (void)pthread_cond_init(condition, &monotonic);
    (void)pthread_condattr_destroy(&monotonic);
}

int vor_clock_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, double until)
{
    struct timespec at = {.tv_sec = (time_t)until};

    at.tv_nsec = (long)((until - (double)at.tv_sec) * 1e9);
    return pthread_cond_timedwait(condition, mutex, &at) == ETIMEDOUT;
}

int64_t vor_clock_boot_ms(void)
{
    struct timespec now;

    clock_gettime(CLOCK_BOOTTIME, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

const char *vor_clock_text(int64_t wall_ms, char out[VOR_CLOCK_TEXT_SIZE])
{
    time_t seconds = (time_t)(wall_ms / 1000);
    char day[24] = "";
    struct tm utc;

    if (gmtime_r(&seconds, &utc) != NULL)
        (void)strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &utc);
    (void)snprintf(out, VOR_CLOCK_TEXT_SIZE, "%s.%03dZ", day, (int)(wall_ms % 1000));
    return out;
}

int vor_clock_read(const char *text, int64_t *seconds)
{
    static const char shape[] = "0000-00-00T00:00:00";
    struct tm utc = {0};

    for (size_t i = 0; i + 1 < sizeof shape; i++)
        if (shape[i] == '0' ? text[i] < '0' || text[i] > '9' : text[i] != shape[i])
            return 0;
    if (strptime(text, "%Y-%m-%dT%H:%M:%S", &utc) == NULL || utc.tm_year < 70)
        return 0;
    *seconds = (int64_t)timegm(&utc);
    return 1;
}

void vor_clock_http_date(char out[VOR_HTTP_DATE_SIZE])
{
    time_t now = time(NULL);
    struct tm tm = {.tm_mday = 1};

    (void)gmtime_r(&now, &tm);
    (void)strftime(out, VOR_HTTP_DATE_SIZE, "%a, %d %b %Y %H:%M:%S GMT", &tm);
}
