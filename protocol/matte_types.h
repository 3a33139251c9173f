// matte_types.h - the Cryptomatte types that a job writes, CONVENTIONS a: what is seen directly, and
// what bounces bring, as one type, by reflection and refraction, or by the way from the camera.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_MATTE_TYPES_H
#define GLINT_PROTOCOL_MATTE_TYPES_H

#include "job.h"

enum glint_matte_layer {
    GLINT_MATTE_OBJECT,
    GLINT_MATTE_MATERIAL,
    GLINT_MATTE_ASSET,
    GLINT_MATTE_LAYERS
};

#define GLINT_MAX_MATTE_CLASSES 11 // what is seen directly, and at most ten bins of depth
#define GLINT_MAX_MATTE_TYPES (GLINT_MATTE_LAYERS * GLINT_MAX_MATTE_CLASSES)

struct glint_matte_type {
    char name[28]; // "CryptoObject", "CryptoGlossObject", ..; none is a prefix of another
    enum glint_matte_layer layer;
    uint32_t class_of_it; // of the slot keys that it is made of, 0: seen directly
};

// Fills out[] with the types of those outputs of the job, directly seen ones first. Returns their
// number.
size_t glint_matte_types(const struct glint_job *job, uint32_t outputs,
                         struct glint_matte_type out[GLINT_MAX_MATTE_TYPES]);

// The type of an output, "CryptoObject" and so on.
const char *glint_matte_layer_type(enum glint_matte_layer layer);

// What a class is called in queries: "primary", and "glossy", or "reflection" and "refraction", or
// "depth0" to "depth9"; NULL: the job has no such class.
const char *glint_matte_class_name(const struct glint_job *job, uint32_t class_of_it);

// Whether any job could have a class so called; length: of the name.
bool glint_matte_class_exists(const char *name, size_t length);

// Classes above 0 that the job tells apart: 0 where nothing goes through bounces.
uint32_t glint_matte_classes(const struct glint_job *job);

// Slots of a pixel: what the job says, or, under exact eviction, one for each key of a scene that has
// so many, in each class.
uint32_t glint_matte_slots(const struct glint_job *job, uint32_t mattes);

// Rows of a list of all that a path meets, where the job has mattes through bounces: its vertices, the
// background and an end; 0 where it keeps none.
uint32_t glint_matte_rows(const struct glint_job *job);

#define GLINT_MAX_EXACT_SLOTS 32766u // a wave's tables fit in one buffer

// GLINT_E_RANGE, at `pointer`: exact eviction would take more than these.
glint_status glint_matte_check(const struct glint_job *job, uint32_t mattes, const char *pointer,
                               struct glint_error *err);

#endif
