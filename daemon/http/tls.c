#include "http/tls.h"

#include "base/file.h"

#include <assert.h>
#include <gnutls/abstract.h>
#include <gnutls/gnutls.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_CHAIN 16
#define MAX_FILE_BYTES ((size_t)1 << 20)

// A handshake may still use one that was replaced, so all stay until the end.
struct pair {
    struct pair *older;
    gnutls_pcert_st chain[MAX_CHAIN];
    unsigned length;
    gnutls_privkey_t key;
};

struct glint_tls {
    pthread_mutex_t mutex;
    struct pair *newest; // under it; what it points to never changes
};

static glint_tls *serving; // set before the server starts, until it has stopped

static void free_pair(struct pair *p)
{
    for (unsigned i = 0; i < p->length; i++)
        gnutls_pcert_deinit(&p->chain[i]);
    if (p->key)
        gnutls_privkey_deinit(p->key);
    free(p);
}

static glint_status refuse(struct glint_error *err, const char *path, const char *what, int code)
{
    return glint_fail(err, GLINT_E_RANGE, "", "%s: %s: %s", path, what, gnutls_strerror(code));
}

static glint_status read_chain(struct pair *p, const char *path, struct glint_error *err)
{
    gnutls_datum_t text;
    size_t length;
    const glint_status st =
        glint_file_read((char **)&text.data, &length, path, MAX_FILE_BYTES, err);
    if (st)
        return st;
    text.size = (unsigned)length;
    unsigned count = MAX_CHAIN;
    const int code = gnutls_pcert_list_import_x509_raw(p->chain, &count, &text, GNUTLS_X509_FMT_PEM,
                                                       GNUTLS_X509_CRT_LIST_FAIL_IF_UNSORTED);
    free(text.data);
    if (code < 0)
        return refuse(err, path, "no chain of certificates", code);
    p->length = count;
    return GLINT_OK;
}

static glint_status check_private(const char *path, struct glint_error *err)
{
    struct stat st;
    if (!stat(path, &st) && st.st_mode & S_IRWXO)
        return glint_fail(err, GLINT_E_IO, "", "%s: everybody may use this key (chmod o= it)",
                          path);
    return GLINT_OK;
}

static glint_status read_key(struct pair *p, const char *path, struct glint_error *err)
{
    gnutls_datum_t text;
    size_t length;
    glint_status st = check_private(path, err);
    if (!st)
        st = glint_file_read((char **)&text.data, &length, path, MAX_FILE_BYTES, err);
    if (st)
        return st;
    text.size = (unsigned)length;
    int code = gnutls_privkey_init(&p->key);
    if (!code)
        code = gnutls_privkey_import_x509_raw(p->key, &text, GNUTLS_X509_FMT_PEM, NULL, 0);
    gnutls_memset(text.data, 0, length);
    free(text.data);
    return code < 0 ? refuse(err, path, "no private key", code) : GLINT_OK;
}

// The public keys of both are the same.
static bool match(const struct pair *p)
{
    unsigned char id[2][64];
    size_t length[2] = {sizeof id[0], sizeof id[1]};
    gnutls_pubkey_t own;
    if (gnutls_pubkey_init(&own))
        return false;
    const bool same =
        !gnutls_pubkey_import_privkey(own, p->key, 0, 0) &&
        !gnutls_pubkey_get_key_id(own, GNUTLS_KEYID_USE_SHA256, id[0], &length[0]) &&
        !gnutls_pubkey_get_key_id(p->chain[0].pubkey, GNUTLS_KEYID_USE_SHA256, id[1], &length[1]) &&
        length[0] == length[1] && !memcmp(id[0], id[1], length[0]);
    gnutls_pubkey_deinit(own);
    return same;
}

glint_status glint_tls_load(glint_tls *tls, const char *cert, const char *key,
                            struct glint_error *err)
{
    struct pair *p = calloc(1, sizeof *p);
    if (!p)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for a certificate");
    glint_status st = read_chain(p, cert, err);
    const glint_status keyed = read_key(p, key, err);
    st = st ? st : keyed;
    if (!st && !match(p))
        st = glint_fail(err, GLINT_E_RANGE, "", "%s: it is not the key of %s", key, cert);
    if (st) {
        free_pair(p);
        return st;
    }
    pthread_mutex_lock(&tls->mutex);
    p->older = tls->newest;
    tls->newest = p;
    pthread_mutex_unlock(&tls->mutex);
    return GLINT_OK;
}

glint_status glint_tls_create(glint_tls **out, const char *cert, const char *key,
                              struct glint_error *err)
{
    assert(!serving);
    glint_tls *tls = *out = calloc(1, sizeof *tls);
    if (!tls)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for certificates");
    pthread_mutex_init(&tls->mutex, NULL);
    serving = tls;
    const glint_status st = glint_tls_load(tls, cert, key, err);
    if (st)
        glint_tls_destroy(out);
    return st;
}

void glint_tls_destroy(glint_tls **tls)
{
    glint_tls *t = *tls;
    *tls = NULL;
    if (!t)
        return;
    serving = NULL;
    for (struct pair *p = t->newest, *older; p; p = older) {
        older = p->older;
        free_pair(p);
    }
    pthread_mutex_destroy(&t->mutex);
    free(t);
}

static int retrieve(gnutls_session_t session, const gnutls_datum_t *authorities,
                    int authority_count, const gnutls_pk_algorithm_t *algorithm, int algorithms,
                    gnutls_pcert_st **chain, unsigned *length, gnutls_privkey_t *key)
{
    (void)session;
    (void)authorities;
    (void)authority_count;
    (void)algorithm;
    (void)algorithms;
    pthread_mutex_lock(&serving->mutex);
    struct pair *p = serving->newest;
    pthread_mutex_unlock(&serving->mutex);
    *chain = p->chain;
    *length = p->length;
    *key = p->key;
    return 0;
}

void *glint_tls_callback(void)
{
    return (void *)retrieve;
}

const char *glint_tls_priorities(void)
{
    return "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2";
}
