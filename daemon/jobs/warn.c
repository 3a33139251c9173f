#include "jobs/warn.h"

#include <stdarg.h>
#include <stdio.h>

void glint_warn(cJSON *warnings, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    cJSON_AddItemToArray(warnings, cJSON_CreateString(text));
}
