#include "proto/json/json.h"

void vor_json_put_given(struct vor_text *text, const char *key, const char *value)
{
    if (value != NULL && value[0] != '\0')
        vor_json_put_string(text, key, value);
}

void vor_json_record(struct vor_text *text, const struct vor_record *record)
{
    vor_json_begin_object(text);
    vor_json_members(text, &vor_record_members, record);
    vor_json_end_object(text);
}

int vor_json_record_read(struct vor_record *out, const struct vor_json *object)
{
    double iteration;

    if (!vor_json_get_number(vor_json_get(object, "iteration"), &iteration))
        return 0;
    vor_json_members_read(out, &vor_record_members, object);
    if (vor_json_get(object, "best") == NULL)
        vor_record_unknown_best(out);
    return 1;
}

void vor_json_link(struct vor_text *text, const struct vor_link *link)
{
    vor_json_begin_object(text);
    vor_json_put_given(text, "rel", link->rel);
    vor_json_put_given(text, "type", link->type);
    vor_json_put_given(text, "title", link->title);
    vor_json_put_given(text, "href", link->href);
    if (link->length >= 0)
        vor_json_put_i64(text, "length", link->length);
    vor_json_end_object(text);
}

void vor_json_links(struct vor_text *text, const struct vor_link *links, size_t count)
{
    vor_json_begin_array(text);
    for (size_t i = 0; i < count; i++)
        vor_json_link(text, &links[i]);
    vor_json_end_array(text);
}
