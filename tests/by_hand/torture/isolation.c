/* usage: isolation ROUNDS [CASE]: what it costs to read an upload in a child, beside the calling
 * thread. A line a case: name, bytes, median milliseconds on the thread, in a child, and of their
 * differences; then mean milliseconds of computing on the thread, and in a child with what it takes
 * the zygote and the caller, which a busy machine changes little. Both write into a blob, as
 * admission does; each round does one and then the other. */
#include "proto/codec.h"
#include "proto/dump.h"
#include "server/base/clock.h"
#include "server/blob/blob.h"
#include "server/work/codec_child.h"
#include "server/work/codec_run.h"
#include "tests/support/vt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>

enum { ROUNDS_MAX = 1000 };

static const struct {
    const char *name;
    size_t points;
    unsigned format;
} cases[] = {
    {"PLY of 1,000 points", 1000, VOR_FORMAT_PLY},
    {"PLY of 80,000 points", 80000, VOR_FORMAT_PLY},
    {"Draco of 200,000 points", 200000, VOR_FORMAT_DRC},
    {"PLY of 1,000,000 points", 1000000, VOR_FORMAT_PLY},
    {"Draco of 1,000,000 points", 1000000, VOR_FORMAT_DRC},
};

static struct vor_error err;

/* What is measured must work: else there is nothing to measure. */
static void must(int holds)
{
    if (holds)
        return;
    (void)fprintf(stderr, "isolation: %s\n", err.message);
    exit(EXIT_FAILURE);
}

/* Points on a sphere, scattered. */
static void make_sphere(struct vor_cloud *cloud, struct vor_memory *memory, size_t n)
{
    vor_memory_init(memory, SIZE_MAX);
    vor_cloud_init(cloud, memory);
    must(vor_cloud_resize(cloud, n, &err) == VOR_OK);
    for (size_t i = 0; i < n; i++) {
        double z = 2 * vt_unit(1, 2 * i) - 1, angle = 6.283185307 * vt_unit(1, 2 * i + 1);

        cloud->xyz[3 * i] = (float)(sqrt(1 - z * z) * cos(angle));
        cloud->xyz[3 * i + 1] = (float)(sqrt(1 - z * z) * sin(angle));
        cloud->xyz[3 * i + 2] = (float)z;
    }
}

static void check(const struct vor_blob_writer *writer)
{
    size_t size = (size_t)vor_blob_size(writer), points;
    void *bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, vor_blob_fd(writer), 0);

    must(bytes != MAP_FAILED);
    must(vor_dump_check(&points, bytes, size, &err) == VOR_OK);
    (void)munmap(bytes, size);
}

static double milliseconds(struct vor_blobs *blobs, const struct vor_codec_place *place,
                           const struct vor_blob_writer *upload)
{
    const struct vor_codec_order order = {.op = VOR_CODEC_DECODE,
                                          .size = vor_blob_size(upload),
                                          .memory = (size_t)1 << 30,
                                          .most = UINT64_MAX,
                                          .limits = VOR_LIMITS_DEFAULT};
    struct vor_blob_writer *writer;
    struct vor_codec_facts facts;
    struct vor_sink sink;
    double began;

    must(vor_blob_create(blobs, &writer, &err) == VOR_OK);
    sink = vor_blob_sink(writer);
    began = vor_clock_seconds();
    must(vor_codec_run(&facts, place, &order, vor_blob_fd(upload), &sink, &err) == VOR_OK);
    if (place->zygote != NULL)
        check(writer);
    began = (vor_clock_seconds() - began) * 1e3;
    vor_blob_discard(writer);
    return began;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, ascending);
    return values[count / 2];
}

/* Milliseconds of computing of this process, or of its children that it has waited for and of
 * theirs. */
static double computed_ms(int who)
{
    struct rusage used;

    must(getrusage(who, &used) == 0);
    return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) * 1e3 +
           (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec) * 1e-3;
}

/* Ends the zygote once its last child is gone; what both took. */
static double children_ms(struct vor_zygote *zygote)
{
    static const struct timespec moment = {.tv_nsec = 100000000};
    double before = computed_ms(RUSAGE_CHILDREN);

    (void)nanosleep(&moment, NULL);
    vor_zygote_stop(zygote);
    return computed_ms(RUSAGE_CHILDREN) - before;
}

static void measure(struct vor_blobs *blobs, const struct vor_codec_place *child, int number,
                    int rounds)
{
    static double here_ms[ROUNDS_MAX], child_ms[ROUNDS_MAX], more_ms[ROUNDS_MAX];
    const struct vor_write_options options = {.quantization_bits = 14, .compression = 7};
    const struct vor_codec_place here = {0};
    struct vor_blob_writer *upload;
    struct vor_memory memory;
    struct vor_cloud cloud;
    struct vor_sink sink;
    double here_cpu = 0, child_cpu = 0;

    make_sphere(&cloud, &memory, cases[number].points);
    must(vor_blob_create(blobs, &upload, &err) == VOR_OK);
    sink = vor_blob_sink(upload);
    must(vor_format(cases[number].format)->write(&sink, &cloud, &options, &err) == VOR_OK);
    vor_cloud_free(&cloud);
    (void)milliseconds(blobs, child, upload);
    for (int i = 0; i < rounds; i++) {
        double began = computed_ms(RUSAGE_SELF), between;

        here_ms[i] = milliseconds(blobs, &here, upload);
        between = computed_ms(RUSAGE_SELF);
        child_ms[i] = milliseconds(blobs, child, upload);
        more_ms[i] = child_ms[i] - here_ms[i];
        here_cpu += between - began;
        child_cpu += computed_ms(RUSAGE_SELF) - between;
    }
    child_cpu += children_ms(child->zygote) * rounds / (rounds + 1); /* one was before them */
    printf("%s\t%llu\t%.3f\t%.3f\t%.3f\t%.3f\t%.3f\n", cases[number].name,
           (unsigned long long)vor_blob_size(upload), median(here_ms, rounds),
           median(child_ms, rounds), median(more_ms, rounds), here_cpu / rounds,
           child_cpu / rounds);
    vor_blob_discard(upload);
}

int main(int argc, char **argv)
{
    int rounds = argc > 1 ? atoi(argv[1]) : 11, only = argc > 2 ? atoi(argv[2]) : -1;
    struct vor_error why;
    struct vor_zygote zygote;
    const struct vor_child_kind kind = {"vor-codec", vor_codec_child};
    struct vor_codec_place child = {.zygote = &zygote, .kind = 0};
    struct vor_blobs *blobs;
    char dir[] = "/tmp/voronoid-isolation-XXXXXX", place[64];
    long holder;

    if (rounds < 1 || rounds > ROUNDS_MAX)
        return EXIT_FAILURE;
    child.sandbox = vor_sandbox_probe(&why);
    must(mkdtemp(dir) != NULL);
    (void)snprintf(place, sizeof place, "dir:%s", dir);
    must(vor_blobs_open(&blobs, place, NULL, &holder, &err) == VOR_OK);
    for (int i = 0; i < (int)(sizeof cases / sizeof cases[0]); i++) {
        if (only >= 0 && only != i)
            continue;
        must(vor_zygote_start(&zygote, &kind, 1, &err) == VOR_OK);
        measure(blobs, &child, i, cases[i].points < 500000 ? rounds * 4 : rounds);
    }
    vor_blobs_close(blobs);
    (void)snprintf(place, sizeof place, "rm -r %s", dir);
    return system(place) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
