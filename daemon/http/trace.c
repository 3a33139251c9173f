#include "http/trace.h"

#include "base/clock.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>

static bool is_number(const char *text, size_t digits, char end)
{
    return strspn(text, "0123456789abcdef") == digits && text[digits] == end;
}

static bool is_id(const char *text, size_t digits, char end)
{
    return is_number(text, digits, end) && strspn(text, "0") < digits;
}

static bool is_traceparent(const char *text)
{
    return !strncmp(text, "00-", 3) && is_id(text + 3, 32, '-') && is_id(text + 36, 16, '-') &&
           is_number(text + 53, 2, 0);
}

// Never zero. Without the system's randomness at least distinct.
static uint64_t draw(void)
{
    static atomic_uint_least64_t fallback; // relaxed: only distinct
    uint64_t number;
    if (getrandom(&number, sizeof number, GRND_NONBLOCK) == sizeof number && number)
        return number;
    const uint64_t count = 1 + atomic_fetch_add_explicit(&fallback, 1, memory_order_relaxed);
    return (uint64_t)(glint_now() * 1e6) << 24 | (count & 0xffffff);
}

void glint_trace_continue(char out[GLINT_TRACE_BYTES], const char *given)
{
    const unsigned long long span = draw();
    if (given && is_traceparent(given))
        // Bit 0 of the flags, the only one that has a meaning.
        snprintf(out, GLINT_TRACE_BYTES, "%.36s%016llx-0%d", given, span,
                 strchr("13579bdf", given[54]) != NULL);
    else
        snprintf(out, GLINT_TRACE_BYTES, "00-%016llx%016llx-%016llx-00", (unsigned long long)draw(),
                 (unsigned long long)draw(), span);
}
