#include "server/cli/progress.h"

#include "proto/json/json.h"
#include "server/base/clock.h"

#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define REDRAW_SECONDS 0.1
#define BAR_MAX 40
#define WORDS_WIDTH 59 /* columns beside the bar */

void vor_progress_start(struct vor_progress *progress, const struct vor_cli *cli)
{
    int to_stdout = strcmp(cli->option[VOR_OPTION_OUTPUT], "-") == 0;
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

static void write_line(struct vor_progress *progress, const struct vor_record *record)
{
    struct vor_text text;

    vor_text_init(&text, 0);
    vor_json_record(&text, record);
    vor_text_puts(&text, "\n");
    if (!text.failed)
        (void)fwrite(text.data, 1, text.size, progress->lines);
    fflush(progress->lines);
    vor_text_free(&text);
}

/* "[####----] ", or nothing where there is no room. */
static void add_bar(struct vor_text *line, int width, double fraction)
{
    if (width < 1)
        return;
    if (width > BAR_MAX)
        width = BAR_MAX;
    vor_text_puts(line, "[");
    for (int i = 0; i < width; i++)
        vor_text_puts(line, i < (int)(fraction * width) ? "#" : "-");
    vor_text_puts(line, "] ");
}

static void draw(struct vor_progress *progress, const struct vor_record *record)
{
    const struct vor_spec *spec = &progress->cli->spec;
    double fraction = vor_pace_done(spec, record);
    double left = vor_pace_left(spec, &progress->pace.first, record);
    struct vor_text line;

    vor_text_init(&line, 0);
    if (record->polish > 0)
        vor_text_printf(&line, "polish %4u/%-4u ", (unsigned)record->polish,
                        (unsigned)vor_pace_polish(spec));
    else
        vor_text_printf(&line, "%4u/%-4u ", (unsigned)record->iteration,
                        (unsigned)vor_spec_iterations(spec));
    add_bar(&line, progress->columns - WORDS_WIDTH, fraction);
    vor_text_printf(&line, "%3.0f %%  delta %.4f", 100 * fraction, record->delta);
    if (left >= 0)
        vor_text_printf(&line, "  %.0f s left", left);
    if (!line.failed)
        vor_progress_note(progress, line.data);
    vor_text_free(&line);
}

void vor_progress_record(struct vor_progress *progress, const struct vor_record *record)
{
    double now = vor_clock_seconds();
    int is_first = !progress->pace.began;

    if (progress->lines != NULL)
        write_line(progress, record);
    vor_pace_add(&progress->pace, record);
    if (progress->bar == NULL || (!is_first && now < progress->drawn_at + REDRAW_SECONDS))
        return;
    progress->drawn_at = now;
    draw(progress, record);
}

static double number_at(const struct vor_json *json, const char *name)
{
    double number = 0;

    (void)vor_json_get_number(vor_json_get(json, name), &number);
    return number;
}

static void summarise(const struct vor_progress *progress, const struct vor_json *report)
{
    const struct vor_json *seconds = vor_json_get(report, "seconds");
    const char *stopped = vor_json_get_string(vor_json_get(report, "stopped"));
    double sum = 0, polish = number_at(report, "polish_steps"), number;
    char line[256], polished[40] = "";

    for (const struct vor_json *s = vor_json_first(seconds); s != NULL; s = vor_json_next(s))
        sum += vor_json_get_number(s, &number) ? number : 0;
    if (polish > 0)
        (void)snprintf(polished, sizeof polished, " and %.0f polish steps", polish);
    (void)snprintf(line, sizeof line,
                   "%.0f points, delta %.4f after %.0f iterations%s (%.20s), %.1f s",
                   number_at(vor_json_get(report, "points"), "out"), number_at(report, "delta"),
                   number_at(report, "iterations"), polished, stopped != NULL ? stopped : "?", sum);
    vor_cli_say(progress->cli->option[VOR_OPTION_OUTPUT], line);
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
        status = vor_fail(err, VOR_E_IO, "the lines of --json cannot be written");
    vor_text_free(&text);
    vor_json_free(json);
    return status;
}
