/* What proxies say of a request: the examples of RFC 7239, chains, and all that must not be
 * believed. */
#include "server/http/forwarded.h"
#include "tests/support/vt.h"

#include <stdio.h>
#include <string.h>

/* The proxies of these tests: 10.0.0.0/8 and fd00::/8; the peer is 10.0.0.1. */
static struct vor_via read_from(const char *peer, enum vor_proxy_headers family,
                                const struct vor_field *fields)
{
    struct vor_head head = {.target = "/", .version = "HTTP/1.1"};
    struct vor_networks trusted;
    struct vor_address from;
    struct vor_via via;

    for (; fields->name != NULL; fields++)
        head.fields[head.field_count++] = *fields;
    vt_assert_ok(vor_networks_parse(&trusted, "trusted-proxy", "10.0.0.0/8,fd00::/8", &vt_err));
    ck_assert(vor_address_parse(&from, peer, strlen(peer)));
    memset(&via, 0xff, sizeof via);
    vor_forwarded_read(&via, &head, &from, &trusted, family);
    return via;
}

static struct vor_via read_forwarded(const char *value)
{
    struct vor_field fields[] = {{"Forwarded", value}, {NULL, NULL}};

    return read_from("10.0.0.1", VOR_PROXY_FORWARDED, fields);
}

static struct vor_via read_for(const char *value)
{
    struct vor_field fields[] = {{"X-Forwarded-For", value}, {NULL, NULL}};

    return read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, fields);
}

static void assert_silent(const struct vor_via *via, const char *client, const char *what)
{
    ck_assert_msg(strcmp(via->client, client) == 0, "%s: client %s", what, via->client);
    ck_assert_msg(via->scheme == NULL && via->host[0] == '\0' && via->prefix[0] == '\0', "%s",
                  what);
}

/* Vector: RFC 7239, sections 4, 5.2, 6 and 7, each as if the last hop was ours. */
VT_TEST(the_examples_of_rfc_7239_are_read)
{
    static const struct {
        const char *value, *client, *scheme;
    } vectors[] = {
        {"for=\"_gazonk\"", "10.0.0.1", NULL},
        {"For=\"[2001:db8:cafe::17]:4711\"", "2001:db8:cafe::17", NULL},
        {"for=192.0.2.60;proto=http;by=203.0.113.43", "192.0.2.60", "http"},
        {"for=192.0.2.43, for=198.51.100.17", "198.51.100.17", NULL},
        {"for=192.0.2.43, for=\"[2001:db8:cafe::17]\"", "2001:db8:cafe::17", NULL},
        {"for=192.0.2.43, for=\"[2001:db8:cafe::17]\", for=unknown", "10.0.0.1", NULL},
        {"for=_hidden, for=_SEVKISEK", "10.0.0.1", NULL},
        {"for=\"192.0.2.43:47011\"", "192.0.2.43", NULL},
        {"for=192.0.2.43,for=\"[2001:db8:cafe::17]\",for=unknown", "10.0.0.1", NULL},
    };

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        struct vor_via via = read_forwarded(vectors[i].value);

        ck_assert_msg(strcmp(via.client, vectors[i].client) == 0, "%s: client %s", vectors[i].value,
                      via.client);
        if (vectors[i].scheme == NULL)
            ck_assert_ptr_null(via.scheme);
        else
            ck_assert_str_eq(via.scheme, vectors[i].scheme);
    }
}

VT_TEST(values_may_be_quoted_escaped_and_spaced)
{
    static const char *const same[] = {
        "for=192.0.2.1;proto=https;host=cloud.example",
        "FOR=\"192.0.2.1\";PROTO=\"HTTPS\";HOST=\"cloud.example\"",
        "for=\"192.0.2\\.1\";proto=\"ht\\tps\";host=\"\\c\\loud.example\"",
        "\t host=cloud.example ; for=192.0.2.1 ; proto=https \t",
        ";;for=192.0.2.1;;proto=https;host=cloud.example;",
        ", for=192.0.2.1;proto=https;host=cloud.example;secret=\"a,b;for=10.9.9.9\" ,,",
        "for=\"192.0.2.1:80\";proto=https;host=cloud.example;by=_me",
        "for=\"192.0.2.1:_x.-\";proto=https;host=cloud.example",
    };

    for (size_t i = 0; i < sizeof same / sizeof same[0]; i++) {
        struct vor_via via = read_forwarded(same[i]);

        ck_assert_msg(strcmp(via.client, "192.0.2.1") == 0, "%s: client %s", same[i], via.client);
        ck_assert_msg(via.scheme != NULL && strcmp(via.scheme, "https") == 0, "%s", same[i]);
        ck_assert_msg(strcmp(via.host, "cloud.example") == 0, "%s: %s", same[i], via.host);
    }
    ck_assert_str_eq(read_forwarded("host=\"cloud.example:8443\"").host, "cloud.example:8443");
    ck_assert_str_eq(read_forwarded("host=\"[2001:db8::1]:8443\"").host, "[2001:db8::1]:8443");
}

VT_TEST(a_malformed_line_is_ignored_whole)
{
    static const char *const bad[] = {
        "for=192.0.2.1:80",            /* a colon wants quotes */
        "for=[2001:db8::1]",           /* so do brackets */
        "for=\"192.0.2.1",             /* no closing quote */
        "for=\"192.0.2.1\\",           /* ends in an escape */
        "for=\"192.0.2.1\"x",          /* something behind a quote */
        "for=192.0.2.1;for=192.0.2.2", /* twice in a hop */
        "proto=https;proto=http",
        "for=",
        "for",
        "=192.0.2.1",
        "for =192.0.2.1",
        "for= 192.0.2.1",
        "for=192.0.2.1 proto=https",
        "for=192.0.2.1;host=cloud.example, for=\"",
        "host=a.example;host=b.example",
    };

    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        struct vor_via via = read_forwarded(bad[i]);

        assert_silent(&via, "10.0.0.1", bad[i]);
    }
}

VT_TEST(a_malformed_line_hides_none_behind_it)
{
    struct vor_field fields[] = {{"Forwarded", "for=\"192.0.2.66;host=evil.example, "},
                                 {"Forwarded", "for=192.0.2.1;host=cloud.example"},
                                 {NULL, NULL}};
    struct vor_via via = read_from("10.0.0.1", VOR_PROXY_FORWARDED, fields);

    ck_assert_str_eq(via.client, "192.0.2.1");
    ck_assert_str_eq(via.host, "cloud.example");
    fields[0].value = "for=192.0.2.66";
    fields[1].value = "for=10.0.0.2, for=\"";
    via = read_from("10.0.0.1", VOR_PROXY_FORWARDED, fields);
    assert_silent(&via, "10.0.0.1", "the line of the peer is the malformed one");
}

/* What a client writes into the header itself lies left of what the outermost proxy adds. */
VT_TEST(the_client_is_the_rightmost_that_is_no_trusted_proxy)
{
    static const struct {
        const char *forwarded_for, *client;
    } vectors[] = {
        {"192.0.2.1", "192.0.2.1"},
        {"192.0.2.66, 192.0.2.1", "192.0.2.1"},
        {"192.0.2.66, 192.0.2.1, 10.3.3.3, fd00::5", "192.0.2.1"},
        {"10.6.6.6, 192.0.2.1, 10.3.3.3", "192.0.2.1"},
        {"10.6.6.6, 10.3.3.3", "10.6.6.6"},
        {"192.0.2.1:4711", "192.0.2.1"},
        {"2001:db8::1", "2001:db8::1"},
        {"[2001:db8::1]", "2001:db8::1"},
        {"[2001:db8::1]:4711, 10.3.3.3:80", "2001:db8::1"},
        {"::ffff:192.0.2.1", "192.0.2.1"},
        {"192.0.2.66,, 192.0.2.1 ,\t, ", "192.0.2.1"},
        {"192.0.2.66, unknown, 10.3.3.3", "10.3.3.3"},
        {"192.0.2.66, 192.0.2.1x", "10.0.0.1"},
        {"192.0.2.66, 192.0.2.1:", "10.0.0.1"},
        {"192.0.2.66, 192.0.2.1:123456", "10.0.0.1"},
        {"192.0.2.66, [192.0.2.1]", "10.0.0.1"},
        {"192.0.2.66, [2001:db8::1", "10.0.0.1"},
        {"192.0.2.66, 2001:db8::1]", "10.0.0.1"},
        {"192.0.2.66, [2001:db8::1]80", "10.0.0.1"},
        {"192.0.2.66, <script>", "10.0.0.1"},
        {"", "10.0.0.1"},
        {" , ,", "10.0.0.1"},
    };

    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        struct vor_via via = read_for(vectors[i].forwarded_for);

        assert_silent(&via, vectors[i].client, vectors[i].forwarded_for);
    }
}

VT_TEST(several_lines_are_one_list)
{
    struct vor_field fields[] = {{"X-Forwarded-For", "192.0.2.66, 192.0.2.1"},
                                 {"x-forwarded-for", "10.3.3.3"},
                                 {"X-Forwarded-For", "fd00::5,"},
                                 {"X-Forwarded-Host", "evil.example"},
                                 {"X-Forwarded-Host", "other.example, cloud.example:8443"},
                                 {NULL, NULL}};
    struct vor_via via = read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, fields);

    ck_assert_str_eq(via.client, "192.0.2.1");
    ck_assert_str_eq(via.host, "cloud.example:8443");
}

VT_TEST(a_chain_longer_than_is_looked_at_ends_at_its_last_proxy)
{
    char chain[40 * 16] = "192.0.2.1", number[32];

    for (int i = 1; i < VOR_HOPS_MAX; i++) {
        (void)snprintf(number, sizeof number, ", 10.1.1.%d", i);
        (void)strcat(chain, number);
    }
    ck_assert_str_eq(read_for(chain).client, "192.0.2.1");
    (void)strcat(chain, ", 10.1.1.99");
    ck_assert_str_eq(read_for(chain).client, "10.1.1.1");
}

VT_TEST(scheme_host_and_prefix_are_taken_when_they_are_sound)
{
    struct vor_field fields[] = {{"X-Forwarded-Proto", "https"},
                                 {"X-Forwarded-Host", "cloud.example"},
                                 {"X-Forwarded-Prefix", "/clouds/"},
                                 {NULL, NULL}};
    static const char *const schemes[] = {"ftp", "https:", "", "javascript", "http https"};
    static const char *const hosts[] = {"a/b", "a b", "user@a", "a:b", "", "a\"", "[::1"};
    static const char *const prefixes[] = {"clouds", "//evil.example", "/a/../b", "/a?b", "", "/%"};
    struct vor_via via = read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, fields);

    ck_assert_str_eq(via.scheme, "https");
    ck_assert_str_eq(via.host, "cloud.example");
    ck_assert_str_eq(via.prefix, "/clouds");
    for (size_t i = 0; i < sizeof schemes / sizeof schemes[0]; i++) {
        fields[0].value = schemes[i];
        ck_assert_ptr_null(read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, fields).scheme);
    }
    for (size_t i = 0; i < sizeof hosts / sizeof hosts[0]; i++) {
        fields[1].value = hosts[i];
        ck_assert_str_eq(read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, fields).host, "");
    }
    for (size_t i = 0; i < sizeof prefixes / sizeof prefixes[0]; i++) {
        fields[2].value = prefixes[i];
        ck_assert_str_eq(read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, fields).prefix, "");
    }
    fields[2].value = "/";
    ck_assert_str_eq(read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, fields).prefix, "");
}

VT_TEST(of_forwarded_the_outermost_trusted_proxy_names_the_host)
{
    struct vor_via via = read_forwarded("for=192.0.2.66;host=evil.example;proto=http, "
                                        "for=192.0.2.1;host=cloud.example;proto=https, "
                                        "for=10.3.3.3;host=inner.example;proto=http");

    ck_assert_str_eq(via.client, "192.0.2.1");
    ck_assert_str_eq(via.host, "cloud.example");
    ck_assert_str_eq(via.scheme, "https");
    via = read_forwarded("for=192.0.2.1, for=10.3.3.3;host=cloud.example;proto=https");
    ck_assert_str_eq(via.client, "192.0.2.1");
    ck_assert_str_eq(via.host, "cloud.example");
    ck_assert_str_eq(via.scheme, "https");
    via = read_forwarded("host=evil.example, for=unknown;host=cloud.example");
    ck_assert_str_eq(via.client, "10.0.0.1");
    ck_assert_str_eq(via.host, "cloud.example");
}

/* Every header of both families. */
static const struct vor_field everything[] = {
    {"X-Forwarded-For", "192.0.2.1"},
    {"X-Forwarded-Proto", "https"},
    {"X-Forwarded-Host", "x.example"},
    {"X-Forwarded-Prefix", "/x"},
    {"X-Real-IP", "192.0.2.3"},
    {"Forwarded", "for=192.0.2.2;proto=https;host=f.example"},
    {NULL, NULL}};

VT_TEST(the_other_family_is_ignored)
{
    struct vor_via x = read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, everything);
    struct vor_via f = read_from("10.0.0.1", VOR_PROXY_FORWARDED, everything);
    struct vor_via none;

    ck_assert_str_eq(x.client, "192.0.2.1");
    ck_assert_str_eq(x.host, "x.example");
    ck_assert_str_eq(f.client, "192.0.2.2");
    ck_assert_str_eq(f.host, "f.example");
    ck_assert_str_eq(f.prefix, "");
    none = read_from("10.0.0.1", VOR_PROXY_X_FORWARDED, everything + 5);
    assert_silent(&none, "10.0.0.1", "Forwarded alone");
}

VT_TEST(an_untrusted_peer_is_not_believed_a_word)
{
    static const char *const peers[] = {"127.0.0.1", "11.0.0.1", "192.0.2.1", "::1", "fe80::1"};

    for (size_t i = 0; i < sizeof peers / sizeof peers[0]; i++) {
        struct vor_via x = read_from(peers[i], VOR_PROXY_X_FORWARDED, everything);
        struct vor_via f = read_from(peers[i], VOR_PROXY_FORWARDED, everything);

        assert_silent(&x, peers[i], "x-forwarded");
        assert_silent(&f, peers[i], "forwarded");
    }
    ck_assert_str_eq(read_from("fd00::1", VOR_PROXY_FORWARDED, everything).client, "192.0.2.2");
    ck_assert_str_eq(read_from("::ffff:10.0.0.9", VOR_PROXY_FORWARDED, everything).client,
                     "192.0.2.2");
}
