// gltf_animations.c - channels of animations, each with its keys.
//
// Source: glTF 2.0, "Animations".
#include "scene/gltf_file.h"

#include <math.h>
#include <stdio.h>

#define MAX_NUMBERS (1u << 26) // of all keys of all channels
// Lengths of quaternions: bytes leave an error of 0.008.
#define UNIT_TOLERANCE 1e-6
#define CUBIC_TOLERANCE 0.02
#define MAX_LENGTH 1e6

struct reading {
    struct glint_gltf *g;
    uint64_t numbers;
    // of the animation at hand
    uint32_t number;
    const char *name;
    struct glint_json list; // its samplers
    const cJSON **sampler;
    uint32_t samplers;
};

// --- targets

// What weights move: as many numbers as the node's mesh has targets.
static bool read_width(struct glint_gltf *g, const struct glint_json *target,
                       struct glint_animation_channel *c)
{
    static const uint32_t width[] = {3, 4, 3, 0};
    c->width = width[c->path];
    if (c->path != GLINT_PATH_WEIGHTS)
        return true;
    const struct glint_json node = glint_gltf_item(g, GLTF_NODES, c->node);
    c->width = glint_gltf_targets(g, &node);
    return c->width || glint_json_fault(target, "node %u has no morph targets", c->node);
}

static bool once(struct reading *r, const struct glint_json *target,
                 const struct glint_animation_channel *c)
{
    uint32_t *last = &r->g->node[c->node].channel[c->path];
    if (*last == r->number + 1)
        return glint_json_fault(target, "the animation has this node and path twice");
    *last = r->number + 1;
    return true;
}

// False: the channel is not for us, or has a fault.
static bool read_target(struct reading *r, const struct glint_json *at,
                        struct glint_animation_channel *c)
{
    static const char *const paths[] = {"translation", "rotation", "scale",
                                        "weights",     "pointer",  NULL};
    struct glint_gltf *g = r->g;
    const struct glint_json target = glint_gltf_object(at, "target");
    const struct glint_json path = glint_json_member(&target, "path");
    struct glint_json hold[2];
    int choice = 0;
    if (!glint_json_require(&target) || !glint_json_require(&path) ||
        !glint_json_choice(&path, paths, &choice))
        return false;
    if (choice > GLINT_PATH_WEIGHTS ||
        glint_gltf_extension(&target, "KHR_animation_pointer", hold)) {
        glint_gltf_note(g, "KHR_animation_pointer",
                        "a channel of animation \"%.200s\" with KHR_animation_pointer is ignored",
                        r->name);
        return false;
    }
    c->path = (enum glint_channel_path)choice;
    c->node = glint_gltf_index(g, &target, "node", GLTF_NODES);
    if (c->node == GLINT_NONE)
        return false; // for some extension to say
    if (!g->node[c->node].reached) {
        glint_gltf_note(g, "channel outside of the scene",
                        "a channel of animation \"%.200s\" moves node %u, which the scene does not "
                        "show; it is ignored",
                        r->name, c->node);
        return false;
    }
    return read_width(g, &target, c) && once(r, &target, c);
}

// --- keys

// The accessor's floats, read once for all channels that share them; NULL after a fault.
static const float *read_floats(struct glint_gltf *g, const struct glint_gltf_accessor *a)
{
    if (g->floats[a->number])
        return g->floats[a->number];
    const size_t count = (size_t)a->count * a->components;
    float *f = glint_arena_array(&g->scene->arena, count, sizeof *f);
    if (!f) {
        glint_gltf_nomem(g);
        return NULL;
    }
    if (!glint_gltf_accessor_floats(g, a, f))
        return NULL;
    for (size_t i = 0; i < count; i++)
        if (!(fabsf(f[i]) <= GLINT_MAX_COORDINATE)) {
            glint_gltf_accessor_fault(g, a, "element %zu has the number %g", i / a->components,
                                      (double)f[i]);
            return NULL;
        }
    g->floats[a->number] = f;
    return f;
}

static bool read_times(struct glint_gltf *g, const struct glint_json *sampler,
                       struct glint_animation_channel *c)
{
    const struct glint_json at = glint_json_member(sampler, "input");
    struct glint_gltf_accessor a;
    if (!glint_json_require(&at))
        return false;
    const uint32_t index = glint_gltf_index(g, sampler, "input", GLTF_ACCESSORS);
    if (index == GLINT_NONE || !glint_gltf_accessor_read(g, index, &a))
        return false;
    if (a.components != 1 || a.type != GLTF_F32)
        return glint_json_fault(&at, "accessor %u does not hold times: scalar floats", index);
    c->keys = a.count;
    c->time = read_floats(g, &a);
    if (!c->time)
        return false;
    if (c->time[0] < 0 || c->time[c->keys - 1] > GLINT_MAX_SECONDS)
        return glint_gltf_accessor_fault(g, &a, "the times go from %g to %g: not within 0 to %g",
                                         (double)c->time[0], (double)c->time[c->keys - 1],
                                         (double)GLINT_MAX_SECONDS);
    for (uint32_t k = 1; k < c->keys; k++)
        if (c->time[k] <= c->time[k - 1])
            return glint_gltf_accessor_fault(g, &a, "time %u is %g, not after %g", k,
                                             (double)c->time[k], (double)c->time[k - 1]);
    return true;
}

static bool fits_path(const struct glint_gltf_accessor *a, enum glint_channel_path path)
{
    static const uint32_t components[] = {3, 4, 3, 1};
    const bool fraction = a->normalized && a->type != GLTF_U32 &&
                          (path == GLINT_PATH_ROTATION || path == GLINT_PATH_WEIGHTS);
    return a->components == components[path] && (a->type == GLTF_F32 || fraction);
}

static double length4(const float *q)
{
    return sqrt((double)q[0] * q[0] + (double)q[1] * q[1] + (double)q[2] * q[2] +
                (double)q[3] * q[3]);
}

static bool make_unit(struct glint_gltf *g, struct glint_animation_channel *c)
{
    float *unit = glint_arena_array(&g->scene->arena, c->keys, 4 * sizeof *unit);
    if (!unit)
        return glint_gltf_nomem(g);
    for (size_t i = 0; i < (size_t)c->keys * 4; i++)
        unit[i] = (float)((double)c->value[i] / length4(c->value + i / 4 * 4));
    c->value = unit;
    return true;
}

// Those between which a spline runs keep their length, which their tangents belong to.
static bool check_rotations(struct glint_gltf *g, const struct glint_gltf_accessor *a,
                            struct glint_animation_channel *c)
{
    const bool cubic = c->interpolation == GLINT_INTERPOLATION_CUBICSPLINE;
    double worst = 0;
    for (uint32_t k = 0; k < c->keys; k++) {
        const double length = length4(c->value + (size_t)(cubic ? 3 * k + 1 : k) * 4);
        if (!(length > 1e-6 && length <= MAX_LENGTH) ||
            (cubic && fabs(length - 1) > CUBIC_TOLERANCE))
            return glint_gltf_accessor_fault(
                g, a, "the quaternion of key %u is no rotation: its length is %g", k, length);
        worst = fmax(worst, fabs(length - 1));
    }
    return cubic || worst <= UNIT_TOLERANCE || make_unit(g, c);
}

static bool check_weights(struct glint_gltf *g, const struct glint_gltf_accessor *a,
                          const float *value)
{
    for (uint32_t i = 0; i < a->count; i++)
        if (fabsf(value[i]) > GLINT_MAX_WEIGHT)
            return glint_gltf_accessor_fault(g, a, "weight %u is %g; the limit is %g", i,
                                             (double)value[i], (double)GLINT_MAX_WEIGHT);
    return true;
}

static bool read_values(struct glint_gltf *g, const struct glint_json *sampler,
                        struct glint_animation_channel *c)
{
    const struct glint_json at = glint_json_member(sampler, "output");
    struct glint_gltf_accessor a;
    if (!glint_json_require(&at))
        return false;
    const uint32_t index = glint_gltf_index(g, sampler, "output", GLTF_ACCESSORS);
    if (index == GLINT_NONE || !glint_gltf_accessor_read(g, index, &a))
        return false;
    if (!fits_path(&a, c->path))
        return glint_json_fault(&at, "accessor %u has the wrong type for it", index);
    const uint64_t each = c->interpolation == GLINT_INTERPOLATION_CUBICSPLINE ? 3 : 1;
    const uint64_t count = each * c->keys * (c->path == GLINT_PATH_WEIGHTS ? c->width : 1);
    if (a.count != count)
        return glint_json_fault(&at, "accessor %u has %u elements; %u keys need %llu", index,
                                a.count, c->keys, (unsigned long long)count);
    c->value = read_floats(g, &a);
    return c->value && (c->path != GLINT_PATH_ROTATION || check_rotations(g, &a, c)) &&
           (c->path != GLINT_PATH_WEIGHTS || check_weights(g, &a, c->value));
}

static bool read_sampler(struct reading *r, const struct glint_json *at,
                         struct glint_animation_channel *c)
{
    static const char *const modes[] = {"LINEAR", "STEP", "CUBICSPLINE", NULL};
    const struct glint_json member = glint_json_member(at, "sampler");
    uint32_t index = 0;
    int mode = 0;
    if (!glint_json_require(&member) || !glint_json_uint(&member, 0, UINT32_MAX, &index))
        return false;
    if (index >= r->samplers)
        return glint_json_fault(&member, "%u: the animation has %u samplers", index, r->samplers);
    const struct glint_json sampler = glint_json_item(&r->list, r->sampler[index], index);
    const struct glint_json interpolation = glint_json_member(&sampler, "interpolation");
    if (!glint_json_choice(&interpolation, modes, &mode))
        return false;
    c->interpolation = (enum glint_interpolation)mode;
    if (!read_times(r->g, &sampler, c) || !read_values(r->g, &sampler, c))
        return false;
    r->numbers += (uint64_t)c->keys * c->width * (mode == GLINT_INTERPOLATION_CUBICSPLINE ? 3 : 1);
    return r->numbers <= MAX_NUMBERS ||
           glint_json_fault(at, "the channels have more than %u numbers", MAX_NUMBERS);
}

// --- animations

static void read_channel(struct reading *r, const struct glint_json *at,
                         struct glint_animation *out)
{
    struct glint_animation_channel c = {0};
    if (!read_target(r, at, &c) || !read_sampler(r, at, &c))
        return;
    struct glint_gltf_node *n = &r->g->node[c.node];
    if (c.path == GLINT_PATH_WEIGHTS)
        n->weighs = true;
    else
        n->animated = true;
    out->channel[out->channels++] = c;
}

static bool list_samplers(struct reading *r, const struct glint_json *at)
{
    size_t count = 0;
    r->list = glint_json_member(at, "samplers");
    r->samplers = 0;
    glint_json_require(&r->list);
    glint_json_length(&r->list, &count);
    r->sampler = glint_arena_array(&r->g->scratch, count + 1, sizeof *r->sampler);
    if (!r->sampler)
        return glint_gltf_nomem(r->g);
    for (const cJSON *c = count ? r->list.value->child : NULL; c; c = c->next)
        r->sampler[r->samplers++] = c;
    return true;
}

static bool read_channels(struct reading *r, const struct glint_json *at,
                          struct glint_animation *out)
{
    const struct glint_json list = glint_json_member(at, "channels");
    size_t count = 0, i = 0;
    glint_json_require(&list);
    glint_json_length(&list, &count);
    out->channel = glint_arena_array(&r->g->scene->arena, count + 1, sizeof *out->channel);
    if (!out->channel || !list_samplers(r, at))
        return glint_gltf_nomem(r->g);
    for (const cJSON *c = count ? list.value->child : NULL; c; c = c->next, i++) {
        const struct glint_json channel = glint_json_item(&list, c, i);
        read_channel(r, &channel, out);
    }
    return out->channels > 0;
}

static void read_animation(struct reading *r, uint32_t i)
{
    static const char *const none[] = {NULL};
    struct glint_gltf *g = r->g;
    struct glint_scene *s = g->scene;
    struct glint_animation *out = &s->animation[s->animations];
    const struct glint_json at = glint_gltf_item(g, GLTF_ANIMATIONS, i);
    const char *name = glint_gltf_name(g, &at);
    char number[24];
    snprintf(number, sizeof number, "animation_%u", i);
    out->name = glint_arena_string(&s->arena, *name ? name : number);
    if (!out->name) {
        glint_gltf_nomem(g);
        return;
    }
    r->number = i;
    r->name = out->name;
    glint_gltf_ignored(g, &at, "animation", out->name, none);
    if (!read_channels(r, &at, out)) {
        if (!g->err->status)
            glint_gltf_note(g, "animation without channels",
                            "animation \"%.200s\" moves nothing and is left out", out->name);
        return;
    }
    out->id = glint_gltf_names_id(&g->ids[GLTF_ID_ANIMATION], &s->arena, out->name);
    if (out->id)
        s->animations++;
    else
        glint_gltf_nomem(g);
}

void glint_gltf_read_animations(struct glint_gltf *g)
{
    const uint32_t count = g->list[GLTF_ANIMATIONS].count;
    struct reading r = {.g = g};
    g->floats =
        glint_arena_array(&g->scratch, g->list[GLTF_ACCESSORS].count + 1, sizeof *g->floats);
    g->scene->animation =
        glint_arena_array(&g->scene->arena, count + 1, sizeof *g->scene->animation);
    if (!g->floats || !g->scene->animation) {
        glint_gltf_nomem(g);
        return;
    }
    for (uint32_t i = 0; i < count; i++)
        read_animation(&r, i);
}
