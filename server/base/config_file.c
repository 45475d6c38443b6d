#include "server/base/config_file.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const char blanks[] = " \t\r\n";

vor_status vor_config_file_blame(struct vor_error *err, const char *path, unsigned line)
{
    struct vor_error was = *err;

    return vor_fail_param(err, was.status, was.parameter, "%.200s line %u: %.700s", path, line,
                          was.message);
}

/* Cuts blanks off both ends. */
static char *trim(char *text)
{
    size_t size;

    text += strspn(text, blanks);
    size = strlen(text);
    while (size > 0 && strchr(blanks, text[size - 1]) != NULL)
        size--;
    text[size] = '\0';
    return text;
}

/* A control byte besides blanks, where an editor shows none. */
static int has_control(const char *text)
{
    for (; *text != '\0'; text++)
        if (((unsigned char)*text < ' ' && *text != '\t') || *text == 0x7f)
            return 1;
    return 0;
}

/* One line, which is changed. */
static vor_status take_line(char *line, unsigned number, const struct vor_config_lines *lines,
                            struct vor_error *err)
{
    char *name = trim(line), *equals = strchr(name, '=');

    if (name[0] == '\0' || name[0] == '#' || name[0] == ';')
        return VOR_OK;
    if (has_control(name))
        return vor_fail(err, VOR_E_PARAM, "the line has a control character, want name = value");
    if (equals == NULL || equals == name)
        return vor_fail(err, VOR_E_PARAM, "\"%.60s\" is not of the form name = value", name);
    *equals = '\0';
    return lines->take(lines->ctx, number, trim(name), trim(equals + 1), err);
}

vor_status vor_config_file_read(const char *path, int must_exist,
                                const struct vor_config_lines *lines, struct vor_error *err)
{
    FILE *file = fopen(path, "re");
    char line[VOR_CONFIG_LINE_MAX];
    vor_status status = VOR_OK;
    struct vor_error why;
    int is_cut = 0;

    if (file == NULL && !must_exist && (errno == ENOENT || errno == ENOTDIR))
        return VOR_OK;
    if (file == NULL)
        return vor_fail_param(err, VOR_E_PARAM, "config", "%.200s cannot be read: %s", path,
                              strerror(errno));
    for (unsigned number = 1; !is_cut && fgets(line, sizeof line, file) != NULL; number++) {
        is_cut = strchr(line, '\n') == NULL && !feof(file);
        status = is_cut
                     ? vor_fail(&why, VOR_E_PARAM, "the line has a NUL byte, or more than %d bytes",
                                VOR_CONFIG_LINE_MAX - 2)
                     : take_line(line, number, lines, &why);
        if (status == VOR_OK)
            continue;
        (void)vor_config_file_blame(&why, path, number);
        lines->fault(lines->ctx, &why);
    }
    status = ferror(file) ? vor_fail_param(err, VOR_E_PARAM, "config", "%.200s cannot be read: %s",
                                           path, strerror(errno))
                          : VOR_OK;
    (void)fclose(file);
    return status;
}

vor_status vor_config_file_value(char *out, size_t size, const char *variable, const char *path,
                                 struct vor_error *err)
{
    FILE *file = fopen(path, "re");
    size_t got;
    int failed;

    if (file == NULL)
        return vor_fail(err, VOR_E_PARAM, "%.60s is \"%.200s\", which cannot be read: %s", variable,
                        path, strerror(errno));
    got = fread(out, 1, size, file);
    failed = ferror(file);
    (void)fclose(file);
    if (failed)
        return vor_fail(err, VOR_E_PARAM, "%.60s is \"%.200s\", which cannot be read", variable,
                        path);
    if (got == size)
        return vor_fail(err, VOR_E_PARAM,
                        "%.60s: %.200s has %zu bytes or more, want a value of at "
                        "most %zu",
                        variable, path, size, size - 1);
    out[got] = '\0';
    if (got > 0 && out[got - 1] == '\n')
        out[--got] = '\0';
    if (got > 0 && out[got - 1] == '\r')
        out[--got] = '\0';
    if (strlen(out) != got || has_control(out))
        return vor_fail(err, VOR_E_PARAM,
                        "%.60s: %.200s holds a control byte (such as a line break), want a single "
                        "line without control bytes",
                        variable, path);
    return VOR_OK;
}
