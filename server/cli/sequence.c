#include "server/cli/sequence.h"

#include "server/cli/cli_log.h"
#include "server/cli/interrupt.h"
#include "server/cli/work.h"

#include <stdio.h>
#include <string.h>

static int has(const struct vor_attribute_names *names, const char *name)
{
    for (unsigned i = 0; i < names->count; i++)
        if (strcmp(names->name[i], name) == 0)
            return 1;
    return 0;
}

static void add(struct vor_attribute_names *names, const char *name)
{
    if (names->count < VOR_ATTRIBUTES_MAX && !has(names, name))
        memcpy(names->name[names->count++], name, strlen(name) + 1);
}

/* Takes the attributes of a frame: others is what some frames have and some not. */
static void take(struct vor_attribute_names *common, struct vor_attribute_names *others,
                 const struct vor_cloud *cloud, int is_first)
{
    unsigned kept = 0;

    for (size_t i = 0; i < cloud->attribute_count; i++) {
        const char *name = cloud->attributes[i].name;

        if (strcmp(name, VOR_TRACK) == 0)
            continue;
        if (is_first)
            add(common, name);
        else if (!has(common, name))
            add(others, name);
    }
    for (unsigned i = 0; i < common->count; i++) {
        if (vor_cloud_find_name(cloud, common->name[i]) == NULL)
            add(others, common->name[i]);
        else if (kept++ != i)
            memcpy(common->name[kept - 1], common->name[i], sizeof common->name[i]);
    }
    common->count = kept;
}

vor_status vor_sequence_common(struct vor_attribute_names *out, const struct vor_cli *cli,
                               struct vor_error *err)
{
    struct vor_attribute_names others = {.count = 0};
    char line[512] = "not all frames have these attributes, so no result has them: ";
    struct vor_work work;
    int frames = 0;
    vor_status status = vor_work_start(&work, cli, NULL, err);

    out->count = 0;
    for (int i = 0; status == VOR_OK && i < cli->operand_count && !vor_interrupt_seen(); i++) {
        struct vor_cloud cloud;
        struct vor_error why;

        if (vor_work_load(&work, &cloud, NULL, cli->operands[i], &why) == VOR_OK)
            take(out, &others, &cloud, frames++ == 0);
        vor_cloud_free(&cloud);
    }
    vor_work_end(&work);
    for (unsigned i = 0; i < others.count; i++)
        (void)snprintf(line + strlen(line), sizeof line - strlen(line), "%s%s", i > 0 ? ", " : "",
                       others.name[i]);
    if (status == VOR_OK && others.count > 0)
        vor_cli_say(cli->command->name, line);
    return status;
}

void vor_sequence_keep(struct vor_cloud *cloud, const struct vor_attribute_names *names)
{
    size_t kept = 0;

    for (size_t i = 0; i < cloud->attribute_count; i++) {
        if (!has(names, cloud->attributes[i].name))
            vor_free(cloud->memory, cloud->attributes[i].data);
        else
            cloud->attributes[kept++] = cloud->attributes[i];
    }
    cloud->attribute_count = kept;
}
