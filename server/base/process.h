/** What the kernel says of this process, as Prometheus's client libraries name it. */
#ifndef VOR_SERVER_BASE_PROCESS_H
#define VOR_SERVER_BASE_PROCESS_H

#include "proto/text.h"

/** Appends process_cpu_seconds_total, process_resident_memory_bytes and their like; those that
 *  /proc does not tell are left out. */
void vor_process_write(struct vor_text *text);

#endif
