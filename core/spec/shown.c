#include "core/spec/shown.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *title;
    enum vor_level level;
} titles[VOR_PARAMETER_COUNT] = {
#define TITLE_ROW(parameter, level, title) [VOR_PARAM_##parameter] = {title, VOR_LEVEL_##level},
    VOR_TITLE_TABLE(TITLE_ROW)
#undef TITLE_ROW
};

static const char *const level_words[VOR_LEVELS][2] = {
#define LEVEL_ROW(id, word, title) {word, title},
    VOR_LEVEL_TABLE(LEVEL_ROW)
#undef LEVEL_ROW
};

static const struct vor_when whens[] = {
#define WHEN_ROW(parameter, name, other, words, sentence)                                          \
    {VOR_PARAM_##parameter, VOR_PARAM_##other, words},
    VOR_WHEN_TABLE(WHEN_ROW)
#undef WHEN_ROW
};

static const struct vor_named_preset presets[] = {
#define PRESET_ROW(name, title, process, values, sentence) {name, title, process, values, sentence},
    VOR_NAMED_PRESET_TABLE(PRESET_ROW)
#undef PRESET_ROW
};

enum { PRESET_COUNT = sizeof presets / sizeof presets[0] };

const char *vor_parameter_title(enum vor_parameter parameter)
{
    assert((unsigned)parameter < VOR_PARAMETER_COUNT);
    return titles[parameter].title != NULL ? titles[parameter].title
                                           : vor_parameter_info(parameter)->name;
}

enum vor_level vor_parameter_level(enum vor_parameter parameter)
{
    assert((unsigned)parameter < VOR_PARAMETER_COUNT);
    return titles[parameter].title != NULL ? titles[parameter].level : VOR_LEVEL_ADVANCED;
}

const char *vor_level_word(enum vor_level level)
{
    assert((unsigned)level < VOR_LEVELS);
    return level_words[level][0];
}

const char *vor_level_title(enum vor_level level)
{
    assert((unsigned)level < VOR_LEVELS);
    return level_words[level][1];
}

const struct vor_when *vor_parameter_when(enum vor_parameter parameter)
{
    for (size_t i = 0; i < sizeof whens / sizeof whens[0]; i++)
        if (whens[i].parameter == parameter)
            return &whens[i];
    return NULL;
}

const struct vor_named_preset *vor_named_preset(const char *process, unsigned index)
{
    for (unsigned i = 0; i < PRESET_COUNT; i++)
        if (strcmp(presets[i].process, process) == 0 && index-- == 0)
            return &presets[i];
    return NULL;
}

const struct vor_named_preset *vor_named_preset_find(const char *process, const char *name)
{
    const struct vor_named_preset *preset;
    unsigned i = 0;

    while ((preset = vor_named_preset(process, i++)) != NULL)
        if (strcmp(preset->name, name) == 0)
            return preset;
    return NULL;
}

int vor_named_preset_next(const char **at, enum vor_parameter *parameter,
                          char value[VOR_PRESET_VALUE_SIZE])
{
    const char *item = *at + strspn(*at, " ");
    size_t length = strcspn(item, " "), name_length = strcspn(item, "=");
    char name[VOR_PRESET_VALUE_SIZE];

    *at = item + length;
    if (length == 0)
        return 0;
    assert(name_length < length && length < VOR_PRESET_VALUE_SIZE); /* the table is ours */
    (void)snprintf(name, sizeof name, "%.*s", (int)name_length, item);
    (void)snprintf(value, VOR_PRESET_VALUE_SIZE, "%.*s", (int)(length - name_length - 1),
                   item + name_length + 1);
    *parameter = vor_parameter_find(name);
    return 1;
}
