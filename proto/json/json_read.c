#include "proto/json/json.h"

#include <cjson/cJSON.h>

#include <string.h>

static const cJSON *node(const struct vor_json *value)
{
    return (const cJSON *)(const void *)value;
}

static const struct vor_json *value_of(const cJSON *item)
{
    return (const struct vor_json *)(const void *)item;
}

vor_status vor_json_parse(struct vor_json **out, const char *bytes, size_t size,
                          struct vor_error *err)
{
    vor_status status = vor_json_scan(bytes, size, err);

    *out = NULL;
    if (status != VOR_OK)
        return status;
    /* What the scan lets pass, cJSON reads, unless memory ends. */
    *out = (struct vor_json *)cJSON_ParseWithLengthOpts(bytes, size, NULL, 0);
    return *out != NULL ? VOR_OK : vor_fail(err, VOR_E_NOMEM, "a JSON text of %zu bytes", size);
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
