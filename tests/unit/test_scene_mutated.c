// Scenes that somebody has tampered with: refused or sound, never a crash. Fixed seeds.
#include "scene_text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROUNDS 20000

static const uint8_t pixels[8] = {1, 2, 3, 4, 5, 6, 7, 8};

static uint32_t draw(uint64_t *state) // Knuth's multiplier
{
    *state = *state * 6364136223846793005ull + 1442695040888963407ull;
    return (uint32_t)(*state >> 33);
}

struct original {
    char *text;
    size_t length;
    struct glint_asset *asset;
    size_t assets;
};

// `canonical`: long arrays are in assets.
static struct original make_original(bool canonical)
{
    struct original o = {.asset = calloc(1, sizeof *o.asset), .assets = 1};
    uint8_t *own = malloc(sizeof pixels);
    memcpy(own, pixels, sizeof pixels);
    *o.asset = name_asset(own, sizeof pixels);
    char *quoted = NULL;
    assert_true(asprintf(&quoted, scene_rich, o.asset->sha256) > 0);
    o.text = json(quoted);
    o.length = strlen(o.text);
    free(quoted);
    if (!canonical)
        return o;
    struct glint_scene *s = reparse(o.text, o.length, o.asset, 1, NULL);
    free(o.text);
    assert_int_equal(glint_scene_write(s, &o.text, &o.length, &o.asset, &o.assets, NULL), GLINT_OK);
    glint_scene_destroy(&s);
    return o;
}

static void forget(struct original *o)
{
    for (size_t i = 0; i < o->assets; i++)
        free((void *)o->asset[i].bytes);
    free(o->asset);
    free(o->text);
}

// One to four changes: a byte, a digit, a span that is lost, or one that is put elsewhere.
static size_t mutate(char *text, size_t length, uint64_t *state)
{
    static const char marks[] = "{}[]:,\"-+.eE0123456789ntf\\/ \x7f\x80";
    for (uint32_t changes = 1 + draw(state) % 4; changes; changes--) {
        const size_t at = draw(state) % length, from = draw(state) % length;
        const size_t most = length - (at > from ? at : from);
        const size_t span = 1 + draw(state) % (most < 12 ? most : 12);
        switch (draw(state) % 4) {
        case 0:
            text[at] = marks[draw(state) % (sizeof marks - 1)];
            break;
        case 1:
            if (text[at] >= '0' && text[at] <= '9')
                text[at] = (char)('0' + draw(state) % 10);
            else
                text[at] = (char)(text[at] ^ 1 << draw(state) % 7);
            break;
        case 2:
            memmove(text + at, text + from, span);
            break;
        default:
            memmove(text + at, text + at + span, length - at - span);
            length -= span;
            break;
        }
    }
    return length;
}

// A scene that was accepted says the same again, and its parts hang together.
static void assert_sound(const struct glint_scene *s, const struct original *o)
{
    struct glint_asset *asset = malloc(o->assets * sizeof *asset);
    memcpy(asset, o->asset, o->assets * sizeof *asset);
    size_t assets = o->assets, length;
    char *text, *again;
    assert_int_equal(glint_scene_write(s, &text, &length, &asset, &assets, NULL), GLINT_OK);
    struct glint_scene *b = reparse(text, length, asset, assets, s);
    assert_int_equal(glint_scene_write(b, &again, &length, &asset, &assets, NULL), GLINT_OK);
    assert_string_equal(text, again);
    glint_scene_destroy(&b);
    for (size_t i = o->assets; i < assets; i++)
        free((void *)asset[i].bytes);
    free(asset);
    free(text);
    free(again);
}

static void tamper_with_text(bool canonical, uint64_t seed)
{
    struct original o = make_original(canonical);
    char *text = malloc(o.length);
    int accepted = 0, refused = 0;
    for (int i = 0; i < ROUNDS; i++) {
        struct glint_scene *s;
        struct glint_error err = {0};
        memcpy(text, o.text, o.length);
        const size_t length = mutate(text, o.length, &seed);
        const glint_status status = glint_scene_parse(&s, text, length, o.asset, o.assets, &err);
        assert_true(status == GLINT_OK || status == GLINT_E_SYNTAX || status == GLINT_E_RANGE);
        assert_true(!status == (err.count == 0) && !status == (s != NULL));
        refused += status == GLINT_E_RANGE;
        accepted += !status;
        if (!status && accepted % 16 == 0)
            assert_sound(s, &o);
        glint_scene_destroy(&s);
        glint_error_finish(&err);
    }
    print_message("# %d accepted, %d refused for what they say\n", accepted, refused);
    assert_true(accepted > ROUNDS / 100 && refused > ROUNDS / 100);
    free(text);
    forget(&o);
}

static void mutated_inline_text_is_refused_or_sound(void **state)
{
    (void)state;
    tamper_with_text(false, 1);
}

static void mutated_canonical_text_is_refused_or_sound(void **state)
{
    (void)state;
    tamper_with_text(true, 2);
}

// ---- bytes of assets under their old names

static void assert_finite(const float *values, size_t count)
{
    for (size_t i = 0; values && i < count; i++)
        assert_true(fabsf(values[i]) <= GLINT_MAX_COORDINATE);
}

static void assert_mesh_fits(const struct glint_mesh *m)
{
    assert_finite(m->position, 3ull * m->vertices);
    assert_finite(m->normal, 3ull * m->vertices);
    assert_finite(m->color, 4ull * m->vertices);
    assert_finite(m->weight, 4ull * m->vertices);
    assert_finite(m->target_position, 3ull * m->vertices * m->targets);
    for (size_t i = 0; i < 3ull * m->triangles; i++)
        assert_true(m->index[i] < m->vertices);
    for (size_t i = 0; m->joint && i < 4ull * m->vertices; i++)
        assert_true(m->joint[i] < m->joint_end);
}

static void assert_animation_fits(const struct glint_animation *a)
{
    for (uint32_t c = 0; c < a->channels; c++) {
        const struct glint_animation_channel *channel = &a->channel[c];
        assert_finite(channel->time, channel->keys);
        assert_finite(channel->value, glint_channel_values(channel));
        for (uint32_t k = 1; k < channel->keys; k++)
            assert_true(channel->time[k] > channel->time[k - 1]);
    }
}

static void mutated_assets_are_refused_or_sound(void **state)
{
    (void)state;
    struct original o = make_original(true);
    uint64_t seed = 3;
    int accepted = 0;
    for (int i = 0; i < ROUNDS; i++) {
        const struct glint_asset *a = &o.asset[draw(&seed) % o.assets];
        uint8_t *byte = (uint8_t *)a->bytes + draw(&seed) % a->size;
        const uint8_t kept = *byte;
        struct glint_scene *s;
        *byte = (uint8_t)(draw(&seed) % 4 ? kept ^ 1u << draw(&seed) % 8 : 0xff);
        const glint_status status =
            glint_scene_parse(&s, o.text, o.length, o.asset, o.assets, NULL);
        assert_true(status == GLINT_OK || status == GLINT_E_RANGE);
        for (uint32_t m = 0; !status && m < s->meshes; m++)
            assert_mesh_fits(&s->mesh[m]);
        for (uint32_t m = 0; !status && m < s->animations; m++)
            assert_animation_fits(&s->animation[m]);
        accepted += !status;
        glint_scene_destroy(&s);
        *byte = kept;
    }
    print_message("# %d of %d accepted\n", accepted, ROUNDS);
    assert_true(accepted > 0 && accepted < ROUNDS);
    forget(&o);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mutated_inline_text_is_refused_or_sound),
        cmocka_unit_test(mutated_canonical_text_is_refused_or_sound),
        cmocka_unit_test(mutated_assets_are_refused_or_sound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
