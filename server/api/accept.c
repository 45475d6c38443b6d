#include "server/api/accept.h"

#include <string.h>
#include <strings.h>

bool vor_accepts(const struct vor_request *request, const char *media_type, bool absent)
{
    unsigned index = 0;
    const char *value = vor_request_header_next(request, "Accept", &index);
    size_t want = strlen(media_type);

    if (value == NULL)
        return absent;
    for (; value != NULL; value = vor_request_header_next(request, "Accept", &index)) {
        while (*value != '\0') {
            value += strspn(value, ", \t");
            if (strncasecmp(value, media_type, want) == 0 && strchr(",; \t", value[want]) != NULL)
                return true;
            value += strcspn(value, ",");
        }
    }
    return false;
}
