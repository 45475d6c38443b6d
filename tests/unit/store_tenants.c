/* Whose a job is: what a tenant asks a store for has his rows alone. */
#include "server/store/store.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <stdio.h>
#include <string.h>

static struct vor_job_view insert(struct vor_store *store, const char *tenant, const char *key)
{
    struct vor_job_view row = vt_row(10);

    (void)snprintf(row.key.principal, sizeof row.key.principal, "%s", tenant);
    (void)snprintf(row.key.text, sizeof row.key.text, "%s", key);
    row.kept = 1000;
    vt_assert_ok(vor_store_insert(store, &row, NULL, &vt_err));
    return row;
}

static int is_found(struct vor_store *store, const struct vor_job_view *row, const char *tenant)
{
    struct vor_job_view back;
    int found;

    vt_assert_ok(vor_store_get(store, &row->id, tenant, &back, &found, &vt_err));
    if (found)
        ck_assert_str_eq(back.key.principal, row->key.principal);
    return found;
}

static int take_letter(void *ctx, const struct vor_job_view *row)
{
    char *end = (char *)ctx + strlen(ctx);

    *end++ = row->key.principal[0] != '\0' ? row->key.principal[0] : '-';
    *end = '\0';
    return 1;
}

/* The first letters of the tenants of a list, "-" for none. */
static const char *list(struct vor_store *store, const char *tenant)
{
    static char letters[32];
    const struct vor_job_filter filter = {.limit = 20, .tenant = tenant};

    letters[0] = '\0';
    vt_assert_ok(vor_store_list(store, &filter, take_letter, letters, &vt_err));
    return letters;
}

VT_TEST(a_tenant_gets_and_lists_his_rows_alone)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view none = insert(store, "", ""), a = insert(store, "alice", "");
    struct vor_job_view b = insert(store, "bob", "");

    (void)insert(store, "alice", "");
    ck_assert(is_found(store, &a, "alice") && is_found(store, &b, "bob"));
    ck_assert(!is_found(store, &a, "bob") && !is_found(store, &b, "alice"));
    ck_assert(!is_found(store, &none, "alice") && !is_found(store, &a, ""));
    ck_assert(!is_found(store, &a, "Alice") && !is_found(store, &a, "alic"));
    ck_assert(is_found(store, &none, "") && is_found(store, &a, NULL));
    ck_assert(is_found(store, &b, NULL) && is_found(store, &none, NULL));
    ck_assert_str_eq(list(store, "alice"), "aa");
    ck_assert_str_eq(list(store, "bob"), "b");
    ck_assert_str_eq(list(store, ""), "-");
    ck_assert_str_eq(list(store, "' OR 1=1 --"), "");
    ck_assert_str_eq(list(store, NULL), "aba-");
    vor_store_close(store);
}

VT_TEST(a_key_of_a_request_is_one_s_own)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view a = insert(store, "alice", "k"), b = insert(store, "bob", "k"), back;
    int found;

    vt_assert_ok(vor_store_find_key(store, &a.key, &back, &found, &vt_err));
    ck_assert(found);
    ck_assert_str_eq(back.id.text, a.id.text);
    vt_assert_ok(vor_store_find_key(store, &b.key, &back, &found, &vt_err));
    ck_assert(found);
    ck_assert_str_eq(back.id.text, b.id.text);
    vor_store_close(store);
}

VT_TEST(what_is_stored_for_a_tenant_is_the_sum_of_his_jobs)
{
    const char *dir = vt_dir_make();
    struct vor_store *store = vt_dir_store(dir);
    struct vor_job_view done = insert(store, "alice", "");
    struct vor_ledger ledger;
    int changed;

    (void)insert(store, "alice", "");
    (void)insert(store, "bob", "");
    done.status = VOR_JOB_SUCCESSFUL;
    done.finished = done.created + 1;
    done.output[0].bytes = 500;
    vt_assert_ok(vor_store_finish(store, &done, NULL, NULL, &changed, &vt_err));
    ck_assert(changed);
    vt_assert_ok(vor_store_ledger(store, "alice", &ledger, &vt_err));
    ck_assert_uint_eq(ledger.bytes, 2500);
    vt_assert_ok(vor_store_ledger(store, "bob", &ledger, &vt_err));
    ck_assert_uint_eq(ledger.bytes, 1000);
    vt_assert_ok(vor_store_ledger(store, "carol", &ledger, &vt_err));
    ck_assert_uint_eq(ledger.bytes, 0);
    vor_store_close(store);
}
