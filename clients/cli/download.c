#include "download.h"
#include "output.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *glint_download_kind(const char *file)
{
    if (glint_output_is(file, "exr"))
        return "exr";
    return glint_output_is(file, "png") ? "png" : NULL;
}

glint_status glint_download_file(struct glint_session *s, const char *path, const char *file,
                                 uint64_t *size, struct glint_error *err)
{
    struct glint_output_file output;
    glint_status status = glint_output_open(&output, file, err);
    if (status)
        return status;
    const struct glint_request request = {
        .method = "GET", .path = path, .receive = glint_output_write, .user = &output};
    status = glint_client_send(s->client, &request, NULL, err);
    if (size)
        *size = output.size;
    const glint_status closed = glint_output_close(&output, !status, err);
    return status ? status : closed;
}

glint_status glint_download_frame(struct glint_session *s, const struct glint_frame_request *frame,
                                  const char *file, uint64_t *size, struct glint_error *err)
{
    const bool exr = strcmp(glint_download_kind(file), "exr") == 0;
    char *path = glint_client_path("/v1/jobs/", frame->job, exr ? "/frame.exr" : "/frame.png");
    path = glint_client_query(path, exr ? "outputs" : "output", frame->outputs);
    path = glint_client_query(path, "exposure", exr ? NULL : frame->exposure);
    path = glint_client_query(path, "wait", frame->wait ? "done" : NULL);
    if (!path)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory");
    const glint_status status = glint_download_file(s, path, file, size, err);
    free(path);
    return status;
}

void glint_download_report(const struct glint_session *s, const char *file, uint64_t size)
{
    if (!s->json) {
        printf("%s: %llu bytes\n", file, (unsigned long long)size);
        return;
    }
    cJSON *document = cJSON_CreateObject();
    cJSON_AddStringToObject(document, "file", file);
    cJSON_AddNumberToObject(document, "bytes", (double)size);
    glint_session_print(document);
}
