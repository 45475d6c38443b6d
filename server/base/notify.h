/** What systemd, or another supervisor that sets NOTIFY_SOCKET, is told of this process
 * (sd_notify(3)). Does nothing where nobody asked. Never waits. */
#ifndef VOR_SERVER_BASE_NOTIFY_H
#define VOR_SERVER_BASE_NOTIFY_H

/** Sends a datagram of "NAME=value" lines: "READY=1", "STOPPING=1", "WATCHDOG=1". */
void vor_notify(const char *lines);

/** "RELOADING=1" with the time of the monotonic clock, which systemd 253 and later want beside it.
 */
void vor_notify_reloading(void);

/** Seconds after which WATCHDOG=1 is due again: half of what $WATCHDOG_USEC allows; 0 when nobody
 *  watches this process. */
double vor_notify_watchdog(void);

#endif
