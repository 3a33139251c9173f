// The contract that is served against the routes that serve it.
#include "http/contract.h"
#include "http/routes.h"

#include <ctype.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *contract; // terminated

static int load(void **state)
{
    (void)state;
    contract = strndup(glint_contract[0].text, glint_contract[0].length);
    return !contract;
}

static int unload(void **state)
{
    (void)state;
    free(contract);
    return 0;
}

// The lines after "HEAD:\n" that are indented deeper than `indent` blanks; malloc'd.
static char *block(const char *text, const char *head, int indent)
{
    char line[256];
    snprintf(line, sizeof line, "\n%*s%s:\n", indent, "", head);
    const char *from = strstr(text, line);
    if (!from)
        return NULL;
    from += strlen(line);
    const char *to = from;
    while (*to && ((int)strspn(to, " ") > indent || *to == '\n'))
        to += strcspn(to, "\n") + 1;
    return strndup(from - 1, (size_t)(to - from) + 1);
}

static char *operation(const struct glint_route *row)
{
    char path[128] = "", method[8];
    const char *hole = strstr(row->pattern, "{}");
    const char *name = !strncmp(row->pattern, "/v1/scenes", 10)   ? "{scene}"
                       : !strncmp(row->pattern, "/v1/assets", 10) ? "{sha256}"
                       : !strncmp(row->pattern, "/viewer", 7)     ? "{file}"
                       : !strncmp(row->pattern, "/problems", 9)   ? "{name}"
                                                                  : "{id}";
    if (hole)
        snprintf(path, sizeof path, "%.*s%s%s", (int)(hole - row->pattern), row->pattern, name,
                 hole + 2);
    else
        snprintf(path, sizeof path, "%s", row->pattern);
    for (size_t i = 0; i <= strlen(row->method); i++)
        method[i] = (char)tolower(row->method[i]);
    char *item = block(contract, path, 2);
    char *found = item ? block(item, method, 4) : NULL;
    free(item);
    return found;
}

static int count(const char *text, const char *what)
{
    int n = 0;
    for (; (text = strstr(text, what)); text++)
        n++;
    return n;
}

static void every_route_is_described_and_nothing_else(void **state)
{
    (void)state;
    int rows = 0, described = 0;
    for (const struct glint_route *row = glint_route_table; row->method; row++, rows++) {
        char *found = operation(row);
        if (!found)
            fail_msg("%s %s is not in the contract", row->method, row->pattern);
        free(found);
    }
    static const char *const methods[] = {"get", "put", "post", "patch", "delete"};
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
        char line[16];
        snprintf(line, sizeof line, "\n    %s:\n", methods[i]);
        described += count(contract, line);
    }
    assert_int_equal(described, rows);
}

// Parameters that several calls share are components; `name` is "names" there.
static int describes(const char *operation, const char *name)
{
    char own[64], inline_[64], quoted[64], shared[96];
    snprintf(own, sizeof own, "- name: %s\n          in: query", name);
    snprintf(inline_, sizeof inline_, "{name: %s, in: query", name);
    snprintf(quoted, sizeof quoted, "{name: \"%s\", in: query", name);
    snprintf(shared, sizeof shared, "parameters/%s%s\"}", name, strcmp(name, "name") ? "" : "s");
    return strstr(operation, own) || strstr(operation, inline_) || strstr(operation, quoted) ||
           strstr(operation, shared);
}

static void every_query_parameter_is_described_and_no_other(void **state)
{
    (void)state;
    static const char *const shared[] = {"wait", "layer", "names", "through"};
    for (const struct glint_route *row = glint_route_table; row->method; row++) {
        char *found = operation(row), names[128], *rest = names;
        int known = 0;
        snprintf(names, sizeof names, "%s", row->query);
        for (char *name; (name = strsep(&rest, " "));) {
            name[strcspn(name, "*")] = '\0';
            if (!*name)
                continue;
            known++;
            if (!describes(found, name))
                fail_msg("%s %s: %s is not in the contract", row->method, row->pattern, name);
        }
        int described = count(found, "in: query");
        for (size_t i = 0; i < sizeof shared / sizeof *shared; i++) {
            char ref[64];
            snprintf(ref, sizeof ref, "parameters/%s\"}", shared[i]);
            described += count(found, ref);
        }
        if (described != known)
            fail_msg("%s %s: %d parameters, %d described", row->method, row->pattern, known,
                     described);
        free(found);
    }
}

// As text: the names of components and definitions are keys of their own lines.
static void every_reference_leads_somewhere(void **state)
{
    (void)state;
    int references = 0;
    for (const char *at = contract; (at = strstr(at, "#/components/")); references++) {
        char name[128], line[160];
        const size_t n = strcspn(at, "\"'}");
        assert_true(n < sizeof name);
        snprintf(name, sizeof name, "%.*s", (int)n, at);
        at += n;
        const char *key = strrchr(name, '/') + 1;
        const int inside = strstr(name, "/$defs/") != NULL;
        snprintf(line, sizeof line, inside ? "\"%s\": {" : "\n    %s:", key);
        if (!strstr(contract, line))
            fail_msg("%s is not there", name);
    }
    assert_true(references > 100);
    assert_null(strstr(contract, "schema/")); // nothing outside of the document
    assert_null(strstr(contract, "scene.json"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_route_is_described_and_nothing_else),
        cmocka_unit_test(every_query_parameter_is_described_and_no_other),
        cmocka_unit_test(every_reference_leads_somewhere),
    };
    return cmocka_run_group_tests(tests, load, unload);
}
