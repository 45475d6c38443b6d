/* Admission: strangers' bytes become a durable, checked cloud, or an error and nothing else. */
#include "proto/codec.h"
#include "proto/dump.h"
#include "server/base/disk.h"
#include "server/work/admit.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <pthread.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static const struct vor_admit_limits limits = {.codec = VOR_LIMITS_DEFAULT, .memory = 64u << 20};
static struct vor_spec spec;

static int kept(const char *dir)
{
    return vt_dir_count(dir, "blobs/keep");
}

/* The dump of an admitted cloud. */
static void load(struct vor_blobs *blobs, const struct vor_uuid *id, struct vor_cloud *cloud)
{
    uint64_t size;
    size_t sealed;
    int fd, found;
    void *bytes;

    vt_assert_ok(vor_blob_get(blobs, id, "input", &fd, &size, &found, &vt_err));
    ck_assert(found);
    bytes = mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0);
    ck_assert_ptr_ne(bytes, MAP_FAILED);
    vor_cloud_init(cloud, &vt_memory);
    sealed = size;
    vt_assert_ok(vor_blob_unseal(bytes, &sealed, "input", &vt_err));
    ck_assert_uint_lt(sealed, size);
    vt_assert_ok(vor_dump_read(cloud, bytes, sealed, &vt_err));
    munmap(bytes, size);
    close(fd);
}

VT_TEST_LOOP(an_admitted_cloud_is_kept_as_it_was, 5)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_cloud cloud, back;
    struct vor_blob_writer *upload;
    struct vor_admitted admitted = {.count = 0};
    struct vor_job_input input;
    char sha256[VOR_DIGEST_SIZE];

    vt_cloud_cube(&cloud, (uint64_t)_i, 50 + (size_t)_i);
    upload = vt_upload_cloud(blobs, &cloud);
    vt_assert_ok(vor_admit_file(&admitted, "cloud", blobs, upload, &limits, &vt_err));
    vor_blob_sha256(upload, sha256);
    ck_assert_uint_eq(admitted.count, 1);
    ck_assert_str_eq(admitted.item[0].name, "cloud");
    input = admitted.item[0].found;
    ck_assert_uint_eq(input.format, VOR_FORMAT_PLY);
    ck_assert_uint_eq(input.points, cloud.n);
    ck_assert_uint_eq(input.bytes, vor_blob_size(upload));
    ck_assert_str_eq(input.sha256, sha256);
    ck_assert_double_ge(input.seconds, 0);
    vor_blob_discard(upload);
    load(blobs, &admitted.id, &back);
    ck_assert_uint_eq(back.n, cloud.n);
    ck_assert_mem_eq(back.xyz, cloud.xyz, 3 * cloud.n * sizeof(float));
    vor_cloud_free(&back);
    vor_cloud_free(&cloud);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_blobs_close(blobs);
}

#define HEAD "ply\nformat ascii 1.0\nelement vertex "
#define XYZ "\nproperty float x\nproperty float y\nproperty float z\nend_header\n"

/* Refusal: what is wrong is said, and nothing is kept. */
VT_TEST(what_cannot_be_decoded_leaves_nothing)
{
    static const struct {
        const char *bytes;
        vor_status status;
    } bad[] = {
        {"", VOR_E_EMPTY},
        {"solid of an STL file", VOR_E_UNSUPPORTED},
        {HEAD "0" XYZ, VOR_E_EMPTY},
        {HEAD "2" XYZ "0 0 0\n", VOR_E_FORMAT},
        {HEAD "1" XYZ "0 nan 0\n", VOR_E_NONFINITE},
        {HEAD "50000001" XYZ, VOR_E_LIMIT},
        {"DRACO\2\3\0\0rubbish", VOR_E_FORMAT},
    };
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_admitted admitted = {.id = {"untouched"}, .item[0].found.points = 77};

    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        struct vor_blob_writer *upload = vt_upload(blobs, bad[i].bytes, strlen(bad[i].bytes));

        vt_assert_fails(bad[i].status,
                        vor_admit_file(&admitted, "cloud", blobs, upload, &limits, &vt_err));
        vor_blob_discard(upload);
    }
    ck_assert_str_eq(admitted.id.text, "untouched");
    ck_assert_uint_eq(admitted.count, 0);
    ck_assert_uint_eq(admitted.item[0].found.points, 77);
    ck_assert_int_eq(kept(dir), 0);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_blobs_close(blobs);
}

VT_TEST(a_cloud_that_does_not_fit_is_refused_before_it_is_kept)
{
    struct vor_admit_limits small = limits;
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_blob_writer *upload;
    struct vor_admitted admitted = {.count = 0};
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 1000);
    upload = vt_upload_cloud(blobs, &cloud);
    small.memory = 1000;
    vt_assert_fails(VOR_E_NOMEM,
                    vor_admit_file(&admitted, "cloud", blobs, upload, &small, &vt_err));
    small.memory = limits.memory;
    small.codec.points = 999;
    vt_assert_fails(VOR_E_LIMIT,
                    vor_admit_file(&admitted, "cloud", blobs, upload, &small, &vt_err));
    ck_assert_uint_eq(vt_err.limit, 999);
    ck_assert_uint_eq(vt_err.got, 1000);
    ck_assert_int_eq(kept(dir), 0);
    vor_blob_discard(upload);
    vor_cloud_free(&cloud);
    vor_blobs_close(blobs);
}

/* --- threads ---------------------------------------------------------------------------------- */

struct answers {
    pthread_mutex_t mutex;
    pthread_cond_t cond;
    int count, hold; /* while hold is set, an admission thread waits in done */
};

static void init_answers(struct answers *answers)
{
    memset(answers, 0, sizeof *answers);
    vor_spec_preset(&spec, vor_process_find("inspect"));
    pthread_mutex_init(&answers->mutex, NULL);
    pthread_cond_init(&answers->cond, NULL);
}

static void answered(struct vor_admission *admission)
{
    struct answers *answers = admission->ctx;

    pthread_mutex_lock(&answers->mutex);
    answers->count++;
    pthread_cond_broadcast(&answers->cond);
    while (answers->hold)
        pthread_cond_wait(&answers->cond, &answers->mutex);
    pthread_mutex_unlock(&answers->mutex);
}

static void wait_answers(struct answers *answers, int count)
{
    pthread_mutex_lock(&answers->mutex);
    while (answers->count < count)
        pthread_cond_wait(&answers->cond, &answers->mutex);
    pthread_mutex_unlock(&answers->mutex);
}

static void let_go(struct answers *answers)
{
    pthread_mutex_lock(&answers->mutex);
    answers->hold = 0;
    pthread_cond_broadcast(&answers->cond);
    pthread_mutex_unlock(&answers->mutex);
}

static void upload_for(struct vor_admission *admission, struct vor_blob_writer *bytes)
{
    admission->uploads =
        (struct vor_uploads){.item = {{.name = "cloud", .bytes = bytes}}, .count = 1};
    admission->spec = &spec;
}

VT_TEST(every_upload_is_answered_once)
{
    enum { UPLOADS = 20 };
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_admission admissions[UPLOADS];
    struct vor_admit *admit;
    struct vor_cloud cloud;
    struct answers answers;

    init_answers(&answers);
    vt_cloud_cube(&cloud, 1, 500);
    vt_assert_ok(vor_admit_create(&admit, blobs, &limits, 3, 4 * UPLOADS, &vt_err));
    for (int i = 0; i < UPLOADS; i++) {
        admissions[i] = (struct vor_admission){.done = answered, .ctx = &answers};
        upload_for(&admissions[i],
                   i % 4 == 3 ? vt_upload(blobs, "rubbish", 7) : vt_upload_cloud(blobs, &cloud));
        ck_assert_int_eq(vor_admit_submit(admit, &admissions[i]), VOR_DONE);
    }
    wait_answers(&answers, UPLOADS);
    vor_admit_destroy(admit);
    ck_assert_int_eq(answers.count, UPLOADS);
    for (int i = 0; i < UPLOADS; i++) {
        ck_assert_int_eq(admissions[i].status, i % 4 == 3 ? VOR_E_UNSUPPORTED : VOR_OK);
        ck_assert_int_eq(admissions[i].error.status, i % 4 == 3 ? VOR_E_UNSUPPORTED : VOR_OK);
        ck_assert_uint_eq(admissions[i].uploads.count, 0);
    }
    ck_assert_int_eq(kept(dir), UPLOADS - UPLOADS / 4);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_cloud_free(&cloud);
    vor_blobs_close(blobs);
}

VT_TEST(waiting_uploads_are_bounded_and_answered_when_the_daemon_goes)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_admission busy = {.done = answered}, waits = busy, over = busy;
    struct vor_admit *admit;
    struct answers answers;
    struct vor_cloud cloud;

    init_answers(&answers);
    answers.hold = 1;
    vt_cloud_cube(&cloud, 1, 10);
    busy.ctx = waits.ctx = over.ctx = &answers;
    vt_assert_ok(vor_admit_create(&admit, blobs, &limits, 1, 1, &vt_err));
    upload_for(&busy, vt_upload_cloud(blobs, &cloud));
    upload_for(&waits, vt_upload_cloud(blobs, &cloud));
    upload_for(&over, vt_upload_cloud(blobs, &cloud));
    ck_assert_int_eq(vor_admit_submit(admit, &busy), VOR_DONE);
    wait_answers(&answers, 1); /* its thread now waits in done */
    ck_assert_int_eq(vor_admit_submit(admit, &waits), VOR_DONE);
    ck_assert_int_eq(vor_admit_submit(admit, &over), VOR_FULL);
    ck_assert_uint_eq(over.uploads.count, 1);
    vor_uploads_discard(&over.uploads);
    let_go(&answers);
    wait_answers(&answers, 2);
    ck_assert_int_eq(waits.status, VOR_OK);
    vor_admit_destroy(admit);
    vor_cloud_free(&cloud);
    vor_blobs_close(blobs);
}

static int nobody_waits(void *ctx)
{
    (void)ctx;
    return 1;
}

VT_TEST(an_upload_whose_caller_has_left_is_not_read)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_admission left = {.done = answered, .has_left = nobody_waits};
    struct vor_admit *admit;
    struct answers answers;

    init_answers(&answers);
    left.ctx = &answers;
    vt_assert_ok(vor_admit_create(&admit, blobs, &limits, 1, 1, &vt_err));
    upload_for(&left, vt_upload(blobs, "rubbish", 7)); /* else VOR_E_UNSUPPORTED */
    ck_assert_int_eq(vor_admit_submit(admit, &left), VOR_DONE);
    wait_answers(&answers, 1);
    vor_admit_destroy(admit);
    ck_assert_int_eq(left.status, VOR_E_CANCELLED);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_blobs_close(blobs);
}

static void *destroy(void *admit)
{
    vor_admit_destroy(admit);
    return NULL;
}

VT_TEST(what_waits_when_the_daemon_goes_is_answered_as_cancelled)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_admission busy = {.done = answered}, waits = busy, late = busy;
    enum vor_job_outcome outcome;
    struct vor_admit *admit;
    struct answers answers;
    struct vor_cloud cloud;
    pthread_t thread;

    init_answers(&answers);
    answers.hold = 1;
    vt_cloud_cube(&cloud, 1, 10);
    busy.ctx = waits.ctx = late.ctx = &answers;
    vt_assert_ok(vor_admit_create(&admit, blobs, &limits, 1, 1, &vt_err));
    upload_for(&busy, vt_upload_cloud(blobs, &cloud));
    upload_for(&waits, vt_upload_cloud(blobs, &cloud));
    ck_assert_int_eq(vor_admit_submit(admit, &busy), VOR_DONE);
    wait_answers(&answers, 1);
    ck_assert_int_eq(vor_admit_submit(admit, &waits), VOR_DONE);
    ck_assert_int_eq(pthread_create(&thread, NULL, destroy, admit), 0);
    upload_for(&late, vt_upload(blobs, "x", 1));
    do /* full, until the other thread has closed it */
        outcome = vor_admit_submit(admit, &late);
    while (outcome == VOR_FULL);
    ck_assert_int_eq(outcome, VOR_DRAINING);
    vor_uploads_discard(&late.uploads);
    let_go(&answers);
    pthread_join(thread, NULL);
    ck_assert_int_eq(busy.status, VOR_OK);
    ck_assert_int_eq(waits.status, VOR_E_CANCELLED);
    ck_assert_int_eq(kept(dir), 1);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_cloud_free(&cloud);
    vor_blobs_close(blobs);
}

/* Two inputs of a request, admitted; *admission has the answer. */
static void admit_two(struct vor_blobs *blobs, struct vor_admission *admission,
                      struct vor_blob_writer *cloud, struct vor_blob_writer *reference)
{
    struct vor_admit_limits roomy = limits;
    struct vor_admit *admit;
    struct answers answers;

    init_answers(&answers);
    roomy.inflated = 1 << 20;
    *admission = (struct vor_admission){
        .uploads = {.item = {{.name = "cloud", .bytes = cloud},
                             {.name = "reference", .bytes = reference, .is_gzip = 1}},
                    .count = 2},
        .spec = &spec,
        .done = answered,
        .ctx = &answers};
    vt_assert_ok(vor_admit_create(&admit, blobs, &roomy, 1, 1, &vt_err));
    ck_assert_int_eq(vor_admit_submit(admit, admission), VOR_DONE);
    wait_answers(&answers, 1);
    vor_admit_destroy(admit);
    ck_assert_uint_eq(admission->uploads.count, 0);
}

/* gzip of an ASCII PLY file with the points 0 0 0 and 1 2 3 (gzip -9n). */
static const uint8_t packed[] = {
    0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03, 0x5d, 0x8a, 0x4d, 0x0a, 0x80, 0x20,
    0x18, 0x05, 0xf7, 0xdf, 0x29, 0xde, 0x09, 0x42, 0xed, 0x40, 0x21, 0xf9, 0xa4, 0xc0, 0x3f, 0x4c,
    0x42, 0x3b, 0x7d, 0xae, 0x65, 0x36, 0xc3, 0x30, 0x25, 0x0c, 0xf1, 0xb9, 0x46, 0xdb, 0x60, 0x9f,
    0xf3, 0xbe, 0xa1, 0x37, 0x25, 0x0c, 0x8c, 0x4c, 0x0d, 0x2f, 0x6b, 0x63, 0x87, 0x91, 0x52, 0x73,
    0x99, 0x3e, 0xe0, 0x43, 0x9e, 0x67, 0x5f, 0xc3, 0x58, 0xc3, 0x27, 0x4c, 0xee, 0xb8, 0x68, 0x1d,
    0xab, 0x28, 0x4c, 0x44, 0xc3, 0x60, 0x97, 0x1f, 0x80, 0x70, 0x1b, 0x59, 0x70, 0x00, 0x00, 0x00};

VT_TEST(inputs_are_admitted_together_or_none_is)
{
    const char *dir = vt_dir_make();
    struct vor_blobs *blobs = vt_dir_blobs(dir);
    struct vor_admission admission;
    struct vor_cloud cloud;

    vt_cloud_cube(&cloud, 1, 10);
    admit_two(blobs, &admission, vt_upload_cloud(blobs, &cloud),
              vt_upload(blobs, packed, sizeof packed));
    vt_assert_ok(admission.status);
    ck_assert_uint_eq(admission.admitted.count, 2);
    ck_assert_str_eq(admission.admitted.item[1].name, "reference");
    ck_assert_uint_eq(admission.admitted.item[1].found.points, 2);
    ck_assert_uint_eq(admission.admitted.item[1].found.bytes, 112); /* as inflated */
    ck_assert_int_eq(kept(dir), 2);
    vor_admit_drop(blobs, &admission.admitted);
    ck_assert_int_eq(kept(dir), 0);

    admit_two(blobs, &admission, vt_upload_cloud(blobs, &cloud),
              vt_upload(blobs, packed, sizeof packed - 1));
    ck_assert_int_eq(admission.status, VOR_E_REQUEST);
    ck_assert_str_eq(admission.error.parameter, "reference");
    ck_assert_ptr_nonnull(strstr(admission.error.message, "reference: the gzip body is cut short"));
    ck_assert_int_eq(admission.error.byte_offset, (int64_t)sizeof packed - 1);
    ck_assert_uint_eq(admission.admitted.count, 0);
    ck_assert_int_eq(kept(dir), 0);
    ck_assert_int_eq(vt_dir_count(dir, "blobs/tmp"), 0);
    vor_cloud_free(&cloud);
    vor_blobs_close(blobs);
}
