#include "server/base/config_help.h"

#include "server/base/markup.h"

/* What stands behind a flag in the help. */
static const char *placeholder(const struct vor_setting_info *info)
{
    switch (info->kind) {
    case VOR_SETTING_TEXT:
    case VOR_SETTING_LIST:
        return info->unit;
    case VOR_SETTING_COUNT_OF:
        return "N";
    case VOR_SETTING_BYTES:
        return "BYTES";
    case VOR_SETTING_TIME:
        return "SECONDS";
    case VOR_SETTING_CHOICE:
        return "WORD";
    case VOR_SETTING_FLAG:
        break;
    }
    return "";
}

static int write_range(char *out, size_t size, const struct vor_setting_info *info)
{
    switch (info->kind) {
    case VOR_SETTING_COUNT_OF:
    case VOR_SETTING_TIME:
        return snprintf(out, size, "%.10g to %.10g %s, ", info->min, info->max, info->unit);
    case VOR_SETTING_BYTES:
        return snprintf(out, size, "%.10g to %.10g %s, or with K, M, G or T, ", info->min,
                        info->max, info->unit);
    case VOR_SETTING_CHOICE:
        return snprintf(out, size, "one of %s, ", info->unit);
    case VOR_SETTING_TEXT:
    case VOR_SETTING_LIST:
    case VOR_SETTING_FLAG:
        break;
    }
    return 0;
}

int vor_config_describe(struct vor_setting_text *out, unsigned index)
{
    const struct vor_setting_info *info;
    int at;

    if (index >= VOR_SETTING_COUNT)
        return 0;
    info = &vor_setting_infos[index];
    out->flag = info->flag;
    out->value = placeholder(info);
    out->words = info->kind == VOR_SETTING_CHOICE ? info->unit : "";
    out->sentence = info->sentence;
    vor_config_variable(info->flag, out->variable);
    out->range[0] = '\0';
    at = write_range(out->range, sizeof out->range, info);
    if (info->fallback[0] != '\0' && info->kind != VOR_SETTING_FLAG)
        (void)snprintf(out->range + at, sizeof out->range - (size_t)at, "default %s ",
                       info->fallback);
    return 1;
}

void vor_config_help(FILE *out)
{
    struct vor_setting_text setting;

    for (unsigned i = 0; vor_config_describe(&setting, i); i++) {
        (void)fprintf(out, "  --%s%s%s\n", setting.flag, setting.value[0] != '\0' ? " " : "",
                      setting.value);
        vor_markup_wrap_string(out, setting.sentence, 6);
        (void)fprintf(out, "      %s(env: %s)\n", setting.range, setting.variable);
    }
    vor_markup_wrap_string(out,
                           "A flag overrides the environment variable of the same setting, and "
                           "the variable overrides the file of --config. A variable with a "
                           "name that ends in _FILE has the path of a file that contains the "
                           "value. See also voronoid help settings.",
                           0);
}
