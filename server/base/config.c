#include "server/base/config.h"

#include "core/base/nearest.h"
#include "proto/text.h"
#include "server/base/option.h"

#include <errno.h>
#include <string.h>

enum {
    OPERAND = 1,        /* what getopt_long returns for a word that is no option */
    LONG_SETTING = 256, /* and for a setting, above every letter: its row behind this */
    LINE_SIZE = 2048    /* of a line of the file of settings, with the NUL */
};

const struct vor_option_row vor_setting_infos[VOR_SETTING_COUNT] = {
#define INFO_ROW(id, flag, kind, unit, min, max, fallback, sentence)                               \
    {flag, VOR_TYPE_##kind, unit, min, max, fallback, sentence, "VORONOID_" #id, 0, 0},
    VOR_SETTING_TABLE(INFO_ROW)
#undef INFO_ROW
};

static vor_status set(struct vor_config *config, int setting, const char *text,
                      struct vor_error *err)
{
    char *to = config->text[setting];
    size_t before;
    const struct vor_option_row *info = &vor_setting_infos[setting];

    if (info->type != VOR_TYPE_TEXT && info->type != VOR_TYPE_LIST)
        return vor_option_read(&config->number[setting], info, text, err);
    /* A list grows with every flag, any other text is the last one's. */
    before = info->type == VOR_TYPE_LIST ? strlen(to) : 0;
    if (before > 0)
        before++;
    if (before + strlen(text) >= VOR_CONFIG_TEXT_MAX)
        return vor_fail_param(err, VOR_E_PARAM, info->name, "--%s has %zu bytes, want at most %d",
                              info->name, before + strlen(text), VOR_CONFIG_TEXT_MAX - 1);
    if (before > 0)
        to[before - 1] = ',';
    memcpy(to + before, text, strlen(text) + 1);
    return VOR_OK;
}

/* Reads a file that is a value, but for a newline at its end. variable names the file, for
 * messages.
 */
static vor_status read_value(char *out, size_t size, const char *variable, const char *path,
                             struct vor_error *err)
{
    FILE *file = fopen(path, "re");
    size_t got;
    int failed;

    if (file == NULL)
        return vor_fail(err, VOR_E_PARAM, "%.60s is \"%.200s\", which cannot be read: %s", variable,
                        path, strerror(errno));
    got = fread(out, 1, size, file);
    failed = ferror(file);
    (void)fclose(file);
    if (failed)
        return vor_fail(err, VOR_E_PARAM, "%.60s is \"%.200s\", which cannot be read", variable,
                        path);
    if (got == size)
        return vor_fail(err, VOR_E_PARAM,
                        "%.60s: %.200s has %zu bytes or more, want a value of at "
                        "most %zu",
                        variable, path, size, size - 1);
    out[got] = '\0';
    if (got > 0 && out[got - 1] == '\n')
        out[--got] = '\0';
    if (got > 0 && out[got - 1] == '\r')
        out[--got] = '\0';
    if (strlen(out) != got || strpbrk(out, VOR_CONTROLS) != NULL)
        return vor_fail(err, VOR_E_PARAM,
                        "%.60s: %.200s holds a control byte (such as a line break), want a single "
                        "line without control bytes",
                        variable, path);
    return VOR_OK;
}

/* A setting from its variable, or from the file that its variable with _FILE names. What is a file
 * itself has no such variable: it would be mistaken for the one without. */
static vor_status read_variable(struct vor_config *config, int setting, char *(*get)(const char *),
                                struct vor_error *err)
{
    const char *name = vor_setting_infos[setting].variable, *value, *path = NULL;
    char file[64], held[VOR_CONFIG_TEXT_MAX];
    vor_status status = VOR_OK;

    (void)snprintf(file, sizeof file, "%s_FILE", name);
    value = get(name);
    if (setting != VOR_SET_CONFIG)
        path = get(file);
    if (value != NULL && path != NULL)
        return vor_fail_param(err, VOR_E_PARAM, vor_setting_infos[setting].name,
                              "%s and %s are both given, want only one", name, file);
    if (path != NULL)
        status = read_value(held, sizeof held, file, path, err);
    if (path != NULL && status == VOR_OK)
        value = held;
    if (value != NULL && status == VOR_OK)
        status = set(config, setting, value, err);
    config->given[setting] = value != NULL;
    return status;
}

/* Where faults go while settings are read: all into the settings, the first here as well. */
struct reading {
    struct vor_config *config;
    struct vor_error first; /* its status is VOR_OK as long as there is none */
};

static void note(struct reading *reading, const struct vor_error *why)
{
    struct vor_config *config = reading->config;
    size_t size = strlen(why->message) + 1;

    if (reading->first.status == VOR_OK)
        reading->first = *why;
    if (size > sizeof config->faults - config->faults_size)
        return;
    memcpy(config->faults + config->faults_size, why->message, size);
    config->faults_size += size;
}

static const char the_address[] = "; the address is --listen HOST:PORT";

static int is_address(const char *name)
{
    return strcspn(name, "=") == 4 &&
           (memcmp(name, "port", 4) == 0 || memcmp(name, "host", 4) == 0);
}

/* Refuses a name with those that it may be meant for. */
static vor_status no_setting(const char *name, struct vor_error *err)
{
    char meant[VOR_NEAREST_TEXT_SIZE];
    struct vor_nearest nearest;

    vor_nearest_init(&nearest, name, strlen(name));
    for (int i = 0; i < VOR_SETTING_COUNT; i++)
        vor_nearest_try(&nearest, vor_setting_infos[i].name, strlen(vor_setting_infos[i].name));
    return vor_fail(err, VOR_E_PARAM, "no setting \"%.60s\"%s", name,
                    is_address(name)    ? the_address
                    : nearest.count > 0 ? vor_nearest_text(&nearest, "", meant)
                                        : "; see voronoid serve --help");
}

static int find_setting(const char *flag)
{
    for (int i = 0; i < VOR_SETTING_COUNT; i++)
        if (strcmp(vor_setting_infos[i].name, flag) == 0)
            return i;
    return -1;
}

/* A line of the file, unless a flag or a variable has given the setting. A list grows by lines. */
static vor_status take_setting(struct vor_config *config, unsigned line, const char *name,
                               const char *value, struct vor_error *err)
{
    int setting = find_setting(name);

    if (setting < 0 || setting == VOR_SET_CONFIG || setting == VOR_SET_CHECK_CONFIG)
        return no_setting(name, err);
    if (config->given[setting] && config->line[setting] == 0)
        return VOR_OK;
    if (config->line[setting] > 0 && vor_setting_infos[setting].type != VOR_TYPE_LIST)
        return vor_fail(err, VOR_E_PARAM, "%s is set twice, first on line %u", name,
                        config->line[setting]);
    config->given[setting] = 1;
    config->line[setting] = line;
    return set(config, setting, value, err);
}

static const char *config_place(const struct vor_config *config)
{
    const char *path = config->text[VOR_SET_CONFIG];

    return path[0] != '\0' ? path : VOR_CONFIG_PLACE;
}

/* One line, which is changed; empty ones and those that begin with # or ; are passed over. */
static vor_status take_line(char *line, unsigned number, struct vor_config *config,
                            struct vor_error *err)
{
    char *name = vor_trim(line), *equals = strchr(name, '=');

    if (name[0] == '\0' || name[0] == '#' || name[0] == ';')
        return VOR_OK;
    if (strpbrk(name, VOR_CONTROLS) != NULL)
        return vor_fail(err, VOR_E_PARAM, "the line has a control character, want name = value");
    if (equals == NULL || equals == name)
        return vor_fail(err, VOR_E_PARAM, "\"%.60s\" is not of the form name = value", name);
    *equals = '\0';
    return take_setting(config, number, vor_trim(name), vor_trim(equals + 1), err);
}

/* Puts "FILE line N: " before a message. Returns its status. */
static vor_status blame_line(struct vor_error *err, const char *path, unsigned line)
{
    struct vor_error was = *err;

    return vor_fail_param(err, was.status, was.parameter, "%.200s line %u: %.700s", path, line,
                          was.message);
}

/* Reads on behind a line that is at fault, except one that is too long. */
static vor_status read_file(struct reading *reading, struct vor_error *err)
{
    const char *path = config_place(reading->config);
    FILE *file = fopen(path, "re");
    char line[LINE_SIZE];
    vor_status status = VOR_OK;
    struct vor_error why;
    int is_cut = 0;

    if (file == NULL && !reading->config->given[VOR_SET_CONFIG] &&
        (errno == ENOENT || errno == ENOTDIR))
        return VOR_OK;
    if (file == NULL)
        return vor_fail_param(err, VOR_E_PARAM, "config", "%.200s cannot be read: %s", path,
                              strerror(errno));
    for (unsigned number = 1; !is_cut && fgets(line, sizeof line, file) != NULL; number++) {
        is_cut = strchr(line, '\n') == NULL && !feof(file);
        status = is_cut ? vor_fail(&why, VOR_E_PARAM,
                                   "the line has a NUL byte, or more than %d bytes", LINE_SIZE - 2)
                        : take_line(line, number, reading->config, &why);
        if (status == VOR_OK)
            continue;
        (void)blame_line(&why, path, number);
        note(reading, &why);
    }
    status = ferror(file) ? vor_fail_param(err, VOR_E_PARAM, "config", "%.200s cannot be read: %s",
                                           path, strerror(errno))
                          : VOR_OK;
    (void)fclose(file);
    return status;
}

/* "-" has operands come in their order, whatever POSIXLY_CORRECT says; ":" tells a missing value
 * from an unknown setting, and prints nothing. */
static void read_arguments(struct reading *reading, int argc, char **argv)
{
    struct vor_config *config = reading->config;
    struct option longs[VOR_SETTING_COUNT + 1];
    vor_status status;
    struct vor_error why;
    int got, before = 0;

    memset(longs, 0, sizeof longs);
    for (int i = 0; i < VOR_SETTING_COUNT; i++)
        longs[i] = (struct option){vor_setting_infos[i].name,
                                   vor_setting_infos[i].type == VOR_TYPE_FLAG ? optional_argument
                                                                              : required_argument,
                                   NULL, LONG_SETTING + i};
    optind = 0; /* glibc's word for a new command line */
    for (; (got = getopt_long(argc, argv, "-:", longs, NULL)) != -1; before = got) {
        const char letter[] = {'-', (char)optopt, '\0'};

        if (got == OPERAND && before == '?')
            continue; /* as good as surely the value of a flag that is none */
        if (got == OPERAND) {
            status = no_setting(optarg, &why);
        } else if (got == ':') {
            status = vor_fail(&why, VOR_E_PARAM, "--%s needs a value",
                              vor_setting_infos[optopt - LONG_SETTING].name);
        } else if (got == '?') {
            const char *word = optopt == 0 ? argv[optind - 1] : letter;

            status = is_address(word + 2)
                         ? vor_fail(&why, VOR_E_PARAM, "no option %.6s%s", word, the_address)
                         : vor_option_refuse(longs, word, "serve", &why);
        } else {
            status = set(config, got - LONG_SETTING, optarg != NULL ? optarg : "1", &why);
            config->given[got - LONG_SETTING] = status == VOR_OK;
        }
        if (status != VOR_OK)
            note(reading, &why);
    }
    for (; optind < argc; optind++) {
        (void)no_setting(argv[optind], &why);
        note(reading, &why);
    }
}

/* The metrics are for the operator: beyond this machine only when that is asked for. */
static vor_status split_admin(struct vor_config *config, struct vor_error *err)
{
    const char *text = config->text[VOR_SET_ADMIN_LISTEN];
    vor_status status = VOR_OK;

    if (text[0] != '\0')
        status = vor_endpoint_parse(&config->admin, "admin-listen", text, err);
    if (status == VOR_OK && text[0] != '\0' && !config->admin.loopback &&
        config->number[VOR_SET_ADMIN_ANYWHERE] == 0)
        return vor_fail_param(err, VOR_E_PARAM, "admin-listen",
                              "--admin-listen %.80s is open to other machines: use a loopback "
                              "address or unix:/PATH, or allow access from other machines with "
                              "--admin-anywhere",
                              text);
    return status;
}

/* A wrong one would only show as links that lead nowhere. */
static vor_status check_url(const struct vor_config *config, enum vor_setting setting,
                            struct vor_error *err)
{
    const char *url = config->text[setting], *flag = vor_setting_infos[setting].name;
    size_t scheme = strncmp(url, "https://", 8) == 0 ? 8 : strncmp(url, "http://", 7) == 0 ? 7 : 0;
    size_t host = strcspn(url + scheme, "/");
    char copy[VOR_HOST_MAX + 1] = "";

    if (host < sizeof copy)
        memcpy(copy, url + scheme, host);
    if (url[0] == '\0' ||
        (scheme > 0 && vor_host_is_sound(copy) &&
         (url[scheme + host] == '\0' || vor_prefix_is_sound(url + scheme + host))))
        return VOR_OK;
    return vor_fail_param(err, VOR_E_PARAM, flag,
                          "--%s is \"%.80s\", want http://HOST or https://HOST. A port "
                          "and a path may follow (%d bytes at most), but no query",
                          flag, strchr(url, '@') == NULL ? url : "...", VOR_PREFIX_MAX);
}

static vor_status check_urls(struct vor_config *config, struct vor_error *err)
{
    vor_status status = check_url(config, VOR_SET_PUBLIC_URL, err);

    VOR_THEN(status, check_url(config, VOR_SET_BLOBS_PUBLIC_URL, err));
    if (status == VOR_OK && config->text[VOR_SET_BLOBS_PUBLIC_URL][0] != '\0' &&
        strncmp(config->text[VOR_SET_BLOBS], "s3:", 3) != 0)
        status = vor_fail_param(err, VOR_E_PARAM, "blobs-public-url",
                                "--blobs-public-url needs --blobs s3:https://HOST/BUCKET/PREFIX");
    return status;
}

/* A wrong one would only show as pages that are let in nowhere. */
static vor_status check_origins(struct vor_config *config, struct vor_error *err)
{
    static const char host[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._:[]";
    const char *list = config->text[VOR_SET_CORS_ORIGIN];

    while (*(list += strspn(list, ", ")) != '\0') {
        size_t word = strcspn(list, ", ");
        size_t scheme = strspn(list, "abcdefghijklmnopqrstuvwxyz0123456789+-.");
        size_t length = scheme > 0 && strncmp(list + scheme, "://", 3) == 0
                            ? strspn(list + scheme + 3, host)
                            : 0;

        if (length == 0 || scheme + 3 + length != word)
            return vor_fail_param(err, VOR_E_PARAM, "cors-origin",
                                  "--cors-origin holds \"%.*s\", want a list of origins such as "
                                  "https://HOST or http://HOST:PORT, without a path",
                                  (int)(word < 80 ? word : 80), list);
        list += word;
    }
    return VOR_OK;
}

static vor_status check_hosts(struct vor_config *config, struct vor_error *err)
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

/* Who shares no store with others has to do everything, and nobody to listen to. */
static vor_status check_role(struct vor_config *config, struct vor_error *err)
{
    int is_all = (enum vor_role)config->number[VOR_SET_ROLE] == VOR_ROLE_ALL;

    config->is_shared = strncmp(config->text[VOR_SET_STORE], "postgres", 8) == 0 &&
                        config->text[VOR_SET_BLOBS][0] != '\0'; /* by default they are its own */
    if (config->is_shared || (is_all && config->text[VOR_SET_STORE_LISTEN][0] == '\0'))
        return VOR_OK;
    return vor_fail_param(
        err, VOR_E_PARAM, is_all ? "store-listen" : "role",
        "%s only for daemons that share their jobs: give --store postgresql://... and --blobs "
        "s3:..., postgresql://... or dir:PATH%s",
        is_all ? "--store-listen is" : "role is api or worker, but these roles are",
        is_all ? "" : ", or --role all");
}

static vor_status check_callers(const struct vor_config *config, struct vor_error *err)
{
    /* The setting by which others than users of this machine may call. A proxy calls from this
     * machine as well, so behind one nobody is told apart by address. */
    enum vor_setting by = !config->endpoint.loopback                    ? VOR_SET_LISTEN
                          : config->trusted.count > 0                   ? VOR_SET_TRUSTED_PROXY
                          : config->text[VOR_SET_PUBLIC_URL][0] != '\0' ? VOR_SET_PUBLIC_URL
                                                                        : VOR_SETTING_COUNT;
    bool has_keys = config->text[VOR_SET_API_KEYS][0] != '\0';
    bool is_free = config->number[VOR_SET_NO_AUTH] != 0;

    if (has_keys && is_free)
        return vor_fail_param(
            err, VOR_E_PARAM, "no-auth",
            "--no-auth and --api-keys %.80s contradict each other: give only one of them",
            config->text[VOR_SET_API_KEYS]);
    if (by == VOR_SETTING_COUNT || has_keys || is_free)
        return VOR_OK;
    return vor_fail_param(
        err, VOR_E_PARAM, vor_setting_infos[by].name,
        "with --%s %.80s the daemon is open to other machines: give --api-keys FILE (voronoid "
        "key NAME makes a line for the file), or --no-auth to allow requests without a key",
        vor_setting_infos[by].name, config->text[by]);
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
                          "no folder for jobs: give --data DIR, with a path of at most 1000 "
                          "bytes");
}

static vor_status read_networks(struct vor_config *config, struct vor_error *err)
{
    return vor_networks_parse(&config->trusted, "trusted-proxy",
                              config->text[VOR_SET_TRUSTED_PROXY], err);
}

/* A fault that follows from a value: of the line that it stands on, if that is one of the file. */
static void blame(struct reading *reading, struct vor_error *why)
{
    const struct vor_config *config = reading->config;
    int setting = find_setting(why->parameter);

    if (setting >= 0 && config->line[setting] > 0)
        (void)blame_line(why, config_place(config), config->line[setting]);
    note(reading, why);
}

vor_status vor_config_read(struct vor_config *out, int argc, char **argv,
                           char *(*getenv)(const char *name), struct vor_error *err)
{
    static vor_status (*const checks[])(struct vor_config * config, struct vor_error * err) = {
        split_admin, check_urls, check_origins, check_hosts, read_networks, check_role,
    };
    struct reading reading = {.config = out, .first = {.status = VOR_OK}};
    struct vor_error why;
    size_t before;

    memset(out, 0, sizeof *out);
    /* What holds where nothing is given, or what is given is refused. */
    for (int i = 0; i < VOR_SETTING_COUNT; i++)
        if (set(reading.config, i, vor_setting_infos[i].fallback, &why) != VOR_OK)
            note(&reading, &why);
    read_arguments(&reading, argc, argv);
    for (int i = 0; i < VOR_SETTING_COUNT; i++)
        if (!out->given[i] && read_variable(out, i, getenv, &why) != VOR_OK)
            note(&reading, &why);
    if (read_file(&reading, &why) != VOR_OK)
        note(&reading, &why);
    /* What values mean, and whether they go together. Who may call cannot be said while --listen or
     * --trusted-proxy is at fault: that check comes last. */
    before = out->faults_size;
    if (vor_endpoint_parse(&out->endpoint, "listen", out->text[VOR_SET_LISTEN], &why) != VOR_OK)
        blame(&reading, &why);
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++)
        if (checks[i](out, &why) != VOR_OK)
            blame(&reading, &why);
    if (out->faults_size == before && check_callers(out, &why) != VOR_OK)
        blame(&reading, &why);
    if (find_places(out, getenv, &why) != VOR_OK)
        blame(&reading, &why);
    if (reading.first.status != VOR_OK && err != NULL)
        *err = reading.first;
    return reading.first.status;
}

int vor_config_list_has(const char *list, const char *item, size_t length,
                        int (*compare)(const char *a, const char *b, size_t length))
{
    while (*list != '\0') {
        size_t at = strspn(list, ", ");
        size_t word = strcspn(list + at, ", ");

        if (word == length && word > 0 && compare(list + at, item, length) == 0)
            return 1;
        list += at + word;
    }
    return 0;
}
