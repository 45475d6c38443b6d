/* Who must go when there are too many connections, and who counts. */
#include "server/http/conn_guard.h"
#include "server/http/release_zero_pages.h"
#include "tests/support/vt.h"

#include <poll.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

enum { MOST = 4, RESERVE = 32, MANY = 60 };

/* Connections as the daemon sees them, and their other ends. */
struct crowd {
    struct vor_conn_guard *guard;
    struct vor_networks trusted;
    struct vor_conn *peers[MANY];
    int ours[MANY], theirs[MANY];
    int count;
};

static void open_patient_crowd(struct crowd *crowd, double grace_seconds)
{
    struct vor_conn_limits limits = {.header_seconds = 60,
                                     .keep_seconds = 60,
                                     .body_seconds = 60,
                                     .body_idle_seconds = 60,
                                     .beat_seconds = 60,
                                     .grace_seconds = grace_seconds,
                                     .connections = MOST,
                                     .each = 2,
                                     .trusted = &crowd->trusted};

    memset(crowd, 0, sizeof *crowd);
    vt_assert_ok(vor_networks_parse(&crowd->trusted, "trusted-proxy", "198.51.100.7", &vt_err));
    vt_assert_ok(vor_conn_guard_start(&crowd->guard, &limits, &vt_err));
}

static void open_crowd(struct crowd *crowd)
{
    open_patient_crowd(crowd, 0);
}

/* One more, from an address or from none, in a phase. */
static int come(struct crowd *crowd, const char *address, enum vor_phase phase)
{
    int ends[2], i = crowd->count++;
    struct vor_address from;

    ck_assert_int_eq(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    crowd->ours[i] = ends[0];
    crowd->theirs[i] = ends[1];
    if (address != NULL)
        ck_assert(vor_address_parse(&from, address, strlen(address)));
    crowd->peers[i] = vor_conn_enter(crowd->guard, ends[0], address != NULL ? &from : NULL);
    vor_conn_phase(crowd->peers[i], phase);
    return i;
}

static bool is_cut(const struct crowd *crowd, int i)
{
    struct pollfd end = {crowd->theirs[i], POLLIN, 0};
    char byte;

    return poll(&end, 1, 0) == 1 && recv(end.fd, &byte, 1, MSG_DONTWAIT) == 0;
}

static void leave(struct crowd *crowd, int i)
{
    vor_conn_leave(crowd->peers[i]);
    (void)close(crowd->ours[i]);
    (void)close(crowd->theirs[i]);
}

static void close_crowd(struct crowd *crowd)
{
    for (int i = 0; i < crowd->count; i++)
        leave(crowd, i);
    vor_conn_guard_stop(crowd->guard);
}

VT_TEST(the_oldest_silent_connection_goes)
{
    struct crowd crowd;

    open_crowd(&crowd);
    for (int i = 0; i < 20; i++) {
        come(&crowd, NULL, VOR_PHASE_HEAD);
        for (int k = 0; k <= i; k++)
            ck_assert_msg(is_cut(&crowd, k) == (k <= i - MOST), "%d of %d", k, i);
        ck_assert_uint_eq(vor_conn_guard_count(crowd.guard), i < MOST ? (unsigned)i + 1 : MOST);
        ck_assert_int_eq(vor_conn_excess(crowd.guard, crowd.peers[i]), VOR_EXCESS_NONE);
    }
    close_crowd(&crowd);
}

VT_TEST(who_sent_no_head_goes_before_who_is_kept_and_nobody_who_is_served)
{
    static const enum vor_phase served[] = {VOR_PHASE_BODY, VOR_PHASE_SERVE, VOR_PHASE_SEND};
    struct crowd crowd;
    int kept, silent;

    open_crowd(&crowd);
    for (size_t i = 0; i < sizeof served / sizeof served[0]; i++)
        come(&crowd, NULL, served[i]);
    kept = come(&crowd, NULL, VOR_PHASE_IDLE);
    silent = come(&crowd, NULL, VOR_PHASE_HEAD);
    ck_assert(is_cut(&crowd, kept)); /* nobody else was silent before the newcomer */
    come(&crowd, NULL, VOR_PHASE_IDLE);
    ck_assert(is_cut(&crowd, silent));
    for (int i = 0; i < 3; i++)
        ck_assert(!is_cut(&crowd, i));
    close_crowd(&crowd);
}

VT_TEST(a_health_check_gets_in_among_those_who_are_all_served)
{
    struct crowd crowd;

    open_crowd(&crowd);
    for (int i = 0; i < MOST + RESERVE; i++)
        ck_assert(!is_cut(&crowd, come(&crowd, NULL, VOR_PHASE_SERVE)));
    ck_assert_int_eq(vor_conn_excess(crowd.guard, crowd.peers[0]), VOR_EXCESS_ALL);
    ck_assert(is_cut(&crowd, come(&crowd, NULL, VOR_PHASE_HEAD)));
    leave(&crowd, --crowd.count);
    leave(&crowd, --crowd.count);
    ck_assert(!is_cut(&crowd, come(&crowd, NULL, VOR_PHASE_HEAD)));
    close_crowd(&crowd);
}

VT_TEST(a_connection_with_unread_bytes_stays_while_the_reserve_lasts)
{
    struct crowd crowd;

    open_crowd(&crowd);
    for (int i = 0; i < MOST + RESERVE; i++) {
        come(&crowd, NULL, VOR_PHASE_HEAD);
        ck_assert_int_eq(write(crowd.theirs[i], "GET", 3), 3);
    }
    for (int i = 0; i < crowd.count; i++)
        ck_assert_msg(!is_cut(&crowd, i), "%d", i);
    come(&crowd, NULL, VOR_PHASE_HEAD);
    ck_assert(is_cut(&crowd, 0));
    close_crowd(&crowd);
}

VT_TEST(a_new_connection_stays_while_the_reserve_lasts)
{
    struct crowd crowd;

    open_patient_crowd(&crowd, 60);
    for (int i = 0; i < MANY; i++) {
        come(&crowd, NULL, VOR_PHASE_HEAD);
        for (int k = 0; k <= i; k++)
            ck_assert_msg(is_cut(&crowd, k) == (k <= i - MOST - RESERVE), "%d of %d", k, i);
    }
    close_crowd(&crowd);
}

VT_TEST(streams_do_not_count)
{
    struct crowd crowd;

    open_crowd(&crowd);
    for (int i = 0; i < MANY - MOST; i++)
        ck_assert(!is_cut(&crowd, come(&crowd, NULL, VOR_PHASE_STREAM)));
    ck_assert_uint_eq(vor_conn_guard_count(crowd.guard), 0);
    for (int i = 0; i < MOST; i++)
        come(&crowd, NULL, VOR_PHASE_HEAD);
    for (int i = 0; i < MANY; i++)
        ck_assert(!is_cut(&crowd, i));
    close_crowd(&crowd);
}

VT_TEST(an_address_has_its_share_unless_it_is_ours_or_a_proxys)
{
    static const struct {
        const char *address[3];
        enum vor_conn_excess third;
    } cases[] = {
        {{"192.0.2.1", "192.0.2.1", "192.0.2.1"}, VOR_EXCESS_ADDRESS},
        {{"192.0.2.1", "192.0.2.1", "192.0.2.2"}, VOR_EXCESS_NONE},
        {{"2001:db8::1", "2001:db8::2", "2001:db8:0:0:ffff::"}, VOR_EXCESS_ADDRESS},
        {{"2001:db8::1", "2001:db8::2", "2001:db8:0:1::1"}, VOR_EXCESS_NONE},
        {{"127.0.0.1", "127.0.0.1", "127.0.0.1"}, VOR_EXCESS_NONE},
        {{"127.9.9.9", "127.9.9.9", "127.9.9.9"}, VOR_EXCESS_NONE},
        {{"::1", "::1", "::1"}, VOR_EXCESS_NONE},
        {{"198.51.100.7", "198.51.100.7", "198.51.100.7"}, VOR_EXCESS_NONE},
        {{"198.51.100.8", "198.51.100.8", "198.51.100.8"}, VOR_EXCESS_ADDRESS},
        {{NULL, NULL, NULL}, VOR_EXCESS_NONE},
    };

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct crowd crowd;

        open_crowd(&crowd);
        for (int k = 0; k < 3; k++)
            come(&crowd, cases[i].address[k], VOR_PHASE_SERVE);
        ck_assert_msg(vor_conn_excess(crowd.guard, crowd.peers[2]) == cases[i].third, "case %zu",
                      i);
        leave(&crowd, --crowd.count);
        leave(&crowd, --crowd.count);
        come(&crowd, cases[i].address[2], VOR_PHASE_SERVE);
        ck_assert_int_eq(vor_conn_excess(crowd.guard, crowd.peers[1]), VOR_EXCESS_NONE);
        close_crowd(&crowd);
    }
}

VT_TEST(an_address_beyond_share_and_reserve_is_cut_at_once)
{
    struct crowd crowd;

    open_crowd(&crowd);
    for (int i = 0; i < 2 + RESERVE; i++)
        ck_assert(!is_cut(&crowd, come(&crowd, "192.0.2.1", VOR_PHASE_STREAM)));
    ck_assert(is_cut(&crowd, come(&crowd, "192.0.2.1", VOR_PHASE_HEAD)));
    ck_assert(!is_cut(&crowd, come(&crowd, "192.0.2.2", VOR_PHASE_HEAD)));
    close_crowd(&crowd);
}

VT_TEST(a_timer_that_comes_first_counts_and_each_wakes_once)
{
    struct crowd crowd;
    struct vor_waker *waker = vor_waker_create(NULL);
    int i;

    open_crowd(&crowd);
    i = come(&crowd, NULL, VOR_PHASE_SERVE);
    vor_conn_request(crowd.peers[i], waker);
    vor_conn_wake_after(crowd.peers[i], 0);
    vor_conn_wake_after(crowd.peers[i], 60);
    for (int k = 0; k < 500 && !vor_waker_is_pending(waker); k++)
        (void)poll(NULL, 0, 10);
    ck_assert(vor_waker_is_pending(waker));
    close_crowd(&crowd);
    vor_waker_end(waker);
    vor_waker_drop(waker);
}

VT_TEST(a_waiter_is_told_of_a_peer_that_left_before_it_waited_and_of_one_that_leaves)
{
    for (int before = 0; before < 2; before++) {
        struct vor_waker *waker = vor_waker_create(NULL);
        struct crowd crowd;
        int i;

        open_crowd(&crowd);
        i = come(&crowd, NULL, VOR_PHASE_SERVE);
        vor_conn_request(crowd.peers[i], waker);
        if (before)
            (void)shutdown(crowd.theirs[i], SHUT_RDWR);
        vor_conn_wait(crowd.peers[i], true);
        if (!before)
            (void)shutdown(crowd.theirs[i], SHUT_RDWR);
        for (int k = 0; k < 500 && !vor_waker_is_gone(waker); k++)
            (void)poll(NULL, 0, 10);
        ck_assert(vor_waker_is_gone(waker));
        close_crowd(&crowd);
        vor_waker_end(waker);
        vor_waker_drop(waker);
    }
}

/* Every choice of four pages: those of zeros go, the others keep their bytes. */
VT_TEST(pages_of_zeros_go_and_others_stay)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    unsigned char here[4];
    unsigned char *memory =
        mmap(NULL, 4 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);

    ck_assert(memory != MAP_FAILED);
    for (unsigned choice = 0; choice < 16; choice++) {
        for (unsigned i = 0; i < 4; i++) {
            memset(memory + i * page, 0, page);
            memory[(i + 1) * page - 1] = (unsigned char)((choice >> i & 1) * 7);
        }
        vor_release_zero_pages(memory + 1, 4 * page); /* does not begin a page: left alone */
        vor_release_zero_pages(memory, 4 * page);
        ck_assert_int_eq(mincore(memory, 4 * page, here), 0);
        for (unsigned i = 0; i < 4; i++) {
            ck_assert_uint_eq(here[i] & 1, choice >> i & 1);
            ck_assert_uint_eq(memory[(i + 1) * page - 1], (choice >> i & 1) * 7);
        }
    }
    (void)munmap(memory, 4 * page);
}
