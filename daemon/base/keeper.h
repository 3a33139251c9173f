// keeper.h - the state folder of a daemon: who may use it, and what lies in it.
//
//   DIR/lock        held while a daemon runs: a second one is refused
//   DIR/journal.db  what was accepted (journal.h)
//   DIR/assets/     content of scenes (vault.h)
//   DIR/films/      checkpoints of jobs (jobs/checkpoint.h)
//
// Thread-safety: create and destroy by main; the rest immutable.
#ifndef GLINT_BASE_KEEPER_H
#define GLINT_BASE_KEEPER_H

#include "base/journal.h"
#include "base/vault.h"

typedef struct glint_keeper glint_keeper;

// Takes the folder, which exists. metrics: may be NULL; lives longer.
//   GLINT_E_CONFLICT  another daemon uses it, or its content is newer or not ours
//   GLINT_E_IO, GLINT_E_CAPACITY  it is damaged or cannot be written
glint_status glint_keeper_create(glint_keeper **out, const char *folder, glint_metrics *metrics,
                                 struct glint_error *err);
void glint_keeper_destroy(glint_keeper **keeper); // after whoever uses it

glint_journal *glint_keeper_journal(glint_keeper *keeper);
glint_vault *glint_keeper_vault(glint_keeper *keeper);
glint_metrics *glint_keeper_metrics(glint_keeper *keeper);  // NULL: none
const char *glint_keeper_films(const glint_keeper *keeper); // the folder

#endif
