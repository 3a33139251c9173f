#include "protocol/nearest.h"

#include <stddef.h>
#include <string.h>

#define LONGEST 48 // letters; longer names are not guessed

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

// Source: optimal string alignment, the restricted Damerau-Levenshtein distance.
static size_t slips(const char *a, size_t m, const char *b, size_t n)
{
    size_t row[3][LONGEST + 1]; // of the letter before the last, the last, this one
    size_t *before = row[0], *last = row[1], *now = row[2];
    for (size_t j = 0; j <= n; j++)
        last[j] = j;
    for (size_t i = 1; i <= m; i++) {
        now[0] = i;
        for (size_t j = 1; j <= n; j++) {
            now[j] = least(last[j], now[j - 1]) + 1;
            now[j] = least(now[j], last[j - 1] + (a[i - 1] != b[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                now[j] = least(now[j], before[j - 2] + 1);
        }
        size_t *spare = before;
        before = last;
        last = now;
        now = spare;
    }
    return last[n];
}

const char *glint_nearest(const char *const *names, const char *typed)
{
    const size_t length = strlen(typed);
    const char *nearest = NULL;
    size_t fewest = length / 3 + 1; // and no more than that
    for (size_t i = 0; names[i] && length <= LONGEST; i++) {
        const size_t other = strlen(names[i]);
        if (other > LONGEST)
            continue;
        const size_t count = slips(typed, length, names[i], other);
        if (count < fewest) {
            fewest = count;
            nearest = names[i];
        }
    }
    return nearest;
}
