// shade.cl - one path vertex: emission, a light sample, a BSDF sample, the next ray.
//
// Unbiased path tracing with next-event estimation and multiple importance sampling (Veach 1997).
// One item per path; every item reads and writes its own columns only.
#include "kernels/gk_film.h"
#include "kernels/gk_light_grid.h"
#include "kernels/gk_passing.h"
#include "kernels/gk_radiance.h"
#include "kernels/gk_vertex.h"

#define GK_LITTLE 0.25f // of the light that a path set out with

struct gk_lights {
    const __global struct gk_light *light;
    const __global struct gk_alias *alias;
    const __global gk_u32 *cells; // of the light grid
    struct gk_environment environment;
    struct gk_cut cut;
};

// Radiance from beyond the scene, weighted against the light sample that could have found it.
GK_INLINE struct gk_vec gk_miss_radiance(const __global struct gk_frame *frame,
                                         const struct gk_lights *lights, const struct gk_path *path)
{
#ifdef GK_ENVIRONMENT_IMAGE
    const struct gk_direction_uv at = gk_environment_uv(&lights->environment, path->d);
    const gk_f32 pdf = gk_environment_pdf(&lights->environment, at) * frame->env_choice;
    const gk_f32 mis = gk_mis_weight(path->pdf, pdf);
    const gk_f32 w = path->pdf < 0.0f ? 1.0f : mis;
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

#ifdef GK_EMISSION
// Probability that a light sample from p which goes to the table takes a light of it.
GK_INLINE gk_f32 gk_table_choice(const __global struct gk_frame *frame,
                                 const struct gk_lights *lights, struct gk_vec p, gk_u32 index)
{
    const gk_f32 everywhere = gk_light_choice(lights->light, index, frame->lights);
#ifdef GK_LIGHT_GRID
    const struct gk_light_grid grid = gk_light_grid_at(frame, lights->cells, p, lights->cut);
    const gk_f32 here = gk_grid_choice(&grid, index);
    return grid.clusters > 0u ? here : everywhere;
#else
    (void)p;
    return everywhere;
#endif
}
#endif

// Radiance emitted at the hit, weighted likewise.
GK_INLINE struct gk_vec gk_found_emission(const __global struct gk_frame *frame,
                                          const struct gk_resident *scene,
                                          const struct gk_lights *lights,
                                          const struct gk_path *path, const struct gk_hit *hit)
{
#ifdef GK_EMISSION
    const gk_u32 first = GK_READ_ALONE(scene->instance, gk_instance, hit->instance, light);
    const gk_u32 index = first + (hit->triangle - GK_INSTANCE(scene, hit->instance, triangle));
    const gk_i32 sampled = (first != GK_NONE) & (frame->lights > 0u) & (path->pdf >= 0.0f);
    const gk_u32 light = sampled ? index : 0u;
    GK_CUT(lights->cut, light);
    const gk_f32 choice =
        gk_table_choice(frame, lights, path->o, light) * (1.0f - frame->env_choice);
    const gk_f32 pdf =
        gk_triangle_light_pdf(lights->light, light, gk_light_keys_at(frame, path->time), path->t,
                              gk_abs(hit->cos_g), choice);
    const gk_f32 mis = gk_mis_weight(path->pdf, pdf);
    const gk_f32 w = sampled ? mis : 1.0f;
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
                                                 struct gk_lane lane, gk_u32 order, gk_u32 depth,
                                                 const struct gk_light_receiver *to)
{
    gk_f32 u, v;
    gk_sample_ordered(lane.base, order, GK_PAIR_BOUNCE(depth, GK_PAIR_LIGHT_POINT), &u, &v);
    const gk_f32 split = frame->env_choice;
    const gk_f32 table = 1.0f - split;
    const gk_i32 sky = u < split;
    const gk_f32 part = (u - (sky ? 0.0f : split)) / (sky ? split : gk_max(table, 1e-20f));
    u = gk_clamp(part, 0.0f, 1.0f - GK_UNIT);
#ifdef GK_LIGHT_TABLE
    struct gk_light_pair whole, pair;
    gk_light_pair_make(&whole, u, v);
    pair = whole;
    gk_u32 index = gk_alias_choose(lights->alias, frame->lights, &pair, lights->cut);
    gk_f32 chosen = gk_light_choice(lights->light, index, frame->lights) * table;
    gk_f32 s1 = gk_unit_float(pair.u), s2 = pair.v;
#ifdef GK_LIGHT_GRID
    gk_f32 pick, unused;
    gk_sample_2d(lane.base, lane.index, GK_PAIR_BOUNCE(depth, GK_PAIR_LIGHT_PICK), &pick, &unused);
    const struct gk_light_grid grid = gk_light_grid_at(frame, lights->cells, to->x, lights->cut);
    const struct gk_light_fold near =
        gk_light_from_grid(&grid, lights->light, to, table, &whole, pick);
    const gk_i32 in_grid = grid.clusters > 0u;
    index = in_grid ? near.pick.light : index;
    chosen = in_grid ? near.pick.choice : chosen;
    s1 = in_grid ? near.s : s1;
    s2 = in_grid ? near.t : s2;
#endif
    GK_CUT(lights->cut, index);
    struct gk_light_sample s =
        gk_light_from_table(lights->light, index, to->keys, to->x, chosen, s1, s2);
#ifdef GK_LIGHT_GRID
    s.L = gk_scale(s.L, in_grid ? gk_grid_weight(&grid, &near) : 1.0f);
#endif
#if defined(GK_TEXTURES) && defined(GK_EMISSION_TEXTURES)
    const gk_u32 record = s.triangle == GK_NONE ? 0u : s.triangle;
    const gk_u32 texture =
        s.material == GK_NONE ? GK_NONE : GK_MATERIAL(scene, s.material, emission_texture);
    const struct gk_texel e = gk_texture_at(&scene->textures, texture, GK_TEXELS_COLOUR,
                                            gk_coordinates_at(scene, record, s.u, s.v));
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
    gk_f32 place, inside;
    gk_sample_2d(lane.base, lane.index, GK_PAIR_BOUNCE(depth, GK_PAIR_LIGHT_CHOICE), &place,
                 &inside);
    const struct gk_vec wi = gk_environment_sample(&lights->environment, u, v, place, inside);
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

// Stores the shadow ray of a light sample; its contribution counts if nothing is in the way.
GK_INLINE void gk_sample_light(__global float *wave, gk_u32 stride, gk_u32 i,
                               const __global struct gk_frame *frame,
                               const struct gk_resident *scene, const struct gk_lights *lights,
                               const struct gk_vertex *x)
{
#ifdef GK_LIGHTS
    const struct gk_path *path = &x->path;
    const struct gk_vec p = x->p;
    const gk_i32 open = x->surface.transmission > 0.0f || x->in_medium;
    const struct gk_light_receiver receiver = {p, x->hit.ns, open ? 1.0f : 0.0f,
                                               gk_light_keys_at(frame, path->time)};
    const struct gk_light_sample s =
        gk_choose_light(frame, scene, lights, x->lane, x->order, path->depth, &receiver);
    const struct gk_vec wi = gk_to_local(x->onb, s.wi);
    const struct gk_bsdf_value value = gk_vertex_eval(frame, x, s.wi, wi);
    const gk_f32 side = gk_dot(s.wi, x->hit.ng);
    const gk_i32 one_side = x->in_medium || side * wi.z > 0.0f;
    const gk_f32 w = s.delta ? 1.0f : gk_mis_weight(s.pdf, value.pdf);
    const struct gk_vec bright = gk_scale(gk_mul(gk_mul(path->beta, value.f), s.L), w / s.pdf);
    const struct gk_vec lifted = gk_vec_select(x->back, x->front, side > 0.0f);
    const struct gk_vec o = gk_vec_select(lifted, p, x->in_medium);
    // From the lifted origin to the same target: with p's distance the ray would overshoot it.
    const gk_i32 finite = s.distance < GK_INFINITY;
    const struct gk_vec to = gk_sub(gk_along(p, s.wi, finite ? s.distance : 0.0f), o);
    const gk_f32 length = gk_sqrt(gk_dot(to, to));
    const struct gk_vec d =
        gk_vec_select(s.wi, gk_scale(to, 1.0f / gk_max(length, 1e-37f)), finite);
    const gk_f32 reach = finite ? length : GK_INFINITY;
    const gk_i32 far_side = !x->in_medium && side <= 0.0f;
    const struct gk_vec c =
        gk_mul(bright, gk_way_transmittance(frame, scene, x, far_side, o, d, reach));
    const gk_i32 useful =
        x->scatters && !x->passes && one_side && gk_max3(c) > 0.0f && s.distance > 0.0f;
    GK_STORE(GK_COL_SOX, i, o.x);
    GK_STORE(GK_COL_SOY, i, o.y);
    GK_STORE(GK_COL_SOZ, i, o.z);
    GK_STORE(GK_COL_SDX, i, d.x);
    GK_STORE(GK_COL_SDY, i, d.y);
    GK_STORE(GK_COL_SDZ, i, d.z);
    GK_STORE(GK_COL_ST, i, useful ? reach : -GK_INFINITY);
    GK_STORE(GK_COL_SR, i, c.x);
    GK_STORE(GK_COL_SG, i, c.y);
    GK_STORE(GK_COL_SB, i, c.z);
    GK_STORE_U32(GK_COL_SLANE, i, path->lane);
#endif
}

// What the pass that carries coverage wants to know of the vertex. scale: 1/q.
GK_INLINE void gk_pass_coverage(__global float *wave, gk_u32 stride, gk_u32 i,
                                const struct gk_resident *scene, const struct gk_vertex *x,
                                const struct gk_next *next, gk_f32 scale, gk_i32 alive)
{
#ifdef GK_THROUGH
    gk_passing_store(wave, stride, i, scene, x, next, scale, alive);
#else
    (void)wave;
    (void)stride;
    (void)i;
    (void)scene;
    (void)x;
    (void)next;
    (void)scale;
    (void)alive;
#endif
}

// Probability with which a path goes on that has had `depth` bounces. share: of its light that this one
// leaves; carried: that which is left. Never below the share, so that a bounce can hand on no more
// coverage than it has; before roulette_start bounces only paths that carry little play, and a path that
// survives then carries GK_LITTLE again, or less where this surface is darker than the path so far.
GK_INLINE gk_f32 gk_survival(const __global struct gk_frame *frame, gk_u32 depth, gk_f32 share,
                             gk_f32 carried)
{
    const gk_i32 all = depth >= frame->roulette_start, some = depth >= frame->roulette_little;
    const gk_f32 much = carried / (GK_LITTLE * frame->weight);
    const gk_f32 more = gk_max(share, much);
    const gk_f32 q = gk_min(all ? share : more, 1.0f);
    return some ? q : 1.0f;
}

// Stores the path's next ray, or none.
GK_INLINE void gk_go_on(__global float *wave, gk_u32 stride, gk_u32 i,
                        const __global struct gk_frame *frame, const struct gk_resident *scene,
                        const struct gk_vertex *x)
{
    const gk_u32 depth = x->path.depth;
    gk_f32 u_lobe, u_roulette;
    gk_sample_2d(x->lane.base, x->lane.index, GK_PAIR_BOUNCE(depth, GK_PAIR_LOBE), &u_lobe,
                 &u_roulette);
    const struct gk_next next = gk_next_straight(x, gk_next_make(frame, x, u_lobe));
    const gk_f32 strongest = gk_max3(next.weight) * gk_next_share(x, &next);

    // One roulette rule for all jobs, blind to mattes: survive with q >= min(1, mean share).
    const gk_f32 carried = gk_max3(gk_mul(x->path.beta, next.weight));
    const gk_f32 survival = gk_survival(frame, depth, strongest, carried);
    const gk_f32 q = x->passes ? 1.0f : survival;
    const gk_i32 alive = (x->scatters || x->passes) && !x->fails && next.possible &&
                         strongest > 0.0f && u_roulette < q;
    const struct gk_vec beta =
        gk_scale(gk_mul(x->path.beta, next.weight), 1.0f / gk_max(q, 1e-30f));
    GK_STORE(GK_COL_OX, i, next.o.x);
    GK_STORE(GK_COL_OY, i, next.o.y);
    GK_STORE(GK_COL_OZ, i, next.o.z);
    GK_STORE(GK_COL_DX, i, next.d.x);
    GK_STORE(GK_COL_DY, i, next.d.y);
    GK_STORE(GK_COL_DZ, i, next.d.z);
    GK_STORE(GK_COL_T, i, alive ? GK_INFINITY : -GK_INFINITY);
    GK_STORE(GK_COL_BETA_R, i, beta.x);
    GK_STORE(GK_COL_BETA_G, i, beta.y);
    GK_STORE(GK_COL_BETA_B, i, beta.z);
    GK_STORE(GK_COL_PDF, i, next.pdf);
    GK_STORE_U32(GK_COL_DEPTH, i, depth + (x->passes ? 0u : 1u));
    GK_STORE_U32(GK_COL_GEOMETRY, i, GK_NONE);
    GK_STORE_U32(GK_COL_INSTANCE, i, GK_NONE);
    gk_store_carried(wave, stride, i, x, &next);
    gk_pass_coverage(wave, stride, i, scene, x, &next, 1.0f / gk_max(q, 1e-30f), alive);
}

#ifdef GK_FLOW
GK_INLINE struct gk_vec gk_flow_at(const __global gk_f32 *a, gk_f32 u, gk_f32 v)
{
    return gk_interpolate3(gk_vec(a[0], a[1], a[2]), gk_vec(a[3], a[4], a[5]),
                           gk_vec(a[6], a[7], a[8]), u, v);
}

// Where the first hit is a frame later and a frame earlier. What lies at infinity is a direction.
GK_INLINE void gk_store_flow(__global float *wave, gk_u32 stride,
                             const __global struct gk_frame *frame, const struct gk_resident *scene,
                             const struct gk_vertex *x, gk_u32 lane)
{
    const __global struct gk_instance *row = scene->instance + x->hit.instance;
    const gk_u32 flow_of_mover = scene->mover[row->mover == GK_NONE ? 0u : row->mover].flow;
    const gk_u32 first = row->mover == GK_NONE ? GK_NONE : flow_of_mover;
    const gk_i32 moves = first != GK_NONE && !x->missed;
    const gk_u32 of_mesh = x->hit.triangle - row->triangle;
    const __global struct gk_flow *flow = scene->flow + (moves ? first + of_mesh : 0u);
    const struct gk_vec still = gk_vec_select(
        gk_along(x->path.o, x->path.d, x->missed ? 0.0f : x->path.t), x->path.d, x->missed);
    const struct gk_vec after =
        gk_vec_select(still, gk_flow_at(flow->after, x->hit.u, x->hit.v), moves);
    const struct gk_vec before =
        gk_vec_select(still, gk_flow_at(flow->before, x->hit.u, x->hit.v), moves);
    const gk_f32 w = x->missed ? 0.0f : 1.0f;
    gk_f32 px, py, u, v;
    gk_camera_raster(frame, x->lane, &px, &py);
    gk_camera_flow(frame->to_after, after, w, px, py, &u, &v);
    GK_STORE(GK_COL_FORWARD_U, lane, u);
    GK_STORE(GK_COL_FORWARD_V, lane, v);
    gk_camera_flow(frame->to_before, before, w, px, py, &u, &v);
    GK_STORE(GK_COL_BACKWARD_U, lane, u);
    GK_STORE(GK_COL_BACKWARD_V, lane, v);
}
#endif

// The first surface behind the pixel, for mattes, alpha and AOVs; a medium hides nothing from them.
// Vertices that are none store theirs where nobody looks: a branch here costs every lane its own, for
// each number, and twice the compilation where lanes have no gathers (measured).
GK_INLINE void gk_store_first_hit(__global float *wave, gk_u32 stride,
                                  const __global struct gk_frame *frame,
                                  const struct gk_resident *scene, const struct gk_vertex *x)
{
    const gk_i32 first = x->path.depth == 0u && !x->passes;
    const gk_u32 lane = first ? x->path.lane : GK_LANE_OF_NOBODY(stride);
    const gk_i32 missed = x->missed;
    const gk_u32 matte = GK_READ_ALONE(scene->instance, gk_instance, x->hit.instance, matte);
    GK_STORE_U32(GK_COL_KEY, lane, missed ? GK_MATTE_BACKGROUND : matte);
#ifdef GK_AOVS
    const struct gk_vec forward = gk_vec(frame->forward[0], frame->forward[1], frame->forward[2]);
    const struct gk_vec eye = gk_vec(frame->origin[0], frame->origin[1], frame->origin[2]);
    const struct gk_vec p = gk_along(x->path.o, x->path.d, missed ? 0.0f : x->path.t);
    GK_STORE(GK_COL_Z, lane, missed ? 1e30f : gk_dot(gk_sub(p, eye), forward));
    GK_STORE(GK_COL_FNX, lane, missed ? 0.0f : x->hit.ns.x);
    GK_STORE(GK_COL_FNY, lane, missed ? 0.0f : x->hit.ns.y);
    GK_STORE(GK_COL_FNZ, lane, missed ? 0.0f : x->hit.ns.z);
    GK_STORE(GK_COL_AR, lane, missed ? 0.0f : x->surface.base.x);
    GK_STORE(GK_COL_AG, lane, missed ? 0.0f : x->surface.base.y);
    GK_STORE(GK_COL_AB, lane, missed ? 0.0f : x->surface.base.z);
#else
    (void)frame;
#endif
#ifdef GK_FLOW
    gk_store_flow(wave, stride, frame, scene, x, lane);
#endif
}

// Light that the path's last direction found: emitted at the hit, or from beyond the scene. A
// sample that cannot be followed is marked as one to reject.
GK_INLINE void gk_add_found(__global float *wave, gk_u32 stride,
                            const __global struct gk_frame *frame, const struct gk_resident *scene,
                            const struct gk_lights *lights, const struct gk_vertex *x)
{
    const struct gk_vec emitted = gk_found_emission(frame, scene, lights, &x->path, &x->hit);
    const struct gk_vec beyond = gk_miss_radiance(frame, lights, &x->path);
    const struct gk_vec found = gk_mul(x->path.beta, gk_vec_select(emitted, beyond, x->missed));
    const struct gk_vec seen = gk_vec_select(found, gk_splat(0.0f), x->in_medium || x->passes);
    const gk_f32 failed = x->fails ? GK_RADIANCE_NESTED : 0.0f;
    const gk_u32 lane = x->path.lane;
    gk_radiance_add(wave, stride, lane, 0u, seen.x + failed);
    gk_radiance_add(wave, stride, lane, 1u, seen.y);
    gk_radiance_add(wave, stride, lane, 2u, seen.z);
}

GK_INLINE struct gk_environment gk_environment_of(const __global struct gk_frame *frame,
                                                  const __global struct gk_env_texel *texels,
                                                  const __global struct gk_env_cell *cells,
                                                  struct gk_cut cut)
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
    e.cut = cut;
    return e;
}

// A path has never had so many bounces; the compiler does not know.
GK_INLINE struct gk_cut gk_cut_of(__global float *wave, gk_u32 stride, gk_u32 i)
{
    struct gk_cut cut = gk_cut_none();
#ifdef GK_NO_GATHERS
    cut.at = &GK_LOAD(GK_COL_CUT, i);
    cut.never = GK_LOAD_U32(GK_COL_DEPTH, i) == 0xffffffffu;
#else
    (void)wave;
    (void)stride;
    (void)i;
#endif
    return cut;
}

__kernel void shade_surface(
    __global float *restrict wave, const gk_u32 stride,
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
    const struct gk_cut cut = gk_cut_of(wave, stride, i);
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
                                      {textures, pool0, pool1, pool2, pool3, decode, cut}};
    const struct gk_lights lights = {light_table, alias, light_cells,
                                     gk_environment_of(frame, env_texels, env_cells, cut), cut};
    const struct gk_vertex x = gk_vertex_load(wave, stride, i, frame, rect, &scene);
    gk_store_first_hit(wave, stride, frame, &scene, &x);
    gk_add_found(wave, stride, frame, &scene, &lights, &x);
    gk_sample_light(wave, stride, i, frame, &scene, &lights, &x);
    gk_go_on(wave, stride, i, frame, &scene, &x);
}
