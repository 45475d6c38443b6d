/** The name of a file with bytes of a job: one rule for Content-Disposition and voronoid fetch. */
#ifndef VOR_SERVER_BASE_RESULT_NAME_H
#define VOR_SERVER_BASE_RESULT_NAME_H

/** Bytes of such a name, with the NUL: shorter than any file system's limit. */
#define VOR_RESULT_NAME_SIZE 240

/** Writes STEM.PROCESS.SUFFIX for the result cloud and STEM.OUTPUT.SUFFIX for any other, such as
 *  "bunny.resample.ply" or "bunny.report.json". The stem is the job's name after its last slash and
 *  without the suffix of a format, cut at 160 bytes; the ID if nothing is left of it. A dot at its
 *  beginning goes, and _ stands for each character that a file name of some system must not have.
 *
 *  @param[in] name    of the job, "" for none
 *  @param[in] id      of the job
 *  @param[in] output  of the process, or "input"
 *  @param[in] suffix  with its dot */
void vor_result_name(char out[VOR_RESULT_NAME_SIZE], const char *name, const char *id,
                     const char *process, const char *output, const char *suffix);

#endif
