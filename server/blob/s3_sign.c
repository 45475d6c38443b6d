#include "server/blob/s3_sign.h"

#include "server/base/digest.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

/* Writes "https://HOST", in small letters and without the scheme's own port. Returns the path. */
static const char *put_origin(struct vor_text *out, const char *url)
{
    const char *host = strstr(url, "://") + 3, *path = host + strcspn(host, "/");
    const char *port = strncmp(url, "https", 5) == 0 ? ":443" : ":80";
    size_t size = (size_t)(path - url), tail = strlen(port);

    if (strncmp(path - tail, port, tail) == 0)
        size -= tail;
    vor_text_add(out, url, size);
    for (size_t i = 0; i < size && !out->failed; i++)
        out->data[i] = (char)tolower((unsigned char)out->data[i]);
    return path;
}

static void put_hex(struct vor_text *out, const uint8_t bytes[VOR_DIGEST_BYTES])
{
    for (int i = 0; i < VOR_DIGEST_BYTES; i++)
        vor_text_printf(out, "%02x", bytes[i]);
}

/* The key of a day, region and service, each of which is signed by the key before. */
static void sign(const struct vor_s3_signing *signing, const char *day, const struct vor_text *text,
                 uint8_t out[VOR_DIGEST_BYTES])
{
    const char *part[] = {day, signing->region, "s3", "aws4_request"};
    struct vor_text secret;
    uint8_t key[VOR_DIGEST_BYTES] = {0};

    vor_text_init(&secret, 0);
    vor_text_printf(&secret, "AWS4%s", signing->secret);
    if (!secret.failed)
        vor_digest_hmac(secret.data, secret.size, day, strlen(day), key);
    for (size_t i = 1; i < sizeof part / sizeof part[0]; i++)
        vor_digest_hmac(key, sizeof key, part[i], strlen(part[i]), key);
    vor_digest_hmac(key, sizeof key, text->data, text->size, out);
    if (secret.data != NULL)
        explicit_bzero(secret.data, secret.size);
    vor_text_free(&secret);
}

void vor_s3_sign(const struct vor_s3_signing *signing, struct vor_text *out)
{
    struct vor_text origin, query, request, question;
    time_t at = (time_t)signing->at;
    char time[24] = "", day[9], scope[128];
    uint8_t digest[VOR_DIGEST_BYTES], signature[VOR_DIGEST_BYTES];
    const char *path;
    struct tm tm;

    vor_text_init(&origin, 0);
    vor_text_init(&query, 0);
    vor_text_init(&request, 0);
    vor_text_init(&question, 0);
    (void)strftime(time, sizeof time, "%Y%m%dT%H%M%SZ", gmtime_r(&at, &tm));
    (void)snprintf(day, sizeof day, "%.8s", time);
    (void)snprintf(scope, sizeof scope, "%s/%s/s3/aws4_request", day, signing->region);
    path = put_origin(&origin, signing->url);
    vor_text_puts(&query, "X-Amz-Algorithm=AWS4-HMAC-SHA256&X-Amz-Credential=");
    vor_text_escape(&query, signing->key_id);
    vor_text_escape(&query, "/");
    vor_text_escape(&query, scope);
    vor_text_printf(&query, "&X-Amz-Date=%s&X-Amz-Expires=%u", time, signing->seconds);
    if (signing->token[0] != '\0') {
        vor_text_puts(&query, "&X-Amz-Security-Token=");
        vor_text_escape(&query, signing->token);
    }
    vor_text_printf(&query, "&X-Amz-SignedHeaders=host%s", signing->query);
    if (!origin.failed && !query.failed)
        vor_text_printf(&request, "%s\n%s\n%s\nhost:%s\n\nhost\nUNSIGNED-PAYLOAD", signing->method,
                        path, query.data, strstr(origin.data, "://") + 3);
    if (request.data != NULL) {
        vor_digest_of(request.data, request.size, digest);
        vor_text_printf(&question, "AWS4-HMAC-SHA256\n%s\n%s\n", time, scope);
        put_hex(&question, digest);
    }
    if (request.failed || question.data == NULL || question.failed) {
        out->failed = 1;
    } else {
        sign(signing, day, &question, signature);
        vor_text_printf(out, "%s%s?%s&X-Amz-Signature=", origin.data, path, query.data);
        put_hex(out, signature);
    }
    vor_text_free(&origin);
    vor_text_free(&query);
    vor_text_free(&request);
    vor_text_free(&question);
}
