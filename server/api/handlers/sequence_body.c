#include "core/base/quote.h"
#include "core/base/utf8.h"
#include "proto/codec.h"
#include "server/api/handlers/frames.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    FRAMES_MAX = 10000,
    SHOWN_SIZE = 64 /* of a name in a message */
};

static size_t stem_of(const char *name)
{
    const struct vor_format *format = vor_format_by_suffix(name);

    return strlen(name) - (format != NULL ? strlen(format->suffix) : 0);
}

static int has_suffix(const char *name, const char *suffix)
{
    size_t length = strlen(name), more = strlen(suffix);

    return length >= more && strcmp(name + length - more, suffix) == 0;
}

/* What a file gets in its place must have a name of its own, and the job may have this one. */
static vor_status check_name(const struct vor_sequence *sequence, const char *name,
                             struct vor_error *err)
{
    size_t stem = stem_of(name);
    char shown[SHOWN_SIZE];

    (void)vor_quote(shown, sizeof shown, name, strlen(name));
    if (vor_utf8_count(name) < 1 || stem < 1 ||
        strlen(name) + sizeof VOR_TOLD_SUFFIX - 1 > VOR_TAR_BASE_MAX)
        return vor_fail(err, VOR_E_REQUEST,
                        "a file is called \"%s\", want at most %d bytes of UTF-8 without control "
                        "characters",
                        shown, (int)(VOR_TAR_BASE_MAX - (sizeof VOR_TOLD_SUFFIX - 1)));
    for (size_t i = 0; i < sequence->count; i++)
        if (sequence->frames[i].stem == stem && memcmp(sequence->frames[i].name, name, stem) == 0)
            return vor_fail(
                err, VOR_E_REQUEST,
                "two files are called %s; the names must differ without folder and suffix", shown);
    return VOR_OK;
}

static vor_status begin_frame(struct vor_sequence *sequence, const char *name,
                              struct vor_error *err)
{
    vor_status status = check_name(sequence, name, err);
    struct vor_frame *frame;

    if (status != VOR_OK)
        return status;
    if (sequence->count == FRAMES_MAX)
        return vor_fail(err, VOR_E_REQUEST, "there are more than %d frames", (int)FRAMES_MAX);
    if (sequence->count == sequence->capacity) {
        size_t capacity = sequence->capacity > 0 ? 2 * sequence->capacity : 16;
        struct vor_frame *frames = realloc(sequence->frames, capacity * sizeof *frames);

        if (frames == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu frames", capacity);
        sequence->frames = frames;
        sequence->capacity = capacity;
    }
    frame = &sequence->frames[sequence->count++];
    *frame = (struct vor_frame){.stem = stem_of(name),
                                .offset = vor_blob_size(sequence->body.item[0].bytes)};
    memcpy(frame->name, name, strlen(name) + 1);
    vor_text_init(&frame->told, 0);
    sequence->is_open = true;
    return VOR_OK;
}

static vor_status on_data(void *ctx, const void *bytes, size_t size, struct vor_error *err)
{
    struct vor_sequence *sequence = ctx;

    if (sequence->is_passed)
        return VOR_OK;
    sequence->frames[sequence->count - 1].size += size;
    return vor_blob_append(sequence->body.item[0].bytes, bytes, size, err);
}

static vor_status on_end(void *ctx, VOR_UNUSED struct vor_error *err)
{
    struct vor_sequence *sequence = ctx;

    sequence->is_open = false;
    return VOR_OK;
}

/* Files that are no frames: what macOS puts beside each, and what we tell of one. */
static vor_status on_file(void *ctx, const char *path, VOR_UNUSED uint64_t size,
                          struct vor_error *err)
{
    struct vor_sequence *sequence = ctx;
    const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path;

    sequence->is_passed = name[0] == '.' || has_suffix(name, VOR_TOLD_SUFFIX);
    return sequence->is_passed ? VOR_OK : begin_frame(sequence, name, err);
}

static vor_status on_part(void *ctx, const struct vor_multipart_part *part, struct vor_error *err)
{
    struct vor_sequence *sequence = ctx;
    char name[16];

    if (!part->is_file || part->coding[0] != '\0')
        return vor_fail_param(err, VOR_E_PARAM, part->name,
                              "%s is %s, but each part of the form must be the file of a frame; "
                              "parameters are in the query",
                              part->name, part->is_file ? "encoded" : "a text");
    (void)snprintf(name, sizeof name, "%04zu", sequence->count + 1);
    return begin_frame(sequence, name, err);
}

vor_status vor_sequence_begin_body(struct vor_sequence *sequence, struct vor_error *err)
{
    const struct vor_multipart_events of_form = {sequence, on_part, on_data, on_end};
    const struct vor_tar_events of_tar = {sequence, on_file, on_data, on_end};

    if (sequence->head.body == VOR_SUBMIT_FORM)
        return vor_multipart_begin(&sequence->scanner.form,
                                   vor_request_header(sequence->request, "Content-Type"), &of_form,
                                   err);
    vor_tar_begin(&sequence->scanner.tar, &of_tar);
    return VOR_OK;
}

vor_status vor_sequence_feed(struct vor_sequence *sequence, const void *bytes, size_t size,
                             struct vor_error *err)
{
    return sequence->head.body == VOR_SUBMIT_FORM
               ? vor_multipart_feed(&sequence->scanner.form, bytes, size, err)
               : vor_tar_feed(&sequence->scanner.tar, bytes, size, err);
}

vor_status vor_sequence_finish(const struct vor_sequence *sequence, struct vor_error *err)
{
    vor_status status = sequence->head.body == VOR_SUBMIT_FORM
                            ? vor_multipart_finish(&sequence->scanner.form, err)
                            : vor_tar_finish(&sequence->scanner.tar, err);

    if (status == VOR_OK && sequence->count == 0)
        status = vor_fail(err, VOR_E_EMPTY, "there is no frame");
    return status;
}
