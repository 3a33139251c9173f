// shadow.cl - adds the light samples that nothing shadowed.
#include "kernels/gk_radiance.h"

__kernel void add_unoccluded(__global float *restrict wave, const gk_u32 stride)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    const gk_u32 lane = GK_LOAD_U32(GK_COL_SLANE, i);
    const gk_i32 visible = GK_LOAD(GK_COL_ST, i) > 0.0f; // the tracer writes -inf when occluded
    gk_radiance_add(wave, stride, lane, 0u, visible ? GK_LOAD(GK_COL_SR, i) : 0.0f);
    gk_radiance_add(wave, stride, lane, 1u, visible ? GK_LOAD(GK_COL_SG, i) : 0.0f);
    gk_radiance_add(wave, stride, lane, 2u, visible ? GK_LOAD(GK_COL_SB, i) : 0.0f);
}
