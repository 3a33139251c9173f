// tokens.h - who may do what: names, scopes and digests of bearer tokens, read from a file.
//
// A line is NAME SCOPE DIGEST, the digest SHA-256 of the token in 64 lower-case hex digits; empty
// lines and those that begin with # count for nothing. A name may stand on several lines: that is
// how its token is exchanged. Tokens themselves are kept nowhere.
//
// Thread-safety: find and count by any thread, beside a load; create and destroy by main.
#ifndef GLINT_BASE_TOKENS_H
#define GLINT_BASE_TOKENS_H

#include "protocol/status.h"

#include <stdbool.h>

#define GLINT_CLIENT_BYTES 65 // a client's name: [A-Za-z0-9._@-]{1,64}
#define GLINT_MAX_TOKENS 1024
#define GLINT_TOKEN_BYTES 72       // of one that glint_token_draw makes, more than enough
#define GLINT_TOKEN_LINE_BYTES 160 // of its line in the file

// Each includes those before it.
enum glint_scope { GLINT_SCOPE_NONE, GLINT_SCOPE_READ, GLINT_SCOPE_SUBMIT, GLINT_SCOPE_ADMIN };
const char *glint_scope_name(enum glint_scope scope);
bool glint_scope_find(const char *name, enum glint_scope *out); // "read", "submit", "admin"

bool glint_client_name_valid(const char *name);

typedef struct glint_tokens glint_tokens;

// Without a token nobody may anything, until a load.
glint_status glint_tokens_create(glint_tokens **out, struct glint_error *err);
void glint_tokens_destroy(glint_tokens **tokens);

// Replaces all tokens by the file's. On any fault, each of them named with its line, those before
// stay.
//   GLINT_E_IO     the file cannot be read, or others than its owner and group may write it
//   GLINT_E_RANGE  a line is malformed, a digest stands twice, or there is no token or too many
glint_status glint_tokens_load(glint_tokens *tokens, const char *path, struct glint_error *err);
// The same from text that was read elsewhere; `name` stands for the file in faults.
glint_status glint_tokens_parse(glint_tokens *tokens, const char *name, const char *text,
                                size_t length, struct glint_error *err);

// Gives `to` the tokens of `from`, and `from` those of `to`. `from` is nobody else's.
void glint_tokens_exchange(glint_tokens *to, glint_tokens *from);

size_t glint_tokens_count(glint_tokens *tokens);

// What the bearer of `secret` may, and his name. The time it takes tells nothing of the digests.
enum glint_scope glint_tokens_find(glint_tokens *tokens, const char *secret,
                                   char name[GLINT_CLIENT_BYTES]);

// Draws a new token of 256 random bits and the line that makes it good.
//   GLINT_E_RANGE  no such name or scope
//   GLINT_E_IO     no randomness
glint_status glint_token_draw(char secret[GLINT_TOKEN_BYTES], char line[GLINT_TOKEN_LINE_BYTES],
                              const char *name, enum glint_scope scope, struct glint_error *err);

#endif
