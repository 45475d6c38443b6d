#include "server/cli/files.h"

#include "core/report.h"
#include "proto/json/json.h"
#include "server/cli/cli_log.h"

#include <stdio.h>
#include <string.h>

/* Documents that are told in lines. That of measure is JSON even so: programs have read it since
 * before there were lines. */
static const char *const documents[] = {"inspect"};

/* Digits of a number: a count is shown whole. */
enum {
    REAL_DIGITS = 6,
    PLACE_DIGITS = 10,
    COUNT_DIGITS = 17,
    NAME_SIZE = 64 /* of a member, with the NUL */
};

int vor_lines_wanted(const struct vor_cli *cli)
{
    const char *name = cli->spec.process->outputs[0].name;

    if (cli->option[VOR_OPTION_JSON] != NULL || strcmp(cli->option[VOR_OPTION_OUTPUT], "-") != 0)
        return 0;
    for (size_t i = 0; i < sizeof documents / sizeof documents[0]; i++)
        if (strcmp(documents[i], name) == 0)
            return 1;
    return 0;
}

/* The member of a name with dots; NULL where there is none. */
static const struct vor_json *find(const struct vor_json *object, const char *name)
{
    char part[NAME_SIZE];

    while (object != NULL && name[0] != '\0') {
        size_t length = strcspn(name, ".");

        (void)snprintf(part, sizeof part, "%.*s", (int)length, name);
        object = vor_json_get(object, part);
        name += length + (name[length] == '.');
    }
    return object;
}

/* What is not finite is null in JSON. */
static void add_value(struct vor_text *out, const struct vor_json *value, int digits)
{
    const char *word = vor_json_get_string(value);
    double number;

    if (word == NULL && vor_json_get_number(value, &number))
        vor_text_printf(out, "%.*g", digits, number);
    else if (word == NULL)
        vor_text_puts(out, "none");
    for (size_t size; word != NULL && *word != '\0'; word += size > 0 ? size : 1) {
        size = vor_cli_control(word);
        vor_text_add(out, size > 0 ? "?" : word, 1);
    }
}

static void add_line_value(struct vor_text *out, const struct vor_member *row,
                           const struct vor_json *value)
{
    if (row->kind == VOR_MEMBER_VECTOR) {
        /* "x y z", with as many digits as a place far from zero needs. */
        add_value(out, vor_json_get(value, "x"), PLACE_DIGITS);
        vor_text_puts(out, " ");
        add_value(out, vor_json_get(value, "y"), PLACE_DIGITS);
        vor_text_puts(out, " ");
        add_value(out, vor_json_get(value, "z"), PLACE_DIGITS);
    } else if (row->kind == VOR_MEMBER_LIST) {
        const struct vor_json *element = vor_json_first(value);

        /* "normal float32 3, intensity uint16 1", or "none". */
        if (element == NULL)
            vor_text_puts(out, "none");
        for (; element != NULL; element = vor_json_next(element)) {
            for (unsigned i = 0; i < row->inner->count; i++) {
                vor_text_puts(out, i > 0 ? " " : "");
                add_value(out, vor_json_get(element, row->inner->rows[i].name), COUNT_DIGITS);
            }
            vor_text_puts(out, vor_json_next(element) != NULL ? ", " : "");
        }
    } else {
        add_value(out, value, row->kind == VOR_MEMBER_REAL ? REAL_DIGITS : COUNT_DIGITS);
    }
    vor_text_printf(out, "%s%s", row->unit[0] != '\0' ? " " : "", row->unit);
}

static void add_line(struct vor_text *out, const char *name, const struct vor_member *row,
                     const struct vor_json *value)
{
    vor_text_printf(out, "%-24s", name);
    add_line_value(out, row, value);
    vor_text_puts(out, "\n");
}

/* A line for each element of such a list: "loops.1  length 6.28 unit of the cloud, points 40 ...".
 */
static void add_elements(struct vor_text *out, const struct vor_member *row,
                         const struct vor_json *value)
{
    for (const struct vor_json *element = vor_json_first(value); element != NULL;
         element = vor_json_next(element)) {
        char name[2 * NAME_SIZE];
        double id = 0;

        (void)vor_json_get_number(vor_json_get(element, "id"), &id);
        (void)snprintf(name, sizeof name, "%s.%.*g", row->name, COUNT_DIGITS, id);
        vor_text_printf(out, "%-24s", name);
        for (unsigned i = 1; i < row->inner->count; i++) {
            const struct vor_member *inner = &row->inner->rows[i];

            vor_text_printf(out, "%s%s ", i > 1 ? ", " : "", inner->name);
            add_line_value(out, inner, vor_json_get(element, inner->name));
        }
        vor_text_puts(out, "\n");
    }
}

/* A line for a member; for each of its own, if it is an object with a table, and for each element
 * that has an id. */
static void add_member(struct vor_text *out, const struct vor_member *row,
                       const struct vor_json *value)
{
    char name[2 * NAME_SIZE];

    if (row->kind == VOR_MEMBER_LIST && strcmp(row->inner->rows[0].name, "id") == 0 &&
        vor_json_first(value) != NULL) { /* whose elements have ids */
        add_elements(out, row, value);
        return;
    }
    if (row->kind != VOR_MEMBER_OBJECT) {
        add_line(out, row->name, row, value);
        return;
    }
    for (unsigned i = 0; i < row->inner->count; i++) {
        const struct vor_member *inner = &row->inner->rows[i];

        (void)snprintf(name, sizeof name, "%s.%s", row->name, inner->name);
        add_line(out, name, inner, vor_json_get(value, inner->name));
    }
}

vor_status vor_lines_from_json(struct vor_text *text, const struct vor_cli *cli,
                               struct vor_error *err)
{
    const struct vor_members *members = vor_document_members(cli->spec.process->outputs[0].name);
    struct vor_json *json = NULL;
    struct vor_text lines;
    vor_status status =
        vor_json_parse(&json, text->data != NULL ? text->data : "", text->size, err);

    vor_text_init(&lines, 0);
    for (unsigned i = 0; status == VOR_OK && i < members->count; i++) {
        const struct vor_json *value = find(json, members->rows[i].name);

        if (value != NULL && members->rows[i].kind != VOR_MEMBER_OPTIONAL)
            add_member(&lines, &members->rows[i], value);
    }
    VOR_THEN(status, vor_text_status(&lines, err));
    if (status == VOR_OK) {
        struct vor_text whole = *text;

        *text = lines;
        lines = whole;
    }
    vor_text_free(&lines);
    vor_json_free(json);
    return status;
}
