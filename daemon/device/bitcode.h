// bitcode.h - programs made of what their source was compiled to; private to device/.
//
// To find a program in its cache PoCL has clang read the whole source, once for each device: most of
// what a start takes where everything is compiled. A program made of the bitcode that lies there is
// found by the bytes' hash instead, in a folder of another name; that name is made a link to the
// folder of the source's program, so that both are one, kernels included.
//
// Threads: as clBuildProgram().
#ifndef GLINT_DEVICE_BITCODE_H
#define GLINT_DEVICE_BITCODE_H

#include "device/internal.h"

// The program of the file for the first `count` devices, to be built yet. NULL: it cannot be made.
cl_program glint_bitcode_program(glint_devices *devices, uint32_t count, const char *path);

// In a cache that holds one program, built with these options: makes the link, which PoCL is asked
// for the name of. False: there is none, and nothing that looks like one.
bool glint_bitcode_link(glint_devices *devices, const char *options, const char *cache);

#endif
