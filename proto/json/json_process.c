/* Descriptions of the processes (OGC API - Processes, core), made of the tables in core/spec.h and
 * of the formats: what is described is what is accepted. */
#include "proto/json/json_process.h"
#include "proto/codec.h"
#include "proto/json/json_write.h"

static void put_range(struct vor_text *text, const struct vor_parameter_info *info)
{
    vor_json_put_string(text, "type", info->kind == VOR_KIND_REAL ? "number" : "integer");
    vor_json_put_double(text, "minimum", info->min);
    vor_json_put_double(text, "maximum", info->max);
}

static void put_choices(struct vor_text *text, enum vor_parameter parameter)
{
    const char *word;
    size_t length;

    vor_json_put_string(text, "type", "string");
    vor_json_key(text, "enum");
    vor_json_begin_array(text);
    for (unsigned i = 0; (length = vor_parameter_choice(parameter, i, &word)) > 0; i++)
        vor_json_bytes(text, word, length);
    vor_json_end_array(text);
}

static void put_range_or_auto(struct vor_text *text, const struct vor_parameter_info *info)
{
    vor_json_key(text, "oneOf");
    vor_json_begin_array(text);
    vor_json_begin_object(text);
    put_range(text, info);
    vor_json_end_object(text);
    vor_json_begin_object(text);
    vor_json_put_string(text, "type", "string");
    vor_json_key(text, "enum");
    vor_json_begin_array(text);
    vor_json_string(text, "auto");
    vor_json_end_array(text);
    vor_json_end_object(text);
    vor_json_end_array(text);
}

static void put_default(struct vor_text *text, enum vor_parameter parameter,
                        const struct vor_parameter_info *info)
{
    struct vor_spec spec;
    char word[64];

    vor_spec_init(&spec);
    spec.value[parameter] = info->fallback;
    if (!vor_spec_given(&spec, parameter))
        return;
    vor_json_key(text, "default");
    if (info->kind == VOR_KIND_CHOICE || info->fallback == VOR_UNSET)
        vor_json_string(text, vor_spec_text(&spec, parameter, word, sizeof word));
    else
        vor_json_double(text, info->fallback);
}

static void put_parameter(struct vor_text *text, const struct vor_process_info *process,
                          enum vor_parameter parameter)
{
    struct vor_parameter_info info = vor_process_parameter(process, parameter);

    vor_json_key(text, info.name);
    vor_json_begin_object(text);
    vor_json_put_string(text, "title", info.name);
    vor_json_put_string(text, "description", info.sentence);
    vor_json_put_u64(text, "minOccurs", 0);
    vor_json_put_u64(text, "maxOccurs", 1);
    vor_json_key(text, "schema");
    vor_json_begin_object(text);
    if (info.kind == VOR_KIND_CHOICE)
        put_choices(text, parameter);
    else if (info.kind == VOR_KIND_COUNT_OR_AUTO)
        put_range_or_auto(text, &info);
    else
        put_range(text, &info);
    put_default(text, parameter, &info);
    if (info.unit[0] != '\0')
        vor_json_put_string(text, "x-unit", info.unit);
    vor_json_end_object(text);
    vor_json_end_object(text);
}

static void put_cloud_schema(struct vor_text *text)
{
    const struct vor_format *format;

    vor_json_key(text, "schema");
    vor_json_begin_object(text);
    vor_json_key(text, "oneOf");
    vor_json_begin_array(text);
    for (unsigned i = 0; (format = vor_format(i)) != NULL; i++) {
        vor_json_begin_object(text);
        vor_json_put_string(text, "type", "string");
        vor_json_put_string(text, "contentEncoding", "binary");
        vor_json_put_string(text, "contentMediaType", format->media_type);
        vor_json_end_object(text);
    }
    vor_json_end_array(text);
    vor_json_end_object(text);
}

static void put_inputs(struct vor_text *text, const struct vor_process_info *process)
{
    vor_json_key(text, "inputs");
    vor_json_begin_object(text);
    vor_json_key(text, "cloud");
    vor_json_begin_object(text);
    vor_json_put_string(text, "title", "cloud");
    vor_json_put_string(text, "description",
                        "The point cloud, as the body of the request; recognised by its bytes");
    put_cloud_schema(text);
    vor_json_end_object(text);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++)
        put_parameter(text, process, (enum vor_parameter)i);
    vor_json_end_object(text);
}

static void put_outputs(struct vor_text *text)
{
    vor_json_key(text, "outputs");
    vor_json_begin_object(text);
    vor_json_key(text, "cloud");
    vor_json_begin_object(text);
    vor_json_put_string(text, "title", "cloud");
    vor_json_put_string(text, "description", "The cloud that comes of it");
    put_cloud_schema(text);
    vor_json_end_object(text);
    vor_json_key(text, "report");
    vor_json_begin_object(text);
    vor_json_put_string(text, "title", "report");
    vor_json_put_string(text, "description", "What the run did and how even the result is");
    vor_json_key(text, "schema");
    vor_json_begin_object(text);
    vor_json_put_string(text, "type", "object");
    vor_json_put_string(text, "contentMediaType", "application/json");
    vor_json_end_object(text);
    vor_json_end_object(text);
    vor_json_end_object(text);
}

static void put_words(struct vor_text *text, const char *key, const char *const *words)
{
    vor_json_key(text, key);
    vor_json_begin_array(text);
    for (; *words != NULL; words++)
        vor_json_string(text, *words);
    vor_json_end_array(text);
}

static void put_summary(struct vor_text *text, const struct vor_process_info *process,
                        const struct vor_link *links, size_t link_count)
{
    static const char *const controls[] = {"sync-execute", "async-execute", "dismiss", NULL};
    static const char *const transmissions[] = {"value", "reference", NULL};

    vor_json_put_string(text, "id", process->id);
    vor_json_put_string(text, "title", process->title);
    vor_json_put_string(text, "description", process->sentence);
    vor_json_put_string(text, "version", VOR_VERSION);
    put_words(text, "jobControlOptions", controls);
    put_words(text, "outputTransmission", transmissions);
    vor_json_key(text, "links");
    vor_json_links(text, links, link_count);
}

void vor_json_process_summary(struct vor_text *text, const struct vor_process_info *process,
                              const struct vor_link *links, size_t link_count)
{
    vor_json_begin_object(text);
    put_summary(text, process, links, link_count);
    vor_json_end_object(text);
}

void vor_json_process(struct vor_text *text, const struct vor_process_info *process,
                      const struct vor_link *links, size_t link_count)
{
    vor_json_begin_object(text);
    put_summary(text, process, links, link_count);
    put_inputs(text, process);
    put_outputs(text);
    vor_json_end_object(text);
}
