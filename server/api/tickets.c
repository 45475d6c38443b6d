#include "server/api/tickets.h"

#include "server/base/clock.h"
#include "server/base/digest.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SECRET_BYTES = VOR_DIGEST_BYTES };

struct vor_tickets {
    uint8_t secret[SECRET_BYTES];
    int is_shared;
};

vor_status vor_tickets_create(struct vor_tickets **out, struct vor_error *err)
{
    struct vor_tickets *tickets = calloc(1, sizeof *tickets);

    if (tickets == NULL)
        return vor_fail(err, VOR_E_NOMEM, "the key that signs tickets");
    if (vor_random_fill(tickets->secret, SECRET_BYTES, err) != VOR_OK) {
        free(tickets);
        return VOR_E_IO;
    }
    *out = tickets;
    return VOR_OK;
}

void vor_tickets_share(struct vor_tickets *tickets, const char *secret)
{
    if (secret[0] == '\0')
        return;
    vor_digest_of(secret, strlen(secret), tickets->secret);
    tickets->is_shared = 1;
}

double vor_tickets_now(const struct vor_tickets *tickets)
{
    return tickets->is_shared ? (double)vor_clock_wall_ms() / 1000 : vor_clock_seconds();
}

void vor_tickets_destroy(struct vor_tickets *tickets)
{
    free(tickets);
}

const char *vor_ticket_write(const struct vor_tickets *tickets, const struct vor_uuid *job,
                             const char *output, double now, char out[VOR_TICKET_SIZE])
{
    uint8_t bytes[VOR_TICKET_BYTES_MAX];
    char text[VOR_TICKET_BYTES_MAX - VOR_DIGEST_BYTES];
    int length = snprintf(text, sizeof text, "%s|results/%.*s|%.0f|", job->text,
                          VOR_TICKET_OUTPUT_MAX - 1, output, ceil(now + VOR_TICKET_SECONDS));

    memcpy(bytes, text, (size_t)length);
    vor_digest_hmac(tickets->secret, SECRET_BYTES, bytes, (size_t)length, bytes + length);
    vor_base64_write(bytes, (size_t)length + VOR_DIGEST_BYTES, out);
    return out;
}

bool vor_ticket_check(const struct vor_tickets *tickets, const char *ticket,
                      const struct vor_uuid *job, const char *output, size_t length, double now)
{
    uint8_t bytes[VOR_TICKET_BYTES_MAX + 1], want[VOR_DIGEST_BYTES];
    long size = vor_base64_read(ticket, bytes, VOR_TICKET_BYTES_MAX);
    char head[VOR_TICKET_BYTES_MAX];
    size_t text;
    int begins;

    if (size <= VOR_DIGEST_BYTES || length >= VOR_TICKET_OUTPUT_MAX)
        return false;
    text = (size_t)size - VOR_DIGEST_BYTES;
    vor_digest_hmac(tickets->secret, SECRET_BYTES, bytes, text, want);
    if (!vor_digest_same(want, bytes + text))
        return false;
    bytes[text] = '\0'; /* the signature is read */
    begins = snprintf(head, sizeof head, "%s|results/%.*s|", job->text, (int)length, output);
    return strncmp((const char *)bytes, head, (size_t)begins) == 0 &&
           now < strtod((const char *)bytes + begins, NULL); /* the second at which it ends */
}
