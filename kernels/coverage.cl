// coverage.cl - the matte keys of a wave's samples go into the slot tables of their pixels.
//
// One item per pixel of one tile, all its samples in order: a pixel has one owner, so no atomics.
// Runs of equal keys are merged before the table is touched.
#include "kernels/gk_matte.h"
#include "kernels/gk_wave.h"

// tables: [256][slots + 1], the last word of a pixel counts what found no slot; from `offset` slots
// on. step: lanes from one sample of a pixel to the next.
__kernel void deposit_coverage(const __global float *restrict wave, const gk_u32 stride,
                               const gk_u32 n, const gk_u32 lane, const gk_u32 step,
                               const gk_u32 samples, __global gk_u64 *restrict tables,
                               const gk_u32 offset, const gk_u32 slots, const gk_u32 policy)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    if (i >= n)
        return;
    __global gk_u64 *table = tables + offset + i * (slots + 1u);
    gk_u32 key = GK_LOAD_U32(GK_COL_KEY, lane + i);
    gk_u64 amount = 0, lost = 0;
    for (gk_u32 s = 0; s < samples; s++) {
        const gk_u32 next = GK_LOAD_U32(GK_COL_KEY, lane + i + s * step);
        if (next != key) {
            lost += gk_matte_deposit(table, slots, key, 1u, amount, policy);
            key = next;
            amount = 0;
        }
        amount += GK_MATTE_ONE;
    }
    lost += gk_matte_deposit(table, slots, key, 1u, amount, policy);
    table[slots] += lost;
}
