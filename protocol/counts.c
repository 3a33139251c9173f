#include "protocol/counts.h"

const char *const glint_count_name[GLINT_COUNTS] = {
    [GLINT_COUNT_NAN] = "not_a_number",  [GLINT_COUNT_INFINITE] = "infinite",
    [GLINT_COUNT_NEGATIVE] = "negative", [GLINT_COUNT_NESTED] = "nested",
    [GLINT_COUNT_BRIGHT] = "bright",     [GLINT_COUNT_CLAMPED] = "coverage_clamped",
    [GLINT_COUNT_LOST] = "coverage_lost"};

void glint_counts_add(uint64_t sum[GLINT_COUNTS], const uint64_t more[GLINT_COUNTS])
{
    for (int i = 0; i < GLINT_COUNTS; i++)
        sum[i] += more[i];
}

uint64_t glint_counts_rejected(const uint64_t count[GLINT_COUNTS])
{
    uint64_t sum = 0;
    for (int i = 0; i < GLINT_REJECTIONS; i++)
        sum += count[i];
    return sum;
}

bool glint_counts_sound(const uint64_t count[GLINT_COUNTS], uint64_t samples)
{
    return glint_counts_rejected(count) <= samples / 1000000;
}

double glint_counts_share(const uint64_t count[GLINT_COUNTS], enum glint_count which,
                          uint64_t samples)
{
    return samples ? (double)count[which] / ((double)samples * GLINT_COUNT_SAMPLE) : 0.0;
}
