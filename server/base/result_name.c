#include "server/base/result_name.h"

#include "core/base/utf8.h"
#include "proto/codec.h"

#include <stdio.h>
#include <string.h>

enum { STEM_MAX = 160 /* bytes */ };

void vor_result_name(char out[VOR_RESULT_NAME_SIZE], const char *name, const char *id,
                     const char *process, const char *output, const char *suffix)
{
    const char *slash = strrchr(name, '/'), *back = strrchr(name, '\\');
    const struct vor_format *format;
    size_t length, at = 0, bytes;
    char stem[STEM_MAX + 1]; /* what of the job's name can begin the name of a file */

    if (back != NULL && (slash == NULL || back > slash))
        slash = back;
    name = slash != NULL ? slash + 1 : name;
    format = vor_format_by_suffix(name);
    length = strlen(name) - (format != NULL ? strlen(format->suffix) : 0);
    for (; length > 0 && *name == '.'; name++)
        length--;
    for (; at < length; at += bytes) {
        bytes = vor_utf8_length((const unsigned char *)name + at, length - at);
        bytes = bytes > 0 ? bytes : 1;
        if (at + bytes > STEM_MAX)
            break;
        memcpy(stem + at, name + at, bytes);
        if ((unsigned char)stem[at] < 0x20 || strchr("\x7f<>:\"|?*", stem[at]) != NULL)
            stem[at] = '_';
    }
    stem[at] = '\0';
    (void)snprintf(out, VOR_RESULT_NAME_SIZE, "%s.%s%s", stem[0] != '\0' ? stem : id,
                   strcmp(output, "cloud") == 0 ? process : output, suffix);
}
