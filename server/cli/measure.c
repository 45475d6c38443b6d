/* voronoid measure: how even a cloud is, and how far from another one. */
#include "proto/json/json.h"
#include "server/cli/work.h"

#include <stdio.h>
#include <string.h>

static vor_status print(const struct vor_measure *measure, struct vor_error *err)
{
    struct vor_document document = {"measure", &vor_measure_members, measure};
    struct vor_text text;
    vor_status status;

    vor_text_init(&text, 0);
    vor_json_document(&text, &document);
    vor_text_puts(&text, "\n");
    status = vor_text_status(&text, err);
    if (status == VOR_OK &&
        (fwrite(text.data, 1, text.size, stdout) != text.size || fflush(stdout) != 0))
        status = vor_fail(err, VOR_E_IO, "the measure cannot be written");
    vor_text_free(&text);
    return status;
}

int vor_cli_measure(const struct vor_cli *cli)
{
    const char *reference_path = cli->option[VOR_OPTION_REFERENCE], *subject = cli->input;
    struct vor_cloud cloud, reference;
    struct vor_measure measure;
    struct vor_work work;
    struct vor_error err;
    vor_status status = vor_work_start(&work, cli, NULL, &err);

    vor_cloud_init(&cloud, &work.memory);
    vor_cloud_init(&reference, &work.memory);
    if (status == VOR_OK)
        status = vor_work_load(&work, &cloud, NULL, cli->input, &err);
    if (status == VOR_OK && reference_path != NULL) {
        subject = reference_path;
        status = vor_work_load(&work, &reference, NULL, reference_path, &err);
    }
    if (status == VOR_OK) {
        subject = cli->input;
        status = vor_engine_measure(&measure, &cloud, reference_path != NULL ? &reference : NULL,
                                    cli->peak, &work.run, &err);
    }
    if (status == VOR_OK)
        status = print(&measure, &err);
    vor_cloud_free(&cloud);
    vor_cloud_free(&reference);
    vor_work_end(&work);
    return status == VOR_OK ? VOR_EXIT_OK : vor_cli_fail(subject, &err);
}
