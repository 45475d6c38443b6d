#include "server/cli/files.h"

#include "proto/codec.h"
#include "server/cli/cli_log.h"
#include "server/cli/interrupt.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BEGINNING = 4096 /* bytes, by which a format is recognised (proto/foreign.c) */ };

static vor_status cannot(struct vor_error *err, const char *what, int error)
{
    return vor_fail(err, VOR_E_IO, "cannot be %s: %s", what, strerror(error));
}

/* Reads until there are `until` bytes or no more; *more tells which. */
static vor_status read_up_to(struct vor_input *out, int fd, size_t until, bool *more,
                             struct vor_error *err)
{
    while (out->size < until) {
        ssize_t got;

        if (vor_interrupt_seen())
            return vor_interrupt_fail(err);
        got = read(fd, out->bytes + out->size, until - out->size);
        if (got < 0 && errno != EINTR)
            return cannot(err, "read", errno);
        if (got == 0)
            break;
        out->size += got > 0 ? (size_t)got : 0;
    }
    *more = out->size == until;
    return VOR_OK;
}

/* A device or a pipe may never end: only what begins like a format is read on. */
static vor_status read_all(struct vor_input *out, int fd, size_t capacity, struct vor_error *err)
{
    size_t until = BEGINNING;
    bool more = true;

    while (more) {
        uint8_t *bytes = realloc(out->bytes, capacity);
        vor_status status;

        if (bytes == NULL)
            return vor_fail(err, VOR_E_NOMEM, "%zu bytes of a file", capacity);
        out->bytes = bytes;
        status = read_up_to(out, fd, until, &more, err);
        if (status != VOR_OK)
            return status;
        if (until == BEGINNING && vor_format_sniff(bytes, out->size) == NULL)
            return VOR_OK;
        if (until == capacity)
            capacity *= 2;
        until = capacity;
    }
    return VOR_OK;
}

vor_status vor_input_read(struct vor_input *out, const char *path, struct vor_error *err)
{
    struct stat info;
    vor_status status;
    int fd;

    out->bytes = NULL;
    out->size = 0;
    fd = strcmp(path, "-") == 0 ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0 || fstat(fd, &info) != 0)
        status = cannot(err, "read", errno);
    else if (S_ISDIR(info.st_mode))
        status = cannot(err, "read", EISDIR);
    else /* of a file one byte more, so that read sees the end before the buffer is full */
        status = read_all(
            out, fd,
            S_ISREG(info.st_mode) && info.st_size > BEGINNING ? (size_t)info.st_size + 1 : 1 << 16,
            err);
    if (fd > STDIN_FILENO)
        (void)close(fd);
    return status;
}

void vor_input_free(struct vor_input *input)
{
    free(input->bytes);
    input->bytes = NULL;
    input->size = 0;
}

/* Makes a new file beside path, with the rights that a new file gets. */
static int open_temporary(struct vor_output *out)
{
    const char *slash = strrchr(out->path, '/');
    size_t folder = slash != NULL ? (size_t)(slash - out->path) + 1 : 0;
    mode_t mask;
    int fd, length;

    length = snprintf(out->temporary, sizeof out->temporary, "%.*s.voronoid-XXXXXX", (int)folder,
                      out->path);
    if (length < 0 || (size_t)length >= sizeof out->temporary) {
        errno = ENAMETOOLONG;
        return -1;
    }
    fd = mkstemp(out->temporary);
    if (fd < 0)
        return -1;
    out->is_temporary = 1;
    mask = umask(0);
    (void)umask(mask);
    (void)fchmod(fd, 0666 & ~mask);
    return fd;
}

/* Follows a link, so that the file is replaced and not the link. */
static int resolve(struct vor_output *out, const char *path)
{
    char real[PATH_MAX];

    if (realpath(path, real) == NULL) {
        if (errno != ENOENT)
            return -1;
        return snprintf(out->path, sizeof out->path, "%s", path) < (int)sizeof out->path ? 0 : -1;
    }
    memcpy(out->path, real, sizeof out->path);
    return 0;
}

vor_status vor_output_open(struct vor_output *out, const char *path, int replace,
                           struct vor_error *err)
{
    struct stat info;
    int fd = -1;

    memset(out, 0, sizeof *out);
    out->may_replace = replace;
    if (strcmp(path, "-") == 0)
        fd = dup(STDOUT_FILENO);
    else if (resolve(out, path) != 0)
        return cannot(err, "written", errno);
    else if (stat(out->path, &info) != 0 || S_ISREG(info.st_mode))
        fd = open_temporary(out);
    else
        fd = open(out->path, O_WRONLY | O_CLOEXEC);
    if (fd >= 0)
        out->file = fdopen(fd, "wb");
    if (out->file != NULL)
        return VOR_OK;
    out->error = errno;
    if (fd >= 0)
        (void)close(fd);
    vor_output_abandon(out);
    return cannot(err, "written", out->error);
}

int vor_output_write(void *ctx, const void *bytes, size_t size)
{
    struct vor_output *output = ctx;

    if (vor_interrupt_seen())
        return -1;
    if (fwrite(bytes, 1, size, output->file) == size)
        return 0;
    if (output->error == 0)
        output->error = errno;
    return -1;
}

vor_status vor_output_fail(const struct vor_output *output, struct vor_error *err)
{
    if (vor_interrupt_seen())
        return vor_interrupt_fail(err);
    return cannot(err, "written", output->error != 0 ? output->error : EIO);
}

/* A link takes no name that a file got meanwhile. Not every file system has links. */
static int take_name(const struct vor_output *output)
{
    if (!output->may_replace) {
        if (link(output->temporary, output->path) == 0) {
            (void)unlink(output->temporary);
            return 0;
        }
        if (errno == EEXIST)
            return -1;
    }
    return rename(output->temporary, output->path);
}

vor_status vor_output_commit(struct vor_output *output, struct vor_error *err)
{
    vor_status status = VOR_OK;

    /* Syncs the bytes before the file takes its name: a crash in between leaves the old file. */
    if (fflush(output->file) == 0 && (!output->is_temporary || fsync(fileno(output->file)) == 0) &&
        !vor_interrupt_seen() && (!output->is_temporary || take_name(output) == 0)) {
        output->is_temporary = 0;
    } else {
        if (output->error == 0)
            output->error = errno;
        status = vor_output_fail(output, err);
    }
    vor_output_abandon(output);
    return status;
}

void vor_output_abandon(struct vor_output *output)
{
    if (output->file != NULL)
        (void)fclose(output->file);
    output->file = NULL;
    if (output->is_temporary)
        (void)unlink(output->temporary);
    output->is_temporary = 0;
}

vor_status vor_folder_make(const char *path, struct vor_error *err)
{
    if (mkdir(path, 0777) == 0 || errno == EEXIST)
        return VOR_OK;
    return vor_fail(err, VOR_E_IO, "%.300s cannot be made: %s", path, strerror(errno));
}

static int is_same(const struct stat *output, const char *input)
{
    struct stat info;

    return (strcmp(input, "-") == 0 ? fstat(STDIN_FILENO, &info) : stat(input, &info)) == 0 &&
           info.st_dev == output->st_dev && info.st_ino == output->st_ino;
}

/* The input that the output is; NULL if it is none. */
static const char *find_input(const struct vor_cli *cli, const struct stat *output)
{
    if (cli->command->process == NULL)
        return NULL;
    for (int i = 0; i < cli->operand_count; i++)
        if (is_same(output, cli->operands[i]))
            return cli->operands[i];
    for (int i = 0; i < VOR_INPUTS_MAX; i++)
        if (cli->input[i] != NULL && is_same(output, cli->input[i]))
            return cli->input[i];
    return NULL;
}

/* Whether --force is not needed: the user says yes at the terminal. */
static int is_allowed(const struct vor_cli *cli, const char *path)
{
    char answer[16];

    for (int i = 0; i < VOR_INPUTS_MAX; i++)
        if (cli->input[i] != NULL && strcmp(cli->input[i], "-") == 0)
            return 0;
    if (!isatty(STDIN_FILENO) || !isatty(STDERR_FILENO))
        return 0;
    vor_cli_ask(path, "the file exists. Overwrite it? [y/N] ");
    if (fgets(answer, sizeof answer, stdin) != NULL)
        return answer[0] == 'y' || answer[0] == 'Y';
    fputc('\n', stderr);
    return 0;
}

vor_status vor_overwrite_check(const struct vor_cli *cli, const char *path, int *replace,
                               struct vor_error *err)
{
    int is_stdout = strcmp(path, "-") == 0;
    struct stat output;
    const char *input;

    *replace = 0;
    if ((is_stdout ? fstat(STDOUT_FILENO, &output) : stat(path, &output)) != 0 ||
        !S_ISREG(output.st_mode))
        return VOR_OK;
    input = find_input(cli, &output);
    if (input != NULL)
        return vor_fail(err, VOR_E_PARAM,
                        "the output is the input %.300s itself: give another "
                        "output",
                        strcmp(input, "-") == 0 ? "on stdin" : input);
    if (is_stdout)
        return VOR_OK;
    *replace = cli->option[VOR_OPTION_FORCE] != NULL || is_allowed(cli, path);
    return *replace ? VOR_OK
                    : vor_fail(err, VOR_E_PARAM,
                               "the file exists: use --force (-f) to "
                               "overwrite it");
}
