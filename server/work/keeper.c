#include "server/work/keeper.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/base/machine.h"

/* A checkpoint of 1 M points has 50 MB: at most so often, however fast the machine is. */
static const double pause_seconds = 10;

void vor_keeper_open(struct vor_keeper *out, struct vor_blobs *blobs, const struct vor_uuid *id,
                     double pause)
{
    *out =
        (struct vor_keeper){.blobs = blobs, .id = *id, .pause = pause > 0 ? pause : pause_seconds};
    out->next = vor_clock_seconds() + out->pause;
}

/* Ends the thread; false while it is busy and is not to be waited for. */
static int settle(struct vor_keeper *keeper, int waits)
{
    if (!keeper->is_storing)
        return 1;
    if (!waits && !atomic_load(&keeper->is_stored))
        return 0;
    (void)pthread_join(keeper->thread, NULL);
    keeper->is_storing = 0;
    keeper->writer = NULL;
    keeper->next = vor_clock_seconds() + keeper->pause;
    return 1;
}

int vor_keeper_file(struct vor_keeper *keeper)
{
    if (!settle(keeper, 0) || keeper->writer != NULL || vor_clock_seconds() < keeper->next)
        return -1;
    if (vor_blobs_room(keeper->blobs, 0, NULL) == VOR_OK &&
        vor_blob_create(keeper->blobs, &keeper->writer, NULL) == VOR_OK &&
        vor_blob_expect(keeper->writer, UINT32_MAX, NULL) == VOR_OK)
        return vor_blob_fd(keeper->writer);
    keeper->next = vor_clock_seconds() + pause_seconds;
    return -1;
}

static int is_wanted(void *ctx)
{
    struct vor_keeper *keeper = ctx;

    return !atomic_load(&keeper->is_closing) || vor_clock_seconds() < keeper->until;
}

static void *store(void *arg)
{
    struct vor_keeper *keeper = arg;
    const struct vor_blob_patience patience = {.is_wanted = is_wanted, .ctx = keeper};
    char name[VOR_BLOB_NAME_MAX + 1];
    struct vor_error err;

    vor_blob_be_lazy(keeper->writer);
    vor_blob_be_patient(keeper->writer, &patience);
    if (vor_blob_commit(keeper->writer, &keeper->id, vor_blob_of_input(VOR_BLOB_CHECKPOINT, name),
                        &err) != VOR_OK &&
        is_wanted(keeper))
        vor_log(VOR_LOG_WARN, "a checkpoint was not stored", VOR_TEXT("job", keeper->id.text),
                VOR_TEXT("error", err.message));
    atomic_store(&keeper->is_stored, 1);
    return NULL;
}

static void discard(struct vor_keeper *keeper)
{
    vor_blob_discard(keeper->writer);
    keeper->writer = NULL;
    keeper->next = vor_clock_seconds() + keeper->pause;
}

void vor_keeper_take(struct vor_keeper *keeper, const struct vor_job_output *file)
{
    if (keeper->writer == NULL || keeper->is_storing)
        return;
    atomic_store(&keeper->is_stored, 0);
    if (file->bytes == 0 ||
        vor_blob_adopt(keeper->writer, file->bytes, file->sha256, NULL) != VOR_OK ||
        vor_machine_thread(&keeper->thread, "vor-keeper", store, keeper) != 0) {
        discard(keeper);
        return;
    }
    keeper->is_storing = keeper->has_kept = 1;
}

int vor_keeper_close(struct vor_keeper *keeper, double seconds)
{
    keeper->until = vor_clock_seconds() + seconds;
    atomic_store(&keeper->is_closing, 1);
    (void)settle(keeper, 1);
    discard(keeper);
    return keeper->has_kept;
}
