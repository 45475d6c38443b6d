/* What callers have for a time: tokens of their rate, tickets to results; and identifiers of jobs,
 * which nobody can guess. */
#include "server/api/tickets.h"
#include "server/base/rates.h"
#include "server/base/uuid.h"
#include "tests/support/vt.h"
#include "tests/support/vt_dir.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

VT_TEST(a_name_has_twice_its_rate_at_once_and_its_rate_from_then_on)
{
    struct vor_rates *rates = vor_rates_create();
    int taken = 0;

    for (int i = 0; i < 25; i++)
        taken += vor_rates_take(rates, "a", 10, 100) == 0;
    ck_assert_int_eq(taken, 20);
    ck_assert_double_eq_tol(vor_rates_left(rates, "a", 10, 100), 0, 1e-9);
    ck_assert_double_eq_tol(vor_rates_left(rates, "c", 10, 100), 20, 1e-9);
    ck_assert_double_eq_tol(vor_rates_take(rates, "a", 10, 100), 0.1, 1e-9);
    ck_assert_double_eq_tol(vor_rates_take(rates, "a", 10, 100.05), 0.05, 1e-9);
    ck_assert(vor_rates_take(rates, "b", 10, 100.05) == 0); /* nobody pays for another */
    taken = 0;
    for (int i = 1; i <= 1000; i++)
        taken += vor_rates_take(rates, "a", 10, 100.05 + i * 0.01) == 0;
    ck_assert_int_ge(taken, 99);
    ck_assert_int_le(taken, 101);
    ck_assert(vor_rates_take(rates, "a", 10, 90) >= 0); /* a clock that goes back gives nothing */
    vor_rates_destroy(rates);
}

VT_TEST(a_slow_rate_still_gives_one_at_first)
{
    struct vor_rates *rates = vor_rates_create();

    ck_assert(vor_rates_take(rates, "a", 0.01, 5) == 0);
    ck_assert_double_eq_tol(vor_rates_take(rates, "a", 0.01, 5), 100, 1e-6);
    ck_assert(vor_rates_take(rates, "a", 0.01, 106) == 0);
    vor_rates_destroy(rates);
}

VT_TEST(a_ticket_is_good_for_its_result_for_a_minute)
{
    struct vor_uuid job = vt_row(1).id, other = vt_row(1).id;
    char ticket[VOR_TICKET_SIZE];
    struct vor_tickets *tickets, *restarted;

    vt_assert_ok(vor_tickets_create(&tickets, &vt_err));
    vt_assert_ok(vor_tickets_create(&restarted, &vt_err));
    vor_ticket_write(tickets, &job, "cloud", 1000, ticket);
    ck_assert(vor_ticket_check(tickets, ticket, &job, "cloud", 5, 1000));
    ck_assert(vor_ticket_check(tickets, ticket, &job, "cloud/more", 5, 1059.9));
    ck_assert(!vor_ticket_check(tickets, ticket, &job, "cloud", 5, 1060));
    ck_assert(!vor_ticket_check(tickets, ticket, &other, "cloud", 5, 1000));
    ck_assert(!vor_ticket_check(tickets, ticket, &job, "report", 6, 1000));
    ck_assert(!vor_ticket_check(tickets, ticket, &job, "clou", 4, 1000));
    ck_assert(!vor_ticket_check(tickets, ticket, &job, "", 0, 1000));
    ck_assert(!vor_ticket_check(restarted, ticket, &job, "cloud", 5, 1000));
    vor_tickets_destroy(tickets);
    vor_tickets_destroy(restarted);
}

/* Property: no other text is a ticket: one character changed, left out or added anywhere. */
VT_TEST(a_ticket_that_was_changed_is_none)
{
    static const char letters[] = "AZaz09-_ .";
    struct vor_uuid job = vt_row(1).id;
    char ticket[VOR_TICKET_SIZE], changed[VOR_TICKET_SIZE + 1];
    struct vor_tickets *tickets;
    size_t length;

    vt_assert_ok(vor_tickets_create(&tickets, &vt_err));
    length = strlen(vor_ticket_write(tickets, &job, "cloud", 1000, ticket));
    for (size_t i = 0; i < length; i++) {
        for (size_t k = 0; k < sizeof letters - 1; k++) {
            memcpy(changed, ticket, length + 1);
            if (changed[i] == letters[k])
                continue;
            changed[i] = letters[k];
            ck_assert(!vor_ticket_check(tickets, changed, &job, "cloud", 5, 1000));
            memcpy(changed + i + 1, ticket + i, length + 1 - i);
            ck_assert(!vor_ticket_check(tickets, changed, &job, "cloud", 5, 1000));
        }
        memcpy(changed, ticket, length + 1);
        memmove(changed + i, changed + i + 1, length - i);
        ck_assert(!vor_ticket_check(tickets, changed, &job, "cloud", 5, 1000));
    }
    vor_tickets_destroy(tickets);
}

/* --- identifiers ------------------------------------------------------------------------------ */

enum { IDS = 60000, RANDOM_FROM = 9, TEXT = 36, BYTES = 256 };

static size_t ids_wanted(void)
{
    const char *text = getenv("VT_IDS");

    return text != NULL ? strtoul(text, NULL, 10) : IDS;
}

static int compare(const void *a, const void *b)
{
    return memcmp(a, b, TEXT);
}

/* Byte number `index` of an identifier. */
static unsigned byte_of(const struct vor_uuid *id, int index)
{
    static const int places[16] = {0, 2, 4, 6, 9, 11, 14, 16, 19, 21, 24, 26, 28, 30, 32, 34};
    char digits[3] = {id->text[places[index]], id->text[places[index] + 1], '\0'};

    return (unsigned)strtoul(digits, NULL, 16);
}

static double chi_square(const struct vor_uuid *ids, size_t count, int index)
{
    double want = (double)count / BYTES, sum = 0;
    size_t seen[BYTES] = {0};

    for (size_t i = 0; i < count; i++)
        seen[byte_of(&ids[i], index)]++;
    for (int i = 0; i < BYTES; i++)
        sum += ((double)seen[i] - want) * ((double)seen[i] - want) / want;
    return sum;
}

/* Property, RFC 9562, 5.7: of the 74 random bits those of bytes 9 to 15 are whole bytes. With 255
 * degrees of freedom 400 comes once in 1e8. VT_IDS says of how many. */
VT_TEST(identifiers_do_not_repeat_and_their_random_bytes_are_even)
{
    size_t count = ids_wanted(), repeated = 0;
    struct vor_uuid *ids = calloc(count, sizeof *ids);
    double worst = 0;

    ck_assert_ptr_nonnull(ids);
    for (size_t i = 0; i < count; i++)
        ids[i] = vt_row(1).id;
    for (int i = RANDOM_FROM; i < 16; i++)
        worst = fmax(worst, chi_square(ids, count, i));
    qsort(ids, count, sizeof *ids, compare);
    for (size_t i = 1; i < count; i++)
        repeated += compare(&ids[i - 1], &ids[i]) == 0;
    printf("# ids %zu repeated %zu worst chi-square %.1f\n", count, repeated, worst);
    (void)fflush(stdout);
    ck_assert_uint_eq(repeated, 0);
    ck_assert_double_lt(worst, 400);
    free(ids);
}
