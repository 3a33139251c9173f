// price.h - what settings cost: the front measured for each scene, and those of classes of scenes.
//
// Clients measure and put fronts, which are kept with the scenes. A scene without one has that of
// its class, which the daemon brings along: see docs/accuracy.
//
// Threads: any that may wait for a disk; create and destroy by one.
#ifndef GLINT_JOBS_PRICE_H
#define GLINT_JOBS_PRICE_H

#include "base/keeper.h"
#include "device/sources.h"
#include "protocol/accuracy_front.h"
#include "scene/facts.h"

typedef struct glint_prices glint_prices;

// Fronts of classes, embedded by the build: "glass.json" and so on.
extern const struct glint_source glint_class_fronts[];

// keeper: NULL: fronts are not kept.
glint_status glint_prices_create(glint_prices **out, glint_keeper *keeper, struct glint_error *err);
void glint_prices_destroy(glint_prices **prices);

// The front of the scene from now on, once it is on the disk. *created: it had none.
//   GLINT_E_SYNTAX, GLINT_E_RANGE  what is wrong with it
//   GLINT_E_CAPACITY               too many scenes have one
glint_status glint_prices_put(glint_prices *prices, const char *scene, const char *text,
                              size_t length, bool *created, struct glint_error *err);
// The scene has none any more; no fault where it had none.
glint_status glint_prices_remove(glint_prices *prices, const char *scene, struct glint_error *err);

// The class of a scene, by what it contains.
const char *glint_price_class(const struct glint_scene_facts *facts);

// The front that holds for the scene as JSON, malloc'd, and whether it is the scene's own; NULL
// without memory. A class is one that glint_price_class() gave.
char *glint_prices_find(glint_prices *prices, const char *scene, const char *of_class, bool *own);

#endif
