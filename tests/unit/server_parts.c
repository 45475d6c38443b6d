/* The small parts under the jobs: identifiers, digests, clock, log, locks. */
#include "proto/json/json.h"
#include "server/base/clock.h"
#include "server/base/digest.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/uuid.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* Vector: FIPS 180-4 examples, and a million a's. */
VT_TEST(sha256_gives_the_published_digests)
{
    static const struct {
        const char *text, *hex;
        int times;
    } vectors[] = {
        {"", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855", 1},
        {"abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad", 1},
        {"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
         "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1", 1},
        {"a", "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0", 1000000},
    };

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        struct vor_digest digest;
        char hex[VOR_DIGEST_SIZE], again[VOR_DIGEST_SIZE];

        vor_digest_begin(&digest);
        for (int t = 0; t < vectors[i].times; t++)
            vor_digest_update(&digest, vectors[i].text, strlen(vectors[i].text));
        vor_digest_hex(&digest, hex);
        vor_digest_hex(&digest, again); /* reading it changes nothing */
        ck_assert_str_eq(hex, vectors[i].hex);
        ck_assert_str_eq(again, hex);
    }
}

static int compare_ids(const void *a, const void *b)
{
    return strcmp(((const struct vor_uuid *)a)->text, ((const struct vor_uuid *)b)->text);
}

VT_TEST(identifiers_are_version_7_and_never_repeat)
{
    enum { COUNT = 20000 };
    struct vor_uuid *ids = calloc(COUNT, sizeof *ids), read;

    for (size_t i = 0; i < COUNT; i++) {
        vt_assert_ok(vor_uuid_make(&ids[i], &vt_err));
        ck_assert(vor_uuid_parse(&read, ids[i].text, strlen(ids[i].text)));
        ck_assert_str_eq(read.text, ids[i].text);
        ck_assert_int_eq(ids[i].text[14], '7');
        ck_assert_ptr_nonnull(strchr("89ab", ids[i].text[19]));
    }
    qsort(ids, COUNT, sizeof *ids, compare_ids);
    for (size_t i = 1; i < COUNT; i++)
        ck_assert_str_ne(ids[i - 1].text, ids[i].text);
    free(ids);
}

VT_TEST(an_identifier_made_later_sorts_later)
{
    struct vor_uuid first, second;
    struct timespec pause = {.tv_nsec = 3000000};

    vt_assert_ok(vor_uuid_make(&first, &vt_err));
    nanosleep(&pause, NULL);
    vt_assert_ok(vor_uuid_make(&second, &vt_err));
    ck_assert_str_lt(first.text, second.text);
}

VT_TEST(what_is_no_identifier_is_refused)
{
    static const char *const bad[] = {
        "",
        "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e1",
        "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e111",
        "0193B5F2-7C1E-7F7A-9D3E-2A6C1F0B8E11",
        "0193b5f2_7c1e_7f7a_9d3e_2a6c1f0b8e11",
        "0193b5f27c1e7f7a9d3e2a6c1f0b8e110000",
        "../../../../../../../../etc/passwd-1",
        "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e1g",
        "-193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11",
    };
    struct vor_uuid out = {"untouched"};

    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        ck_assert_msg(!vor_uuid_parse(&out, bad[i], strlen(bad[i])), "%s", bad[i]);
    ck_assert(!vor_uuid_parse(&out, "0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e1\0", 36));
    ck_assert_str_eq(out.text, "untouched");
}

VT_TEST(times_are_written_as_rfc_3339_in_utc)
{
    char text[VOR_CLOCK_TEXT_SIZE];

    ck_assert_str_eq(vor_clock_text(0, text), "1970-01-01T00:00:00.000Z");
    ck_assert_str_eq(vor_clock_text(951827696789, text), "2000-02-29T12:34:56.789Z");
    ck_assert_str_eq(vor_clock_text(2147483648001, text), "2038-01-19T03:14:08.001Z");
}

/* Reads everything a pipe holds. */
static char *drain(int fd)
{
    static char text[1 << 16];
    size_t size = 0;
    ssize_t got;

    while (size < sizeof text - 1 && (got = read(fd, text + size, sizeof text - 1 - size)) > 0)
        size += (size_t)got;
    text[size] = '\0';
    return text;
}

static void open_log(int ends[2], enum vor_log_level level)
{
    ck_assert_int_eq(pipe(ends), 0);
    ck_assert_int_eq(fcntl(ends[0], F_SETFL, O_NONBLOCK), 0);
    vor_log_open(ends[1], level);
}

VT_TEST(hostile_text_stays_inside_its_log_line)
{
    const char *evil = "\"}\n{\"level\":\"error\",\x01\x1b[31m\xff\xfe\r\n";
    struct vor_json *json = NULL;
    int ends[2];
    char *text, *newline;

    open_log(ends, VOR_LOG_INFO);
    vor_log(VOR_LOG_WARN, evil, VOR_TEXT("a", evil), VOR_TEXT("none", NULL), VOR_COUNT("n", -7),
            VOR_REAL("r", 0.5));
    text = drain(ends[0]);
    newline = strchr(text, '\n');
    ck_assert_ptr_nonnull(newline);
    ck_assert_ptr_eq(newline, text + strlen(text) - 1);
    for (char *c = text; c < newline; c++)
        ck_assert_msg((unsigned char)*c >= 0x20 && *c != 0x7f, "raw byte %d", *c);
    vt_assert_ok(vor_json_parse(&json, text, strlen(text), &vt_err));
    ck_assert_str_eq(vor_json_get_string(vor_json_get(json, "level")), "warn");
    ck_assert_int_eq(vor_json_kind(vor_json_get(json, "none")), VOR_JSON_NULL);
    vor_json_free(json);
}

VT_TEST(levels_below_the_log_s_are_not_written)
{
    int ends[2];
    char *text;

    open_log(ends, VOR_LOG_WARN);
    vor_log(VOR_LOG_DEBUG, "one");
    vor_log(VOR_LOG_INFO, "two");
    vor_log(VOR_LOG_ERROR, "three");
    text = drain(ends[0]);
    ck_assert_ptr_null(strstr(text, "one"));
    ck_assert_ptr_null(strstr(text, "two"));
    ck_assert_ptr_nonnull(strstr(text, "three"));
}

static void *log_many(void *arg)
{
    for (int i = 0; i < 50; i++)
        vor_log(VOR_LOG_INFO, "a line that is long enough to be torn apart", VOR_TEXT("who", arg),
                VOR_COUNT("i", i));
    return NULL;
}

VT_TEST(lines_of_several_threads_do_not_mix)
{
    static char a[] = "a", b[] = "b", c[] = "c";
    pthread_t threads[3];
    int ends[2], lines = 0;
    char *line, *rest;

    open_log(ends, VOR_LOG_INFO);
    ck_assert_int_eq(pthread_create(&threads[0], NULL, log_many, a), 0);
    ck_assert_int_eq(pthread_create(&threads[1], NULL, log_many, b), 0);
    ck_assert_int_eq(pthread_create(&threads[2], NULL, log_many, c), 0);
    for (int i = 0; i < 3; i++)
        pthread_join(threads[i], NULL);
    for (line = strtok_r(drain(ends[0]), "\n", &rest); line != NULL;
         line = strtok_r(NULL, "\n", &rest), lines++)
        vt_assert_ok(vor_json_scan(line, strlen(line), &vt_err));
    ck_assert_int_eq(lines, 150);
}

VT_TEST(a_full_disk_is_told_apart)
{
    struct vor_error err;

    ck_assert_int_eq(vor_fail_errno(&err, ENOSPC, "writing"), VOR_E_IO);
    ck_assert(vor_error_storage_full(&err));
    ck_assert_ptr_nonnull(strstr(err.message, "writing: No space left"));
    (void)vor_fail_errno(&err, EDQUOT, "writing");
    ck_assert(vor_error_storage_full(&err));
    (void)vor_fail_errno(&err, EIO, "writing");
    ck_assert(!vor_error_storage_full(&err));
    (void)vor_fail(&err, VOR_E_LIMIT, "too many");
    err.got = ENOSPC;
    ck_assert(!vor_error_storage_full(&err));
    ck_assert_int_eq(vor_fail_errno(NULL, EIO, "no error wanted"), VOR_E_IO);
}

VT_TEST(directories_are_made_with_their_parents)
{
    const char *dir = vt_dir_make();
    char path[512];
    struct stat info;

    (void)snprintf(path, sizeof path, "%s/a//b/c/", dir);
    vt_assert_ok(vor_storage_directory(path, &vt_err));
    vt_assert_ok(vor_storage_directory(path, &vt_err));
    ck_assert_int_eq(stat(path, &info), 0);
    ck_assert_int_eq(info.st_mode & 07777, 0700);
    (void)snprintf(path, sizeof path, "%s/file", dir);
    close(open(path, O_CREAT | O_WRONLY, 0600));
    (void)snprintf(path, sizeof path, "%s/file/below", dir);
    vt_assert_fails(VOR_E_IO, vor_storage_directory(path, &vt_err));
}

/* The message of a failure that a child without privileges meets; act sets vt_err. */
static const char *unprivileged(void (*act)(const char *path), const char *path)
{
    static char message[sizeof vt_err.message];
    int ends[2];
    ssize_t got;
    pid_t child;

    ck_assert_int_eq(pipe(ends), 0);
    child = fork();
    ck_assert_int_ge(child, 0);
    if (child == 0) {
        if (geteuid() == 0 && (setgid(65532) != 0 || setuid(65532) != 0))
            _exit(1);
        vt_err.message[0] = '\0';
        act(path);
        _exit(write(ends[1], vt_err.message, sizeof message) != sizeof message);
    }
    close(ends[1]);
    got = read(ends[0], message, sizeof message);
    close(ends[0]);
    waitpid(child, NULL, 0);
    ck_assert_int_eq(got, sizeof message);
    return message;
}

static void lock_in(const char *path)
{
    long holder;
    char name[1024];
    int fd;

    (void)snprintf(name, sizeof name, "%s/lock", path);
    (void)!vor_storage_lock(&fd, name, 0, &holder, &vt_err);
}

static void make_folder(const char *path)
{
    (void)!vor_storage_directory(path, &vt_err);
}

static void lock_in_closed_folder(const char *path)
{
    char name[512];

    (void)snprintf(name, sizeof name, "%s/closed", path);
    if (mkdir(name, 0500) == 0)
        lock_in(name);
}

/* A folder that a container's host mounted, as root. */
VT_TEST(a_folder_of_another_user_is_named_with_what_mends_it)
{
    unsigned user = geteuid() == 0 ? 65532 : (unsigned)geteuid();
    unsigned group = geteuid() == 0 ? 65532 : (unsigned)getegid();
    const char *dir = vt_dir_make();
    char want[512];

    (void)snprintf(want, sizeof want,
                   "/usr belongs to user 0, but this process runs as user %u, who may not write "
                   "there. Run chown -R %u:%u /usr (in a container, on the folder that is mounted "
                   "there)",
                   user, user, group);
    ck_assert_str_eq(unprivileged(lock_in, "/usr"), want);
    (void)snprintf(want, sizeof want,
                   "there is no /usr/none/at/all, and this process runs as user %u, who may not "
                   "create it in /usr, which belongs to user 0 (mode 0755). Run install -d -o %u "
                   "-g %u /usr/none/at/all",
                   user, user, group);
    ck_assert_str_eq(unprivileged(make_folder, "/usr/none/at/all"), want);
    ck_assert_int_eq(chmod(dir, 0777), 0);
    (void)snprintf(want, sizeof want,
                   "%s/closed belongs to user %u, who runs this process, but its mode is 0500. "
                   "Run chmod u+rwX %s/closed",
                   dir, user, dir);
    ck_assert_str_eq(unprivileged(lock_in_closed_folder, dir), want);
}

/* A child that has the lock until it is killed. */
static pid_t locked_child(const char *path)
{
    int ready[2], fd = -1;
    long holder;
    char byte;
    pid_t child;

    ck_assert_int_eq(pipe(ready), 0);
    child = fork();
    if (child == 0) {
        if (vor_storage_lock(&fd, path, 0, &holder, NULL) == VOR_OK)
            (void)!write(ready[1], "x", 1);
        for (;;)
            pause();
    }
    close(ready[1]);
    ck_assert_int_eq(read(ready[0], &byte, 1), 1);
    close(ready[0]);
    return child;
}

VT_TEST(a_lock_names_its_holder_and_dies_with_it)
{
    const char *dir = vt_dir_make();
    char path[512];
    long holder = 0;
    int fd = -1;
    pid_t child;

    (void)snprintf(path, sizeof path, "%s/lock", dir);
    child = locked_child(path);
    vt_assert_fails(VOR_E_IO, vor_storage_lock(&fd, path, 0, &holder, &vt_err));
    ck_assert_int_eq(holder, child);
    ck_assert_ptr_nonnull(strstr(vt_err.message, ", another daemon; choose another --data"));
    ck_assert_int_eq(fd, -1);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    vt_assert_ok(vor_storage_lock(&fd, path, 0, &holder, &vt_err));
    ck_assert_int_eq(holder, 0);
    close(fd);
}
