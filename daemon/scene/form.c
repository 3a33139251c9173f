#include "scene/form.h"

#include "protocol/utf8.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#define MAX_HEADER 8192u // bytes of a part's headers

struct form {
    struct glint_files *files;
    struct glint_arena *arena;
    const char *at, *end;
    char delimiter[80]; // CR LF "--" boundary
    size_t delimiter_length;
    struct glint_error *err;
};

static bool refuse(struct form *f, const char *why)
{
    glint_fail(f->err, GLINT_E_SYNTAX, "", "part %u of the form: %s", f->files->count + 1, why);
    return false;
}

static const char *find(const char *from, const char *end, const char *what, size_t length)
{
    return memmem(from, (size_t)(end - from), what, length);
}

// ---- headers

// The value of a parameter of Content-Disposition, in the arena; NULL where it has none.
static char *parameter(struct form *f, const char *from, const char *end, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = from; (size_t)(end - at) > length + 1; at++) {
        const bool starts = at > from && strchr("; \t", at[-1]) && at[length] == '=';
        if (!starts || strncasecmp(at, name, length) != 0)
            continue;
        at += length + 1;
        const bool quoted = *at == '"';
        char *out = glint_arena_alloc(f->arena, (size_t)(end - at) + 1), *to = out;
        for (at += quoted; out && at < end && *at != (quoted ? '"' : ';'); at++) {
            if (quoted && *at == '\\' && at + 1 < end && (at[1] == '"' || at[1] == '\\'))
                at++;
            *to++ = *at;
        }
        return out;
    }
    return NULL;
}

static char *file_name(struct form *f, const char *head, const char *end)
{
    static const char wanted[] = "Content-Disposition:";
    while (head < end) {
        const char *stop = find(head, end, "\r\n", 2);
        stop = stop ? stop : end;
        if ((size_t)(stop - head) > sizeof wanted && !strncasecmp(head, wanted, sizeof wanted - 1))
            return parameter(f, head, stop, "filename");
        head = stop < end ? stop + 2 : end;
    }
    return NULL;
}

// ---- parts

static bool is_there(const struct form *f, const char *name)
{
    for (uint32_t i = 0; i < f->files->count; i++)
        if (!strcmp(f->files->file[i].name, name))
            return true;
    return false;
}

static bool add_file(struct form *f, char *name, const char *bytes, size_t size)
{
    if (!name || !*name)
        return refuse(f, "it has no filename in its Content-Disposition");
    if (f->files->count == GLINT_MAX_FORM_FILES)
        return refuse(f, "there are more parts than are read");
    glint_utf8_clean(name);
    glint_files_tidy(name);
    if (is_there(f, name))
        return refuse(f, "a file of this name came before");
    f->files->file[f->files->count++] =
        (struct glint_file){.name = name, .bytes = (const uint8_t *)bytes, .size = size};
    return true;
}

// From behind a delimiter to behind the next. *more: that is not the last one.
static bool read_part(struct form *f, bool *more)
{
    *more = f->end - f->at < 2 || memcmp(f->at, "--", 2) != 0;
    if (!*more)
        return true;
    while (f->at < f->end && (*f->at == ' ' || *f->at == '\t'))
        f->at++;
    if (f->end - f->at < 2 || memcmp(f->at, "\r\n", 2) != 0)
        return refuse(f, "its delimiter does not end its line");
    const char *head = f->at + 2;
    const char *limit = f->end - head > MAX_HEADER ? head + MAX_HEADER : f->end;
    const char *body = find(f->at, limit, "\r\n\r\n", 4);
    if (!body)
        return refuse(f, "its headers do not end");
    body += 4;
    const char *next = find(body - 2, f->end, f->delimiter, f->delimiter_length);
    if (!next)
        return refuse(f, "no delimiter follows it");
    if (!add_file(f, file_name(f, head, body - 4 > head ? body - 4 : head), body,
                  next > body ? (size_t)(next - body) : 0))
        return false;
    f->at = next + f->delimiter_length;
    return true;
}

static bool read_parts(struct form *f)
{
    // The first delimiter may stand at the very start.
    const char *first = f->at;
    const size_t length = f->delimiter_length - 2;
    if ((size_t)(f->end - first) < length || memcmp(first, f->delimiter + 2, length) != 0) {
        first = find(f->at, f->end, f->delimiter, f->delimiter_length);
        if (!first)
            return refuse(f, "the boundary of Content-Type is nowhere in the body");
        first += 2;
    }
    f->at = first + length;
    bool more = true;
    while (more)
        if (!read_part(f, &more))
            return false;
    return f->files->count != 0 || refuse(f, "there is none");
}

glint_status glint_form_read(struct glint_files *out, struct glint_arena *arena,
                             const char *boundary, const uint8_t *bytes, size_t size,
                             struct glint_error *err)
{
    struct form f = {.files = out, .arena = arena, .at = (const char *)bytes, .err = err};
    f.end = f.at + size;
    f.delimiter_length = (size_t)snprintf(f.delimiter, sizeof f.delimiter, "\r\n--%s", boundary);
    out->count = 0;
    out->file = glint_arena_array(arena, GLINT_MAX_FORM_FILES, sizeof *out->file);
    if (!out->file)
        return glint_fail(err, GLINT_E_NOMEM, "", "no memory for the files");
    return read_parts(&f) ? GLINT_OK : GLINT_E_SYNTAX;
}
