#include "fake_scene.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct glint_resident {
    atomic_int references;
    struct glint_scene *scene;
    void (*free_assets)(void *);
    void *assets;
    char revision[65];
};

static atomic_int residents, imports;
static glint_status next_failure;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static bool held;
static int waiting;

void fake_scene_fail(glint_status status)
{
    next_failure = status;
}

int fake_scene_residents(void)
{
    return atomic_load(&residents);
}

int fake_scene_imports(void)
{
    return atomic_load(&imports);
}

void fake_scene_hold(bool hold)
{
    pthread_mutex_lock(&mutex);
    held = hold;
    pthread_cond_broadcast(&changed);
    pthread_mutex_unlock(&mutex);
}

void fake_scene_waiting(void)
{
    pthread_mutex_lock(&mutex);
    while (!waiting)
        pthread_cond_wait(&changed, &mutex);
    pthread_mutex_unlock(&mutex);
}

static void wait_while_held(void)
{
    pthread_mutex_lock(&mutex);
    waiting++;
    pthread_cond_broadcast(&changed);
    while (held)
        pthread_cond_wait(&changed, &mutex);
    waiting--;
    pthread_mutex_unlock(&mutex);
}

static void free_text(void *text, size_t bytes)
{
    (void)bytes;
    free(text);
    atomic_fetch_sub(&imports, 1);
}

glint_status glint_import_run(glint_importer *importer, const struct glint_import_source *source,
                              const struct glint_import_limits *limits, struct glint_import **out,
                              struct glint_error *err)
{
    (void)importer;
    (void)limits;
    wait_while_held();
    *out = NULL;
    if (source->size >= 3 && !memcmp(source->bytes, "bad", 3))
        return glint_fail(err, GLINT_E_SYNTAX, "", "the file is bad");
    *out = calloc(1, sizeof **out);
    (*out)->text = malloc(source->size + 1);
    memcpy((*out)->text, source->bytes, source->size);
    (*out)->text[source->size] = '\0';
    (*out)->length = source->size;
    (*out)->memory = glint_memory_ref_create((*out)->text, source->size, free_text);
    (*out)->seconds = 0.25;
    atomic_fetch_add(&imports, 1);
    return GLINT_OK;
}

bool glint_importer_lives(const glint_importer *importer)
{
    (void)importer;
    return true;
}

void glint_import_destroy(struct glint_import **import)
{
    struct glint_import *im = *import;
    *import = NULL;
    if (!im)
        return;
    glint_asset_set_release(&im->set);
    glint_memory_ref_release(&im->memory);
    free(im->warning);
    free(im);
}

glint_status glint_resident_create(glint_resident **out, glint_devices *devices,
                                   const struct glint_resident_order *order,
                                   struct glint_error *err)
{
    (void)devices;
    *out = NULL;
    if (next_failure) {
        const glint_status status = next_failure;
        next_failure = GLINT_OK;
        return glint_fail(err, status, "", "the scene does not fit");
    }
    *out = calloc(1, sizeof **out);
    atomic_init(&(*out)->references, 1);
    (*out)->scene = order->scene;
    (*out)->free_assets = order->free_assets;
    (*out)->assets = order->assets;
    atomic_fetch_add(&residents, 1);
    return GLINT_OK;
}

glint_resident *glint_resident_retain(glint_resident *resident)
{
    atomic_fetch_add(&resident->references, 1);
    return resident;
}

void glint_resident_release(glint_resident **resident)
{
    glint_resident *r = *resident;
    *resident = NULL;
    if (!r || atomic_fetch_sub(&r->references, 1) != 1)
        return;
    glint_scene_destroy(&r->scene);
    r->free_assets(r->assets);
    free(r);
    atomic_fetch_sub(&residents, 1);
}

const char *const glint_part_name[GLINT_PARTS] = {
    "meshes", "textures", "materials", "instances", "lights", "environment", "bvh", "placement"};

const struct glint_resident_change *glint_resident_change(const glint_resident *resident)
{
    (void)resident;
    static const struct glint_resident_change change = {
        .fate = {[GLINT_PART_MATERIALS] = GLINT_UPLOADED, [GLINT_PART_LIGHTS] = GLINT_REBUILT},
        .items = {[GLINT_PART_MATERIALS] = 1},
        .seconds = {[GLINT_PART_MATERIALS] = 0.001}};
    return &change;
}

const struct glint_scene *glint_resident_scene(const glint_resident *resident)
{
    return resident->scene;
}

void glint_resident_set_revision(glint_resident *resident, const char *revision)
{
    strcpy(resident->revision, revision);
}

const char *glint_resident_revision(const glint_resident *resident)
{
    return resident->revision;
}

void glint_resident_stats(const glint_resident *resident, struct glint_resident_stats *out)
{
    (void)resident;
    *out = (struct glint_resident_stats){.triangles = 12,
                                         .instanced_triangles = 24,
                                         .geometry_bytes = 1000,
                                         .bvh_bytes = 200,
                                         .record_bytes = 150,
                                         .texture_bytes = 100,
                                         .light_bytes = 50,
                                         .bvh_seconds = 0.5,
                                         .lights = 1,
                                         .dropped = 2};
}

bool glint_resident_has_geometry(const glint_resident *resident, enum glint_geometry_kind kind,
                                 bool robust)
{
    (void)resident;
    (void)kind;
    (void)robust;
    return false;
}

const struct glint_scene_facts *glint_resident_facts(const glint_resident *resident)
{
    (void)resident;
    static const struct glint_scene_facts facts = {.transmission = true};
    return &facts;
}
