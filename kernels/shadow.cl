// shadow.cl - adds the light samples that nothing shadowed.
#include "kernels/gk_wave.h"

__kernel void add_unoccluded(__global float *restrict wave, const gk_u32 stride, const gk_u32 n)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    if (i >= n)
        return;
    const gk_u32 lane = GK_LOAD_U32(GK_COL_SLANE, i);
    const gk_i32 visible = GK_LOAD(GK_COL_ST, i) > 0.0f; // the tracer writes -inf when occluded
    GK_STORE(GK_COL_LR, lane, GK_LOAD(GK_COL_LR, lane) + (visible ? GK_LOAD(GK_COL_SR, i) : 0.0f));
    GK_STORE(GK_COL_LG, lane, GK_LOAD(GK_COL_LG, lane) + (visible ? GK_LOAD(GK_COL_SG, i) : 0.0f));
    GK_STORE(GK_COL_LB, lane, GK_LOAD(GK_COL_LB, lane) + (visible ? GK_LOAD(GK_COL_SB, i) : 0.0f));
}
