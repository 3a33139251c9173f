// jobs_fixture.h - a job table over stand-ins, and ways to wait for it.
#ifndef GLINT_TESTS_JOBS_FIXTURE_H
#define GLINT_TESTS_JOBS_FIXTURE_H

#include "fake_render.h"
#include "fake_scene.h"
#include "jobs/jobs.h"

struct fixture {
    glint_store *store;
    glint_jobs *jobs;
    const char *client; // who submits, NULL: nobody says
};

// A store with the scene "s" (camera id "c", name "Front") and jobs on `workers` stand-in workers.
void fixture_start(struct fixture *f, uint32_t workers);
void fixture_start_within(struct fixture *f, uint32_t workers, uint64_t film_bytes);
// Ends all; nothing may be left, no rule broken.
void fixture_stop(struct fixture *f);

// Submits JSON (single quotes stand for double ones) and returns the id in static memory of 8 turns.
const char *fixture_submit(struct fixture *f, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
glint_status fixture_try(struct fixture *f, const char *text, const char *key,
                         char id[GLINT_JOB_ID_BYTES], bool *repeated, struct glint_error *err);
// Patches with such JSON.
glint_status fixture_patch(struct fixture *f, const char *id, const char *text);

// The member of the job's description, by value; NAN for null and for what is no number.
double fixture_number(struct fixture *f, const char *id, const char *member);
enum glint_job_state fixture_state(struct fixture *f, const char *id);

// Wait for a state; fails the test after 20 seconds.
void fixture_wait(struct fixture *f, const char *id, enum glint_job_state state);

#endif
