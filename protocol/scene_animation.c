// scene_animation.c - what moves nodes and weights: channels of keys.
#include "protocol/scene_parts.h"

#include <math.h>
#include <string.h>

#define MAX_KEYS 0x7fffffffu
#define UNIT_SLACK 0.02     // of a quaternion's length; bytes in glTF leave 0.008
#define UNIT_TOLERANCE 1e-6 // beyond it the quaternion is made unit
#define MAX_QUATERNION 1e6f // of tangents, too

size_t glint_channel_values(const struct glint_animation_channel *channel)
{
    const bool cubic = channel->interpolation == GLINT_INTERPOLATION_CUBICSPLINE;
    return (size_t)channel->keys * channel->width * (cubic ? 3 : 1);
}

// ---- what is there to be animated

static void count_targets(struct glint_scene_reader *r, const struct glint_instance *in)
{
    if (in->node == GLINT_NONE || in->mesh == GLINT_NONE || !r->scene->mesh[in->mesh].targets)
        return;
    const uint32_t targets = r->scene->mesh[in->mesh].targets;
    uint32_t *known = &r->targets[in->node];
    *known = *known && *known != targets ? GLINT_NONE : targets;
}

bool glint_animations_prepare(struct glint_scene_reader *r)
{
    const struct glint_scene *s = r->scene;
    r->animated = glint_arena_array(&r->scratch, s->nodes, 4 * sizeof *r->animated);
    r->targets = glint_arena_array(&r->scratch, s->nodes, sizeof *r->targets);
    if (!r->animated || !r->targets)
        return glint_scene_no_memory(r);
    for (uint32_t i = 0; i < s->instances; i++)
        count_targets(r, &s->instance[i]);
    return true;
}

// ---- keys

// Where a fault of element i is: in the list, or in the asset as a whole.
static struct glint_json element(const struct glint_json *list, const struct glint_json *asset,
                                 size_t i)
{
    return asset->value ? *asset : glint_json_item(list, NULL, i);
}

static bool check_times(const struct glint_json *list, const struct glint_json *asset,
                        const struct glint_animation_channel *c)
{
    for (uint32_t i = 0; i < c->keys; i++) {
        const struct glint_json at = element(list, asset, i);
        if (!(c->time[i] >= 0 && c->time[i] <= GLINT_MAX_SECONDS))
            return glint_json_fault(&at, "time %u is %g: outside of 0 to %g", i, c->time[i],
                                    GLINT_MAX_SECONDS);
        if (i && c->time[i] <= c->time[i - 1])
            return glint_json_fault(&at, "time %u, %g, does not come after %g", i, c->time[i],
                                    c->time[i - 1]);
    }
    return true;
}

static float bound_of(enum glint_channel_path path)
{
    static const float bound[] = {[GLINT_PATH_TRANSLATION] = GLINT_MAX_COORDINATE,
                                  [GLINT_PATH_ROTATION] = MAX_QUATERNION,
                                  [GLINT_PATH_SCALE] = GLINT_MAX_COORDINATE,
                                  [GLINT_PATH_WEIGHTS] = GLINT_MAX_WEIGHT};
    return bound[path];
}

static bool check_values(const struct glint_json *list, const struct glint_json *asset,
                         const struct glint_animation_channel *c)
{
    const size_t count = glint_channel_values(c);
    for (size_t i = 0; i < count; i++) {
        const struct glint_json at = element(list, asset, i);
        if (!(fabsf(c->value[i]) <= bound_of(c->path)))
            return glint_json_fault(&at, "number %zu is %g: not finite or larger than %g", i,
                                    c->value[i], bound_of(c->path));
    }
    return true;
}

static double length4(const float *q)
{
    return sqrt((double)q[0] * q[0] + (double)q[1] * q[1] + (double)q[2] * q[2] +
                (double)q[3] * q[3]);
}

static bool make_unit(struct glint_scene_reader *r, struct glint_animation_channel *c)
{
    float *copy = glint_arena_array(&r->scene->arena, c->keys, 4 * sizeof *copy);
    if (!copy)
        return glint_scene_no_memory(r);
    for (size_t i = 0; i < (size_t)c->keys * 4; i++)
        copy[i] = (float)(c->value[i] / length4(c->value + i / 4 * 4));
    c->value = copy;
    return true;
}

// Cubic ones keep their length: the tangents belong to it.
static bool check_rotations(struct glint_scene_reader *r, const struct glint_json *list,
                            const struct glint_json *asset, struct glint_animation_channel *c)
{
    const bool cubic = c->interpolation == GLINT_INTERPOLATION_CUBICSPLINE;
    const size_t stride = cubic ? 12 : 4, first = cubic ? 4 : 0;
    double worst = 0;
    for (uint32_t i = 0; i < c->keys; i++) {
        const double length = length4(c->value + i * stride + first);
        const struct glint_json at = element(list, asset, i * stride + first);
        if (fabs(length - 1) > UNIT_SLACK)
            return glint_json_fault(&at, "the quaternion of key %u has the length %g, not 1", i,
                                    length);
        worst = fmax(worst, fabs(length - 1));
    }
    return cubic || worst <= UNIT_TOLERANCE || make_unit(r, c);
}

// ---- a channel

static bool read_asset(struct glint_scene_reader *r, const struct glint_json *at,
                       struct glint_animation_channel *c)
{
    const struct glint_json asset = glint_json_member(at, "asset");
    const struct glint_json keys = glint_json_member(at, "keys");
    const struct glint_json times = glint_json_member(at, "times");
    const struct glint_json values = glint_json_member(at, "values");
    if (times.value || values.value)
        return glint_json_fault(&asset, "a channel has either times and values or an asset");
    if (!glint_json_require(&keys) || !glint_json_uint(&keys, 1, MAX_KEYS, &c->keys))
        return false;
    const uint64_t bytes = ((uint64_t)c->keys + glint_channel_values(c)) * sizeof(float);
    const float *numbers = glint_scene_asset(r, &asset, bytes, c->asset);
    if (!numbers)
        return false;
    c->time = numbers;
    c->value = numbers + c->keys;
    return glint_scene_charge(r, &asset, bytes);
}

static bool read_list(struct glint_scene_reader *r, const struct glint_json *at, size_t count,
                      float bound, const float **out)
{
    float *values = glint_arena_array(&r->scene->arena, count, sizeof *values);
    if (!values)
        return glint_scene_no_memory(r);
    *out = values;
    return glint_json_floats(at, count, -bound, bound, values);
}

static bool read_inline(struct glint_scene_reader *r, const struct glint_json *at,
                        struct glint_animation_channel *c)
{
    const struct glint_json keys = glint_json_member(at, "keys");
    const struct glint_json times = glint_json_member(at, "times");
    const struct glint_json values = glint_json_member(at, "values");
    size_t count, numbers;
    bool fine = !keys.value || glint_json_fault(&keys, "keys are counted where there is an asset");
    fine &= glint_json_require(&times) && glint_json_length(&times, &count);
    fine &= glint_json_require(&values) && glint_json_length(&values, &numbers);
    if (!fine)
        return false;
    if (!count)
        return glint_json_fault(&times, "at least one time is expected");
    c->keys = (uint32_t)count;
    if (numbers != glint_channel_values(c))
        return glint_json_fault(&values, "%zu numbers are expected for %u keys, not %zu",
                                glint_channel_values(c), c->keys, numbers);
    fine = read_list(r, &times, count, GLINT_MAX_SECONDS, &c->time);
    return read_list(r, &values, numbers, bound_of(c->path), &c->value) && fine;
}

static void read_keys(struct glint_scene_reader *r, const struct glint_json *at,
                      struct glint_animation_channel *c)
{
    const struct glint_json asset = glint_json_member(at, "asset");
    const struct glint_json times = glint_json_member(at, "times");
    const struct glint_json values = glint_json_member(at, "values");
    if (asset.value ? !read_asset(r, at, c) : !read_inline(r, at, c))
        return;
    bool fine = check_times(&times, &asset, c);
    fine &= check_values(&values, &asset, c);
    if (fine && c->path == GLINT_PATH_ROTATION)
        check_rotations(r, &values, &asset, c);
}

static bool find_width(struct glint_scene_reader *r, const struct glint_json *node,
                       struct glint_animation_channel *c)
{
    static const uint32_t width[] = {
        [GLINT_PATH_TRANSLATION] = 3, [GLINT_PATH_ROTATION] = 4, [GLINT_PATH_SCALE] = 3};
    c->width = c->path == GLINT_PATH_WEIGHTS ? r->targets[c->node] : width[c->path];
    if (!c->width)
        return glint_json_fault(node, "no instance on the node has a mesh with targets");
    return c->width != GLINT_NONE ||
           glint_json_fault(node, "the meshes on the node have different numbers of targets");
}

// Of a node that is there.
static bool check_place(struct glint_scene_reader *r, const struct glint_json *at,
                        struct glint_animation_channel *c)
{
    const struct glint_json node = glint_json_member(at, "node");
    const uint32_t animation = r->scene->animations + 1; // read so far
    uint32_t *last = &r->animated[4 * (size_t)c->node + c->path];
    if (*last == animation)
        return glint_json_fault(at, "the animation has another channel of this node and path");
    *last = animation;
    if (r->scene->node[c->node].matrix && c->path != GLINT_PATH_WEIGHTS)
        return glint_json_fault(&node, "the node is given as a matrix: it cannot be animated");
    return find_width(r, &node, c);
}

static void read_channel(struct glint_scene_reader *r, const struct glint_json *at, void *out)
{
    struct glint_animation_channel *c = out;
    const struct glint_json node = glint_json_member(at, "node");
    const struct glint_json path = glint_json_member(at, "path");
    bool fine = glint_fields_read(at, glint_channel_fields, &r->scene->arena, c);
    c->node = GLINT_NONE;
    fine &= glint_json_require(&path);
    if (glint_json_require(&node))
        c->node = glint_scene_reference(&node, &r->nodes, "node");
    if (fine && c->node < r->scene->nodes && check_place(r, at, c))
        read_keys(r, at, c);
}

void glint_animation_read(struct glint_scene_reader *r, const struct glint_json *at,
                          struct glint_animation *out)
{
    const struct glint_json channels = glint_json_member(at, "channels");
    out->name = out->id;
    glint_fields_read(at, glint_animation_fields, &r->scene->arena, out);
    out->channel =
        glint_collection_read(r, &channels, sizeof *out->channel, read_channel, 0, &out->channels);
}
