// fake_scene.h - stands in for the import child and for resident scenes: text in, counted scene out.
#ifndef GLINT_TESTS_FAKE_SCENE_H
#define GLINT_TESTS_FAKE_SCENE_H

#include "scene/store.h"

#define FAKE_RESIDENT_BYTES 1500u // of every resident scene, over all kinds

// A scene whose bytes begin with "bad" is refused by the import with GLINT_E_SYNTAX.

// The next resident scene fails with this status.
void fake_scene_fail(glint_status status);

// Resident scenes and imports that live.
int fake_scene_residents(void);
int fake_scene_imports(void);

// While it is held, imports wait; `fake_scene_waiting` returns once one does.
void fake_scene_hold(bool held);
void fake_scene_waiting(void);

#endif
