#include "server/base/endpoint.h"

#include "server/base/option.h"

#include <string.h>
#include <strings.h>

enum { PORT_MAX = 65535 };

vor_status vor_endpoint_parse(struct vor_endpoint *out, const char *flag, const char *text,
                              struct vor_error *err)
{
    const char *colon = strrchr(text, ':');
    size_t length = colon != NULL ? (size_t)(colon - text) : 0;

    memset(out, 0, sizeof *out);
    if (strncmp(text, "unix:", 5) == 0) {
        if (text[5] != '/' || strlen(text + 5) >= sizeof out->path)
            return vor_fail_param(err, VOR_E_PARAM, flag,
                                  "--%s is \"unix:%.120s\", want unix:/PATH with a path of at most "
                                  "%d bytes",
                                  flag, text + 5, VOR_SOCKET_PATH_MAX - 1);
        memcpy(out->path, text + 5, strlen(text + 5) + 1);
        memcpy(out->host, "localhost", sizeof "localhost");
        out->loopback = 1;
        return VOR_OK;
    }
    if (length == 0 || length >= sizeof out->host ||
        !vor_whole_read(&out->port, colon + 1, 0, PORT_MAX))
        return vor_fail_param(err, VOR_E_PARAM, flag,
                              "--%s is \"%.80s\", want HOST:PORT with a port from 0 to %d, or "
                              "unix:/PATH",
                              flag, text, PORT_MAX);
    if (text[0] == '[' && text[length - 1] == ']') {
        text++;
        length -= 2;
    }
    memcpy(out->host, text, length);
    out->loopback = strncmp(out->host, "127.", 4) == 0 || strcmp(out->host, "::1") == 0 ||
                    strcasecmp(out->host, "localhost") == 0;
    return VOR_OK;
}
