/** A signed request to S3 and its answer. Only s3_client.c includes this. */
#ifndef VOR_SERVER_BLOB_S3_REQUEST_H
#define VOR_SERVER_BLOB_S3_REQUEST_H

#include "proto/text.h"
#include "server/base/curl_library.h"
#include "server/blob/objects.h"

enum {
    VOR_S3_IDLE_MAX = 8,       /**< connections that are kept open */
    VOR_S3_URL_SIZE = 512,     /**< of the bucket, with the prefix */
    VOR_S3_SECRET_SIZE = 4096, /**< of a session token: some 1,000 bytes */
    VOR_S3_HEADER_SIZE = VOR_S3_SECRET_SIZE + 32
};

struct vor_s3 {
    struct vor_objects base;
    const struct vor_curl *curl;
    char bucket[2 * VOR_S3_URL_SIZE]; /**< "https://HOST/BUCKET" or "https://BUCKET.HOST" */
    char name[VOR_S3_URL_SIZE];       /**< "BUCKET" */
    char prefix[VOR_S3_URL_SIZE];     /**< "" or "PART/PART/" */
    char key_id[VOR_S3_SECRET_SIZE], secret[VOR_S3_SECRET_SIZE];
    char token[VOR_S3_HEADER_SIZE]; /**< a header; "" for none */
    char region[65];
    char sign[96]; /**< what CURLOPT_AWS_SIGV4 takes */
    CURL *idle[VOR_S3_IDLE_MAX];
    int idles;
};

struct vor_s3_call {
    struct vor_s3 *s3;
    CURL *handle;
    const char *verb;   /**< label of the metrics */
    const char *method; /**< not PUT: GET, HEAD, DELETE, or POST of body */
    const char *body;
    const char *ends; /**< an answer with 200 has this, or it is none; NULL: any is */
    const char *url;
    const char *header[3];   /**< NULL: none */
    int fd;                  /**< of the bytes that are sent; -1 for none */
    uint64_t from, size, at; /**< of those that are sent: where they stand, where the next one */
    int is_put;              /**< else bytes are received */
    int is_once;             /**< and soon over */
    int is_probe;            /**< says whether S3 answers at all */
    struct vor_text text;    /**< an answer that is no object */
    const struct vor_object_reader *reader; /**< of what is received; NULL: that is a text */
    const struct vor_blob_patience *patience;
    double began;   /**< when it was sent */
    int is_stopped; /**< the reader wants no more */
    long http;
    curl_off_t length; /**< of the answer, as it was declared */
    char etag[80];     /**< of the answer, with its quotes; cut where it is longer */
    char why[CURL_ERROR_SIZE];
};

/** Sends a request until it is answered with less than 500.
 *
 *  @retval VOR_OK   it was answered with 2xx, or with 404 for an object
 *  @retval VOR_E_IO as the functions of objects.h
 *  @retval VOR_E_NOMEM */
VOR_NODISCARD vor_status vor_s3_perform(struct vor_s3_call *call, struct vor_error *err);

/** VOR_E_IO for an answer that says no. */
vor_status vor_s3_fail(const struct vor_s3_call *call, struct vor_error *err);

/** The text of an element of an answer, "" when it has none. */
void vor_s3_element(const char *xml, const char *name, char *out, size_t size);

#endif
