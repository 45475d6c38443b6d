/** Files of the command line: whole ones in, and out in one step or not at all. */
#ifndef VOR_CLI_FILES_H
#define VOR_CLI_FILES_H

#include "core/base/status.h"
#include "proto/text.h"
#include "server/cli/options.h"

#include <limits.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/** A whole file in memory. It is read and not mapped: a file that shrinks meanwhile must not kill
 *  us. */
struct vor_input {
    uint8_t *bytes;
    size_t size;
};

/** Reads a file, or stdin for "-". Free it with vor_input_free, also after a failure. Of what
 *  begins like no format only that beginning is read: it is enough to be refused by, and a device
 *  such as /dev/zero never ends.
 *
 *  @retval VOR_E_IO        it cannot be read (the message says why)
 *  @retval VOR_E_NOMEM
 *  @retval VOR_E_CANCELLED a signal came */
VOR_NODISCARD vor_status vor_input_read(struct vor_input *out, const char *path,
                                        struct vor_error *err);
void vor_input_free(struct vor_input *input);

/** Where a result goes: a new file beside the one it replaces, which takes its name only once it is
 *  complete and on the disk. "-" is stdout; what is no regular file (a pipe, /dev/null) is written
 *  as it comes. A signal makes writing fail. */
struct vor_output {
    FILE *file;
    int is_temporary, may_replace;
    int error; /**< errno of the first failure */
    char path[PATH_MAX], temporary[PATH_MAX];
};

/** @param[in] replace  whether a file may be replaced that has that name when this one is complete
 *  @retval VOR_E_IO it cannot be created (the message says why) */
VOR_NODISCARD vor_status vor_output_open(struct vor_output *out, const char *path, int replace,
                                         struct vor_error *err);

/** The sink's function (proto/codec.h); ctx is the output. */
int vor_output_write(void *ctx, const void *bytes, size_t size);

/** Why writing failed: cancelled, or what the system says. */
VOR_NODISCARD vor_status vor_output_fail(const struct vor_output *output, struct vor_error *err);

/** Completes the file. The output is closed whatever comes of it, and nothing is left behind after
 *  a failure.
 *
 *  @retval VOR_E_IO, VOR_E_CANCELLED */
VOR_NODISCARD vor_status vor_output_commit(struct vor_output *output, struct vor_error *err);

/** Removes what was written; nothing after a commit, or on an output that was not opened but is
 *  zero. */
void vor_output_abandon(struct vor_output *output);

/** Makes a folder, unless it is there; not those above it.
 *
 *  @retval VOR_E_IO it cannot be made (the message names it and says why) */
VOR_NODISCARD vor_status vor_folder_make(const char *path, struct vor_error *err);

/** Checks an output before it is opened. An input is never written, under whatever name. Any other
 *  regular file needs --force, or a yes: asked for on stderr if that and stdin are terminals and
 *  stdin is no input. Pipes and devices are written as they are.
 *
 *  @param[out] replace  set if a file is there and may be replaced; else 0
 *  @retval VOR_E_PARAM  it is an input, or exists and may not be replaced */
VOR_NODISCARD vor_status vor_overwrite_check(const struct vor_cli *cli, const char *path,
                                             int *replace, struct vor_error *err);

/* A document as lines for people. */

/** Whether the command's document is printed as lines: one that is meant for people (lines.c), goes
 *  to stdout, and is not asked for as JSON. */
int vor_lines_wanted(const struct vor_cli *cli);

/** Turns the command's document into lines: name, value and unit of each of its members that the
 *  JSON has, in the order of their table.
 *
 *  @param[in,out] text  JSON as vor_json_document writes it; unchanged on failure
 *
 *  @retval VOR_E_REQUEST it is no JSON
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_lines_from_json(struct vor_text *text, const struct vor_cli *cli,
                                             struct vor_error *err);

#endif
