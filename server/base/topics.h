/** The topics of the help: texts of server/cli/help as they were when this binary was built, in the
 *  form of server/base/markup.h. `voronoid help TOPIC`, the manual and /docs show them. */
#ifndef VOR_SERVER_BASE_TOPICS_H
#define VOR_SERVER_BASE_TOPICS_H

#include "server/base/markup.h"

/** Topics in the order in which they are read: name, which is that of the file, and section of the
 *  manual: 1 for users, 8 for operators, 0 for both. */
#define VOR_TOPIC_TABLE(X)                                                                         \
    X(examples, 1)                                                                                 \
    X(choosing, 1)                                                                                 \
    X(parameters, 1)                                                                               \
    X(reports, 1)                                                                                  \
    X(formats, 1)                                                                                  \
    X(http, 1)                                                                                     \
    X(environment, 0)                                                                              \
    X(settings, 8)                                                                                 \
    X(container, 8)                                                                                \
    X(proxies, 8)                                                                                  \
    X(data, 8)                                                                                     \
    X(scale, 8)                                                                                    \
    X(keys, 8)                                                                                     \
    X(metrics, 8)                                                                                  \
    X(limits, 8)                                                                                   \
    X(files, 0)

struct vor_topic {
    const char *name;
    int section;
    const char *title; /**< ends at the line end, not with a NUL */
    int title_length;
    const char *text; /**< what follows the title; ends with a NUL */
};

/** Topic number `index`; false past the last. */
int vor_topic_at(struct vor_topic *out, unsigned index);

/** The topic of that name or, such as backup for data, of another word for it; false when there is
 *  none. */
int vor_topic_find(struct vor_topic *out, const char *name);

/** Calls `show` for each block of a topic in order; in the place of a table, for the blocks of
 * that.
 *
 *  @return false when memory ran out */
int vor_topic_blocks(const struct vor_topic *topic,
                     void (*show)(void *ctx, const struct vor_markup_block *block), void *ctx);

#endif
