#include "server/base/keys.h"

#include "core/base/quote.h"
#include "server/base/base64.h"
#include "server/base/disk.h"
#include "server/base/log.h"
#include "server/base/option.h"
#include "server/base/uuid.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum {
    RANDOM_BYTES = 24,
    SHOWN_SIZE = 64 /* of what the file says, in a message */
};

_Static_assert(sizeof VOR_KEY_PREFIX - 1 + VOR_BASE64_SIZE(RANDOM_BYTES) == VOR_KEY_SIZE,
               "a key is its prefix and the text of its random bytes");

struct key_line {
    struct vor_principal principal;
    uint8_t digest[VOR_DIGEST_BYTES]; /* of the key */
};

/* The keys of one reading of the file. */
struct list {
    struct key_line *lines; /* owned */
    size_t count, capacity;
};

struct vor_keys {
    char *path;
    pthread_rwlock_t lock; /* over list */
    struct list list;
};

/* --- reading ---------------------------------------------------------------------------------- */

static vor_status read_name(struct vor_principal *out, const char *text, size_t length,
                            struct vor_error *err)
{
    static const char allowed[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";

    if (length < 1 || length > VOR_KEY_NAME_MAX || strspn(text, allowed) < length)
        return vor_fail_param(err, VOR_E_PARAM, "name",
                              "the name is \"%s\", want 1 to %d letters, digits, dots, dashes and "
                              "underscores",
                              VOR_QUOTED(SHOWN_SIZE, text, length), VOR_KEY_NAME_MAX);
    memcpy(out->name, text, length);
    out->name[length] = '\0';
    return VOR_OK;
}

static vor_status read_scopes(struct vor_principal *out, const char *text, size_t length,
                              struct vor_error *err)
{
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
                                  VOR_QUOTED(SHOWN_SIZE, text, length));
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

static vor_status read_quota(struct vor_quota *out, const char *text, size_t length,
                             struct vor_error *err)
{
    const struct quota_info *info = NULL;
    char shown[SHOWN_SIZE];
    size_t name = 0;
    double number;

    for (size_t i = 0; i < QUOTAS && info == NULL; i++) {
        name = strlen(quota_infos[i].name) + 1;
        if (length >= name && memcmp(text, quota_infos[i].name, name - 1) == 0 &&
            text[name - 1] == '=')
            info = &quota_infos[i];
    }
    vor_quote(shown, sizeof shown, text, length);
    if (info == NULL)
        return vor_fail_param(err, VOR_E_PARAM, "quotas",
                              "a quota is \"%s\", want jobs=N, rate=N, bytes=N or points=N", shown);
    number = vor_number_read(text + name, length - name, 1);
    if (!(number >= info->least && number <= info->most) ||
        (info->is_whole && number != rint(number)))
        return vor_fail_param(
            err, VOR_E_PARAM, "quotas", "a quota is \"%s\", want %s=%s%.10g to %.10g", shown,
            info->name, info->is_whole ? "a whole number from " : "", info->least, info->most);
    memcpy((char *)out + info->offset, &number, sizeof number);
    return VOR_OK;
}

/* Reads NAME:SCOPES:SHA256[:QUOTAS], without blanks around it. No message holds what may be a key.
 */
static vor_status read_line(struct key_line *out, const char *line, struct vor_error *err)
{
    struct key_line read = {
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
    VOR_THEN(status, read_scopes(&read.principal, scopes, scopes_length, err));
    VOR_THEN(status, read_digest(read.digest, digest, digest_length, err));
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

/* A line of the file, with whatever ends it. */
static vor_status take_line(struct list *list, char *text, struct vor_error *err)
{
    struct key_line line;
    vor_status status;

    text = vor_trim(text);
    if (text[0] == '\0' || text[0] == '#')
        return VOR_OK;
    status = read_line(&line, text, err);
    if (status != VOR_OK)
        return status;
    for (size_t i = 0; i < list->count; i++)
        if (vor_digest_same(list->lines[i].digest, line.digest))
            return vor_fail(err, VOR_E_PARAM, "an earlier line has the same digest");
    if (list->count == VOR_KEYS_MAX)
        return vor_fail(err, VOR_E_PARAM, "there are more than %d keys", VOR_KEYS_MAX);
    if (list->count == list->capacity) {
        size_t capacity = list->capacity > 0 ? 2 * list->capacity : 16;
        struct key_line *lines = realloc(list->lines, capacity * sizeof *lines);

        if (lines == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu keys", capacity);
        list->lines = lines;
        list->capacity = capacity;
    }
    list->lines[list->count++] = line;
    return VOR_OK;
}

static vor_status read_lines(struct list *list, const char *path, FILE *file, struct vor_error *err)
{
    char text[VOR_KEY_LINE_SIZE];
    unsigned number = 0;
    struct vor_error why;
    vor_status status = VOR_OK;

    while (status == VOR_OK && fgets(text, sizeof text, file) != NULL) {
        number++;
        if (strchr(text, '\n') == NULL && !feof(file))
            status = vor_fail(&why, VOR_E_PARAM,
                              "the line has more than %d bytes, or a NUL "
                              "byte",
                              VOR_KEY_LINE_SIZE - 2);
        else
            status = take_line(list, text, &why);
        if (status != VOR_OK)
            status = vor_fail(err, status, "%s, line %u: %s", path, number, why.message);
    }
    if (status == VOR_OK && ferror(file))
        status = vor_fail_errno(err, errno, path);
    else if (status == VOR_OK && list->count == 0)
        status = vor_fail(err, VOR_E_PARAM, "%s has no key; voronoid key NAME makes one", path);
    return status;
}

static vor_status read_file(struct list *out, const char *path, struct vor_error *err)
{
    struct list list = {.lines = NULL};
    FILE *file = fopen(path, "re");
    vor_status status;

    if (file == NULL)
        return vor_fail_errno(err, errno, path);
    status = read_lines(&list, path, file, err);
    if (status == VOR_OK) {
        struct stat info;
        char mode[8];

        if (fstat(fileno(file), &info) == 0 &&
            (info.st_mode & (S_IRGRP | S_IROTH | S_IWGRP | S_IWOTH)) != 0) {
            (void)snprintf(mode, sizeof mode, "%04o", (unsigned)info.st_mode & 07777u);
            vor_log(VOR_LOG_WARN, "other users may read or write the file of keys",
                    VOR_TEXT("path", path), VOR_TEXT("mode", mode), VOR_TEXT("want", "0600"));
        }
    }
    (void)fclose(file);
    if (status == VOR_OK)
        *out = list;
    else
        free(list.lines);
    return status;
}

/* --- the keys --------------------------------------------------------------------------------- */

vor_status vor_keys_open(struct vor_keys **out, const char *path, struct vor_error *err)
{
    struct vor_keys *keys = calloc(1, sizeof *keys);
    vor_status status;

    if (keys == NULL || (keys->path = strdup(path)) == NULL) {
        free(keys);
        return vor_fail(err, VOR_E_NOMEM, "the keys");
    }
    (void)pthread_rwlock_init(&keys->lock, NULL);
    status = read_file(&keys->list, path, err);
    if (status == VOR_OK)
        *out = keys;
    else
        vor_keys_close(keys);
    return status;
}

void vor_keys_close(struct vor_keys *keys)
{
    if (keys == NULL)
        return;
    (void)pthread_rwlock_destroy(&keys->lock);
    free(keys->list.lines);
    free(keys->path);
    free(keys);
}

vor_status vor_keys_reload(struct vor_keys *keys, struct vor_error *err)
{
    struct list fresh, former;
    vor_status status;

    if (keys == NULL)
        return VOR_OK;
    status = read_file(&fresh, keys->path, err);
    if (status != VOR_OK)
        return status;
    (void)pthread_rwlock_wrlock(&keys->lock);
    former = keys->list;
    keys->list = fresh;
    (void)pthread_rwlock_unlock(&keys->lock);
    free(former.lines);
    vor_log(VOR_LOG_INFO, "keys read", VOR_TEXT("path", keys->path),
            VOR_COUNT("keys", fresh.count));
    return VOR_OK;
}

bool vor_keys_find(struct vor_keys *keys, const char *key, struct vor_principal *out)
{
    size_t length = strnlen(key, VOR_KEY_SENT_MAX + 1);
    uint8_t digest[VOR_DIGEST_BYTES];
    bool found = false;

    if (length == 0 || length > VOR_KEY_SENT_MAX)
        return false;
    vor_digest_of(key, length, digest);
    (void)pthread_rwlock_rdlock(&keys->lock);
    for (size_t i = 0; i < keys->list.count; i++)
        if (vor_digest_same(keys->list.lines[i].digest, digest)) {
            *out = keys->list.lines[i].principal;
            found = true;
        }
    (void)pthread_rwlock_unlock(&keys->lock);
    return found;
}

/* --- a new one -------------------------------------------------------------------------------- */

vor_status vor_key_make(const char *name, const char *scopes, const char *quotas,
                        char key[VOR_KEY_SIZE], char line[VOR_KEY_LINE_SIZE], struct vor_error *err)
{
    char text[VOR_KEY_SIZE], digest[VOR_DIGEST_SIZE];
    struct key_line read;
    uint8_t bytes[RANDOM_BYTES];
    vor_status status = vor_random_fill(bytes, sizeof bytes, err);
    int length;

    if (status != VOR_OK)
        return status;
    memcpy(text, VOR_KEY_PREFIX, sizeof VOR_KEY_PREFIX - 1);
    vor_base64_write(bytes, sizeof bytes, text + sizeof VOR_KEY_PREFIX - 1);
    vor_digest_text(text, strlen(text), digest);
    length = snprintf(line, VOR_KEY_LINE_SIZE, "%s:%s:%s%s%s", name, scopes, digest,
                      quotas != NULL ? ":" : "", quotas != NULL ? quotas : "");
    if (length < 0 || length >= VOR_KEY_LINE_SIZE - 1)
        return vor_fail_param(
            err, VOR_E_PARAM, "line",
            "name, scopes and quotas are too long: a line may have at most %d bytes",
            VOR_KEY_LINE_SIZE - 2);
    status = read_line(&read, line, err);
    if (status == VOR_OK)
        memcpy(key, text, sizeof text);
    return status;
}
