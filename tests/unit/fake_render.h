// fake_render.h - stands in for devices and renders: jobs of counted slices, run under the test's
// control. A job has `width` blocks and stop.samples passes of one sample; a pass begins when the
// one before is back. Jobs are told apart by their seed; a film has a byte per pixel.
//
// It checks what a render may rely on: a block has one owner at a time, no slice is run twice, and
// nothing is given back that was not taken.
#ifndef GLINT_TESTS_FAKE_RENDER_H
#define GLINT_TESTS_FAKE_RENDER_H

#include "render/render.h"

// One set of devices at a time.
glint_devices *fake_devices(uint32_t workers);

// Forgets everything set and recorded; no render may live. The gate is open.
void fake_reset(void);

// A closed gate holds every slice before it runs, until that many are let through.
void fake_close_gate(void);
void fake_open_gate(void);
void fake_let(unsigned slices);
// Slices at the gate do not notice an interruption: their workers get no processor.
void fake_deafen(void);
// Holds every slice that has been taken up and is not traced yet: it cannot be taken away.
void fake_hold_prepare(bool held);
// The same for glint_render_create.
void fake_hold_create(bool held);
// Returns once a create waits.
void fake_wait_create(void);

// The next slice of the job fails with GLINT_E_DEVICE; the next `times` creates fail.
void fake_fail_slice(uint32_t seed);
void fake_fail_create(uint32_t seed, glint_status status, unsigned times);
// The next move of the job fails with GLINT_E_RANGE.
void fake_fail_move(uint32_t seed);
// Holds every glint_render_move until it is let go.
void fake_hold_move(bool held);
void fake_wait_moves(uint32_t count); // until so many have begun
uint32_t fake_moves(void);
// Waits until so many renders have started again; the yfov of the job's own camera of the last.
float fake_wait_restarts(uint32_t count);
uint32_t fake_restarts(void);
int fake_views(void); // that live
// take() answers false before the first slice, though none has been taken.
void fake_stick(uint32_t seed);
// The job begins as a sketch: each block once, and no more until it is moved.
void fake_sketch(uint32_t seed);
// Each slice of the job spins for so long.
void fake_slice_seconds(uint32_t seed, double seconds);

// Waits until `count` slices have begun in all (those at the gate are counted), and copies the
// seeds of the first `count` in order.
void fake_begun(size_t count, uint32_t *seed);
size_t fake_begun_now(void);
uint32_t fake_creates(void); // calls so far
void fake_wait_creates(uint32_t count);
int fake_renders(void); // that live

// Rules broken so far; 0 in every test.
int fake_broken(void);

#endif
