#include "base/tokens.h"

#include "base/file.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#define DIGEST_BYTES 32
#define MAX_FILE_BYTES ((size_t)1 << 20)
#define SECRET_PREFIX "glint_" // so that a leaked one can be searched for
#define SECRET_BYTES 32

struct token {
    char name[GLINT_CLIENT_BYTES];
    enum glint_scope scope;
    uint8_t digest[DIGEST_BYTES];
};

struct glint_tokens {
    pthread_mutex_t mutex;
    struct token *token; // owned
    size_t count;
};

static const char *const scope_name[] = {"none", "read", "submit", "admin"};

const char *glint_scope_name(enum glint_scope scope)
{
    return scope_name[scope];
}

bool glint_scope_find(const char *name, enum glint_scope *out)
{
    for (int s = GLINT_SCOPE_READ; s <= GLINT_SCOPE_ADMIN; s++)
        if (!strcmp(name, scope_name[s])) {
            *out = (enum glint_scope)s;
            return true;
        }
    return false;
}

bool glint_client_name_valid(const char *name)
{
    static const char allowed[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._@-";
    const size_t length = strspn(name, allowed);
    return length && length < GLINT_CLIENT_BYTES && !name[length];
}

glint_status glint_tokens_create(glint_tokens **out, struct glint_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for tokens");
    pthread_mutex_init(&(*out)->mutex, NULL);
    return GLINT_OK;
}

void glint_tokens_destroy(glint_tokens **tokens)
{
    glint_tokens *t = *tokens;
    *tokens = NULL;
    if (!t)
        return;
    free(t->token);
    pthread_mutex_destroy(&t->mutex);
    free(t);
}

static bool read_digest(const char *text, uint8_t out[DIGEST_BYTES])
{
    if (strspn(text, "0123456789abcdef") != 2 * DIGEST_BYTES || text[2 * DIGEST_BYTES])
        return false;
    for (size_t i = 0; i < DIGEST_BYTES; i++) {
        const char pair[3] = {text[2 * i], text[2 * i + 1], '\0'};
        out[i] = (uint8_t)strtoul(pair, NULL, 16);
    }
    return true;
}

static bool known(const struct token *token, size_t count, const uint8_t digest[DIGEST_BYTES])
{
    for (size_t i = 0; i < count; i++)
        if (!memcmp(token[i].digest, digest, DIGEST_BYTES))
            return true;
    return false;
}

// The words of one line into *out; `where` names the line in faults. A wrong digest is not repeated
// in them: somebody may have put the token there.
static glint_status read_token(struct token *out, char *text, const char *where,
                               struct glint_error *err)
{
    char *rest = text, *word[4];
    for (size_t i = 0; i < 4; i++)
        do
            word[i] = strsep(&rest, " \t");
        while (word[i] && !*word[i]);
    if (!word[2] || word[3])
        return glint_fail(err, GLINT_E_RANGE, "", "%s: a line is NAME SCOPE DIGEST", where);
    glint_status st = GLINT_OK;
    if (glint_client_name_valid(word[0]))
        strcpy(out->name, word[0]);
    else
        st = glint_fail(err, GLINT_E_RANGE, "", "%s: a name is 1 to %d of A-Z a-z 0-9 . _ @ -",
                        where, GLINT_CLIENT_BYTES - 1);
    if (!glint_scope_find(word[1], &out->scope))
        st = glint_fail(err, GLINT_E_RANGE, "", "%s: the scope is read, submit or admin", where);
    if (!read_digest(word[2], out->digest))
        st = glint_fail(err, GLINT_E_RANGE, "", "%s: a digest is 64 of 0-9 a-f", where);
    return st;
}

// One more line, counted where it is a token.
static glint_status read_line(struct token *token, size_t *count, char *line, const char *where,
                              struct glint_error *err)
{
    line[strcspn(line, "\r")] = '\0';
    line += strspn(line, " \t");
    if (!*line || *line == '#')
        return GLINT_OK;
    if (*count == GLINT_MAX_TOKENS)
        return glint_fail(err, GLINT_E_RANGE, "", "%s: over %d tokens", where, GLINT_MAX_TOKENS);
    glint_status st = read_token(&token[*count], line, where, err);
    if (!st && known(token, *count, token[*count].digest))
        st = glint_fail(err, GLINT_E_RANGE, "", "%s: this digest stands above already", where);
    *count += !st;
    return st;
}

// Lines of `text`, which is cut up, into `token`, which has room for GLINT_MAX_TOKENS.
static glint_status read_lines(struct token *token, size_t *count, const char *name, char *text,
                               struct glint_error *err)
{
    glint_status st = GLINT_OK;
    unsigned number = 0;
    for (char *rest = text, *line; (line = strsep(&rest, "\n"));) {
        char where[300];
        snprintf(where, sizeof where, "%.256s:%u", name, ++number);
        const glint_status one = read_line(token, count, line, where, err);
        st = st ? st : one;
    }
    if (!st && !*count)
        st = glint_fail(err, GLINT_E_RANGE, "", "%s: there is no token in it", name);
    return st;
}

void glint_tokens_exchange(glint_tokens *to, glint_tokens *from)
{
    pthread_mutex_lock(&to->mutex);
    struct token *const token = to->token;
    const size_t count = to->count;
    to->token = from->token;
    to->count = from->count;
    pthread_mutex_unlock(&to->mutex);
    from->token = token;
    from->count = count;
}

static void replace(glint_tokens *tokens, struct token *token, size_t count)
{
    glint_tokens other = {.token = token, .count = count};
    glint_tokens_exchange(tokens, &other);
    free(other.token);
}

glint_status glint_tokens_parse(glint_tokens *tokens, const char *name, const char *text,
                                size_t length, struct glint_error *err)
{
    if (memchr(text, '\0', length))
        return glint_fail(err, GLINT_E_RANGE, "", "%s: it is no text", name);
    size_t count = 0;
    char *copy = strndup(text, length);
    struct token *token = calloc(GLINT_MAX_TOKENS, sizeof *token);
    const glint_status st = copy && token
                                ? read_lines(token, &count, name, copy, err)
                                : glint_fail(err, GLINT_E_NOMEM, "", "no memory for tokens");
    if (!st) {
        replace(tokens, token, count);
        token = NULL;
    }
    free(token);
    free(copy);
    return st;
}

glint_status glint_tokens_load(glint_tokens *tokens, const char *path, struct glint_error *err)
{
    char *text;
    size_t length;
    glint_status st = glint_file_read(&text, &length, path, MAX_FILE_BYTES, err);
    if (st)
        return st;
    st = glint_tokens_parse(tokens, path, text, length, err);
    free(text);
    return st;
}

size_t glint_tokens_count(glint_tokens *tokens)
{
    pthread_mutex_lock(&tokens->mutex);
    const size_t count = tokens->count;
    pthread_mutex_unlock(&tokens->mutex);
    return count;
}

static bool digest(const char *secret, uint8_t out[DIGEST_BYTES])
{
    return EVP_Digest(secret, strlen(secret), out, NULL, EVP_sha256(), NULL) == 1;
}

enum glint_scope glint_tokens_find(glint_tokens *tokens, const char *secret,
                                   char name[GLINT_CLIENT_BYTES])
{
    uint8_t wanted[DIGEST_BYTES];
    enum glint_scope scope = GLINT_SCOPE_NONE;
    *name = '\0';
    if (!digest(secret, wanted))
        return scope;
    pthread_mutex_lock(&tokens->mutex);
    for (size_t i = 0; i < tokens->count; i++) // all of them, found or not
        if (!CRYPTO_memcmp(tokens->token[i].digest, wanted, DIGEST_BYTES)) {
            scope = tokens->token[i].scope;
            strcpy(name, tokens->token[i].name);
        }
    pthread_mutex_unlock(&tokens->mutex);
    return scope;
}

static void write_hex(char *out, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++)
        snprintf(out + 2 * i, 3, "%02x", bytes[i]);
}

glint_status glint_token_draw(char secret[GLINT_TOKEN_BYTES], char line[GLINT_TOKEN_LINE_BYTES],
                              const char *name, enum glint_scope scope, struct glint_error *err)
{
    if (!glint_client_name_valid(name))
        return glint_fail(err, GLINT_E_RANGE, "", "a name is 1 to %d of A-Z a-z 0-9 . _ @ -",
                          GLINT_CLIENT_BYTES - 1);
    uint8_t random[SECRET_BYTES], sum[DIGEST_BYTES];
    strcpy(secret, SECRET_PREFIX);
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return glint_fail(err, GLINT_E_IO, "", "no random bytes are to be had");
    write_hex(secret + strlen(SECRET_PREFIX), random, sizeof random);
    if (!digest(secret, sum))
        return glint_fail(err, GLINT_E_IO, "", "no SHA-256 is to be had");
    char hex[2 * DIGEST_BYTES + 1];
    write_hex(hex, sum, sizeof sum);
    snprintf(line, GLINT_TOKEN_LINE_BYTES, "%s %s %s", name, scope_name[scope], hex);
    return GLINT_OK;
}
