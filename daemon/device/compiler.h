// compiler.h - sets the compiler of PoCL; private to device/.
#ifndef GLINT_DEVICE_COMPILER_H
#define GLINT_DEVICE_COMPILER_H

#include "device/sources.h"

#define GLINT_COMPILER_FOLDER 32

// Tells the LLVM that PoCL has loaded how to compile the table's kernels; once in a process, before
// the first is compiled. folder: a name for what it makes of them.
void glint_compiler_set(char folder[GLINT_COMPILER_FOLDER], const struct glint_source *table,
                        const char *platform);

// What kernels are built with besides, for this processor.
const char *glint_compiler_options(void);

// That name alone: another one for another platform (name and version of PoCL and LLVM), processor
// or set of options, none of which PoCL's own cache knows for certain.
void glint_compiler_name(char folder[GLINT_COMPILER_FOLDER], const struct glint_source *table,
                         const char *platform);

#endif
