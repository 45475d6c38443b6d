/* voronoid measure: how even a cloud is, and how far from another one. */
#include "proto/json/json.h"
#include "server/cli/work.h"

#include <stdio.h>
#include <string.h>

static vor_status print(const struct vor_document *document, struct vor_error *err)
{
    struct vor_text text;
    vor_status status;

    vor_text_init(&text, 0);
    vor_json_document(&text, document);
    vor_text_puts(&text, "\n");
    status = vor_text_status(&text, err);
    if (status == VOR_OK &&
        (fwrite(text.data, 1, text.size, stdout) != text.size || fflush(stdout) != 0))
        status = vor_fail(err, VOR_E_IO, "the measure cannot be written");
    vor_text_free(&text);
    return status;
}

/* The request: the table's defaults, and the peak that was given. */
static void make_request(struct vor_spec *spec, const struct vor_cli *cli)
{
    vor_spec_preset(spec, vor_process_find("measure"));
    if (cli->peak > 0)
        spec->value[VOR_PARAM_PEAK] = cli->peak;
}

static vor_status load(struct vor_artefacts *in, struct vor_work *work, const char *name,
                       const char *path, struct vor_error *err)
{
    struct vor_cloud cloud;
    vor_status status = vor_work_load(work, &cloud, NULL, path, err);

    if (status == VOR_OK)
        vor_artefacts_put_cloud(in, name, &cloud);
    return status;
}

int vor_cli_measure(const struct vor_cli *cli)
{
    const char *reference = cli->option[VOR_OPTION_REFERENCE], *subject = cli->input;
    struct vor_artefacts in, out;
    struct vor_spec spec;
    struct vor_work work;
    struct vor_error err;
    vor_status status = vor_work_start(&work, cli, NULL, &err);

    make_request(&spec, cli);
    vor_artefacts_init(&in, &work.memory);
    vor_artefacts_init(&out, &work.memory);
    if (status == VOR_OK)
        status = load(&in, &work, "cloud", cli->input, &err);
    if (status == VOR_OK && reference != NULL) {
        subject = reference;
        status = load(&in, &work, "reference", reference, &err);
    }
    if (status == VOR_OK) {
        subject = cli->input;
        status = vor_engine_run(&out, &in, &spec, &work.run, &err);
    }
    if (status == VOR_OK)
        status = print(&vor_artefacts_find(&out, "measure")->document, &err);
    vor_artefacts_free(&out);
    vor_artefacts_free(&in);
    vor_work_end(&work);
    return status == VOR_OK ? VOR_EXIT_OK : vor_cli_fail(subject, &err);
}
