/* The contract as JSON, for programs that read no YAML: made while we build, so that nothing that
 * runs parses YAML. usage: yaml_to_json <openapi.yaml >openapi.json. Reads with libyaml, which
 * knows all of YAML; aliases it has resolved already. Ends with 1 and a line where the input is not
 * YAML. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

static void write_string(const char *text, size_t length)
{
    putchar('"');
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];

        if (c == '"' || c == '\\')
            printf("\\%c", c);
        else if (c < 0x20)
            printf("\\u%04x", c);
        else
            putchar(c);
    }
    putchar('"');
}

/* A number as JSON has it: what else looks like one to somebody stays text. */
static int is_number(const char *text)
{
    size_t digits;

    text += *text == '-';
    digits = strspn(text, "0123456789");
    if (digits == 0 || (*text == '0' && digits > 1))
        return 0;
    text += digits;
    if (*text == '.') {
        digits = strspn(++text, "0123456789");
        if (digits == 0)
            return 0;
        text += digits;
    }
    if (*text == 'e' || *text == 'E') {
        text++;
        text += *text == '-' || *text == '+';
        digits = strspn(text, "0123456789");
        if (digits == 0)
            return 0;
        text += digits;
    }
    return *text == '\0';
}

/* Plain words have the types of YAML 1.2's JSON schema; what is quoted is text. */
static void write_scalar(const yaml_node_t *node)
{
    const char *text = (const char *)node->data.scalar.value;
    int is_plain = node->data.scalar.style == YAML_PLAIN_SCALAR_STYLE;

    if (is_plain && (strcmp(text, "true") == 0 || strcmp(text, "false") == 0 ||
                     strcmp(text, "null") == 0 || is_number(text)))
        fputs(text, stdout);
    else
        write_string(text, node->data.scalar.length);
}

static void write_node(yaml_document_t *document, int index)
{
    const yaml_node_t *node = yaml_document_get_node(document, index);

    switch (node->type) {
    case YAML_MAPPING_NODE:
        putchar('{');
        for (const yaml_node_pair_t *pair = node->data.mapping.pairs.start;
             pair < node->data.mapping.pairs.top; pair++) {
            const yaml_node_t *key = yaml_document_get_node(document, pair->key);

            if (pair > node->data.mapping.pairs.start)
                putchar(',');
            write_string((const char *)key->data.scalar.value, key->data.scalar.length);
            putchar(':');
            write_node(document, pair->value);
        }
        putchar('}');
        break;
    case YAML_SEQUENCE_NODE:
        putchar('[');
        for (const yaml_node_item_t *item = node->data.sequence.items.start;
             item < node->data.sequence.items.top; item++) {
            if (item > node->data.sequence.items.start)
                putchar(',');
            write_node(document, *item);
        }
        putchar(']');
        break;
    default:
        write_scalar(node);
    }
}

int main(void)
{
    yaml_parser_t parser;
    yaml_document_t document;

    if (!yaml_parser_initialize(&parser))
        return 1;
    yaml_parser_set_input_file(&parser, stdin);
    if (!yaml_parser_load(&parser, &document) || yaml_document_get_root_node(&document) == NULL) {
        fprintf(stderr, "yaml_to_json: line %zu: %s\n", parser.problem_mark.line + 1,
                parser.problem != NULL ? parser.problem : "no document");
        return 1;
    }
    write_node(&document, 1);
    putchar('\n');
    yaml_document_delete(&document);
    yaml_parser_delete(&parser);
    return fflush(stdout) == 0 ? 0 : 1;
}
