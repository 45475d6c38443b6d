/* Descriptions of the processes (OGC API - Processes, core), made of the tables in core/spec.h and
 * of the formats: what is described is what is accepted. */
#include "core/report.h"
#include "proto/codec.h"
#include "proto/json/json.h"

#include <stdio.h>

enum { WORD_SIZE = 64 };

/* What the parameter hangs on: {"method":["wlop","ear"]}. */
static void put_when(struct vor_text *text, const struct vor_process_info *process,
                     enum vor_parameter parameter)
{
    const struct vor_when *when = vor_parameter_when(parameter);
    char word[WORD_SIZE];
    int length = 0;

    if (when == NULL || !vor_process_takes(process, when->other))
        return;
    vor_json_put_object(text, "x-when");
    vor_json_put_array(text, vor_parameter_info(when->other)->name);
    for (const char *at = when->words; sscanf(at, "%63s%n", word, &length) == 1; at += length)
        vor_json_string(text, word);
    vor_json_end_array(text);
    vor_json_end_object(text);
}

static void put_parameter(struct vor_text *text, const struct vor_process_info *process,
                          enum vor_parameter parameter)
{
    struct vor_parameter_info info = vor_process_parameter(process, parameter);

    vor_json_put_object(text, info.name);
    vor_json_put_string(text, "title", vor_parameter_title(parameter));
    vor_json_put_string(text, "description", info.sentence);
    vor_json_put_string(text, "x-level", vor_level_word(vor_parameter_level(parameter)));
    vor_json_put_string(text, "x-group", vor_group_title(info.group));
    put_when(text, process, parameter);
    vor_json_put_u64(text, "minOccurs", 0);
    vor_json_put_u64(text, "maxOccurs", 1);
    vor_json_key(text, "schema");
    vor_json_parameter_schema(text, process, parameter);
    vor_json_end_object(text);
}

static void put_artefact(struct vor_text *text, const struct vor_artefact_info *artefact)
{
    const struct vor_members *members = vor_document_members(artefact->name);
    const struct vor_format *format;

    vor_json_put_object(text, artefact->name);
    vor_json_put_string(text, "title", artefact->name);
    vor_json_put_string(text, "description", artefact->sentence);
    if (!artefact->is_required)
        vor_json_put_u64(text, "minOccurs", 0);
    vor_json_key(text, "schema");
    vor_json_begin_object(text);
    if (artefact->kind == VOR_ARTEFACT_CLOUD) {
        vor_json_put_array(text, "oneOf");
        for (unsigned i = 0; (format = vor_format(i)) != NULL; i++) {
            vor_json_begin_object(text);
            vor_json_put_string(text, "type", "string");
            vor_json_put_string(text, "contentEncoding", "binary");
            vor_json_put_string(text, "contentMediaType", format->media_type);
            vor_json_end_object(text);
        }
        vor_json_end_array(text);
    } else {
        if (members != NULL)
            vor_json_members_schema(text, members);
        else
            vor_json_put_string(text, "type", "object");
        vor_json_put_string(text, "contentMediaType", "application/json");
    }
    vor_json_end_object(text);
    vor_json_end_object(text);
}

static void put_words(struct vor_text *text, const char *key, const char *const *words)
{
    vor_json_put_array(text, key);
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
    const struct vor_named_preset *preset;
    char value[VOR_PRESET_VALUE_SIZE];
    enum vor_parameter parameter;
    struct vor_spec spec;
    const char *at;

    vor_json_begin_object(text);
    put_summary(text, process, links, link_count);
    vor_json_put_object(text, "inputs");
    for (unsigned i = 0; process->inputs[i].name != NULL; i++)
        put_artefact(text, &process->inputs[i]);
    for (int i = 0; i < VOR_PARAMETER_COUNT; i++)
        if (vor_process_takes(process, (enum vor_parameter)i))
            put_parameter(text, process, (enum vor_parameter)i);
    vor_json_end_object(text);
    vor_json_put_object(text, "outputs");
    for (unsigned i = 0; process->outputs[i].name != NULL; i++)
        put_artefact(text, &process->outputs[i]);
    vor_json_end_object(text);
    vor_json_put_array(text, "x-presets");
    for (unsigned i = 0; (preset = vor_named_preset(process->id, i)) != NULL; i++) {
        vor_json_begin_object(text);
        vor_json_put_string(text, "name", preset->name);
        vor_json_put_string(text, "title", preset->title);
        vor_json_put_string(text, "description", preset->sentence);
        vor_json_key(text, "values");
        /* As a request has them. The table is ours: they are taken. */
        vor_spec_preset(&spec, process);
        vor_json_begin_object(text);
        for (at = preset->values; vor_named_preset_next(&at, &parameter, value);) {
            if (vor_spec_set(&spec, vor_parameter_info(parameter)->name, value, NULL) != VOR_OK)
                continue;
            vor_json_key(text, vor_parameter_info(parameter)->name);
            vor_json_spec_value(text, &spec, parameter);
        }
        vor_json_end_object(text);
        vor_json_end_object(text);
    }
    vor_json_end_array(text);
    /* What is told while it runs. */
    vor_json_put_object(text, "x-record");
    vor_json_members_schema(text, &vor_record_members);
    vor_json_end_object(text);
    vor_json_end_object(text);
}
