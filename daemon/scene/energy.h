// energy.h - parts of the table of gk_energy.h, for the interfaces that scenes have.
#ifndef GLINT_SCENE_ENERGY_H
#define GLINT_SCENE_ENERGY_H

// The part of a white reflector, and that of an interface: GK_ENERGY_PART numbers each. ior >= 1,
// taken for the nearest of 640 steps in (ior - 1) / (ior + 1), of which 1.5 is one. Parts of white, of
// 1, of 1.33, 1.45 and 1.5 are built in; any other takes some 40 ms of CPU time, by all cores, when a
// process first asks for it, and is there as long as the process. Any thread.
const float *glint_energy_white(void);
const float *glint_energy_interface(float ior);

// The GK_ENERGY_PARTS parts of a transmitting interface, the first of which is the above's.
const float *glint_energy_glass(float ior);

#endif
