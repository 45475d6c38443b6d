/* Addresses, networks and hosts as the settings and the headers of proxies write them. */
#include "server/base/address.h"
#include "tests/support/vt.h"

#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>

static struct vor_address address(const char *text)
{
    struct vor_address out;

    ck_assert_msg(vor_address_parse(&out, text, strlen(text)), "%s", text);
    return out;
}

VT_TEST(an_address_is_written_in_its_shortest_form)
{
    static const struct {
        const char *in, *out;
    } vectors[] = {
        {"192.0.2.1", "192.0.2.1"},
        {"::ffff:192.0.2.1", "192.0.2.1"},
        {"2001:DB8:0:0:0:0:0:1", "2001:db8::1"},
        {"::1", "::1"},
        {"::", "::"},
        {"0.0.0.0", "0.0.0.0"},
    };

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        struct vor_address read = address(vectors[i].in);
        char text[VOR_ADDRESS_TEXT];

        ck_assert_str_eq(vor_address_text(&read, text), vectors[i].out);
    }
}

VT_TEST(what_is_no_address_is_not_read)
{
    static const char *const bad[] = {
        "",
        "1",
        "1.2.3",
        "1.2.3.4.5",
        "256.1.1.1",
        "01.2.3.4",
        "1.2.3.4 ",
        " 1.2.3.4",
        "[::1]",
        "::1%lo",
        ":::",
        "1::2::3",
        "localhost",
        "_hidden",
        "unknown",
        "1.2.3.4:80",
        "0x7f.1",
        "::ffff:1.2.3",
        "2001:db8:0000:0000:0000:0000:0000:0000:0000:0001",
    };
    struct vor_address out = address("192.0.2.9");
    char text[VOR_ADDRESS_TEXT];

    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        ck_assert_msg(!vor_address_parse(&out, bad[i], strlen(bad[i])), "%s", bad[i]);
    ck_assert(!vor_address_parse(&out, "1.2.3.4\0x", 9));
    ck_assert_str_eq(vor_address_text(&out, text), "192.0.2.9");
}

VT_TEST(the_two_families_of_a_socket_are_one)
{
    struct sockaddr_in four = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(0xc0000201)};
    struct sockaddr_in6 six = {.sin6_family = AF_INET6};
    struct sockaddr local = {.sa_family = AF_UNIX}, other = {.sa_family = AF_UNSPEC};
    struct vor_address a, b = address("::ffff:192.0.2.1");

    ck_assert(vor_address_of_socket(&a, (const struct sockaddr *)&four));
    ck_assert_mem_eq(a.bytes, b.bytes, sizeof a.bytes);
    memcpy(&six.sin6_addr, b.bytes, sizeof b.bytes);
    ck_assert(vor_address_of_socket(&a, (const struct sockaddr *)&six));
    ck_assert_mem_eq(a.bytes, b.bytes, sizeof a.bytes);
    ck_assert(!vor_address_of_socket(&a, &other));
    b = address("127.0.0.1");
    ck_assert(vor_address_of_socket(&a, &local));
    ck_assert_mem_eq(a.bytes, b.bytes, sizeof a.bytes);
}

VT_TEST(a_network_holds_its_addresses_and_no_others)
{
    static const struct {
        const char *list, *in, *out;
    } vectors[] = {
        {"127.0.0.1", "127.0.0.1", "127.0.0.2"},
        {"10.0.0.0/8", "10.255.255.255", "11.0.0.0"},
        {"10.1.2.3/8", "10.0.0.0", "9.255.255.255"},
        {"192.0.2.128/25", "192.0.2.128", "192.0.2.127"},
        {"192.0.2.4/31", "192.0.2.5", "192.0.2.6"},
        {"0.0.0.0/0", "203.0.113.7", "2001:db8::1"},
        {"::/0", "2001:db8::1", "203.0.113.7"},
        {"::1", "::1", "::2"},
        {"fd00::/8", "fdff::1", "fe00::"},
        {"2001:db8::/33", "2001:db8:7fff::", "2001:db8:8000::"},
        {"::ffff:10.0.0.0/104", "10.1.1.1", "11.1.1.1"},
        {"192.0.2.1,, fd00::/8 ,10.0.0.0/8", "10.1.1.1", "192.0.2.2"},
    };

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        struct vor_networks networks;
        struct vor_address in = address(vectors[i].in), out = address(vectors[i].out);

        vt_assert_ok(vor_networks_parse(&networks, "trusted-proxy", vectors[i].list, &vt_err));
        ck_assert_msg(vor_networks_hold(&networks, &in), "%s", vectors[i].list);
        ck_assert_msg(!vor_networks_hold(&networks, &out), "%s", vectors[i].list);
    }
}

/* Oracle: bit by bit. */
VT_TEST_LOOP(a_network_goes_by_its_first_bits, 300)
{
    struct vor_networks networks;
    struct vor_address base = address("2001:db8:1234:5678:9abc:def0:1357:9bdf");
    unsigned bits = (unsigned)(128 * vt_unit((uint64_t)_i, 0));
    unsigned flipped = (unsigned)(128 * vt_unit((uint64_t)_i, 1));
    struct vor_address other = base;
    char list[64];

    other.bytes[flipped / 8] ^= (uint8_t)(0x80 >> flipped % 8);
    (void)snprintf(list, sizeof list, "2001:db8:1234:5678:9abc:def0:1357:9bdf/%u", bits);
    vt_assert_ok(vor_networks_parse(&networks, "trusted-proxy", list, &vt_err));
    ck_assert(vor_networks_hold(&networks, &base));
    ck_assert_int_eq(vor_networks_hold(&networks, &other), flipped >= bits);
}

VT_TEST(an_empty_list_holds_nothing)
{
    struct vor_networks networks;
    struct vor_address any = address("127.0.0.1");

    vt_assert_ok(vor_networks_parse(&networks, "trusted-proxy", " , ", &vt_err));
    ck_assert_uint_eq(networks.count, 0);
    ck_assert(!vor_networks_hold(&networks, &any));
}

VT_TEST(what_is_no_network_is_refused_by_name)
{
    static const char *const bad[] = {"10.0.0.0/33", "::/129",      "10.0.0.0/", "10.0.0.0/x",
                                      "10.0.0/8",    "localhost",   "unix",      "10.0.0.0/8/8",
                                      "[::1]",       "10.0.0.0/-1", "::1/0128",  "/8"};
    struct vor_networks networks;
    char list[128], many[VOR_NETWORKS_MAX * 4 + 8] = "";

    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        (void)snprintf(list, sizeof list, "192.0.2.1,%s,192.0.2.2", bad[i]);
        vt_assert_fails(VOR_E_PARAM, vor_networks_parse(&networks, "trusted-proxy", list, &vt_err));
        ck_assert_str_eq(vt_err.parameter, "trusted-proxy");
        (void)snprintf(list, sizeof list, "--trusted-proxy holds \"%s\", want", bad[i]);
        ck_assert_ptr_nonnull(strstr(vt_err.message, list));
    }
    for (size_t i = 0; i <= VOR_NETWORKS_MAX; i++)
        memcpy(many + 4 * i, "::1,", 5);
    vt_assert_fails(VOR_E_PARAM, vor_networks_parse(&networks, "trusted-proxy", many, &vt_err));
    ck_assert_ptr_nonnull(strstr(vt_err.message, "more than 64"));
}

VT_TEST(hosts_are_told_from_what_is_none)
{
    static const struct {
        const char *host;
        size_t name; /* 0: unsound */
    } vectors[] = {
        {"localhost", 9},
        {"cloud.example:8443", 13},
        {"127.0.0.1:80", 9},
        {"[::1]", 5},
        {"[2001:db8::1]:443", 13},
        {"my_container:8080", 12},
        {"a:1", 1},
        {"a:65535", 1},
        {"[::1]:8080", 5},
        {"a:", 0},
        {"a:0", 0},
        {"a:65536", 0},
        {"a:99999", 0},
        {"a:80x", 0},
        {"a:80:80", 0},
        {"localhost:evil.com", 0},
        {"[::1]evil.example", 0},
        {"[::1]:80.evil.example", 0},
        {"[::1]:", 0},
        {"", 0},
        {":80", 0},
        {"a b", 0},
        {"a:b", 0},
        {"::1", 0},
        {"[::1", 0},
        {"[::1]x", 0},
        {"[1.2.3.4]", 0},
        {"[]", 0},
        {"a:123456", 0},
        {"user@host", 0},
        {"a/b", 0},
        {"a,b", 0},
        {"a\"b", 0},
        {"[::1%lo]", 0},
        {"\xc3\xa4.example", 0},
    };
    char longest[VOR_HOST_MAX + 2];

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        ck_assert_msg(vor_host_is_sound(vectors[i].host) == (vectors[i].name > 0), "%s",
                      vectors[i].host);
        if (vectors[i].name > 0)
            ck_assert_uint_eq(vor_host_name_length(vectors[i].host), vectors[i].name);
    }
    memset(longest, 'a', sizeof longest);
    longest[VOR_HOST_MAX + 1] = '\0';
    ck_assert(!vor_host_is_sound(longest));
    ck_assert(vor_host_is_sound(longest + 1));
}

VT_TEST(prefixes_are_told_from_what_is_none)
{
    static const char *const good[] = {"/", "/a", "/a/", "/a/b.c/..d", "/~x/%20/@:=", "/..."};
    static const char *const bad[] = {
        "",     "a",    "//",  "//evil.example", "/a//b", "/.",  "/..",   "/a/../b",  "/a?b",
        "/a#b", "/a b", "/%2", "/%zz",           "/a\\b", "/\"", "/a/./", "/\xc3\xa4"};
    char longest[VOR_PREFIX_MAX + 2];

    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++)
        ck_assert_msg(vor_prefix_is_sound(good[i]), "%s", good[i]);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        ck_assert_msg(!vor_prefix_is_sound(bad[i]), "%s", bad[i]);
    memset(longest, 'a', sizeof longest);
    longest[0] = longest[1] = '/';
    longest[VOR_PREFIX_MAX + 1] = '\0';
    ck_assert(vor_prefix_is_sound(longest + 1));
    longest[1] = 'a';
    ck_assert(!vor_prefix_is_sound(longest));
}
