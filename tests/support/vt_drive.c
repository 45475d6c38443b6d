#include "tests/support/vt_drive.h"

#include "tests/support/vt_ask.h"

#include <execinfo.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { MOMENTS = 3, UNSET = 0x5a };

/* Allocations of one call by the place that asked: the function that called vor_malloc, and its
 * caller. A place that failed for one row of a table need not fail for the next. */
enum { PLACES = 1 << 16, CALLS = 1 << 14, DEPTH = 2 };
static atomic_size_t noted = CALLS; /* CALLS: nobody notes them */
static uint16_t place_of[CALLS];
static unsigned char *tried; /* shared by the processes of all tests */

static void __attribute__((constructor)) share_places(void)
{
    tried = mmap(NULL, PLACES, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (tried == MAP_FAILED)
        abort();
}

static __attribute__((noinline)) void note_place(void)
{
    size_t at = atomic_load(&noted) < CALLS ? atomic_fetch_add(&noted, 1) : CALLS;
    void *frame[DEPTH + 2] = {NULL}; /* of this function, of the WRAP, and DEPTH callers */

    if (at >= CALLS)
        return;
    backtrace(frame, DEPTH + 2);
    place_of[at] = (uint16_t)vt_hash(&frame[2], DEPTH * sizeof *frame);
}

/* The linker has calls of vor_malloc and its like come here (--wrap). */
#define WRAP(name, parameters, ...)                                                                \
    void *__real_##name parameters;                                                                \
    void *__wrap_##name parameters;                                                                \
    void *__wrap_##name parameters                                                                 \
    {                                                                                              \
        note_place();                                                                              \
        return __real_##name(__VA_ARGS__);                                                         \
    }
WRAP(vor_malloc, (struct vor_memory * memory, size_t count, size_t size), memory, count, size)
WRAP(vor_calloc, (struct vor_memory * memory, size_t count, size_t size), memory, count, size)
WRAP(vor_realloc, (struct vor_memory * memory, void *p, size_t count, size_t size), memory, p,
     count, size)

/* Answers with `answer` from the at-th question or record on. */
struct trap {
    atomic_size_t asked;
    size_t at;
    enum vor_answer answer;
    struct vt_call *call; /* hashes the records */
};

static enum vor_answer ask(void *ctx)
{
    struct trap *trap = ctx;

    return atomic_fetch_add(&trap->asked, 1) + 1 >= trap->at ? trap->answer : VOR_CONTINUE;
}

void vt_call_hash(struct vt_call *call, const void *data, size_t size)
{
    call->hash = 31 * call->hash + vt_hash(data, size);
}

static void hash_values(struct vt_call *call, const struct vor_members *members, const void *values)
{
    for (unsigned i = 0; i < members->count; i++) {
        const struct vor_member *row = &members->rows[i];
        const unsigned char *at = vor_member_at(row, values);
        size_t size = sizeof(double), count = 1;

        if (strcmp(row->unit, "s") == 0 || strcmp(row->unit, "bytes") == 0)
            continue;
        if (row->kind == VOR_MEMBER_LIST)
            memcpy(&count, (const unsigned char *)values + row->count_offset, sizeof(unsigned));
        if (row->kind == VOR_MEMBER_OBJECT || row->kind == VOR_MEMBER_LIST)
            for (size_t k = 0; k < (unsigned)count; k++)
                hash_values(call, row->inner, at + k * row->inner->size);
        else if (row->kind != VOR_MEMBER_REQUEST && row->kind != VOR_MEMBER_TEXT) {
            if (row->kind == VOR_MEMBER_VECTOR)
                size = 3 * sizeof(double);
            else if (row->kind == VOR_MEMBER_NUMBERS)
                size = row->word_count * sizeof(double);
            else if (row->kind != VOR_MEMBER_REAL && row->kind != VOR_MEMBER_U64)
                size = sizeof(uint32_t);
            vt_call_hash(call, at, size);
        }
    }
}

static enum vor_answer note(void *ctx, const struct vor_record *record)
{
    hash_values(((struct trap *)ctx)->call, &vor_record_members, record);
    return ask(ctx);
}

static void hash_artefacts(struct vt_call *call, const struct vor_artefacts *set)
{
    for (unsigned i = 0; i < set->count; i++) {
        const struct vor_artefact *item = &set->item[i];
        const struct vor_cloud *cloud = &item->cloud;

        if (item->kind == VOR_ARTEFACT_DOCUMENT) {
            hash_values(call, item->document.members, item->document.values);
            continue;
        }
        call->points = item->mesh.polygons ? 0 : cloud->n;
        vt_call_hash(call, cloud->xyz, 3 * cloud->n * sizeof *cloud->xyz);
        vt_call_hash(call, cloud->origin, sizeof cloud->origin);
        for (unsigned k = 0; k < cloud->attribute_count; k++) {
            const struct vor_attribute *a = &cloud->attributes[k];

            vt_call_hash(call, a->data, cloud->n * a->components * vor_type_size(a->type));
        }
        vt_call_hash(call, item->mesh.triangle, 3 * item->mesh.count * sizeof(uint32_t));
    }
}

vor_status vt_call_request(struct vt_call *call)
{
    const char *options = strchr(call->options, ' ');
    size_t length = options == NULL ? strlen(call->options) : (size_t)(options - call->options);
    struct vor_artefacts inputs, outputs;
    struct vt_engine engine;
    char process[32] = "";
    vor_status status;

    memcpy(process, call->options, length);
    vor_spec_preset(&engine.spec, vor_process_find(process));
    vt_ask_set(&engine, options == NULL ? "" : options);
    vt_assert_ok(vor_spec_complete(&engine.spec, &vt_err));
    vor_artefacts_init(&inputs, &vt_memory);
    vor_artefacts_init(&outputs, &vt_memory);
    inputs.item[inputs.count++] =
        (struct vor_artefact){.name = "cloud", .kind = VOR_ARTEFACT_CLOUD, .cloud = *call->in};
    if (engine.spec.process->inputs[1].name != NULL &&
        (!vor_process_takes(engine.spec.process, VOR_PARAM_COHERENCE) ||
         vor_spec_given(&engine.spec, VOR_PARAM_COHERENCE))) /* the first half of itself */
        inputs.item[inputs.count++] =
            (struct vor_artefact){.name = engine.spec.process->inputs[1].name,
                                  .kind = VOR_ARTEFACT_CLOUD,
                                  .cloud = {.n = call->in->n / 2, .xyz = call->in->xyz}};
    status = vor_engine_run(&outputs, &inputs, &engine.spec, call->run, &vt_err);
    if (status == VOR_OK)
        hash_artefacts(call, &outputs);
    vor_artefacts_free(&outputs);
    return status;
}

/* Calls the row, and asserts what holds of any call. */
static vor_status attempt(struct vt_call *call, const struct vt_row *row,
                          const struct vor_cloud *in, const struct vor_run *run)
{
    size_t used = atomic_load(&vt_memory.used);
    vor_status status;

    call->in = in;
    call->run = run;
    call->options = row->options;
    call->points = 0;
    call->hash = 0;
    memset(call->out, UNSET, sizeof call->out);
    vt_err.message[0] = '\0';
    status = row->call(call);
    vt_memory.fail_at = 0;
    ck_assert_msg(atomic_load(&vt_memory.used) == used, "%s: %zu bytes are left after %s",
                  row->name, atomic_load(&vt_memory.used) - used, vor_status_slug(status));
    for (size_t i = 0; status != VOR_OK && i < sizeof call->out; i++)
        if (call->out[i] != UNSET)
            ck_abort_msg("%s: byte %zu of the result is written after %s", row->name, i,
                         vor_status_slug(status));
    return status;
}

void vt_drive_threads(const struct vt_row *row)
{
    static struct vt_call one, three;
    struct trap trap = {.at = SIZE_MAX};
    struct vor_watch watch = {.ctx = &trap, .poll = ask, .progress = note};
    struct vt_engine engine;
    struct vor_cloud in;

    row->make(&in, 1, row->many / VT_SMALLER);
    for (unsigned threads = 5 - 2 * VT_ONCE(2); threads <= 3; threads += 2) {
        vt_engine_open(&engine, threads);
        engine.run.watch = &watch;
        trap.call = threads == 1 ? &one : &three;
        vt_assert_ok(attempt(trap.call, row, &in, &engine.run));
        vt_engine_close(&engine);
    }
    ck_assert_msg(three.hash != 0 && (VT_ONCE(2) == 1 || one.hash == three.hash),
                  "%s: three threads give other bytes", row->name);
    vor_cloud_free(&in);
}

void vt_drive_failures(const struct vt_row *row)
{
    static struct vt_call call;
    struct vt_engine engine;
    struct vor_cloud in;
    size_t first, all, fresh = 0;

    row->make(&in, 1, row->few);
    vt_engine_open(&engine, 2);
    first = atomic_load(&vt_memory.calls);
    atomic_store(&noted, 0);
    vt_assert_ok(attempt(&call, row, &in, &engine.run));
    atomic_store(&noted, CALLS);
    all = atomic_load(&vt_memory.calls) - first;
    ck_assert_msg(all > 0, "%s: it allocates nothing", row->name);
    for (size_t at = 0; at < all; at++) {
        vor_status status;

        if (!vt_soaks() && row->options != NULL &&
            (at >= CALLS || tried[place_of[at]] || fresh++ % VT_STEP_FAILS > 0))
            continue;
        if (at < CALLS)
            tried[place_of[at]] = 1;
        vt_memory.fail_at = atomic_load(&vt_memory.calls) + at + 1;
        status = attempt(&call, row, &in, &engine.run);
        ck_assert_msg(status == VOR_E_NOMEM &&
                          strstr(vt_err.message, "not enough memory for ") != NULL,
                      "%s: %s after allocation %zu of %zu failed", row->name,
                      vor_status_slug(status), at + 1, all);
    }
    vt_engine_close(&engine);
    vor_cloud_free(&in);
}

void vt_drive_answers(const struct vt_row *row)
{
    static struct vt_call call;
    struct trap trap = {.at = SIZE_MAX, .call = &call};
    struct vor_watch watch = {.ctx = &trap, .poll = ask, .progress = note};
    struct vt_engine engine;
    struct vor_cloud in;
    size_t all, points, tries;
    int stopped; /* answers are VOR_CANCEL, then VOR_STOP */

    row->make(&in, 1, row->few);
    vt_engine_open(&engine, 1);
    engine.run.watch = &watch;
    vt_assert_ok(attempt(&call, row, &in, &engine.run));
    all = atomic_load(&trap.asked);
    points = call.points;
    ck_assert_msg((all > 0) == !row->silent, "%s: it asks %zu times", row->name, all);
    tries = all < MOMENTS ? all : MOMENTS;
    /* What gives no points hands out nothing early, and stages have no result to stop with. */
    for (stopped = 0; stopped <= (row->options != NULL && points > 0); stopped++)
        for (size_t k = 0; k < tries; k += VT_STEP) {
            size_t at = all < MOMENTS ? k + 1 : 1 + k * (all - 1) / (MOMENTS - 1);
            vor_status status;

            atomic_store(&trap.asked, 0);
            trap.at = at;
            trap.answer = stopped ? VOR_STOP : VOR_CANCEL;
            status = attempt(&call, row, &in, &engine.run);
            ck_assert_msg(status == (stopped ? VOR_OK : VOR_E_CANCELLED),
                          "%s: %s at question %zu of %zu", row->name, vor_status_slug(status), at,
                          all);
            ck_assert_uint_eq(call.points, stopped ? points : 0);
        }
    vt_engine_close(&engine);
    vor_cloud_free(&in);
}
