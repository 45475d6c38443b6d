#include "server/cli/progress.h"

#include "proto/origin.h"
#include "server/base/clock.h"
#include "server/cli/cli_log.h"

#include <math.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define REDRAW_SECONDS 0.1
#define BAR_MAX 40
#define REST_WIDTH                                                                                 \
    42 /* columns of what follows the steps, without the bar: percent, delta, seconds left */

void vor_progress_start(struct vor_progress *progress, const struct vor_cli *cli)
{
    const char *output = cli->option[VOR_OPTION_OUTPUT];
    int to_stdout = output != NULL && strcmp(output, "-") == 0;
    int quiet = cli->option[VOR_OPTION_QUIET] != NULL;
    struct winsize window;

    memset(progress, 0, sizeof *progress);
    progress->cli = cli;
    progress->columns = 80;
    if (cli->option[VOR_OPTION_JSON] != NULL)
        progress->lines = to_stdout ? stderr : stdout;
    else if (!quiet && isatty(STDERR_FILENO))
        progress->bar = stderr;
    if (progress->bar != NULL && ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 &&
        window.ws_col > 0)
        progress->columns = window.ws_col;
}

void vor_progress_clear(struct vor_progress *progress)
{
    if (progress->bar != NULL)
        fputs("\r\x1b[K", progress->bar);
}

void vor_progress_note(struct vor_progress *progress, const char *note)
{
    if (progress->bar == NULL)
        return;
    vor_progress_clear(progress);
    fprintf(progress->bar, "%.*s", progress->columns - 1, note);
    fflush(progress->bar);
}

void vor_progress_record(struct vor_progress *progress, const struct vor_record *record)
{
    double now = vor_clock_seconds();
    int is_first = !progress->eta.began;
    const struct vor_spec *spec;
    double fraction, left;
    struct vor_text line;
    int width; /* of the bar */

    if (progress->lines != NULL) {
        struct vor_text text;

        vor_text_init(&text, 0);
        vor_json_record(&text, record);
        vor_text_puts(&text, "\n");
        if (!text.failed)
            (void)fwrite(text.data, 1, text.size, progress->lines);
        fflush(progress->lines);
        vor_text_free(&text);
    }
    vor_eta_add(&progress->eta, record);
    if (progress->bar == NULL || (!is_first && now < progress->drawn_at + REDRAW_SECONDS))
        return;
    progress->drawn_at = now;
    spec = &progress->cli->spec;
    fraction = vor_eta_done(&progress->eta, spec);
    left = vor_eta_left(&progress->eta, spec);
    vor_text_init(&line, 0);
    /* Adds "iterate   20/50   ", without the limit when it is not known. */
    vor_text_printf(&line, "%s %4u", vor_run_stage_info(record->stage)->name,
                    (unsigned)record->step);
    if (record->of > 0 || record->step == 0)
        vor_text_printf(&line, "/%-4u", (unsigned)record->of);
    vor_text_puts(&line, " ");
    width = (int)fmin(progress->columns - REST_WIDTH - (int)line.size, BAR_MAX);
    for (int i = 0; i < width; i++)
        vor_text_printf(&line, "%s%s", i == 0 ? "[" : "", i < (int)(fraction * width) ? "#" : "-");
    vor_text_puts(&line, width > 0 ? "] " : "");
    vor_text_printf(&line, "%3.0f %%", 100 * fraction);
    if (isfinite(record->delta)) /* not every stage knows it */
        vor_text_printf(&line, "  delta %.4f", record->delta);
    else if (record->mse > 0)
        vor_text_printf(&line, "  mse %.3g", record->mse);
    if (left >= 0)
        vor_text_printf(&line, "  %.0f s left", left);
    if (!line.failed)
        vor_progress_note(progress, line.data);
    vor_text_free(&line);
}

static double number_at(const struct vor_json *json, const char *name)
{
    double number = 0;

    (void)vor_json_get_number(vor_json_get(json, name), &number);
    return number;
}

void vor_progress_event(struct vor_progress *progress, const struct vor_json *event)
{
    struct vor_record record;

    if (vor_json_record_read(&record, event))
        vor_progress_record(progress, &record);
}

/* Says where zero lies in the file of the result, unless it is the input's. */
static void say_origin(const struct vor_progress *progress, const struct vor_json *report)
{
    const struct vor_json *told = vor_json_get(report, "origin");
    double origin[3] = {number_at(told, "x"), number_at(told, "y"), number_at(told, "z")};
    char text[VOR_ORIGIN_TEXT_SIZE], line[160];

    if (origin[0] == 0 && origin[1] == 0 && origin[2] == 0)
        return;
    (void)snprintf(line, sizeof line, "positions in the file are relative to the origin %s",
                   vor_origin_text(origin, text));
    vor_cli_say(progress->cli->option[VOR_OPTION_OUTPUT], line);
}

/* Says in one line what of the input is not in the result: "dropped: face (12), comment (2)". */
static void say_dropped(const struct vor_progress *progress, const struct vor_json *report)
{
    const struct vor_json *list = vor_json_get(report, "dropped");
    double invalid = number_at(report, "invalid");
    const char *before = "dropped: ";
    struct vor_text line;

    vor_text_init(&line, 0);
    if (invalid > 0) {
        vor_text_printf(&line, "%sinvalid point (%.0f)", before, invalid);
        before = ", ";
    }
    for (const struct vor_json *s = vor_json_first(list); s != NULL; s = vor_json_next(s)) {
        const char *what = vor_json_get_string(vor_json_get(s, "what"));

        vor_text_printf(&line, "%s%s (%.0f)", before, what != NULL ? what : "?",
                        number_at(s, "count"));
        before = ", ";
    }
    if (line.size > 0 && !line.failed)
        vor_cli_say(progress->cli->option[VOR_OPTION_OUTPUT], line.data);
    vor_text_free(&line);
}

/* Says each warning in a line: "warning: sigmaP is smaller ... (0.001 beside 0.02)". */
static void say_warnings(const struct vor_progress *progress, const struct vor_json *report)
{
    const struct vor_json *list = vor_json_get(report, "warnings");

    for (const struct vor_json *s = vor_json_first(list); s != NULL; s = vor_json_next(s)) {
        const char *says = vor_json_get_string(vor_json_get(s, "says"));
        char figures[64] = "", line[256];
        double value = (double)NAN;

        if (vor_json_get_number(vor_json_get(s, "value"), &value) && !isnan(value))
            (void)snprintf(figures, sizeof figures, " (value %g, threshold %g)", value,
                           number_at(s, "limit"));
        (void)snprintf(line, sizeof line, "warning: %s%s", says != NULL ? says : "?", figures);
        vor_cli_say(progress->cli->option[VOR_OPTION_OUTPUT], line);
    }
}

/* Says of a mesh whose vertices were resampled how to have its surface resampled. One face may be a
 * strip of many, so it is not counted. */
static void say_faces(const struct vor_progress *progress, const struct vor_json *report)
{
    const struct vor_cli *cli = progress->cli;
    double faces = number_at(report, "faces");
    char count[32] = "", line[96];

    if (!(faces > 0) || number_at(report, "samples") > 0 || cli->given[VOR_PARAM_SAMPLE] ||
        !vor_process_takes(cli->spec.process, VOR_PARAM_SAMPLE))
        return;
    if (faces > 1)
        (void)snprintf(count, sizeof count, "%.0f ", faces);
    (void)snprintf(line, sizeof line,
                   "the file has %sfaces: use --sample faces to resample the surface of the "
                   "faces",
                   count);
    vor_cli_say(cli->input[0], line);
}

/* Says how even a set of points is, and how far from the input: a row of a table. */
static void say_row(const struct vor_progress *progress, const char *name, double points,
                    const struct vor_json *told)
{
    const struct vor_json *apart = vor_json_get(told, "ref_to_out");
    char line[160];

    (void)snprintf(line, sizeof line,
                   "%-8s %9.0f points, delta %.4f, sigma %.3g, six neighbours %.3f, "
                   "distance from the input %.3g, at most %.3g",
                   name, points, number_at(told, "delta"), number_at(told, "sigma"),
                   number_at(told, "six_share"), number_at(apart, "mean"), number_at(apart, "max"));
    vor_cli_say(progress->cli->option[VOR_OPTION_OUTPUT], line);
}

/* Says how even the result is beside simple methods, where the request asked for it. */
static void say_baselines(const struct vor_progress *progress, const struct vor_json *report)
{
    static const char *const names[] = {"kmeans", "random", "voxel", "farthest"};
    const struct vor_json *told = vor_json_get(report, "baselines");

    if (told == NULL)
        return;
    say_row(progress, "result", number_at(vor_json_get(report, "points"), "out"), report);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const struct vor_json *one = vor_json_get(told, names[i]);

        say_row(progress, names[i], number_at(one, "points"), one);
    }
}

static void summarise(const struct vor_progress *progress, const struct vor_json *report)
{
    const struct vor_json *stages;
    const struct vor_json *seconds = vor_json_get(report, "seconds");
    const struct vor_json *pose = vor_json_get(report, "registration");
    const char *stopped = vor_json_get_string(vor_json_get(report, "stopped"));
    struct vor_report told = {0};
    double points = number_at(vor_json_get(report, "points"), "out"), sum = 0, number;
    const char *plural = points == 1 ? "" : "s";
    char line[256], steps[128], after[sizeof steps + 8] = "", end[24] = "";

    for (const struct vor_json *s = vor_json_first(seconds); s != NULL; s = vor_json_next(s))
        sum += vor_json_get_number(s, &number) ? number : 0;
    sum += number_at(vor_json_get(report, "mesh"), "seconds");
    stages = vor_json_get(report, "stages");
    for (const struct vor_json *s = vor_json_first(stages); s != NULL; s = vor_json_next(s)) {
        const char *name = vor_json_get_string(vor_json_get(s, "stage"));
        enum vor_run_stage stage = vor_run_stage_find(name != NULL ? name : "");

        if (stage != VOR_RUN_STAGE_COUNT)
            vor_report_stage(&told, stage,
                             (uint32_t)fmin(fmax(number_at(s, "steps"), 0), UINT32_MAX), 0);
    }
    /* Without steps there was nothing to end; all iterations done is the usual end. */
    if (told.stages_count > 0)
        (void)snprintf(after, sizeof after, " after %s",
                       vor_report_steps(&told, steps, sizeof steps));
    if (told.stages_count > 0 && stopped != NULL && strcmp(stopped, "iterations") != 0)
        (void)snprintf(end, sizeof end, " (%.20s)", stopped);
    if (vor_process_takes(progress->cli->spec.process, VOR_PARAM_POINTS))
        (void)snprintf(line, sizeof line, "%.0f point%s, delta %.4f%s%s, %.1f s", points, plural,
                       number_at(report, "delta"), after, end, sum);
    else if (pose != NULL)
        (void)snprintf(line, sizeof line, "%.0f point%s, overlap %.2f, trust %.2f (%.16s), %.1f s",
                       points, plural, number_at(pose, "overlap"), number_at(pose, "trust"),
                       vor_json_get_string(vor_json_get(pose, "reason")), sum);
    else
        (void)snprintf(line, sizeof line, "%.0f point%s, %.1f s", points, plural, sum);
    vor_cli_say(progress->name != NULL ? progress->name : progress->cli->option[VOR_OPTION_OUTPUT],
                line);
    say_origin(progress, report);
    say_dropped(progress, report);
    say_warnings(progress, report);
    say_faces(progress, report);
    say_baselines(progress, report);
}

vor_status vor_progress_finish(struct vor_progress *progress, const char *report, size_t size,
                               struct vor_error *err)
{
    struct vor_json *json = NULL;
    struct vor_text text;
    vor_status status = vor_json_parse(&json, report, size, err);

    vor_progress_clear(progress);
    vor_text_init(&text, 0);
    if (status == VOR_OK && progress->lines != NULL) {
        vor_json_copy(&text, json);
        vor_text_puts(&text, "\n");
        status = vor_text_status(&text, err);
    } else if (status == VOR_OK && progress->cli->option[VOR_OPTION_QUIET] == NULL) {
        summarise(progress, json);
    }
    if (status == VOR_OK && text.size > 0 &&
        (fwrite(text.data, 1, text.size, progress->lines) != text.size ||
         fflush(progress->lines) != 0 || ferror(progress->lines)))
        status = vor_fail(err, VOR_E_IO, "the output of --json cannot be written");
    vor_text_free(&text);
    vor_json_free(json);
    return status;
}
