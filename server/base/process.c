#include "server/base/process.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static void put(struct vor_text *text, const char *name, const char *kind, const char *sentence,
                double value)
{
    vor_text_printf(text, "# HELP %s %s\n# TYPE %s %s\n%s %.15g\n", name, sentence, name, kind,
                    name, value);
}

static double seconds(const struct timeval *time)
{
    return (double)time->tv_sec + (double)time->tv_usec / 1e6;
}

/* Fields 20, 22, 23 and 24 of proc(5)'s stat; the name before them may hold blanks. */
static void put_stat(struct vor_text *text)
{
    FILE *file = fopen("/proc/self/stat", "re");
    char line[1024];
    const char *at = NULL;
    unsigned long long start = 0, size = 0;
    long threads = 0, pages = 0;
    struct timespec now, up;

    if (file != NULL) {
        at = fgets(line, sizeof line, file) != NULL ? strrchr(line, ')') : NULL;
        (void)fclose(file);
    }
    if (at == NULL || sscanf(at + 1,
                             " %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %*u %*u %*d %*d %*d %*d "
                             "%ld %*d %llu %llu %ld",
                             &threads, &start, &size, &pages) != 4)
        return;
    put(text, "process_threads", "gauge", "Threads", (double)threads);
    put(text, "process_virtual_memory_bytes", "gauge", "Size of the address space", (double)size);
    put(text, "process_resident_memory_bytes", "gauge", "Resident memory",
        (double)pages * (double)sysconf(_SC_PAGESIZE));
    if (clock_gettime(CLOCK_REALTIME, &now) == 0 && clock_gettime(CLOCK_BOOTTIME, &up) == 0)
        put(text, "process_start_time_seconds", "gauge",
            "Start of the process, in seconds "
            "since 1970",
            (double)now.tv_sec - (double)up.tv_sec + (double)start / (double)sysconf(_SC_CLK_TCK));
}

void vor_process_write(struct vor_text *text)
{
    struct rusage usage;
    DIR *directory;
    struct rlimit limit;
    double count = -3; /* ".", ".." and the directory itself */

    if (getrusage(RUSAGE_SELF, &usage) == 0)
        put(text, "process_cpu_seconds_total", "counter",
            "CPU time of the process, user and "
            "system",
            seconds(&usage.ru_utime) + seconds(&usage.ru_stime));
    directory = opendir("/proc/self/fd");
    if (directory != NULL) {
        while (readdir(directory) != NULL)
            count++;
        (void)closedir(directory);
        put(text, "process_open_fds", "gauge", "Open file descriptors", count);
    }
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0)
        put(text, "process_max_fds", "gauge", "Largest number of open file descriptors",
            (double)limit.rlim_cur);
    put_stat(text);
}
