#include "accuracy_same.h"

#include "accuracy_files.h"

#include <stdlib.h>

#define FILE_NAME "work/programme.json"

static glint_status keep(const char *folder, const cJSON *programme, struct glint_error *err)
{
    struct glint_text out = {0};
    char *text = cJSON_Print(programme);
    if (!text)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the programme");
    glint_text_add(&out, text);
    glint_text_add(&out, "\n");
    free(text);
    return glint_accuracy_save(folder, FILE_NAME, &out, err);
}

static glint_status compare(const char *folder, const cJSON *known, const cJSON *programme,
                            struct glint_error *err)
{
    glint_status st = GLINT_OK;
    const cJSON *member;
    cJSON_ArrayForEach(member, programme) {
        const cJSON *was = cJSON_GetObjectItemCaseSensitive(known, member->string);
        if (cJSON_Compare(was, member, true))
            continue;
        char *before = cJSON_PrintUnformatted(was), *now = cJSON_PrintUnformatted(member);
        st = glint_fail(err, GLINT_E_CONFLICT, "",
                        "%s: the report there has %.80s as its %s, not %.80s; give another folder "
                        "(-o), or remove that one",
                        folder, before ? before : "nothing", member->string, now ? now : "nothing");
        free(before);
        free(now);
    }
    return st;
}

glint_status glint_accuracy_same(const char *folder, const cJSON *programme,
                                 struct glint_error *err)
{
    char *text;
    glint_status st = glint_accuracy_load(&text, folder, FILE_NAME, err);
    if (st)
        return st;
    if (!text)
        return keep(folder, programme, err);
    cJSON *known = cJSON_Parse(text);
    st = known ? compare(folder, known, programme, err)
               : glint_fail(err, GLINT_E_SYNTAX, "", "%s/" FILE_NAME " is no JSON", folder);
    cJSON_Delete(known);
    free(text);
    return st;
}
