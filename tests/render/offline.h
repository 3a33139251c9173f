// offline.h - scenes and renders without a daemon, for tests and benches. Any failure is printed and
// ends the program.
#ifndef GLINT_TESTS_OFFLINE_H
#define GLINT_TESTS_OFFLINE_H

#include "render/internal.h"
#include "scene/import.h"
#include "scene/posed.h"

// Importer and devices, forked and created in the right order. threads 0: one per core.
struct offline {
    glint_importer *importer;
    glint_devices *devices;
};
void offline_start(struct offline *o, uint32_t threads);
void offline_finish(struct offline *o);

// Workers of a test program: $GLINT_TEST_WORKERS, by default two.
uint32_t offline_workers(void);

// Importer and devices of a test program, as the fixtures of a cmocka group.
extern struct offline offline_crew;
int offline_crew_start(void **state);
int offline_crew_finish(void **state);

// Prints every fault and exits.
void offline_die(const char *what, const struct glint_error *err);

uint8_t *offline_read_file(const char *path, size_t *size);

// A resident scene from a .glb or native .json file, or from native text.
glint_resident *offline_load(const struct offline *o, const char *path);
glint_resident *offline_load_text(const struct offline *o, const char *text);

// The same at rest, with its pose; released by its resident.
struct glint_posed offline_load_posed(const struct offline *o, const char *path);
struct glint_posed offline_load_posed_text(const struct offline *o, const char *text);
// name: of the source, for what is printed.
struct glint_posed offline_load_posed_source(const struct offline *o, const char *name,
                                             const struct glint_import_source *source);

// A job from JSON text; its "scene" member is not looked at.
struct glint_job *offline_job(const char *text);

// Runs all workers until the render is complete.
void offline_render(const struct offline *o, glint_render *render);

// The frame of a text scene and job, rendered with effects forced on.
struct glint_frame *offline_frame(const struct offline *o, glint_resident *scene, const char *job,
                                  uint64_t force);

// The frame of a scene in the pose that the job asks for.
struct glint_frame *offline_frame_posed(const struct offline *o, const struct glint_posed *rest,
                                        const char *job, uint64_t force);

#endif
