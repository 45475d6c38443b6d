#include "proto/tar.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

/* A field of the header: where it begins, and its bytes. */
struct field {
    size_t at, size;
};

static const struct field name_field = {0, 100}, mode_field = {100, 8}, owner_field = {108, 8},
                          group_field = {116, 8}, size_field = {124, 12}, time_field = {136, 12},
                          sum_field = {148, 8}, type_field = {156, 1}, magic_field = {257, 8},
                          prefix_field = {345, 155};

#define SIZE_MAX_READ ((uint64_t)1 << 62)

static vor_status refuse(const struct vor_tar *scanner, const char *what, struct vor_error *err)
{
    (void)vor_fail(err, VOR_E_REQUEST, "the tar archive is damaged at byte %llu: %s",
                   (unsigned long long)scanner->header_at, what);
    return vor_fail_at(err, VOR_E_REQUEST, scanner->header_at);
}

size_t vor_tar_filler(uint64_t size)
{
    return (size_t)((VOR_TAR_BLOCK - size % VOR_TAR_BLOCK) % VOR_TAR_BLOCK);
}

/* Octal digits among spaces and zeros or, of GNU tar, a binary number. 0 when it is neither. */
static int read_number(const uint8_t *header, struct field field, uint64_t *out)
{
    const uint8_t *at = header + field.at, *end = at + field.size;

    *out = 0;
    if (*at == 0x80) {
        while (++at < end) {
            if (*out >= SIZE_MAX_READ >> 8)
                return 0;
            *out = *out << 8 | *at;
        }
        return 1;
    }
    while (at < end && *at == ' ')
        at++;
    for (; at < end && *at >= '0' && *at <= '7'; at++)
        *out = *out << 3 | (uint64_t)(*at - '0'); /* of 12 digits at most */
    return at == end || *at == ' ' || *at == '\0';
}

/* The sum of the bytes, those of the sum itself taken for spaces. */
static uint64_t sum_of(const uint8_t header[VOR_TAR_BLOCK])
{
    uint64_t sum = 0;

    for (size_t i = 0; i < VOR_TAR_BLOCK; i++)
        sum += i - sum_field.at < sum_field.size ? ' ' : header[i];
    return sum;
}

static void skip(struct vor_tar *scanner, uint64_t bytes)
{
    scanner->left = bytes;
    scanner->state = bytes > 0 ? VOR_TAR_SKIP : VOR_TAR_HEADER;
}

static vor_status end_file(struct vor_tar *scanner, struct vor_error *err)
{
    vor_status status = scanner->events.end(scanner->events.ctx, err);

    skip(scanner, scanner->filler);
    return status;
}

static vor_status begin_file(struct vor_tar *scanner, uint64_t size, struct vor_error *err)
{
    const char *name = (const char *)scanner->header + name_field.at,
               *prefix = (const char *)scanner->header + prefix_field.at;
    size_t name_size = strnlen(name, name_field.size),
           prefix_size = strnlen(prefix, prefix_field.size);
    vor_status status;

    if (memcmp(scanner->header + magic_field.at, "ustar\0", 6) != 0)
        prefix_size = 0;            /* of another format */
    if (scanner->path[0] == '\0') { /* which a header before has not said */
        if (prefix_size + 1 + name_size > VOR_TAR_NAME_MAX)
            return refuse(scanner, "the name of a file is too long", err);
        (void)snprintf(scanner->path, sizeof scanner->path, "%.*s%s%.*s", (int)prefix_size, prefix,
                       prefix_size > 0 ? "/" : "", (int)name_size, name);
    }
    status = scanner->path[0] == '\0'
                 ? refuse(scanner, "a file has no name", err)
                 : scanner->events.file(scanner->events.ctx, scanner->path, size, err);
    scanner->path[0] = '\0';
    if (status != VOR_OK)
        return status;
    scanner->state = VOR_TAR_FILE;
    scanner->left = size;
    scanner->filler = vor_tar_filler(size);
    return size > 0 ? VOR_OK : end_file(scanner, err);
}

static vor_status set_path(struct vor_tar *scanner, const char *value, size_t size,
                           struct vor_error *err)
{
    if (size > VOR_TAR_NAME_MAX || memchr(value, '\0', size) != NULL)
        return refuse(scanner, "the name of a file is too long", err);
    memcpy(scanner->path, value, size);
    scanner->path[size] = '\0';
    return VOR_OK;
}

static vor_status set_size(struct vor_tar *scanner, const char *value, size_t size,
                           struct vor_error *err)
{
    scanner->size = 0;
    scanner->has_size = size > 0 && size < 19;
    for (size_t i = 0; i < size && scanner->has_size; i++) {
        scanner->has_size = value[i] >= '0' && value[i] <= '9';
        scanner->size = 10 * scanner->size + (uint64_t)(value[i] - '0');
    }
    return scanner->has_size ? VOR_OK : refuse(scanner, "a size is not a number", err);
}

/* A record of pax: "LENGTH KEYWORD=VALUE\n", of which LENGTH counts every byte. Returns its length,
 * 0 after a failure. */
static size_t take_record(struct vor_tar *scanner, const char *at, size_t left,
                          struct vor_error *err)
{
    size_t length = 0, digits = 0;
    const char *equals, *end;
    vor_status status = VOR_OK;

    while (digits < left && digits < 5 && at[digits] >= '0' && at[digits] <= '9')
        length = 10 * length + (size_t)(at[digits++] - '0');
    if (digits == 0 || length > left || length < digits + 3 || at[digits] != ' ' ||
        at[length - 1] != '\n') {
        (void)refuse(scanner, "a header of pax has no records", err);
        return 0;
    }
    end = at + length - 1;
    at += digits + 1;
    equals = memchr(at, '=', (size_t)(end - at));
    if (equals == NULL)
        status = refuse(scanner, "a header of pax has no records", err);
    else if (equals - at == 4 && memcmp(at, "path", 4) == 0)
        status = set_path(scanner, equals + 1, (size_t)(end - equals - 1), err);
    else if (equals - at == 4 && memcmp(at, "size", 4) == 0)
        status = set_size(scanner, equals + 1, (size_t)(end - equals - 1), err);
    return status == VOR_OK ? length : 0;
}

static vor_status end_extended(struct vor_tar *scanner, struct vor_error *err)
{
    size_t at = 0, size = scanner->have;

    scanner->have = 0;
    skip(scanner, scanner->filler);
    if (scanner->is_gnu)
        return set_path(scanner, scanner->extended, strnlen(scanner->extended, size), err);
    while (at < size) {
        size_t length = take_record(scanner, scanner->extended + at, size - at, err);

        if (length == 0)
            return VOR_E_REQUEST;
        at += length;
    }
    return VOR_OK;
}

static vor_status take_header(struct vor_tar *scanner, struct vor_error *err)
{
    const uint8_t *header = scanner->header;
    uint64_t size, sum;
    char type = (char)header[type_field.at];

    scanner->have = 0;
    if (header[0] == 0 && memcmp(header, header + 1, VOR_TAR_BLOCK - 1) == 0) {
        scanner->state = VOR_TAR_CLOSED;
        return VOR_OK;
    }
    if (!read_number(header, sum_field, &sum) || sum != sum_of(header))
        return refuse(scanner, "this is not the header of a file", err);
    if (!read_number(header, size_field, &size) || size > SIZE_MAX_READ)
        return refuse(scanner, "a size is not a number", err);
    if (type == 'x' || type == 'L') {
        if (size > VOR_TAR_EXTENDED_MAX)
            return refuse(scanner, "a header is too long", err);
        scanner->state = VOR_TAR_EXTENDED;
        scanner->is_gnu = type == 'L';
        scanner->left = size;
        scanner->filler = vor_tar_filler(size);
        return size > 0 ? VOR_OK : end_extended(scanner, err);
    }
    if (scanner->has_size && type != 'g' && type != 'K')
        size = scanner->size;
    if (type == '0' || type == '\0' || type == '7') {
        scanner->has_size = 0;
        return begin_file(scanner, size, err);
    }
    if (type != 'g' && type != 'K') { /* these two stand before the header of something */
        scanner->has_size = 0;
        scanner->path[0] = '\0';
    }
    /* Links, devices and folders have no bytes, whatever their size says. */
    skip(scanner, type >= '1' && type <= '6' ? 0 : size + vor_tar_filler(size));
    return VOR_OK;
}

/* Takes up to `size` bytes, as many as the state has use for at once; *taken is how many. */
static vor_status step(struct vor_tar *scanner, const char *bytes, size_t size, size_t *taken,
                       struct vor_error *err)
{
    uint64_t most = scanner->state == VOR_TAR_HEADER   ? VOR_TAR_BLOCK - scanner->have
                    : scanner->state == VOR_TAR_CLOSED ? size
                                                       : scanner->left;
    vor_status status = VOR_OK;

    size = size < most ? size : (size_t)most;
    *taken = size;
    switch (scanner->state) {
    case VOR_TAR_HEADER:
        if (scanner->have == 0)
            scanner->header_at = scanner->offset;
        memcpy(scanner->header + scanner->have, bytes, size);
        scanner->have += size;
        return scanner->have == VOR_TAR_BLOCK ? take_header(scanner, err) : VOR_OK;
    case VOR_TAR_FILE:
        scanner->left -= size;
        status = scanner->events.data(scanner->events.ctx, bytes, size, err);
        return status == VOR_OK && scanner->left == 0 ? end_file(scanner, err) : status;
    case VOR_TAR_EXTENDED:
        memcpy(scanner->extended + scanner->have, bytes, size);
        scanner->have += size;
        scanner->left -= size;
        return scanner->left == 0 ? end_extended(scanner, err) : VOR_OK;
    case VOR_TAR_SKIP:
        skip(scanner, scanner->left - size);
        return VOR_OK;
    case VOR_TAR_CLOSED:
        break;
    }
    return VOR_OK;
}

void vor_tar_begin(struct vor_tar *scanner, const struct vor_tar_events *events)
{
    memset(scanner, 0, sizeof *scanner);
    scanner->events = *events;
}

vor_status vor_tar_feed(struct vor_tar *scanner, const void *bytes, size_t size,
                        struct vor_error *err)
{
    const char *at = bytes;

    while (size > 0) {
        size_t taken;
        vor_status status = step(scanner, at, size, &taken, err);

        if (status != VOR_OK)
            return status;
        scanner->offset += taken;
        at += taken;
        size -= taken;
    }
    return VOR_OK;
}

vor_status vor_tar_finish(const struct vor_tar *scanner, struct vor_error *err)
{
    if (scanner->state == VOR_TAR_CLOSED ||
        (scanner->state == VOR_TAR_HEADER && scanner->have == 0 && scanner->path[0] == '\0'))
        return VOR_OK;
    return refuse(scanner, "it ends in the middle of a file", err);
}

/* Octal digits and a NUL. */
static void put_number(uint8_t *header, struct field field, uint64_t value)
{
    (void)snprintf((char *)header + field.at, field.size, "%0*llo", (int)field.size - 1,
                   (unsigned long long)value);
}

void vor_tar_header(uint8_t out[VOR_TAR_BLOCK], const char *name, uint64_t size)
{
    static const char magic[] = {'u', 's', 't', 'a', 'r', '\0', '0', '0'};

    assert(name[0] != '\0' && strlen(name) <= VOR_TAR_BASE_MAX);
    memset(out, 0, VOR_TAR_BLOCK);
    (void)snprintf((char *)out + name_field.at, name_field.size, "%s", name);
    put_number(out, mode_field, 0644);
    put_number(out, owner_field, 0);
    put_number(out, group_field, 0);
    put_number(out, size_field, size);
    put_number(out, time_field, 0);
    out[type_field.at] = '0';
    memcpy(out + magic_field.at, magic, sizeof magic);
    (void)snprintf((char *)out + sum_field.at, sum_field.size - 1, "%06o", (unsigned)sum_of(out));
    out[sum_field.at + 7] = ' ';
}
