/** A job whose request is a form (multipart/form-data), as browsers and curl -F send it: text
 *  fields are parameters, files are inputs by name, in any order. */
#ifndef VOR_SERVER_API_HANDLERS_SUBMIT_FORM_H
#define VOR_SERVER_API_HANDLERS_SUBMIT_FORM_H

#include "server/api/app.h"
#include "server/work/upload.h"

struct vor_submit_head;

/** A form on its way in. */
struct vor_submit_form;

/** Begins with the Content-Type of the request.
 *
 *  @param[in,out] head     gets the parameters; outlives the form, as do the next
 *  @param[in,out] uploads  none yet; gets the files, those of a form that is refused as well
 *
 *  @return NULL after a problem has been replied */
struct vor_submit_form *vor_submit_form_begin(struct vor_app *app, struct vor_request *request,
                                              struct vor_submit_head *head,
                                              struct vor_uploads *uploads);

/** form may be NULL. */
void vor_submit_form_free(struct vor_submit_form *form);

/** Takes the next bytes: a body sink's write (server/http/http.h), whose ctx is the form. A form
 *  that is refused is read on for a while, so that its sender can read the refusal, then cut off
 *  with it. */
int vor_submit_form_take(void *form, const void *bytes, size_t size);

/** The body is over: checks that the form is whole, that the process has the inputs it needs, and
 *  the parameters together.
 *
 *  @return true, or false after a problem has been replied */
bool vor_submit_form_end(struct vor_submit_form *form);

#endif
