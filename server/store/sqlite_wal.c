#include "server/store/sqlite_wal.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { HEAD_SIZE = 32, FRAME_HEAD_SIZE = 24, PAGE_MAX = 65536, PATH_MAX_BYTES = 4096 };

/* The log's words are big-endian, but for those that its checksums add up. */
static const uint32_t MAGIC = 0x377f0682; /* its last bit: those are big-endian as well */

struct chain {
    int is_big;
    uint32_t sum[2];
};

static uint32_t big(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

static uint32_t little(const uint8_t *at)
{
    return (uint32_t)at[3] << 24 | (uint32_t)at[2] << 16 | (uint32_t)at[1] << 8 | at[0];
}

/* Adds bytes, a multiple of 8. */
static void add(struct chain *chain, const uint8_t *bytes, size_t size)
{
    uint32_t (*word)(const uint8_t *) = chain->is_big ? big : little;

    for (size_t i = 0; i < size; i += 8) {
        chain->sum[0] += word(bytes + i) + chain->sum[1];
        chain->sum[1] += word(bytes + i + 4) + chain->sum[0];
    }
}

static int ends_as(const struct chain *chain, const uint8_t *checksum)
{
    return chain->sum[0] == big(checksum) && chain->sum[1] == big(checksum + 4);
}

/* Takes a frame into the chain; true when that is how it ends. */
static int continues(struct chain *chain, const uint8_t *frame, size_t page)
{
    add(chain, frame, 8);
    add(chain, frame + FRAME_HEAD_SIZE, page);
    return ends_as(chain, frame + 16);
}

/* A frame that ends a change has the size of the database, others 0: true when this one, which does
 * not continue the chain, is another, and not for a bit of that word that was flipped. A kill
 * between a frame's head and its page leaves such a one, of a change that nobody was told of. */
static int is_of_no_change(const struct chain *before, uint8_t *frame, size_t page)
{
    if (big(frame + 4) != 0)
        return 0;
    for (int bit = 0; bit < 32; bit++) {
        struct chain chain = *before;
        int is_flipped;

        frame[4 + bit / 8] ^= (uint8_t)(1 << bit % 8);
        is_flipped = continues(&chain, frame, page);
        frame[4 + bit / 8] ^= (uint8_t)(1 << bit % 8);
        if (is_flipped)
            return 0;
    }
    return 1;
}

/* Walks the frames: true when one of this round is not in the chain, unless it is the last one and
 * of no change. */
static int has_lost_frame(FILE *log, const uint8_t *head, struct chain *chain, size_t page)
{
    uint8_t frame[FRAME_HEAD_SIZE + PAGE_MAX];
    int broken = 0, lost = 0;

    while (fread(frame, 1, FRAME_HEAD_SIZE + page, log) == FRAME_HEAD_SIZE + page) {
        const struct chain before = *chain;
        /* Those of an earlier round have two other salts. */
        int salts =
            (memcmp(frame + 8, head + 16, 4) == 0) + (memcmp(frame + 12, head + 20, 4) == 0);

        if (broken && salts > 0)
            return 1;
        if (broken || (continues(chain, frame, page) && salts == 2))
            continue;
        broken = 1;
        lost = salts == 1 || (salts == 2 && !is_of_no_change(&before, frame, page));
    }
    return lost;
}

static int is_damaged(FILE *log)
{
    struct chain chain = {0};
    uint8_t head[HEAD_SIZE];
    uint32_t page;

    if (fread(head, 1, sizeof head, log) != sizeof head)
        return 0; /* nothing was ever written behind it */
    chain.is_big = (big(head) & 1) != 0;
    add(&chain, head, HEAD_SIZE - 8);
    page = big(head + 8);
    if ((big(head) & ~1u) != MAGIC || page < 512 || page > PAGE_MAX || !ends_as(&chain, head + 24))
        return fgetc(log) != EOF;
    return has_lost_frame(log, head, &chain, page);
}

int vor_sqlite_wal_is_damaged(const char *path)
{
    char name[PATH_MAX_BYTES];
    FILE *log;
    int damaged;

    if ((size_t)snprintf(name, sizeof name, "%s-wal", path) >= sizeof name)
        return 0;
    log = fopen(name, "rbe");
    if (log == NULL)
        return 0;
    damaged = is_damaged(log);
    (void)fclose(log);
    return damaged;
}
