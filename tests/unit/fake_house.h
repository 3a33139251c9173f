// fake_house.h - scenes, jobs and renders that do what a test says, behind the contracts of
// scene/store.h, jobs/jobs.h and render/render.h. For tests of what stands above them.
//
// A fake job renders a row of `tiles` tiles of 64x64 pixels; a tile's colour is its version
// modulo 1024, which halves hold exactly.
#ifndef GLINT_TESTS_FAKE_HOUSE_H
#define GLINT_TESTS_FAKE_HOUSE_H

#include "jobs/jobs.h"

struct fake_house {
    glint_devices *devices;
    glint_store *store;
    glint_jobs *jobs;
};

// One scene, "room", exists; jobs get `tiles` tiles.
void fake_house_open(struct fake_house *house, uint32_t tiles);
void fake_house_close(struct fake_house *house);

// The newest job's id; "" when there is none.
void fake_job_last(glint_jobs *jobs, char id[GLINT_JOB_ID_BYTES]);

// The job's pixels exist from now on: until then its view is GLINT_E_BUSY.
void fake_job_prepare(glint_jobs *jobs, const char *id);
// A new version of one tile, or of all (UINT32_MAX).
void fake_job_render(glint_jobs *jobs, const char *id, uint32_t tile);
// The same, and while its version is looked for, the first tile and then the last get new ones too:
// the first when it has been looked at already.
void fake_job_race(glint_jobs *jobs, const char *id, uint32_t tile);
void fake_job_set_state(glint_jobs *jobs, const char *id, enum glint_job_state state);
void fake_job_warn(glint_jobs *jobs, const char *id, const char *text);

// While closed, glint_store_put waits: a long import.
void fake_store_gate(glint_store *store, bool open);

#endif
