#include "tests/support/vt_files.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS_MAX = 400, PIECES_MAX = 60, WORDS = 4096 };

/* What a table has said so far. */
struct table {
    struct vt_file rows[ROWS_MAX];
    int count;
    struct piece {
        const char *name, *text;
    } pieces[PIECES_MAX];
    int piece_count;
    struct vor_limits limits;
    unsigned format;
};

/* A table that cannot be read ends the program: no test runs yet that could fail. */
#define must(holds, ...) ((holds) ? (void)0 : (fprintf(stderr, __VA_ARGS__), exit(1)))

static void expand(const struct table *table, struct vt_file *file, const char *text, size_t length,
                   long number);

static void put(struct vt_file *file, const void *bytes, size_t size)
{
    must(vt_bytes_write(&file->bytes, bytes, size) == 0, "memory");
}

static void put_file(struct vt_file *file, const char *name, size_t length)
{
    char *path = strndup(name, length);
    size_t size;
    uint8_t *bytes = vt_slurp(path, &size);

    must(bytes != NULL, "%s: cannot read %s", file->name, path);
    put(file, bytes, size);
    free(bytes);
    free(path);
}

static void patch(const struct table *table, struct vt_file *file, size_t at, const char *text,
                  size_t length)
{
    struct vt_file over = {.name = file->name};

    expand(table, &over, text, length, 0);
    must(at + over.bytes.size <= file->bytes.size, "%s: {@%zu", file->name, at);
    memcpy(file->bytes.data + at, over.bytes.data, over.bytes.size);
    free(over.bytes.data);
}

/* What stands between { and }. */
static void directive(const struct table *table, struct vt_file *file, const char *text,
                      size_t length)
{
    char *end;
    long number = strtol(text + 1, &end, 10);
    size_t rest = length - (size_t)(end - text) - (*end == ':');

    if (*text == '^') {
        file->mark = end == text + 1 ? (int64_t)file->bytes.size : number;
    } else if (*text == '*') {
        for (long i = 0; i < number; i++)
            expand(table, file, end + 1, rest, i);
    } else if (*text == '@') {
        patch(table, file, (size_t)number, end + 1, rest);
    } else if (*text == '-') {
        file->bytes.size -= (size_t)number;
    } else if (*text == '<') {
        put_file(file, text + 1, length - 1);
    } else {
        int i = 0;

        while (i < table->piece_count && (strncmp(table->pieces[i].name, text, length) != 0 ||
                                          table->pieces[i].name[length] != '\0'))
            i++;
        must(i < table->piece_count, "%s: no piece {%.*s}", file->name, (int)length, text);
        expand(table, file, table->pieces[i].text, strlen(table->pieces[i].text), 0);
    }
}

/* The byte of an escape, whose length goes to *length. */
static char escaped(const char *text, size_t *length)
{
    static const char letters[] = "nrt\\0", bytes[] = "\n\r\t\\";
    const char *letter = strchr(letters, text[1]);
    char digits[3] = {0};

    *length = 2;
    if (text[1] != 'x') {
        must(letter != NULL, "escape \\%c", text[1]);
        return bytes[letter - letters];
    }
    memcpy(digits, text + 2, 2);
    *length = 4;
    return (char)strtol(digits, NULL, 16);
}

static void expand(const struct table *table, struct vt_file *file, const char *text, size_t length,
                   long number)
{
    size_t step;

    for (size_t i = 0; i < length; i += step) {
        char byte = text[i], digits[24];

        step = 1;
        if (byte == '{') {
            for (int depth = 1; depth > 0; step++)
                depth += (text[i + step] == '{') - (text[i + step] == '}');
            directive(table, file, text + i + 1, step - 2);
        } else if (byte == '#') {
            (void)snprintf(digits, sizeof digits, "%ld", number);
            put(file, digits, strlen(digits));
        } else {
            byte = byte == '\\' ? escaped(text + i, &step) : byte;
            put(file, &byte, 1);
        }
    }
}

static void set_limits(struct table *table, const char *line)
{
    const struct vor_limits fresh = VOR_LIMITS_DEFAULT;
    const char *points = strstr(line, "points=");

    table->limits = fresh;
    table->format = strstr(line, "[drc") != NULL ? VOR_FORMAT_DRC : VOR_FORMAT_PLY;
    if (points != NULL)
        table->limits.points = strtoul(points + 7, NULL, 10);
    table->limits.keep_faces = strstr(line, "faces") != NULL;
    table->limits.drop_invalid = strstr(line, "drop") != NULL;
    table->limits.strict_draco = strstr(line, "strict") != NULL;
}

static void add_row(struct table *table, char *line)
{
    struct vt_file *row = &table->rows[table->count++];
    char *want = strstr(line, " | "), *file = want != NULL ? strstr(want + 3, " | ") : NULL;

    must(file != NULL && table->count < ROWS_MAX, "row: %s", line);
    *want = *file = '\0';
    *row = (struct vt_file){line, want + 3, {0}, -1, table->format, table->limits};
    expand(table, row, file + 3, strlen(file + 3), 0);
    put(row, "", 1); /* which no reader sees */
    row->bytes.size--;
}

static void add_line(struct table *table, char *line)
{
    char *is = strstr(line, " = ");

    if (*line == '\0' || *line == '#')
        return;
    if (*line == '[') {
        set_limits(table, line);
    } else if (is != NULL && strstr(line, " | ") == NULL) {
        must(table->piece_count < PIECES_MAX, "too many pieces");
        *is = '\0';
        table->pieces[table->piece_count++] = (struct piece){line, is + 3};
    } else {
        add_row(table, line);
    }
}

static void read_table(struct table *table, const char *path)
{
    struct vt_bytes text = {0};
    size_t size;
    char *all = (char *)vt_slurp(path, &size), *line;

    must(all != NULL, "%s cannot be read", path);
    set_limits(table, "");
    for (size_t i = 0; i < size; i++) { /* a line that begins with blanks belongs to the last */
        if (i + 1 < size && all[i] == '\n' && all[i + 1] == ' ')
            i += 1 + strspn(all + i + 1, " ");
        must(vt_bytes_write(&text, &all[i], 1) == 0, "memory");
    }
    must(vt_bytes_write(&text, "", 1) == 0, "memory");
    free(all);
    all = (char *)text.data;
    while ((line = strsep(&all, "\n")) != NULL)
        add_line(table, line);
}

struct vt_file *vt_files(const char *const *paths, int path_count, int *count)
{
    static struct table table;

    for (int i = 0; i < path_count; i++)
        read_table(&table, paths[i]);
    *count = table.count;
    return table.rows;
}

static char words[WORDS];

static void add(const char *format, ...)
{
    size_t length = strlen(words);
    va_list args;

    va_start(args, format);
    ck_assert_int_lt(vsnprintf(words + length, WORDS - length, format, args),
                     (int)(WORDS - length));
    va_end(args);
}

static void add_value(const struct vor_attribute *attribute, size_t k)
{
    double value = vor_attribute_scalar(attribute, k);

    if (attribute->type == VOR_INT64)
        add(" %" PRId64, ((const int64_t *)attribute->data)[k]);
    else if (attribute->type == VOR_UINT64)
        add(" %" PRIu64, ((const uint64_t *)attribute->data)[k]);
    else if (value != value)
        add(" nan"); /* its sign is the machine's */
    else
        add(" %.*g",
            attribute->type == VOR_FLOAT64   ? 17
            : attribute->type == VOR_FLOAT32 ? 9
                                             : 10,
            value);
}

static void add_attribute(const struct vor_attribute *attribute, size_t n)
{
    static const char *const meanings[] = {"", "NORMAL ", "COLOR ", "TEX_COORD "};

    add("; %s%s %s", meanings[attribute->semantic], attribute->name,
        vor_type_name_sized(attribute->type));
    for (size_t k = 0; k < n * attribute->components; k++) {
        if (k > 0 && k % attribute->components == 0)
            add(",");
        add_value(attribute, k);
    }
}

const char *vt_cloud_words(const struct vor_cloud *cloud)
{
    const double *o = cloud->origin;
    int single = cloud->position_type == VOR_FLOAT32 && o[0] == 0 && o[1] == 0 && o[2] == 0;

    words[0] = '\0';
    add("%s", vor_type_name_sized(cloud->position_type));
    for (size_t i = 0; i < cloud->n; i++) {
        const float *xyz = cloud->xyz + 3 * i;
        double at[3];

        vor_cloud_position(cloud, i, at);
        for (int c = 0; c < 3; c++) /* 0 + -0 would be 0 */
            add(c == 0 && i > 0 ? ", %.*g" : " %.*g", single ? 9 : 17,
                single ? (double)xyz[c] : at[c]);
    }
    for (size_t a = 0; a < cloud->attribute_count; a++)
        add_attribute(&cloud->attributes[a], cloud->n);
    for (size_t t = 0; t < cloud->triangle_count; t++) {
        const uint32_t *corner = &cloud->triangles[3 * t];

        add("%s%u %u %u", t > 0 ? ", " : "; triangles ", corner[0], corner[1], corner[2]);
    }
    if (cloud->notes.faces > 0)
        add("; faces %" PRIu64, (uint64_t)cloud->notes.faces);
    if (cloud->notes.invalid > 0)
        add("; invalid %" PRIu64, (uint64_t)cloud->notes.invalid);
    for (unsigned i = 0; i < cloud->notes.dropped_count; i++)
        add("; dropped %s %" PRIu64, cloud->notes.dropped[i].what, cloud->notes.dropped[i].count);
    return words;
}
