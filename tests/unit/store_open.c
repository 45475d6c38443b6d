/* Who may open a store and what is none; and a disk that fails beneath an open one. */
#include "server/store/store.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

VT_TEST(a_second_daemon_is_refused_with_the_holder_s_name)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = NULL, *second = NULL;
    char where[512], byte;
    int ready[2];
    long holder;
    pid_t child;

    (void)snprintf(where, sizeof where, "sqlite:%s/jobs.sqlite", dir);
    ck_assert_int_eq(pipe(ready), 0);
    child = fork();
    if (child == 0) {
        (void)vt_dir_store(dir);
        (void)!write(ready[1], "x", 1);
        for (;;)
            pause();
    }
    ck_assert_int_eq(read(ready[0], &byte, 1), 1);
    vt_assert_fails(VOR_E_IO, vor_store_open(&second, where, 0, &holder, &vt_err));
    ck_assert_int_eq(holder, child);
    ck_assert_ptr_null(second);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    vt_assert_ok(vor_store_open(&store, where, 0, &holder, &vt_err));
    ck_assert_int_eq(holder, 0);
    vor_store_close(store);
}

VT_TEST(what_is_no_store_is_refused)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = NULL;
    char where[512];
    FILE *file;
    long holder;

    (void)snprintf(where, sizeof where, "sqlite:%s/jobs.sqlite", dir);
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, where + 7, 0, &holder, &vt_err));
    ck_assert_str_eq(vt_err.parameter, "store");
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, "sqlite:", 0, &holder, &vt_err));
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, "sqlite:/dev/null/x", 0, &holder, &vt_err));
    ck_assert_int_eq(holder, 0);
    file = fopen(where + 7, "w");
    for (int i = 0; i < 200; i++)
        fputs("this is a text, not a database\n", file);
    fclose(file);
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, where, 0, &holder, &vt_err));
    ck_assert_int_eq(holder, 0);
    ck_assert_ptr_null(store);
}

/* The version of a SQLite file's schema is the big-endian number at byte 60. */
VT_TEST_LOOP(a_store_of_another_version_is_refused_and_left_alone, 2)
{
    static const int versions[] = {17, 19};
    char wanted[80];
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    char where[512];
    FILE *file;
    long holder;

    vor_store_close(store); /* the last close moves everything from the WAL into the file */
    store = NULL;
    (void)snprintf(where, sizeof where, "sqlite:%s/jobs.sqlite", dir);
    file = fopen(where + 7, "r+");
    ck_assert_int_eq(fseek(file, 63, SEEK_SET), 0);
    ck_assert_int_eq(fgetc(file), 18);
    ck_assert_int_eq(fseek(file, 63, SEEK_SET), 0);
    ck_assert_int_eq(fputc(versions[_i], file), versions[_i]);
    fclose(file);
    vt_assert_fails(VOR_E_IO, vor_store_open(&store, where, 0, &holder, &vt_err));
    (void)snprintf(wanted, sizeof wanted,
                   "schema %d, but this version reads only 18: ", versions[_i]);
    ck_assert_ptr_nonnull(strstr(vt_err.message, wanted));
    ck_assert_ptr_null(store);
}

/* A disk that refuses a write (here: a limit on the size of files) puts the store out of order:
 * what it acknowledged stays readable, nothing new is taken. */
VT_TEST(a_store_whose_disk_failed_takes_no_more_and_says_so)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view row = vt_row(10), more = vt_row(10);
    struct rlimit limit;
    int is_lost;

    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = 4096;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    vt_assert_fails(VOR_E_IO, vor_store_insert(store, &more, NULL, &vt_err));
    limit.rlim_cur = limit.rlim_max;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    vt_assert_fails(VOR_E_IO, vor_store_insert(store, &more, NULL, &vt_err));
    vt_assert_fails(VOR_E_IO, vor_store_check(store, &is_lost, &vt_err));
    ck_assert(is_lost);
    row = vt_stored(store, &row.id);
    vor_store_close(store);
    store = vt_dir_store(dir); /* only a restart helps, and it does */
    vt_assert_ok(vor_store_check(store, &is_lost, &vt_err));
    vt_assert_ok(vor_store_insert(store, &more, NULL, &vt_err));
    vor_store_close(store);
}
