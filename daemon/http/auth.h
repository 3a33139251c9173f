// auth.h - who makes a request, and whether he may.
//
// Where the server has tokens every call but the viewer's files, the contract and the health calls
// needs one, as `Authorization: Bearer`: to look needs the scope read, to change anything submit.
// The token's name is the client's, and he sees and changes his own jobs only; the scope admin sees
// and changes all. Without tokens whoever reaches the server may everything, and is who he says in
// `Glint-Client`.
//
// Threads: the one that holds the request.
#ifndef GLINT_HTTP_AUTH_H
#define GLINT_HTTP_AUTH_H

#include "http/request.h"

// Sets r->client_name and r->scope of a request whose route is known. False: it may not, and the
// answer is there.
bool glint_auth_request(struct glint_request *r);
// Adds the fault of a Glint-Client that is no name: of a new job, whose own faults are told with it.
void glint_auth_check_name(struct glint_request *r, struct glint_error *err);

// The client whose jobs alone the request sees, NULL: all of them.
const char *glint_auth_tenant(const struct glint_request *r);

#endif
