#include "server/base/key_line.h"

#include "core/base/quote.h"
#include "server/base/option.h"

#include <math.h>
#include <string.h>

enum { SHOWN_SIZE = 64 /* of what the file says, in a message */ };

static vor_status read_name(struct vor_principal *out, const char *text, size_t length,
                            struct vor_error *err)
{
    static const char allowed[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    char shown[SHOWN_SIZE];

    if (length < 1 || length > VOR_KEY_NAME_MAX || strspn(text, allowed) < length)
        return vor_fail_param(err, VOR_E_PARAM, "name",
                              "the name is \"%s\", want 1 to %d letters, digits, dots, dashes and "
                              "underscores",
                              vor_quote(shown, sizeof shown, text, length), VOR_KEY_NAME_MAX);
    memcpy(out->name, text, length);
    out->name[length] = '\0';
    return VOR_OK;
}

static vor_status read_scopes(struct vor_principal *out, const char *text, size_t length,
                              struct vor_error *err)
{
    char shown[SHOWN_SIZE];

    out->scopes = 0;
    for (size_t at = 0; at <= length;) {
        size_t word = strcspn(text + at, ",:");
        int scope = VOR_SCOPE_OPEN + 1;

        word = word < length - at ? word : length - at;
        while (scope < VOR_SCOPES &&
               (strlen(vor_scope_word((enum vor_scope)scope)) != word ||
                memcmp(vor_scope_word((enum vor_scope)scope), text + at, word) != 0))
            scope++;
        if (scope == VOR_SCOPES)
            return vor_fail_param(err, VOR_E_PARAM, "scopes",
                                  "the scopes are \"%s\", want one or more of read, submit and "
                                  "admin, separated by commas",
                                  vor_quote(shown, sizeof shown, text, length));
        out->scopes |= 1u << scope;
        at += word + 1;
    }
    out->sees_all = (out->scopes >> VOR_SCOPE_ADMIN & 1) != 0;
    if (out->sees_all)
        out->scopes = VOR_EVERY_SCOPE;
    return VOR_OK;
}

static int nibble(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* What stands there may be a key that was taken for its digest: it is not shown. */
static vor_status read_digest(uint8_t out[VOR_DIGEST_BYTES], const char *text, size_t length,
                              struct vor_error *err)
{
    size_t good = 0;

    while (good < length && nibble(text[good]) >= 0)
        good++;
    if (good != length || length != VOR_DIGEST_SIZE - 1)
        return vor_fail_param(
            err, VOR_E_PARAM, "sha256",
            "the digest has %zu characters, of which the first %zu are lower-case hexadecimal "
            "digits; want the SHA-256 of the key, exactly %d such digits",
            length, good, VOR_DIGEST_SIZE - 1);
    for (size_t i = 0; i < VOR_DIGEST_BYTES; i++)
        out[i] = (uint8_t)(nibble(text[2 * i]) << 4 | nibble(text[2 * i + 1]));
    return VOR_OK;
}

/* The quotas: name, member, least, most, whether it is whole. */
struct quota_info {
    const char *name;
    size_t offset;
    double least, most;
    bool is_whole;
};

static const struct quota_info quota_infos[] = {
    {"jobs", offsetof(struct vor_quota, jobs), 1, 100000, true},
    {"rate", offsetof(struct vor_quota, rate), 0.01, 100000, false},
    {"bytes", offsetof(struct vor_quota, bytes), 1, 1e15, true},
    {"points", offsetof(struct vor_quota, points), 1, 2147483646, true},
};

enum { QUOTAS = sizeof quota_infos / sizeof quota_infos[0] };

static const struct quota_info *quota_of(const char *text, size_t length)
{
    for (size_t i = 0; i < QUOTAS; i++) {
        size_t name = strlen(quota_infos[i].name);

        if (length > name && memcmp(text, quota_infos[i].name, name) == 0 && text[name] == '=')
            return &quota_infos[i];
    }
    return NULL;
}

static vor_status read_quota(struct vor_quota *out, const char *text, size_t length,
                             struct vor_error *err)
{
    const struct quota_info *info = quota_of(text, length);
    size_t name = info != NULL ? strlen(info->name) + 1 : 0;
    double number = info != NULL ? vor_number_read(text + name, length - name, 1) : NAN;
    char shown[SHOWN_SIZE];

    vor_quote(shown, sizeof shown, text, length);
    if (info == NULL)
        return vor_fail_param(err, VOR_E_PARAM, "quotas",
                              "a quota is \"%s\", want jobs=N, rate=N, bytes=N or points=N", shown);
    if (!(number >= info->least && number <= info->most) ||
        (info->is_whole && number != rint(number)))
        return vor_fail_param(
            err, VOR_E_PARAM, "quotas", "a quota is \"%s\", want %s=%s%.10g to %.10g", shown,
            info->name, info->is_whole ? "a whole number from " : "", info->least, info->most);
    memcpy((char *)out + info->offset, &number, sizeof number);
    return VOR_OK;
}

vor_status vor_key_line_read(struct vor_key_line *out, const char *line, struct vor_error *err)
{
    struct vor_key_line read = {
        .principal.quota = {.jobs = VOR_QUOTA_JOBS_DEFAULT, .rate = VOR_QUOTA_RATE_DEFAULT}};
    size_t name = strcspn(line, ":");
    const char *scopes = line + name + (line[name] == ':');
    size_t scopes_length = strcspn(scopes, ":");
    const char *digest = scopes + scopes_length + (scopes[scopes_length] == ':');
    size_t digest_length = strcspn(digest, ":");
    const char *quota;
    size_t word;
    vor_status status;

    if (line[name] != ':' || scopes[scopes_length] != ':')
        return vor_fail_param(err, VOR_E_PARAM, "line",
                              "the line has fewer than two colons, want NAME:SCOPES:SHA256, or "
                              "NAME:SCOPES:SHA256:QUOTAS");
    status = read_name(&read.principal, line, name, err);
    if (status == VOR_OK)
        status = read_scopes(&read.principal, scopes, scopes_length, err);
    if (status == VOR_OK)
        status = read_digest(read.digest, digest, digest_length, err);
    if (status == VOR_OK && digest[digest_length] == ':')
        for (quota = digest + digest_length + 1; *quota != '\0' && status == VOR_OK;
             quota += word + (quota[word] == ',')) {
            word = strcspn(quota, ",");
            status = read_quota(&read.principal.quota, quota, word, err);
        }
    if (status == VOR_OK)
        *out = read;
    return status;
}
