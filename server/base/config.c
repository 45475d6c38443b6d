#include "server/base/config.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum {
    VARIABLE_MAX = 64 /* bytes of an environment variable's name */
};

struct setting_info {
    const char *flag;
    enum vor_setting_kind kind;
    const char *unit;
    double min, max;
    const char *fallback, *sentence;
};

static const struct setting_info infos[VOR_SETTING_COUNT] = {
#define INFO_ROW(id, flag, kind, unit, min, max, fallback, sentence)                               \
    {flag, VOR_SETTING_##kind, unit, min, max, fallback, sentence},
    VOR_SETTING_TABLE(INFO_ROW)
#undef INFO_ROW
};

static vor_status bad_number(const struct setting_info *info, const char *text,
                             struct vor_error *err)
{
    return vor_fail_param(err, VOR_E_PARAM, info->flag,
                          "--%s is \"%.60s\", want %s from %.10g to %.10g", info->flag, text,
                          info->kind == VOR_SETTING_TIME    ? "seconds"
                          : info->kind == VOR_SETTING_BYTES ? "bytes (K, M, G, T)"
                                                            : "a whole number",
                          info->min, info->max);
}

static int byte_shift(const char *suffix)
{
    static const char suffixes[] = "KMGT";
    const char *at;

    if (suffix[0] == '\0')
        return 0;
    at = strchr(suffixes, toupper((unsigned char)suffix[0]));
    return at != NULL && suffix[1] == '\0' ? 10 * (int)(at - suffixes + 1) : -1;
}

static vor_status set_number(double *out, const struct setting_info *info, const char *text,
                             struct vor_error *err)
{
    char *end;
    double number;
    int shift = 0;

    if (text[0] == '\0' || strspn(text, "0123456789.") == 0 || strlen(text) > 30)
        return bad_number(info, text, err);
    number = strtod(text, &end);
    if (info->kind == VOR_SETTING_BYTES)
        shift = byte_shift(end);
    else if (*end != '\0')
        shift = -1;
    if (shift < 0)
        return bad_number(info, text, err);
    number = ldexp(number, shift);
    if (!(number >= info->min && number <= info->max) ||
        (info->kind != VOR_SETTING_TIME && number != rint(number)))
        return bad_number(info, text, err);
    *out = number;
    return VOR_OK;
}

static vor_status set_choice(double *out, const struct setting_info *info, const char *text,
                             struct vor_error *err)
{
    const char *at = info->unit;

    for (int i = 0; *at != '\0'; i++) {
        size_t length = strcspn(at, " ");

        if (strlen(text) == length && memcmp(at, text, length) == 0) {
            *out = i;
            return VOR_OK;
        }
        at += length + (at[length] == ' ');
    }
    return vor_fail_param(err, VOR_E_PARAM, info->flag, "--%s is \"%.60s\", want one of %s",
                          info->flag, text, info->unit);
}

/* A list grows with every flag, any other text is the last one's. */
static vor_status set_text(struct vor_config *config, int setting, const char *text,
                           struct vor_error *err)
{
    const struct setting_info *info = &infos[setting];
    char *to = config->text[setting];
    size_t before = info->kind == VOR_SETTING_LIST ? strlen(to) : 0;

    if (before > 0)
        before++;
    if (before + strlen(text) >= VOR_CONFIG_TEXT_MAX)
        return vor_fail_param(err, VOR_E_PARAM, info->flag, "--%s has %zu bytes, want at most %d",
                              info->flag, before + strlen(text), VOR_CONFIG_TEXT_MAX - 1);
    if (before > 0)
        to[before - 1] = ',';
    memcpy(to + before, text, strlen(text) + 1);
    return VOR_OK;
}

static vor_status set(struct vor_config *config, int setting, const char *text,
                      struct vor_error *err)
{
    const struct setting_info *info = &infos[setting];

    switch (info->kind) {
    case VOR_SETTING_TEXT:
    case VOR_SETTING_LIST:
        return set_text(config, setting, text, err);
    case VOR_SETTING_CHOICE:
        return set_choice(&config->number[setting], info, text, err);
    case VOR_SETTING_COUNT_OF:
    case VOR_SETTING_BYTES:
    case VOR_SETTING_TIME:
    case VOR_SETTING_FLAG:
        break;
    }
    return set_number(&config->number[setting], info, text, err);
}

/* VORONOID_ and the flag in capitals. */
static void name_variable(const struct setting_info *info, char *out, size_t size)
{
    (void)snprintf(out, size, "VORONOID_%s", info->flag);
    for (char *c = out; *c != '\0'; c++)
        *c = *c == '-' ? '_' : (char)toupper((unsigned char)*c);
}

/* What no flag has given: from the environment, or the default. */
static vor_status read_environment(struct vor_config *config, char *(*get)(const char *),
                                   struct vor_error *err)
{
    for (int i = 0; i < VOR_SETTING_COUNT; i++) {
        char name[VARIABLE_MAX];
        const char *value;
        vor_status status;

        if (config->given[i])
            continue;
        name_variable(&infos[i], name, sizeof name);
        value = get(name);
        status = set(config, i, value != NULL ? value : infos[i].fallback, err);
        if (status != VOR_OK)
            return status;
        config->given[i] = value != NULL;
    }
    return VOR_OK;
}

static int find_flag(const char *name, size_t length)
{
    int i = 0;

    while (i < VOR_SETTING_COUNT &&
           (strlen(infos[i].flag) != length || memcmp(infos[i].flag, name, length) != 0))
        i++;
    return i;
}

static vor_status read_arguments(struct vor_config *config, int argc, char **argv,
                                 struct vor_error *err)
{
    for (int i = 1; i < argc; i++) {
        const char *name = argv[i] + 2;
        size_t length;
        const char *value;
        vor_status status;
        int setting;

        if (strncmp(argv[i], "--", 2) != 0)
            return vor_fail(err, VOR_E_PARAM, "%.60s is no setting; see voronoid serve --help",
                            argv[i]);
        length = strcspn(name, "=");
        setting = find_flag(name, length);
        if (setting == VOR_SETTING_COUNT)
            return vor_fail(err, VOR_E_PARAM, "no setting %.60s; see voronoid serve --help",
                            argv[i]);
        if (name[length] == '=')
            value = name + length + 1;
        else if (infos[setting].kind == VOR_SETTING_FLAG)
            value = "1";
        else if (++i < argc)
            value = argv[i];
        else
            return vor_fail(err, VOR_E_PARAM, "--%s wants a value", infos[setting].flag);
        status = set(config, setting, value, err);
        if (status != VOR_OK)
            return status;
        config->given[setting] = 1;
    }
    return VOR_OK;
}

static vor_status split_listen(struct vor_config *config, struct vor_error *err)
{
    const char *text = config->text[VOR_SET_LISTEN];
    const char *colon = strrchr(text, ':');
    size_t length = colon != NULL ? (size_t)(colon - text) : 0;
    char *end = NULL;
    unsigned long port = colon != NULL ? strtoul(colon + 1, &end, 10) : 0;

    if (length == 0 || length >= sizeof config->host || !isdigit((unsigned char)colon[1]) ||
        *end != '\0' || port > 65535)
        return vor_fail_param(err, VOR_E_PARAM, "listen",
                              "--listen is \"%.80s\", want HOST:PORT with a port from 0 to 65535",
                              text);
    if (text[0] == '[' && text[length - 1] == ']') {
        text++;
        length -= 2;
    }
    memcpy(config->host, text, length);
    config->host[length] = '\0';
    config->port = (unsigned)port;
    config->loopback = strncmp(config->host, "127.", 4) == 0 || strcmp(config->host, "::1") == 0 ||
                       strcasecmp(config->host, "localhost") == 0;
    if (!config->loopback && config->number[VOR_SET_NO_AUTH] == 0)
        return vor_fail_param(err, VOR_E_PARAM, "listen",
                              "--listen %.80s is open to other machines and this build knows no "
                              "keys yet: use a loopback address, or --no-auth to let anybody in",
                              config->text[VOR_SET_LISTEN]);
    return VOR_OK;
}

/* Length of "http://HOST:PORT" or the like at the start of text; 0 when there is none. */
static size_t origin_length(const char *text)
{
    static const char host[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._:[]";
    size_t scheme = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789+-.");
    size_t length;

    if (scheme == 0 || strncmp(text + scheme, "://", 3) != 0)
        return 0;
    length = strspn(text + scheme + 3, host);
    return length > 0 ? scheme + 3 + length : 0;
}

/* A wrong one would only show as links that lead nowhere. */
static vor_status check_public_url(const struct vor_config *config, struct vor_error *err)
{
    const char *url = config->text[VOR_SET_PUBLIC_URL];
    size_t scheme = strncmp(url, "https://", 8) == 0 ? 8 : strncmp(url, "http://", 7) == 0 ? 7 : 0;
    size_t host = strcspn(url + scheme, "/");
    char copy[VOR_HOST_MAX + 1] = "";

    if (host < sizeof copy)
        memcpy(copy, url + scheme, host);
    if (url[0] == '\0' ||
        (scheme > 0 && vor_host_is_sound(copy) &&
         (url[scheme + host] == '\0' || vor_prefix_is_sound(url + scheme + host))))
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, "public-url",
                          "--public-url is \"%.80s\", want http://HOST or https://HOST, with a "
                          "port and a path of at most %d bytes or without, and no query",
                          url, VOR_PREFIX_MAX);
}

/* A wrong one would only show as pages that are let in nowhere. */
static vor_status check_origins(const struct vor_config *config, struct vor_error *err)
{
    const char *list = config->text[VOR_SET_CORS_ORIGIN];

    while (*(list += strspn(list, ", ")) != '\0') {
        size_t word = strcspn(list, ", ");

        if (origin_length(list) != word)
            return vor_fail_param(err, VOR_E_PARAM, "cors-origin",
                                  "--cors-origin holds \"%.*s\", want a list of origins such as "
                                  "https://HOST or http://HOST:PORT, without a path",
                                  (int)(word < 80 ? word : 80), list);
        list += word;
    }
    return VOR_OK;
}

static vor_status check_hosts(const struct vor_config *config, struct vor_error *err)
{
    const char *list = config->text[VOR_SET_ALLOWED_HOSTS];

    while (*(list += strspn(list, ", ")) != '\0') {
        size_t word = strcspn(list, ", ");
        char copy[VOR_HOST_MAX + 1] = "";

        if (word < sizeof copy)
            memcpy(copy, list, word);
        if (!vor_host_is_sound(copy) || vor_host_name_length(copy) != word)
            return vor_fail_param(err, VOR_E_PARAM, "allowed-hosts",
                                  "--allowed-hosts holds \"%.*s\", want names such as "
                                  "cloud.example, without scheme and port",
                                  (int)(word < 80 ? word : 80), list);
        list += word;
    }
    return VOR_OK;
}

/* prefix, directory and suffix as a setting's text; false when they do not fit. */
static int compose(struct vor_config *config, int setting, const char *prefix,
                   const char *directory, const char *suffix)
{
    char whole[VOR_CONFIG_TEXT_MAX];
    int length = snprintf(whole, sizeof whole, "%s%s%s", prefix, directory, suffix);

    if (length < 0 || (size_t)length >= sizeof whole)
        return 0;
    memcpy(config->text[setting], whole, (size_t)length + 1);
    return 1;
}

static vor_status find_places(struct vor_config *config, char *(*get)(const char *),
                              struct vor_error *err)
{
    const char *state = get("STATE_DIRECTORY");
    const char *xdg = get("XDG_STATE_HOME");
    const char *home = get("HOME");
    int fits = 1;

    if (config->text[VOR_SET_DATA][0] == '\0') {
        if (state != NULL && state[0] == '/')
            fits = compose(config, VOR_SET_DATA, "", state, "");
        else if (xdg != NULL && xdg[0] == '/')
            fits = compose(config, VOR_SET_DATA, "", xdg, "/voronoid");
        else if (home != NULL && home[0] == '/')
            fits = compose(config, VOR_SET_DATA, "", home, "/.local/state/voronoid");
        else
            fits = 0;
    }
    if (fits && config->text[VOR_SET_STORE][0] == '\0')
        fits =
            compose(config, VOR_SET_STORE, "sqlite:", config->text[VOR_SET_DATA], "/jobs.sqlite");
    if (fits && config->text[VOR_SET_BLOBS][0] == '\0')
        fits = compose(config, VOR_SET_BLOBS, "dir:", config->text[VOR_SET_DATA], "/blobs");
    if (fits)
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, "data",
                          "no directory to keep jobs in: give --data DIR of at most 1000 bytes");
}

vor_status vor_config_read(struct vor_config *out, int argc, char **argv,
                           char *(*getenv)(const char *name), struct vor_error *err)
{
    vor_status status;

    memset(out, 0, sizeof *out);
    status = read_arguments(out, argc, argv, err);
    if (status == VOR_OK)
        status = read_environment(out, getenv, err);
    if (status == VOR_OK)
        status = split_listen(out, err);
    if (status == VOR_OK)
        status = check_public_url(out, err);
    if (status == VOR_OK)
        status = check_origins(out, err);
    if (status == VOR_OK)
        status = check_hosts(out, err);
    if (status == VOR_OK)
        status = vor_networks_parse(&out->trusted, "trusted-proxy",
                                    out->text[VOR_SET_TRUSTED_PROXY], err);
    if (status == VOR_OK)
        status = find_places(out, getenv, err);
    return status;
}

/* What stands behind a flag in the help. */
static const char *placeholder(const struct setting_info *info)
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

static void print_range(FILE *out, const struct setting_info *info)
{
    switch (info->kind) {
    case VOR_SETTING_COUNT_OF:
    case VOR_SETTING_TIME:
        (void)fprintf(out, "%.10g to %.10g %s, ", info->min, info->max, info->unit);
        break;
    case VOR_SETTING_BYTES:
        (void)fprintf(out, "%.10g to %.10g %s, or with K, M, G or T, ", info->min, info->max,
                      info->unit);
        break;
    case VOR_SETTING_CHOICE:
        (void)fprintf(out, "one of %s, ", info->unit);
        break;
    case VOR_SETTING_TEXT:
    case VOR_SETTING_LIST:
    case VOR_SETTING_FLAG:
        break;
    }
    if (info->fallback[0] != '\0' && info->kind != VOR_SETTING_FLAG)
        (void)fprintf(out, "default %s ", info->fallback);
}

void vor_config_help(FILE *out)
{
    for (int i = 0; i < VOR_SETTING_COUNT; i++) {
        const char *value = placeholder(&infos[i]);
        char variable[VARIABLE_MAX];

        name_variable(&infos[i], variable, sizeof variable);
        (void)fprintf(out, "  --%s%s%s\n      %s\n      ", infos[i].flag,
                      value[0] != '\0' ? " " : "", value, infos[i].sentence);
        print_range(out, &infos[i]);
        (void)fprintf(out, "(env: %s)\n", variable);
    }
    (void)fputs("A flag wins over the environment.\n", out);
}

int vor_config_list_has(const char *list, const char *item, size_t length)
{
    while (*list != '\0') {
        size_t at = strspn(list, ", ");
        size_t word = strcspn(list + at, ", ");

        if (word == length && word > 0 && memcmp(list + at, item, length) == 0)
            return 1;
        list += at + word;
    }
    return 0;
}
