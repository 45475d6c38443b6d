/* Any bytes as what a client and its proxies write into the headers of proxies, a line each. What
 * is taken from them is sound; from a peer that is not trusted nothing is; and whatever stands
 * before it, the line that the trusted peer adds last is what counts. */
#include "server/http/forwarded.h"
#include "tests/fuzz/fuzz.h"

static const char *const names[] = {"Forwarded", "X-Forwarded-For", "X-Forwarded-Proto",
                                    "X-Forwarded-Host", "X-Forwarded-Prefix"};

enum { NAMES = sizeof names / sizeof names[0], ADDED_MAX = 4 };

/* Each line is a value; its first byte says of which header. */
static void read_head(struct vor_head *head, char *text)
{
    memset(head, 0, sizeof *head);
    head->target = "/";
    head->version = "HTTP/1.1";
    for (char *line = text; line != NULL && head->field_count < VOR_FIELDS_MAX - ADDED_MAX;) {
        char *end = strchr(line, '\n');

        if (end != NULL)
            *end++ = '\0';
        if (*line != '\0')
            head->fields[head->field_count++] =
                (struct vor_field){names[(unsigned char)*line % NAMES], line + 1};
        line = end;
    }
}

static void check_sound(const struct vor_via *via)
{
    struct vor_address client;

    require(vor_address_parse(&client, via->client, strlen(via->client)),
            "the client is no address");
    require(via->scheme == NULL || strcmp(via->scheme, "http") == 0 ||
                strcmp(via->scheme, "https") == 0,
            "a scheme is another");
    require(via->host[0] == '\0' || vor_host_is_sound(via->host), "a host is none");
    require(via->prefix[0] == '\0' ||
                (vor_prefix_is_sound(via->prefix) && via->prefix[strlen(via->prefix) - 1] != '/'),
            "a prefix is none");
}

/* What the outermost proxy adds. */
static void add_own(struct vor_head *head)
{
    static const struct vor_field own[ADDED_MAX + 1] = {
        {"Forwarded", "for=\"198.51.100.7:80\";proto=https;host=a.example"},
        {"X-Forwarded-For", "198.51.100.7"},
        {"X-Forwarded-Proto", "https"},
        {"X-Forwarded-Host", "a.example"},
    };

    for (size_t i = 0; i < ADDED_MAX; i++)
        head->fields[head->field_count++] = own[i];
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static const char peer_text[] = "10.0.0.1";
    struct vor_networks trusted, others;
    struct vor_address peer;
    struct vor_head head;
    struct vor_via via;
    char *text = fuzz_text(bytes, size);

    require(vor_address_parse(&peer, peer_text, strlen(peer_text)) &&
                vor_networks_parse(&trusted, "a", "10.0.0.0/8,fd00::/8", NULL) == VOR_OK &&
                vor_networks_parse(&others, "b", "192.0.2.0/24", NULL) == VOR_OK,
            "the networks of this fuzzer are none");
    read_head(&head, text);
    for (int family = VOR_PROXY_X_FORWARDED; family <= VOR_PROXY_FORWARDED; family++) {
        size_t count = head.field_count;

        vor_forwarded_read(&via, &head, &peer, &trusted, (enum vor_proxy_headers)family);
        check_sound(&via);
        vor_forwarded_read(&via, &head, &peer, &others, (enum vor_proxy_headers)family);
        require(strcmp(via.client, peer_text) == 0 && via.scheme == NULL && via.host[0] == '\0' &&
                    via.prefix[0] == '\0',
                "a peer that is not trusted is believed");
        add_own(&head);
        vor_forwarded_read(&via, &head, &peer, &trusted, (enum vor_proxy_headers)family);
        require(strcmp(via.client, "198.51.100.7") == 0 && strcmp(via.host, "a.example") == 0 &&
                    via.scheme != NULL && strcmp(via.scheme, "https") == 0,
                "what a client wrote wins over its proxy");
        head.field_count = count;
    }
    free(text);
    return 0;
}
