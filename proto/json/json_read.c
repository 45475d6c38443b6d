#include "core/base/quote.h"
#include "proto/json/json.h"

#include <cjson/cJSON.h>

#include <stdlib.h>
#include <string.h>

static const cJSON *node(const struct vor_json *value)
{
    return (const cJSON *)(const void *)value;
}

static const struct vor_json *value_of(const cJSON *item)
{
    return (const struct vor_json *)(const void *)item;
}

/* One key of the text: the object it is in, and where it stands. */
struct key {
    const cJSON *object;
    const char *name;
    uint32_t offset;
};

struct key_list {
    const struct vor_json_keys *found;
    struct key *keys;
    size_t count;
};

/* cJSON keeps the order of the text, so the keys come in the order in which the scan noted them. */
static void collect_keys(struct key_list *list, const cJSON *item)
{
    for (const cJSON *child = item->child; child != NULL; child = child->next) {
        if (cJSON_IsObject(item)) {
            list->keys[list->count].object = item;
            list->keys[list->count].name = child->string;
            list->keys[list->count].offset = list->found->offsets[list->count];
            list->count++;
        }
        collect_keys(list, child);
    }
}

static int compare_names(const struct key *a, const struct key *b)
{
    if (a->object != b->object)
        return a->object < b->object ? -1 : 1;
    return strcmp(a->name, b->name);
}

static int compare_keys(const void *left, const void *right)
{
    const struct key *a = left, *b = right;
    int order = compare_names(a, b);

    return order != 0 ? order : (a->offset > b->offset) - (a->offset < b->offset);
}

static vor_status check_duplicates(const cJSON *root, const struct vor_json_keys *found,
                                   struct vor_error *err)
{
    struct key_list list = {found, NULL, 0};
    const struct key *second = NULL;

    if (found->count < 2)
        return VOR_OK;
    list.keys = malloc(found->count * sizeof *list.keys);
    if (list.keys == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a JSON text");
    collect_keys(&list, root);
    qsort(list.keys, list.count, sizeof *list.keys, compare_keys);
    for (size_t i = 1; i < list.count; i++)
        if (compare_names(&list.keys[i - 1], &list.keys[i]) == 0 &&
            (second == NULL || list.keys[i].offset < second->offset))
            second = &list.keys[i];
    if (second != NULL) {
        (void)vor_fail(err, VOR_E_REQUEST, "JSON: duplicate key \"%s\" at byte %u",
                       VOR_QUOTED(64, second->name, strlen(second->name)),
                       (unsigned)second->offset);
        if (err != NULL)
            err->byte_offset = second->offset;
    }
    free(list.keys);
    return second != NULL ? VOR_E_REQUEST : VOR_OK;
}

vor_status vor_json_parse(struct vor_json **out, const char *bytes, size_t size,
                          struct vor_error *err)
{
    struct vor_json_keys keys = {NULL, 0};
    cJSON *root = NULL;
    vor_status status;

    *out = NULL;
    keys.offsets = malloc(VOR_JSON_TOKENS_MAX * sizeof *keys.offsets);
    if (keys.offsets == NULL)
        return vor_fail(err, VOR_E_NOMEM, "a JSON text");
    status = vor_json_scan(bytes, size, &keys, err);
    if (status != VOR_OK)
        goto done;
    /* What the scan lets pass, cJSON reads, unless memory ends. */
    root = cJSON_ParseWithLengthOpts(bytes, size, NULL, 0);
    if (root == NULL) {
        status = vor_fail(err, VOR_E_NOMEM, "a JSON text of %zu bytes", size);
        goto done;
    }
    status = check_duplicates(root, &keys, err);
    if (status != VOR_OK)
        goto done;
    *out = (struct vor_json *)root;
    root = NULL;
done:
    cJSON_Delete(root);
    free(keys.offsets);
    return status;
}

void vor_json_free(struct vor_json *json)
{
    cJSON_Delete((cJSON *)json);
}

enum vor_json_kind vor_json_kind(const struct vor_json *value)
{
    const cJSON *item = node(value);

    if (cJSON_IsObject(item))
        return VOR_JSON_OBJECT;
    if (cJSON_IsArray(item))
        return VOR_JSON_ARRAY;
    if (cJSON_IsString(item))
        return VOR_JSON_STRING;
    if (cJSON_IsNumber(item))
        return VOR_JSON_NUMBER;
    return cJSON_IsBool(item) ? VOR_JSON_BOOL : VOR_JSON_NULL;
}

const char *vor_json_kind_word(const struct vor_json *value)
{
    static const char *const words[] = {"null",     "a boolean", "a number",
                                        "a string", "an array",  "an object"};

    return words[vor_json_kind(value)];
}

const struct vor_json *vor_json_get(const struct vor_json *value, const char *name)
{
    if (!cJSON_IsObject(node(value)))
        return NULL;
    return value_of(cJSON_GetObjectItemCaseSensitive(node(value), name));
}

const char *vor_json_get_string(const struct vor_json *value)
{
    return cJSON_IsString(node(value)) ? node(value)->valuestring : NULL;
}

int vor_json_get_number(const struct vor_json *value, double *out)
{
    if (!cJSON_IsNumber(node(value)))
        return 0;
    *out = node(value)->valuedouble;
    return 1;
}

int vor_json_get_bool(const struct vor_json *value, int *out)
{
    if (!cJSON_IsBool(node(value)))
        return 0;
    *out = cJSON_IsTrue(node(value)) != 0;
    return 1;
}

const struct vor_json *vor_json_first(const struct vor_json *value)
{
    if (!cJSON_IsObject(node(value)) && !cJSON_IsArray(node(value)))
        return NULL;
    return value_of(node(value)->child);
}

const struct vor_json *vor_json_next(const struct vor_json *element)
{
    return element != NULL ? value_of(node(element)->next) : NULL;
}

const char *vor_json_name(const struct vor_json *member)
{
    return member != NULL ? node(member)->string : NULL;
}

void vor_json_copy(struct vor_text *text, const struct vor_json *value)
{
    enum vor_json_kind kind = vor_json_kind(value);
    const struct vor_json *child = vor_json_first(value);

    switch (kind) {
    case VOR_JSON_OBJECT:
    case VOR_JSON_ARRAY:
        kind == VOR_JSON_OBJECT ? vor_json_begin_object(text) : vor_json_begin_array(text);
        for (; child != NULL; child = vor_json_next(child)) {
            if (kind == VOR_JSON_OBJECT)
                vor_json_key(text, vor_json_name(child));
            vor_json_copy(text, child);
        }
        kind == VOR_JSON_OBJECT ? vor_json_end_object(text) : vor_json_end_array(text);
        break;
    case VOR_JSON_NUMBER:
        vor_json_double(text, node(value)->valuedouble);
        break;
    case VOR_JSON_BOOL:
        vor_json_bool(text, cJSON_IsTrue(node(value)));
        break;
    default:
        vor_json_string(text, vor_json_get_string(value));
    }
}
