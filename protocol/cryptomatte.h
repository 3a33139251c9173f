// cryptomatte.h - names, keys, manifests and ranked layers of the Cryptomatte specification 1.2.0.
//
// Thread-safety: reentrant.
#ifndef GLINT_PROTOCOL_CRYPTOMATTE_H
#define GLINT_PROTOCOL_CRYPTOMATTE_H

#include "frame.h"

// Stored ID of a name: MurmurHash3_x86_32, seed 0, exponent fixed up so that the bits are a normal
// float. The empty name is "default"; 0 is kept for "nothing".
uint32_t glint_cryptomatte_id(const char *name);
uint32_t glint_murmur3_32(const void *bytes, size_t length, uint32_t seed);

// First 7 lower-case hex digits of the type name's stored ID, and a terminator.
void glint_cryptomatte_key(const char *type, char key[8]);

// Whether the types can stand in one file: each a letter, then letters, digits and underscores, at
// most 27 bytes, and none equal to or a prefix of another. GLINT_E_RANGE: a fault for each breach.
glint_status glint_cryptomatte_type_check(const char *const *types, size_t count,
                                          struct glint_error *err);

// The cryptomatte/KEY/name attribute of the type whose ranks a channel holds, or NULL.
const struct glint_attribute *glint_cryptomatte_type_of(const struct glint_frame *frame,
                                                        const char *channel);

// As type_check, for the types that the frame's header names.
glint_status glint_cryptomatte_check(const struct glint_frame *frame, struct glint_error *err);

// {"name":"hex8",...}, keys sorted bytewise and escaped, no duplicates; malloc'd, NULL without memory.
char *glint_cryptomatte_manifest(const char *const *names, size_t count);

// Names that differ and share an ID, each with its neighbour in bytewise order. *out is malloc'd
// on success (also for none), its names are the caller's.
struct glint_cryptomatte_clash {
    const char *a, *b;
};
glint_status glint_cryptomatte_clashes(const char *const *names, size_t count,
                                       struct glint_cryptomatte_clash **out, size_t *clashes);

// Adds cryptomatte/KEY/{name,hash,conversion,manifest}.
glint_status glint_cryptomatte_header(struct glint_frame *frame, const char *type,
                                      const char *manifest);

struct glint_cryptomatte_rank {
    uint32_t id;
    float coverage;
};

// Sorts by coverage descending, ties by stored bits ascending. In place.
void glint_cryptomatte_sort(struct glint_cryptomatte_rank *rank, size_t count);

// Coverage of the union of `ids` at each pixel, from the TYPE00.. channels of a frame that was read
// or made. plane: [height][width]. GLINT_E_NOT_FOUND if the frame has no such type.
glint_status glint_cryptomatte_matte(const struct glint_frame *frame, const char *type,
                                     const uint32_t *ids, size_t count, float *plane,
                                     struct glint_error *err);

#endif
