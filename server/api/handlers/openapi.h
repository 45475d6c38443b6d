/** openapi.yaml, as it was when this binary was built. */
#ifndef VOR_SERVER_API_HANDLERS_OPENAPI_H
#define VOR_SERVER_API_HANDLERS_OPENAPI_H

#include <stddef.h>

const char *vor_openapi_text(void);
size_t vor_openapi_size(void);

#endif
