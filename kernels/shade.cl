// shade.cl - one path vertex: emission, a light sample, a BSDF sample, the next ray.
//
// Unbiased path tracing with next-event estimation and multiple importance sampling (Veach 1997).
// One item per path; every item reads and writes its own columns only.
#include "kernels/gk_camera.h"
#include "kernels/gk_light.h"
#include "kernels/gk_surface.h"
#include "kernels/gk_wave.h"

struct gk_path {
    struct gk_vec o, d, beta;
    gk_f32 t, pdf;
    gk_u32 lane, depth;
};

struct gk_lights {
    const __global struct gk_light *light;
    const __global struct gk_alias *alias;
    const __global gk_u32 *cells; // of the light grid
    struct gk_environment environment;
};

GK_INLINE struct gk_path gk_path_load(const __global float *wave, gk_u32 stride, gk_u32 i)
{
    struct gk_path p;
    p.o = gk_vec(GK_LOAD(GK_COL_OX, i), GK_LOAD(GK_COL_OY, i), GK_LOAD(GK_COL_OZ, i));
    p.d = gk_vec(GK_LOAD(GK_COL_DX, i), GK_LOAD(GK_COL_DY, i), GK_LOAD(GK_COL_DZ, i));
    p.beta =
        gk_vec(GK_LOAD(GK_COL_BETA_R, i), GK_LOAD(GK_COL_BETA_G, i), GK_LOAD(GK_COL_BETA_B, i));
    p.t = GK_LOAD(GK_COL_T, i);
    p.pdf = GK_LOAD(GK_COL_PDF, i);
    p.lane = GK_LOAD_U32(GK_COL_LANE, i);
    p.depth = GK_LOAD_U32(GK_COL_DEPTH, i);
    return p;
}

GK_INLINE struct gk_raw_hit gk_raw_hit_load(const __global float *wave, gk_u32 stride, gk_u32 i)
{
    struct gk_raw_hit h;
    h.primitive = GK_LOAD_U32(GK_COL_PRIMITIVE, i);
    h.geometry = GK_LOAD_U32(GK_COL_GEOMETRY, i);
    h.instance = GK_LOAD_U32(GK_COL_INSTANCE, i);
    h.u = GK_LOAD(GK_COL_U, i);
    h.v = GK_LOAD(GK_COL_V, i);
    h.ng = gk_vec(GK_LOAD(GK_COL_NX, i), GK_LOAD(GK_COL_NY, i), GK_LOAD(GK_COL_NZ, i));
    return h;
}

// Radiance from beyond the scene, weighted against the light sample that could have found it.
GK_INLINE struct gk_vec gk_miss_radiance(const __global struct gk_frame *frame,
                                         const struct gk_lights *lights, const struct gk_path *path)
{
#ifdef GK_ENVIRONMENT_IMAGE
    const struct gk_direction_uv at = gk_environment_uv(&lights->environment, path->d);
    const gk_f32 pdf = gk_environment_pdf(&lights->environment, at) * frame->env_choice;
    const gk_f32 w = path->pdf < 0.0f ? 1.0f : gk_mis_weight(path->pdf, pdf);
    const struct gk_vec image = gk_scale(gk_environment_radiance(&lights->environment, at), w);
    return gk_vec_select(lights->environment.factor, image, frame->has_env_image != 0u);
#elif defined(GK_ENVIRONMENT_CONSTANT)
    (void)lights;
    (void)path;
    return gk_vec(frame->environment[0], frame->environment[1], frame->environment[2]);
#else
    (void)frame;
    (void)lights;
    (void)path;
    return gk_splat(0.0f);
#endif
}

// Radiance emitted at the hit, weighted likewise.
GK_INLINE struct gk_vec gk_found_emission(const __global struct gk_frame *frame,
                                          const struct gk_resident *scene,
                                          const struct gk_lights *lights,
                                          const struct gk_path *path, const struct gk_hit *hit)
{
#ifdef GK_EMISSION
    const __global struct gk_instance *row = scene->instance + hit->instance;
    const gk_u32 index = row->light + (hit->triangle - row->triangle);
    const gk_i32 sampled = row->light != GK_NONE && frame->lights > 0u && path->pdf >= 0.0f;
    const __global struct gk_light *light = lights->light + (sampled ? index : 0u);
    const gk_f32 choice = gk_light_choice(light, frame->lights) * (1.0f - frame->env_choice);
    const gk_f32 pdf = gk_triangle_light_pdf(light, path->t, gk_abs(hit->cos_g), choice);
    const gk_f32 w = sampled ? gk_mis_weight(path->pdf, pdf) : 1.0f;
    return gk_scale(gk_hit_emission(scene, hit), w);
#else
    (void)frame;
    (void)scene;
    (void)lights;
    (void)path;
    (void)hit;
    return gk_splat(0.0f);
#endif
}

#ifdef GK_LIGHTS
GK_INLINE struct gk_light_sample gk_choose_light(const __global struct gk_frame *frame,
                                                 const struct gk_resident *scene,
                                                 const struct gk_lights *lights,
                                                 struct gk_lane lane, gk_u32 depth, struct gk_vec p)
{
    gk_f32 choice, keep, u, v;
    gk_sample_2d(lane.base, lane.index, GK_PAIR_BOUNCE(depth, GK_PAIR_LIGHT_CHOICE), &choice,
                 &keep);
    gk_sample_2d(lane.base, lane.index, GK_PAIR_BOUNCE(depth, GK_PAIR_LIGHT_POINT), &u, &v);
    const gk_f32 split = frame->env_choice;
    const gk_f32 table = 1.0f - split;
#ifdef GK_LIGHT_TABLE
    const gk_f32 scaled = gk_clamp((choice - split) / gk_max(table, 1e-20f), 0.0f, 1.0f);
    const gk_u32 index = gk_alias_choose(lights->alias, frame->lights, scaled, keep);
    const __global struct gk_light *light = lights->light + index;
    const gk_f32 chosen = gk_light_choice(light, frame->lights) * table;
    struct gk_light_sample s = gk_light_from_table(light, p, chosen, u, v);
#ifdef GK_TEXTURES
    const gk_u32 record = s.triangle == GK_NONE ? 0u : s.triangle;
    const __global gk_f32 *uv = scene->triangle[record].uv;
    const gk_f32 w = 1.0f - s.u - s.v;
    const gk_u32 texture =
        s.material == GK_NONE ? GK_NONE : scene->material[s.material].emission_texture;
    const struct gk_texel e =
        gk_texture_fetch(&scene->textures, texture, w * uv[0] + s.u * uv[2] + s.v * uv[4],
                         w * uv[1] + s.u * uv[3] + s.v * uv[5]);
    s.L = gk_mul(s.L, gk_vec(e.r, e.g, e.b));
#else
    (void)scene;
#endif
#else
    struct gk_light_sample s;
    s.wi = gk_splat(0.0f);
    s.L = gk_splat(0.0f);
    s.pdf = 1.0f;
    s.distance = 0.0f;
    s.delta = 0;
#endif
#ifdef GK_ENVIRONMENT_IMAGE
    const gk_i32 sky = choice < split;
    const gk_f32 cell = gk_min(choice / gk_max(split, 1e-20f), 1.0f - GK_UNIT);
    const struct gk_vec wi = gk_environment_sample(&lights->environment, cell, keep, u, v);
    const struct gk_direction_uv at = gk_environment_uv(&lights->environment, wi);
    const gk_f32 pdf = gk_environment_pdf(&lights->environment, at) * split;
    s.wi = gk_vec_select(s.wi, wi, sky);
    s.L = gk_vec_select(s.L, gk_environment_radiance(&lights->environment, at), sky);
    s.pdf = sky ? pdf : s.pdf;
    s.distance = sky ? GK_INFINITY : s.distance;
    s.delta = sky ? 0 : s.delta;
#endif
    return s;
}
#endif

// What one item knows of its path vertex.
struct gk_vertex {
    struct gk_path path;
    struct gk_hit hit;
    struct gk_surface surface;
    struct gk_onb onb;         // around the shading normal
    struct gk_vec wo;          // local
    struct gk_vec front, back; // origins lifted off the surface, on the side of wo and beyond
    struct gk_lane lane;
    gk_i32 missed;
    gk_i32 scatters; // hit something and has a bounce left
};

// Stores the shadow ray of a light sample; its contribution counts if nothing is in the way.
GK_INLINE void gk_sample_light(__global float *wave, gk_u32 stride, gk_u32 i,
                               const __global struct gk_frame *frame,
                               const struct gk_resident *scene, const struct gk_lights *lights,
                               const struct gk_vertex *x)
{
#ifdef GK_LIGHTS
    const struct gk_path *path = &x->path;
    const struct gk_vec p = gk_along(path->o, path->d, path->t);
    const struct gk_light_sample s = gk_choose_light(frame, scene, lights, x->lane, path->depth, p);
    const struct gk_vec wi = gk_to_local(x->onb, s.wi);
    const struct gk_bsdf_value value = gk_bsdf_eval(&x->surface, x->wo, wi);
    const gk_f32 side = gk_dot(s.wi, x->hit.ng);
    const gk_f32 w = s.delta ? 1.0f : gk_mis_weight(s.pdf, value.pdf);
    const struct gk_vec c = gk_scale(gk_mul(gk_mul(path->beta, value.f), s.L), w / s.pdf);
    const gk_i32 useful =
        x->scatters && side * wi.z > 0.0f && gk_max3(c) > 0.0f && s.distance > 0.0f;
    const struct gk_vec o = gk_vec_select(x->back, x->front, side > 0.0f);
    // From the lifted origin to the same target: with p's distance the ray would overshoot it.
    const gk_i32 finite = s.distance < GK_INFINITY;
    const struct gk_vec to = gk_sub(gk_along(p, s.wi, finite ? s.distance : 0.0f), o);
    const gk_f32 length = gk_sqrt(gk_dot(to, to));
    const struct gk_vec d =
        gk_vec_select(s.wi, gk_scale(to, 1.0f / gk_max(length, 1e-37f)), finite);
    GK_STORE(GK_COL_SOX, i, o.x);
    GK_STORE(GK_COL_SOY, i, o.y);
    GK_STORE(GK_COL_SOZ, i, o.z);
    GK_STORE(GK_COL_SDX, i, d.x);
    GK_STORE(GK_COL_SDY, i, d.y);
    GK_STORE(GK_COL_SDZ, i, d.z);
    GK_STORE(GK_COL_ST, i, useful ? (finite ? length : GK_INFINITY) : -GK_INFINITY);
    GK_STORE(GK_COL_SR, i, c.x);
    GK_STORE(GK_COL_SG, i, c.y);
    GK_STORE(GK_COL_SB, i, c.z);
    GK_STORE_U32(GK_COL_SLANE, i, path->lane);
#endif
}

// Stores the path's next ray, or none.
GK_INLINE void gk_sample_bsdf(__global float *wave, gk_u32 stride, gk_u32 i,
                              const __global struct gk_frame *frame, const struct gk_vertex *x)
{
    const gk_u32 depth = x->path.depth;
    gk_f32 u_lobe, u_roulette, u, v;
    gk_sample_2d(x->lane.base, x->lane.index, GK_PAIR_BOUNCE(depth, GK_PAIR_LOBE), &u_lobe,
                 &u_roulette);
    gk_sample_2d(x->lane.base, x->lane.index, GK_PAIR_BOUNCE(depth, GK_PAIR_BSDF), &u, &v);
    const struct gk_bsdf_sample s = gk_bsdf_sample(&x->surface, x->wo, u_lobe, u, v);
    const struct gk_bsdf_value value = gk_bsdf_eval(&x->surface, x->wo, s.wi);
    const gk_f32 inverse = value.pdf > 1e-30f ? 1.0f / value.pdf : 0.0f;
    const struct gk_vec weight = gk_vec_select(gk_scale(value.f, inverse), s.weight, s.delta);
    const struct gk_vec d = gk_normalise(gk_to_world(x->onb, s.wi));
    const gk_f32 side = gk_dot(d, x->hit.ng);
    const gk_f32 strongest = gk_max3(weight);

    // One roulette rule for all jobs, blind to mattes: survive with q >= min(1, mean weight).
    const gk_f32 q = depth >= frame->roulette_start ? gk_min(strongest, 1.0f) : 1.0f;
    const gk_i32 alive = x->scatters && side * s.wi.z > 0.0f && strongest > 0.0f && u_roulette < q;
    const struct gk_vec beta = gk_scale(gk_mul(x->path.beta, weight), 1.0f / gk_max(q, 1e-30f));
    const struct gk_vec o = gk_vec_select(x->back, x->front, side > 0.0f);
    GK_STORE(GK_COL_OX, i, o.x);
    GK_STORE(GK_COL_OY, i, o.y);
    GK_STORE(GK_COL_OZ, i, o.z);
    GK_STORE(GK_COL_DX, i, d.x);
    GK_STORE(GK_COL_DY, i, d.y);
    GK_STORE(GK_COL_DZ, i, d.z);
    GK_STORE(GK_COL_T, i, alive ? GK_INFINITY : -GK_INFINITY);
    GK_STORE(GK_COL_BETA_R, i, beta.x);
    GK_STORE(GK_COL_BETA_G, i, beta.y);
    GK_STORE(GK_COL_BETA_B, i, beta.z);
    GK_STORE(GK_COL_PDF, i, s.delta ? -1.0f : value.pdf);
    GK_STORE_U32(GK_COL_DEPTH, i, depth + 1u);
    GK_STORE_U32(GK_COL_GEOMETRY, i, GK_NONE);
    GK_STORE_U32(GK_COL_INSTANCE, i, GK_NONE);
}

// The first hit of a camera ray, for mattes, alpha and AOVs.
GK_INLINE void gk_store_first_hit(__global float *wave, gk_u32 stride,
                                  const __global struct gk_frame *frame,
                                  const struct gk_resident *scene, const struct gk_vertex *x)
{
    const gk_u32 lane = x->path.lane;
    const gk_i32 missed = x->missed;
    const gk_u32 key = missed ? GK_MATTE_BACKGROUND : scene->instance[x->hit.instance].matte;
    GK_STORE_U32(GK_COL_KEY, lane, key);
#ifdef GK_AOVS
    const struct gk_vec forward = gk_vec(frame->forward[0], frame->forward[1], frame->forward[2]);
    GK_STORE(GK_COL_Z, lane, missed ? 1e30f : x->path.t * gk_dot(x->path.d, forward));
    GK_STORE(GK_COL_FNX, lane, missed ? 0.0f : x->hit.ns.x);
    GK_STORE(GK_COL_FNY, lane, missed ? 0.0f : x->hit.ns.y);
    GK_STORE(GK_COL_FNZ, lane, missed ? 0.0f : x->hit.ns.z);
    GK_STORE(GK_COL_AR, lane, missed ? 0.0f : x->surface.base.x);
    GK_STORE(GK_COL_AG, lane, missed ? 0.0f : x->surface.base.y);
    GK_STORE(GK_COL_AB, lane, missed ? 0.0f : x->surface.base.z);
#else
    (void)frame;
#endif
}

// Light that the path's last direction found: emitted at the hit, or from beyond the scene.
GK_INLINE void gk_add_found(__global float *wave, gk_u32 stride,
                            const __global struct gk_frame *frame, const struct gk_resident *scene,
                            const struct gk_lights *lights, const struct gk_vertex *x)
{
    const struct gk_vec emitted = gk_found_emission(frame, scene, lights, &x->path, &x->hit);
    const struct gk_vec beyond = gk_miss_radiance(frame, lights, &x->path);
    const struct gk_vec seen = gk_mul(x->path.beta, gk_vec_select(emitted, beyond, x->missed));
    const gk_u32 lane = x->path.lane;
    GK_STORE(GK_COL_LR, lane, GK_LOAD(GK_COL_LR, lane) + seen.x);
    GK_STORE(GK_COL_LG, lane, GK_LOAD(GK_COL_LG, lane) + seen.y);
    GK_STORE(GK_COL_LB, lane, GK_LOAD(GK_COL_LB, lane) + seen.z);
}

GK_INLINE struct gk_vertex gk_vertex_load(const __global float *wave, gk_u32 stride, gk_u32 i,
                                          const __global struct gk_frame *frame,
                                          const __global struct gk_wave_rect *rect,
                                          const struct gk_resident *scene)
{
    struct gk_vertex x;
    x.path = gk_path_load(wave, stride, i);
    struct gk_raw_hit raw = gk_raw_hit_load(wave, stride, i);
    x.missed = raw.geometry == GK_NONE;
    // A miss shades the first triangle of the scene and throws the result away: no divergence.
    raw.geometry = x.missed ? 0u : raw.geometry;
    raw.instance = x.missed ? GK_NONE : raw.instance;
    raw.primitive = x.missed ? 0u : raw.primitive;
    x.hit = gk_hit_decode(scene, raw, x.path.d);
    x.onb = gk_onb_make(x.hit.ns);
    x.wo = gk_to_local(x.onb, gk_negate(x.path.d));
    x.wo.z = gk_max(x.wo.z, 1e-6f);
    x.surface = gk_hit_surface(scene, &x.hit, gk_min(x.wo.z, 1.0f));
    const struct gk_vec p = gk_along(x.path.o, x.path.d, x.path.t);
    const gk_f32 lift = gk_point_error(p, x.path.t);
    x.front = gk_along(p, x.hit.ng, lift);
    x.back = gk_along(p, x.hit.ng, -lift);
    x.lane = gk_lane_at(rect, x.path.lane, frame->seed);
    x.scatters = !x.missed && x.path.depth < frame->max_bounces;
    return x;
}

GK_INLINE struct gk_environment gk_environment_of(const __global struct gk_frame *frame,
                                                  const __global struct gk_env_texel *texels,
                                                  const __global struct gk_env_cell *cells)
{
    struct gk_environment e;
    e.texel = texels;
    e.cell = cells;
    e.width = (gk_i32)frame->env_width;
    e.height = (gk_i32)frame->env_height;
    e.cell_width = (gk_i32)frame->env_cell_width;
    e.cell_height = (gk_i32)frame->env_cell_height;
    e.cosine = frame->env_cos;
    e.sine = frame->env_sin;
    e.factor = gk_vec(frame->environment[0], frame->environment[1], frame->environment[2]);
    return e;
}

__kernel void shade_surface(
    __global float *restrict wave, const gk_u32 stride, const gk_u32 n,
    const __global struct gk_frame *restrict frame,
    const __global struct gk_wave_rect *restrict rect,
    const __global struct gk_triangle *restrict triangles,
    const __global struct gk_tangent *restrict tangents, const __global struct gk_uv1 *restrict uv1,
    const __global struct gk_colour *restrict colours,
    const __global struct gk_instance *restrict instances,
    const __global struct gk_mover *restrict movers, const __global struct gk_turn *restrict turns,
    const __global struct gk_flow *restrict flows,
    const __global struct gk_material *restrict materials,
    const __global struct gk_texture *restrict textures, const __global gk_u32 *restrict pool0,
    const __global gk_u32 *restrict pool1, const __global gk_u32 *restrict pool2,
    const __global gk_u32 *restrict pool3, const __global gk_f32 *restrict decode,
    const __global struct gk_light *restrict light_table,
    const __global struct gk_alias *restrict alias, const __global gk_u32 *restrict light_cells,
    const __global gk_f32 *restrict energy, const __global struct gk_env_texel *restrict env_texels,
    const __global struct gk_env_cell *restrict env_cells)
{
    const gk_u32 i = (gk_u32)get_global_id(0);
    if (i >= n)
        return;
    const struct gk_resident scene = {triangles,
                                      tangents,
                                      uv1,
                                      colours,
                                      instances,
                                      movers,
                                      turns,
                                      flows,
                                      materials,
                                      energy,
                                      {textures, pool0, pool1, pool2, pool3, decode}};
    const struct gk_lights lights = {light_table, alias, light_cells,
                                     gk_environment_of(frame, env_texels, env_cells)};
    const struct gk_vertex x = gk_vertex_load(wave, stride, i, frame, rect, &scene);
    if (x.path.depth == 0u)
        gk_store_first_hit(wave, stride, frame, &scene, &x);
    gk_add_found(wave, stride, frame, &scene, &lights, &x);
    gk_sample_light(wave, stride, i, frame, &scene, &lights, &x);
    gk_sample_bsdf(wave, stride, i, frame, &x);
}
