// mtl_images.c - the maps of a library's material as textures.
//
// MTL has a file for each of colour and opacity, roughness and metalness; here two of them share an
// image, which is put together in the size of the first.
#include "protocol/text.h"
#include "scene/image_decode.h"
#include "scene/mtl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define IMAGES_PER_MATERIAL 4u
#define NORMALS_BLUE 170u // mean of blue that a map of normals has at least, of 255
#define CLEAR_CUT 24u     // distance from 0 and 255 within which an opacity is all or nothing

bool glint_mtl_images_start(struct glint_mtl_images *images, struct glint_obj *o,
                            uint32_t materials)
{
    struct glint_scene *s = o->model.scene;
    const uint32_t files = o->files ? o->files->count : 0;
    *images = (struct glint_mtl_images){.obj = o};
    images->pixels = calloc(files + 1u, sizeof *images->pixels);
    images->decoded = calloc(files + 1u, sizeof *images->decoded);
    s->image =
        glint_arena_array(&s->arena, (size_t)materials * IMAGES_PER_MATERIAL + 1, sizeof *s->image);
    return (images->pixels && images->decoded && s->image) || glint_model_nomem(&o->model);
}

void glint_mtl_images_finish(struct glint_mtl_images *images)
{
    free(images->pixels);
    free(images->decoded);
    glint_gltf_names_finish(&images->made);
}

// ---- files

// Kinds of pictures that people keep beside these files and that nothing here reads.
static bool unread_kind(const char *name)
{
    static const char *const kinds[] = {".tga", ".bmp", ".tif",  ".tiff", ".dds", ".gif",
                                        ".psd", ".pcx", ".webp", ".ktx2", ".iff", ".rgb"};
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; dot && i < sizeof kinds / sizeof *kinds; i++)
        if (!strcasecmp(dot, kinds[i]))
            return true;
    return false;
}

// The decoded file of a map, or NULL: there is no map, or a fault or warning says why.
static const struct glint_pixels *load(struct glint_mtl_images *images, const struct glint_mtl *m,
                                       enum glint_mtl_map map)
{
    struct glint_obj *o = images->obj;
    const struct glint_mtl_texture *t = &m->map[map];
    struct glint_file *file = t->path ? glint_files_find(o->files, t->path) : NULL;
    if (!t->path)
        return NULL;
    if (!file) {
        glint_fail(o->model.err, GLINT_E_RANGE, "",
                   "%s, line %u: \"%.200s\" is not among the files", m->file, t->line, t->path);
        return NULL;
    }
    const size_t i = (size_t)(file - o->files->file);
    struct glint_pixels *p = &images->pixels[i];
    if (!images->decoded[i] && unread_kind(file->name))
        glint_obj_warn(o, "the picture \"%.200s\" is of a kind that is not read", file->name);
    else if (!images->decoded[i])
        glint_image_decode(p, &o->model.scene->arena, file->bytes, file->size, "", o->model.err);
    images->decoded[i] = true;
    return p->pixels ? p : NULL;
}

// ---- images of the scene

static uint32_t *made(struct glint_mtl_images *images, const char *kind, const void *a,
                      const void *b)
{
    char key[80];
    snprintf(key, sizeof key, "%s %p %p", kind, a, b);
    uint32_t *number = glint_gltf_names_at(&images->made, &images->obj->scratch, key);
    if (!number)
        glint_model_nomem(&images->obj->model);
    return number;
}

static uint32_t add(struct glint_mtl_images *images, const struct glint_pixels *p,
                    const struct glint_mtl *m, enum glint_mtl_map map)
{
    struct glint_scene *s = images->obj->model.scene;
    struct glint_image *image = &s->image[s->images];
    const char *path = m->map[map].path;
    *image = (struct glint_image){
        .width = p->width, .height = p->height, .format = p->format, .pixels = p->pixels};
    image->id = glint_model_image_id(&images->obj->model, path ? path : "map");
    return image->id ? s->images++ : GLINT_NONE;
}

static uint32_t plain(struct glint_mtl_images *images, const struct glint_mtl *m,
                      enum glint_mtl_map map)
{
    const struct glint_pixels *p = load(images, m, map);
    uint32_t *number = p ? made(images, "plain", p, NULL) : NULL;
    if (!number)
        return GLINT_NONE;
    if (!*number)
        *number = add(images, p, m, map) + 1;
    return *number - 1;
}

// One channel of `from` to one of `to`, at the nearest texel.
static void copy_channel(struct glint_pixels *to, int to_channel, const struct glint_pixels *from,
                         int from_channel)
{
    const uint8_t *source = from->pixels;
    uint8_t *target = to->pixels;
    for (uint32_t y = 0; y < to->height; y++)
        for (uint32_t x = 0; x < to->width; x++) {
            const size_t u = (size_t)((uint64_t)x * from->width / to->width);
            const size_t v = (size_t)((uint64_t)y * from->height / to->height);
            target[((size_t)y * to->width + x) * 4 + (size_t)to_channel] =
                source[(v * from->width + u) * 4 + (size_t)from_channel];
        }
}

static bool eight_bits(const struct glint_pixels *p)
{
    return p && p->format == GLINT_IMAGE_RGBA8;
}

// White, of the size of whichever is there.
static bool blank(struct glint_mtl_images *images, struct glint_pixels *out,
                  const struct glint_pixels *a, const struct glint_pixels *b)
{
    const struct glint_pixels *size = a ? a : b;
    struct glint_obj *o = images->obj;
    if (glint_pixels_alloc(out, &o->model.scene->arena, size->width, size->height,
                           GLINT_IMAGE_RGBA8, "", o->model.err))
        return false;
    memset(out->pixels, 0xff, out->bytes);
    return true;
}

// Roughness to green, metalness to blue.
static uint32_t rough_metal(struct glint_mtl_images *images, const struct glint_mtl *m)
{
    const struct glint_pixels *rough = load(images, m, GLINT_MTL_ROUGHNESS);
    const struct glint_pixels *metal = load(images, m, GLINT_MTL_METALLIC);
    rough = eight_bits(rough) ? rough : NULL;
    metal = eight_bits(metal) ? metal : NULL;
    struct glint_pixels p;
    uint32_t *number = rough || metal ? made(images, "rough", rough, metal) : NULL;
    if (!number)
        return GLINT_NONE;
    if (*number)
        return *number - 1;
    if (!blank(images, &p, rough, metal))
        return GLINT_NONE;
    if (rough)
        copy_channel(&p, 1, rough, 0);
    if (metal)
        copy_channel(&p, 2, metal, 0);
    *number = add(images, &p, m, rough ? GLINT_MTL_ROUGHNESS : GLINT_MTL_METALLIC) + 1;
    return *number - 1;
}

static bool has_alpha(const struct glint_pixels *p)
{
    const uint8_t *bytes = p->pixels;
    for (size_t i = 3; i < p->bytes; i += 4)
        if (bytes[i] != 255)
            return true;
    return false;
}

// An opacity map is grey, or the alpha of a picture that has one.
static uint32_t cut_out(struct glint_mtl_images *images, const struct glint_mtl *m,
                        const struct glint_pixels *opacity)
{
    const struct glint_pixels *color = load(images, m, GLINT_MTL_DIFFUSE);
    struct glint_pixels p;
    color = eight_bits(color) ? color : NULL;
    uint32_t *number = made(images, "cut out", color, opacity);
    if (!number)
        return GLINT_NONE;
    if (*number)
        return *number - 1;
    if (!blank(images, &p, color, opacity))
        return GLINT_NONE;
    for (int k = 0; color && k < 3; k++)
        copy_channel(&p, k, color, k);
    copy_channel(&p, 3, opacity, has_alpha(opacity) ? 3 : 0);
    *number = add(images, &p, m, color ? GLINT_MTL_DIFFUSE : GLINT_MTL_OPACITY) + 1;
    return *number - 1;
}

// ---- textures

static struct glint_texture texture_of(const struct glint_mtl *m, enum glint_mtl_map map,
                                       uint32_t image)
{
    const struct glint_mtl_texture *t = &m->map[map];
    struct glint_texture out;
    glint_texture_init(&out);
    out.image = image;
    if (image == GLINT_NONE)
        return out;
    out.wrap_u = out.wrap_v = t->clamp ? GLINT_WRAP_CLAMP : GLINT_WRAP_REPEAT;
    out.scale[0] = t->scale[0];
    out.scale[1] = t->scale[1];
    out.offset[0] = t->offset[0];
    out.offset[1] = 1 - t->scale[1] - t->offset[1]; // v goes up in MTL
    return out;
}

static bool all_or_nothing(const struct glint_image *image)
{
    const uint8_t *bytes = image->pixels;
    const size_t size = (size_t)image->width * image->height * 4;
    size_t between = 0;
    for (size_t i = 3; i < size; i += 4)
        between += bytes[i] > CLEAR_CUT && bytes[i] < 255 - CLEAR_CUT;
    return between * 20 <= size / 4; // edges may be soft
}

static void set_color(struct glint_mtl_images *images, const struct glint_mtl *m,
                      struct glint_material *to)
{
    const struct glint_pixels *opacity = load(images, m, GLINT_MTL_OPACITY);
    if (!eight_bits(opacity)) {
        to->base_color_texture =
            texture_of(m, GLINT_MTL_DIFFUSE, plain(images, m, GLINT_MTL_DIFFUSE));
        return;
    }
    const uint32_t image = cut_out(images, m, opacity);
    to->base_color_texture = texture_of(
        m, m->map[GLINT_MTL_DIFFUSE].path ? GLINT_MTL_DIFFUSE : GLINT_MTL_OPACITY, image);
    if (image == GLINT_NONE)
        return;
    const bool sharp = to->alpha_mode == GLINT_ALPHA_OPAQUE &&
                       all_or_nothing(&images->obj->model.scene->image[image]);
    to->alpha_mode = sharp ? GLINT_ALPHA_MASK : GLINT_ALPHA_BLEND;
}

// Many programs write maps of normals as maps of heights; those are mostly blue.
static bool holds_normals(const struct glint_pixels *p)
{
    const uint8_t *bytes = p->pixels;
    uint64_t sum = 0;
    for (size_t i = 2; i < p->bytes; i += 4)
        sum += bytes[i];
    return sum > (uint64_t)NORMALS_BLUE * (p->bytes / 4) && bytes[0] != bytes[2];
}

static void set_normal(struct glint_mtl_images *images, const struct glint_mtl *m,
                       struct glint_material *to)
{
    const struct glint_pixels *bump = load(images, m, GLINT_MTL_BUMP);
    enum glint_mtl_map map = GLINT_MTL_NORMAL;
    if (!m->map[map].path && bump) {
        if (!eight_bits(bump) || !holds_normals(bump)) {
            glint_obj_warn(images->obj, "material \"%.200s\": the map of heights is not shown",
                           to->name);
            return;
        }
        map = GLINT_MTL_BUMP;
    }
    to->normal_texture = texture_of(m, map, plain(images, m, map));
    to->normal_scale = m->map[map].path ? m->map[map].bump : 1;
}

void glint_mtl_textures(struct glint_mtl_images *images, const struct glint_mtl *m,
                        struct glint_material *to)
{
    set_color(images, m, to);
    set_normal(images, m, to);
    to->emission_texture = texture_of(m, GLINT_MTL_EMISSION, plain(images, m, GLINT_MTL_EMISSION));
    to->metallic_roughness_texture =
        texture_of(m, m->map[GLINT_MTL_ROUGHNESS].path ? GLINT_MTL_ROUGHNESS : GLINT_MTL_METALLIC,
                   rough_metal(images, m));
}
