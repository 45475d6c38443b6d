/* Keys of callers: the file and its lines, what is found, and what digests, signatures and the text
 * of bytes are made of. */
#include "server/base/base64.h"
#include "server/base/digest.h"
#include "server/base/keys.h"
#include "server/base/log.h"
#include "server/blob/s3_sign.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* SHA-256 of "alpha" and "beta". */
#define ALPHA "8ed3f6ad685b959ead7022518e1af76cd816f8e8ec7ccdda1ed4018e8f2223f8"
#define BETA "f44e64e75f3948e9f73f8dfa94721c4ce8cbb4f265c4790c702b2d41cfbf2753"

static const char *write_file(const char *dir, const char *text, mode_t mode)
{
    static char path[300];
    FILE *file;

    (void)snprintf(path, sizeof path, "%s/keys", dir);
    file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    fputs(text, file);
    fclose(file);
    ck_assert_int_eq(chmod(path, mode), 0);
    return path;
}

/* Vector: RFC 4231, cases 1, 2 and 6 (a key longer than a block). */
VT_TEST(signatures_are_the_published_ones)
{
    static const struct {
        int key_byte, key_size;
        const char *key, *text;
        uint8_t begins[4];
    } vectors[] = {
        {0x0b, 20, NULL, "Hi There", {0xb0, 0x34, 0x4c, 0x61}},
        {0, 4, "Jefe", "what do ya want for nothing?", {0x5b, 0xdc, 0xc1, 0x46}},
        {0xaa,
         131,
         NULL,
         "Test Using Larger Than Block-Size Key - Hash Key First",
         {0x60, 0xe4, 0x31, 0x59}},
    };

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        char key[131];
        uint8_t out[VOR_DIGEST_BYTES];

        memset(key, vectors[i].key_byte, sizeof key);
        if (vectors[i].key != NULL)
            memcpy(key, vectors[i].key, strlen(vectors[i].key));
        vor_digest_hmac(key, (size_t)vectors[i].key_size, vectors[i].text, strlen(vectors[i].text),
                        out);
        ck_assert_mem_eq(out, vectors[i].begins, 4);
    }
}

/* Vector: the example of docs.aws.amazon.com/AmazonS3/latest/API/sigv4-query-string-auth.html. */
VT_TEST(a_link_to_s3_is_the_published_one)
{
    static const struct vor_s3_signing signing = {
        "GET",
        "https://ExampleBucket.s3.amazonaws.com:443/test.txt",
        "",
        "AKIAIOSFODNN7EXAMPLE",
        "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY",
        "us-east-1",
        "",
        1369353600,
        86400};
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_s3_sign(&signing, &text);
    vt_assert_ok(vor_text_status(&text, &vt_err));
    ck_assert_str_eq(
        text.data,
        "https://examplebucket.s3.amazonaws.com/test.txt?X-Amz-Algorithm=AWS4-HMAC-SHA256"
        "&X-Amz-Credential=AKIAIOSFODNN7EXAMPLE%2F20130524%2Fus-east-1%2Fs3%2Faws4_request"
        "&X-Amz-Date=20130524T000000Z&X-Amz-Expires=86400&X-Amz-SignedHeaders=host"
        "&X-Amz-Signature="
        "aeeed9bbccd4d02ee5c0109b86d86835f995330da4c265957d157751f604d404");
    vor_text_free(&text);
}

/* Vector: RFC 4648, section 10, without padding; and the two characters that differ in URLs. */
VT_TEST(base64_is_the_published_one)
{
    static const char *const vectors[][2] = {
        {"", ""},           {"f", "Zg"},          {"fo", "Zm8"},          {"foo", "Zm9v"},
        {"foob", "Zm9vYg"}, {"fooba", "Zm9vYmE"}, {"foobar", "Zm9vYmFy"}, {"\xfb\xff", "-_8"},
    };

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        size_t size = strlen(vectors[i][0]);
        char text[16];
        uint8_t back[16];

        vor_base64_write((const uint8_t *)vectors[i][0], size, text);
        ck_assert_str_eq(text, vectors[i][1]);
        ck_assert_int_eq(vor_base64_read(text, back, size), (long)size);
        ck_assert_mem_eq(back, vectors[i][0], size);
    }
}

VT_TEST(what_is_no_base64_of_ours_is_refused)
{
    static const char *const bad[] = {"Z", "Zg==", "Zh", "Zm9", "Zm 9v", "Zm9v+", "Zm9vYmFyZm9v"};
    uint8_t back[8];

    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        ck_assert_msg(vor_base64_read(bad[i], back, sizeof back) == -1, "%s is read", bad[i]);
}

VT_TEST(a_key_finds_its_caller_and_no_other_text_does)
{
    const char *dir = vt_dir_make();
    const char *path = write_file(dir,
                                  "# who may call\n\n  alice:submit,read:" ALPHA
                                  ":jobs=4,rate=0.5,bytes=2K,points=1000  \r\n"
                                  "bob:admin:" BETA,
                                  0600);
    static const char *const none[] = {"", "Alpha", "alph", "alpha ", "alphaa", "gamma", ALPHA};
    struct vor_principal caller = {.scopes = 0};
    struct vor_keys *keys;
    char longer[600];

    vt_assert_ok(vor_keys_open(&keys, path, &vt_err));
    ck_assert(vor_keys_find(keys, "alpha", &caller));
    ck_assert_str_eq(caller.name, "alice");
    ck_assert(vor_principal_may(&caller, VOR_SCOPE_READ) &&
              vor_principal_may(&caller, VOR_SCOPE_SUBMIT));
    ck_assert(!vor_principal_may(&caller, VOR_SCOPE_ADMIN) && !caller.sees_all);
    ck_assert(caller.quota.jobs == 4 && caller.quota.rate == 0.5);
    ck_assert(caller.quota.bytes == 2048 && caller.quota.points == 1000);
    ck_assert(vor_keys_find(keys, "beta", &caller));
    ck_assert_str_eq(caller.name, "bob");
    ck_assert(vor_principal_may(&caller, VOR_SCOPE_READ) && caller.sees_all);
    ck_assert(caller.quota.jobs == VOR_QUOTA_JOBS_DEFAULT);
    ck_assert(caller.quota.rate == VOR_QUOTA_RATE_DEFAULT);
    ck_assert(caller.quota.bytes == 0 && caller.quota.points == 0);
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
        ck_assert_msg(!vor_keys_find(keys, none[i], &caller), "\"%s\" is a key", none[i]);
    memset(longer, 'a', sizeof longer);
    longer[sizeof longer - 1] = '\0';
    ck_assert(!vor_keys_find(keys, longer, &caller));
    ck_assert_str_eq(caller.name, "bob");
    vor_keys_close(keys);
}

/* Refusal: each names the line and what is wrong with it, and none shows what may be a key. */
VT_TEST(a_wrong_line_is_named_with_its_reason)
{
    static const struct {
        const char *text, *reason;
    } bad[] = {
        {"", "has no key; voronoid key NAME makes one"},
        {"# nothing\n", "has no key"},
        {"\nvor_secret\n", "line 2: the line has fewer than two colons"},
        {"alice:submit\n", "line 1: the line has fewer than two colons"},
        {":submit:" ALPHA, "line 1: the name is \"\", want 1 to 64 letters"},
        {"al ice:submit:" ALPHA, "the name is \"al ice\""},
        {"alice::" ALPHA, "the scopes are \"\", want one or more of read, submit and admin"},
        {"alice:submit,:" ALPHA, "the scopes are \"submit,\""},
        {"alice:write:" ALPHA, "the scopes are \"write\""},
        {"alice:open:" ALPHA, "the scopes are \"open\""},
        {"alice:read:vor_secret", "the digest has 10 characters"},
        {"alice:read:8ED3" ALPHA, "the digest has 68 characters, of which the first 1 are"},
        {"alice:read:" ALPHA ":jobs=0",
         "a quota is \"jobs=0\", want jobs=a whole number from 1 to"},
        {"alice:read:" ALPHA ":jobs=0x1", "a quota is \"jobs=0x1\""},
        {"alice:read:" ALPHA ":jobs=1.5", "a quota is \"jobs=1.5\""},
        {"alice:read:" ALPHA ":rate=-1", "want rate=0.01 to 100000"},
        {"alice:read:" ALPHA ":rate=nan", "a quota is \"rate=nan\""},
        {"alice:read:" ALPHA ":rate=2,colour=3", "a quota is \"colour=3\", want jobs=N, rate=N"},
        {"alice:read:" ALPHA ":bytes=1Q", "a quota is \"bytes=1Q\""},
        {"a:read:" ALPHA "\nb:read:" ALPHA "\n", "line 2: an earlier line has the same digest"},
    };
    const char *dir = vt_dir_make();

    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const char *path = write_file(dir, bad[i].text, 0600);
        struct vor_keys *keys = NULL;

        vt_assert_fails(VOR_E_PARAM, vor_keys_open(&keys, path, &vt_err));
        ck_assert_msg(strstr(vt_err.message, bad[i].reason) != NULL, "%s: %s", bad[i].text,
                      vt_err.message);
        ck_assert_ptr_nonnull(strstr(vt_err.message, path));
        ck_assert_ptr_null(strstr(vt_err.message, "vor_secret"));
        ck_assert_ptr_null(keys);
    }
}

VT_TEST(reading_again_takes_the_new_keys_or_leaves_the_old)
{
    const char *dir = vt_dir_make();
    const char *path = write_file(dir, "alice:read:" ALPHA "\n", 0600);
    struct vor_principal caller;
    struct vor_keys *keys;

    vor_log_open(STDERR_FILENO, VOR_LOG_OFF);
    vt_assert_ok(vor_keys_reload(NULL, &vt_err));
    vt_assert_ok(vor_keys_open(&keys, path, &vt_err));
    write_file(dir, "alice:read:nothing\n", 0600);
    vt_assert_fails(VOR_E_PARAM, vor_keys_reload(keys, &vt_err));
    ck_assert(vor_keys_find(keys, "alpha", &caller));
    write_file(dir, "carol:submit:" BETA "\n", 0600);
    vt_assert_ok(vor_keys_reload(keys, &vt_err));
    ck_assert(!vor_keys_find(keys, "alpha", &caller));
    ck_assert(vor_keys_find(keys, "beta", &caller));
    ck_assert_str_eq(caller.name, "carol");
    ck_assert_int_eq(unlink(path), 0);
    vt_assert_fails(VOR_E_IO, vor_keys_reload(keys, &vt_err));
    ck_assert(vor_keys_find(keys, "beta", &caller));
    vor_keys_close(keys);
}

VT_TEST(a_line_without_end_is_refused)
{
    const char *dir = vt_dir_make();
    char text[VOR_KEY_LINE_SIZE + 10];
    struct vor_keys *keys;

    memset(text, '#', sizeof text);
    text[sizeof text - 1] = '\0';
    vt_assert_fails(VOR_E_PARAM, vor_keys_open(&keys, write_file(dir, text, 0600), &vt_err));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "line 1: the line has more than 510 bytes"));
    vt_assert_fails(VOR_E_PARAM, vor_keys_open(&keys, "/dev/zero", &vt_err));
}

struct look {
    struct vor_keys *keys;
    atomic_int is_over;
    atomic_int missed;
};

static void *look_for_alpha(void *arg)
{
    struct look *look = arg;
    struct vor_principal caller;

    while (!atomic_load(&look->is_over))
        if (!vor_keys_find(look->keys, "alpha", &caller) || strcmp(caller.name, "alice") != 0)
            atomic_fetch_add(&look->missed, 1);
    return NULL;
}

VT_TEST(reading_again_loses_no_key_for_a_moment)
{
    enum { THREADS = 3, TIMES = 100 };
    const char *dir = vt_dir_make();
    struct look look = {.missed = 0};
    pthread_t threads[THREADS];

    vor_log_open(STDERR_FILENO, VOR_LOG_OFF);
    vt_assert_ok(vor_keys_open(
        &look.keys, write_file(dir, "bob:read:" BETA "\nalice:read:" ALPHA "\n", 0600), &vt_err));
    for (int i = 0; i < THREADS; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, look_for_alpha, &look), 0);
    for (int i = 0; i < TIMES; i++)
        vt_assert_ok(vor_keys_reload(look.keys, &vt_err));
    atomic_store(&look.is_over, 1);
    for (int i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
    ck_assert_int_eq(atomic_load(&look.missed), 0);
    vor_keys_close(look.keys);
}

VT_TEST(a_file_that_others_may_read_is_told_of_in_the_log)
{
    static const struct {
        mode_t mode;
        int is_told;
    } cases[] = {{0600, 0}, {0400, 0}, {0644, 1}, {0620, 1}};
    const char *dir = vt_dir_make();
    char log[300], text[1000];

    (void)snprintf(log, sizeof log, "%s/log", dir);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *path = write_file(dir, "alice:read:" ALPHA "\n", cases[i].mode);
        int fd = open(log, O_RDWR | O_CREAT | O_TRUNC, 0600);
        struct vor_keys *keys;
        ssize_t got;

        vor_log_open(fd, VOR_LOG_WARN);
        vt_assert_ok(vor_keys_open(&keys, path, &vt_err));
        got = pread(fd, text, sizeof text - 1, 0);
        ck_assert_int_ge(got, 0);
        text[got] = '\0';
        ck_assert_int_eq(strstr(text, "\"want\":\"0600\"") != NULL, cases[i].is_told);
        vor_keys_close(keys);
        vor_log_open(STDERR_FILENO, VOR_LOG_OFF);
        close(fd);
    }
}

VT_TEST(a_key_that_is_made_opens_the_line_that_is_made_with_it)
{
    const char *dir = vt_dir_make();
    char key[VOR_KEY_SIZE], other[VOR_KEY_SIZE], line[VOR_KEY_LINE_SIZE];
    struct vor_principal caller;
    struct vor_keys *keys;

    vt_assert_ok(vor_key_make("dave", "submit,read", "jobs=2", key, line, &vt_err));
    vt_assert_ok(vor_keys_open(&keys, write_file(dir, line, 0600), &vt_err));
    ck_assert(vor_keys_find(keys, key, &caller));
    ck_assert_str_eq(caller.name, "dave");
    ck_assert(caller.quota.jobs == 2);
    ck_assert_ptr_null(strstr(line, key + 4));
    ck_assert_uint_eq(strlen(key), VOR_KEY_SIZE - 1);
    ck_assert_int_eq(strncmp(key, VOR_KEY_PREFIX, strlen(VOR_KEY_PREFIX)), 0);
    vt_assert_ok(vor_key_make("dave", "read", NULL, other, line, &vt_err));
    ck_assert_str_ne(key, other);
    vt_assert_fails(VOR_E_PARAM, vor_key_make("a:b", "read", NULL, other, line, &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_key_make("#a", "read", NULL, other, line, &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_key_make("a", "write", NULL, other, line, &vt_err));
    vt_assert_fails(VOR_E_PARAM, vor_key_make("a", "read", "jobs=x", other, line, &vt_err));
    vor_keys_close(keys);
}
