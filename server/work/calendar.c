#include "server/work/live.h"

#include "server/base/clock.h"
#include "server/base/log.h"

/* Milliseconds. A clock that is corrected in small steps, or a thread that waits for its core, is
 * no jump; a daemon that was down for less than an hour is common, and an hour more of a result
 * that has expired harms nobody. */
static const int64_t jump_ms = 30000, unsure_ms = 3600000;

vor_status vor_calendar_begin(struct vor_worker *worker, struct vor_error *err)
{
    struct vor_calendar *calendar = &worker->calendar;
    int64_t ahead;
    vor_status status;

    if (vor_store_is_shared(worker->config.store)) /* whose clock it goes by */
        return VOR_OK;
    status = vor_store_newest(worker->config.store, &calendar->newest, err);
    if (status != VOR_OK)
        return status;
    calendar->wall = vor_clock_wall_ms();
    calendar->steady = calendar->began = vor_clock_boot_ms();
    ahead = calendar->wall - calendar->newest;
    calendar->unsure = calendar->newest > 0 && (ahead > unsure_ms || ahead < -jump_ms);
    if (calendar->unsure)
        vor_log(VOR_LOG_WARN,
                "the clock does not agree with the times of the stored jobs: no job expires "
                "for an hour, or until the clock agrees",
                VOR_REAL("ahead_s", (double)ahead / 1000));
    return VOR_OK;
}

static int move_rows(struct vor_worker *worker, int64_t by)
{
    struct vor_error err;

    if (vor_store_shift(worker->config.store, by, &err) != VOR_OK) {
        vor_log(VOR_LOG_ERROR, "the clock jumped, and expiry times could not be adjusted",
                VOR_TEXT("error", err.message));
        return 0;
    }
    vor_worker_trim_lost(worker, by);
    vor_log(VOR_LOG_WARN, "the clock jumped: expiry times are adjusted",
            VOR_REAL("by_s", (double)by / 1000));
    return 1;
}

int vor_calendar_look(struct vor_worker *worker)
{
    struct vor_calendar *calendar = &worker->calendar;
    int64_t wall = vor_clock_wall_ms(), steady = vor_clock_boot_ms();
    int64_t jump = wall - calendar->wall - (steady - calendar->steady);
    int64_t passed = steady - calendar->began, ahead = wall - calendar->newest - passed;

    if (vor_store_is_shared(worker->config.store))
        return 1;
    if (calendar->unsure) /* until it fits, or an hour has passed */
        calendar->unsure = passed <= unsure_ms && (ahead > unsure_ms || ahead < -jump_ms);
    else if ((jump > jump_ms || jump < -jump_ms) && !move_rows(worker, jump))
        return 0;
    calendar->wall = wall;
    calendar->steady = steady;
    return !calendar->unsure;
}
