// import_jail.h - the sandbox that a child enters before it looks at an untrusted byte.
//
// Inside: the calling process can compute, allocate up to a bound, and read, write and map the
// descriptors it already has. Opening anything fails with EACCES; every other system call, sockets,
// processes, executable memory and signals to others among them, ends it with SIGSYS.
//
// Thread-safety: called once, by a process of one thread.
#ifndef GLINT_SCENE_IMPORT_JAIL_H
#define GLINT_SCENE_IMPORT_JAIL_H

#include "scene/import.h"

#include <stdbool.h>

// memory_bytes bounds the growth of the address space from here on, and the size of any file.
// Past cpu_seconds of processor time, rounded up, the process gets SIGXCPU. It dies with `parent`,
// its parent process. False: the process is not confined and must not go on.
bool glint_jail_enter(const struct glint_import_limits *limits, int parent);

// Closes every descriptor from 3 on but the `count` listed, in ascending order.
bool glint_jail_close_others(const int *keep, int count);

#endif
