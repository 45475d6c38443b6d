/** voronoid serve: the daemon from its first setting to its last connection. */
#ifndef VOR_SERVE_H
#define VOR_SERVE_H

/** Runs the daemon until SIGTERM or SIGINT. argv[0] is the name to show, the rest are settings
 *  (server/base/config.h), or --print-routes: then the table of routes is printed, a line a route,
 * and nothing is served.
 *
 *  @return exit status, by VOR_EXIT_TABLE (server/cli/cli_log.h) */
int vor_serve_main(int argc, char **argv);

#endif
