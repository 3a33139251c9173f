// energy.h - the table of gk_energy.h, computed once per process.
#ifndef GLINT_SCENE_ENERGY_H
#define GLINT_SCENE_ENERGY_H

// GK_ENERGY_ENTRIES numbers, there as long as the process. Takes some 50 ms the first time. Any
// thread.
const float *glint_energy_table(void);

#endif
