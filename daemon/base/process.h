// process.h - what this process uses of the machine.
//
// Thread-safety: any thread.
#ifndef GLINT_BASE_PROCESS_H
#define GLINT_BASE_PROCESS_H

#include <stdint.h>

struct glint_process {
    double cpu_seconds;     // of all threads, user and system
    double started;         // seconds since 1970
    uint64_t virtual_bytes; // of address space
    uint64_t resident_bytes;
    uint32_t threads;
    uint32_t files, most_files; // descriptors
};

// What the kernel does not say is 0.
void glint_process_look(struct glint_process *out);

#endif
