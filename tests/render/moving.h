// moving.h - scenes in which one thing moves during the second from 0 to 1, one frame a second.
#ifndef GLINT_TESTS_MOVING_H
#define GLINT_TESTS_MOVING_H

#include "tests/stability/stable.h"

// Members of all of them.
#define MOVING_MATERIALS                                         \
    "'materials':{'white':{'base_color':[0.7,0.7,0.7],'ior':1}," \
    "'red':{'base_color':[0.8,0.15,0.1],'ior':1},'glow':{'emission':[6,5,3],'ior':1}}"
#define MOVING_CAMERA "'cameras':{'eye':{'yfov':0.6,'transform':{'translation':[0,0,6]}}}"
#define MOVING_LAMP                                                                              \
    "'lights':{'lamp':{'type':'point','intensity':25,'transform':{'translation':[1.5,2.5,3]}}}," \
    "'environment':{'radiance':[0.3,0.35,0.45]}"

// Before a wall lit by a lamp and the sky; all malloc'd texts.
char *moving_box(void);     // goes from left to right
char *moving_bar(void);     // turns by a quarter about the line of sight
char *moving_column(void);  // bends over by 60 degrees and swells: a skin and a morph target
char *moving_camera(void);  // the camera passes the box and turns to it
char *moving_emitter(void); // a glowing panel and an area light pass the dark wall
char *moving_lamps(void);   // a point and a spot light pass it

// "'shutter':[open,close]" and so on for one of these, `side` pixels wide, 3/4 as high.
char *moving_job(double open, double close, int side, int samples, int seed);

#endif
