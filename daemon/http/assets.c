// assets.c - bytes that native scenes name by hash.
#include "base/sha256.h"
#include "http/answer.h"
#include "http/resources.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool check_name(const char *name, struct glint_error *err)
{
    if (strlen(name) == 64 && strspn(name, "0123456789abcdef") == 64)
        return true;
    glint_fail(err, GLINT_E_RANGE, "",
               "\"%.80s\" is no SHA-256: 64 digits 0-9 and a-f are expected", name);
    return false;
}

static void answer(struct glint_request *r, int status, const char *name, size_t bytes)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "sha256", name);
    cJSON_AddNumberToObject(json, "bytes", (double)bytes);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    if (!text) {
        glint_answer_response(r, 0, NULL);
        return;
    }
    glint_answer_text(r, status, "application/json", text, strlen(text));
    free(text);
    glint_answer_header(r, "ETag", "\"%s\"", name);
}

void glint_http_assets_get(struct glint_request *r)
{
    const char *name = r->argument[0];
    struct glint_error err = {0};
    glint_asset_ref *ref = NULL;
    if (check_name(name, &err)) {
        ref = glint_assets_find(glint_store_assets(r->http->store), name);
        if (!ref)
            glint_fail(&err, GLINT_E_NOT_FOUND, "", "there is no asset %s", name);
    }
    char etag[68];
    snprintf(etag, sizeof etag, "\"%.64s\"", name);
    if (err.count)
        glint_answer_error(r, &err);
    else if (!glint_answer_unchanged(r, etag))
        answer(r, MHD_HTTP_OK, name, glint_asset_ref_bytes(ref)->size);
    glint_asset_ref_release(&ref);
}

// The body becomes the asset.
static glint_status keep(struct glint_request *r, struct glint_asset *asset, bool *created,
                         struct glint_error *err)
{
    r->body.bytes = NULL;
    glint_memory_ref *memory = glint_memory_ref_of_mapping(&asset->bytes, asset->size);
    if (!memory)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for an asset");
    const glint_status st = glint_store_put_asset(r->http->store, asset, memory, created, err);
    glint_memory_ref_release(&memory);
    return st;
}

void glint_http_assets_put(struct glint_request *r)
{
    struct glint_error err = {0};
    struct glint_asset asset = {.bytes = r->body.bytes, .size = r->body.length};
    bool created = false;
    const char *name = r->argument[0];
    if (check_name(name, &err) && !asset.size)
        glint_fail(&err, GLINT_E_RANGE, "", "the body is empty");
    if (!err.count) {
        glint_sha256(asset.bytes, asset.size, asset.sha256);
        if (strcmp(asset.sha256, name))
            glint_fail(&err, GLINT_E_RANGE, "", "the SHA-256 of the body is %s", asset.sha256);
        else
            keep(r, &asset, &created, &err);
    }
    if (err.count)
        glint_answer_error(r, &err);
    else
        answer(r, created ? MHD_HTTP_CREATED : MHD_HTTP_OK, name, asset.size);
}
