// import_helper.h - the process between the daemon and its import children.
//
// It is forked before the daemon has threads, so that the children that it forks in turn start from
// a small image of one thread. For each request, which brings the input, the output and a pipe, it
// forks a child and, when that has ended, writes how to the pipe. At most GLINT_IMPORT_CHILDREN run
// at a time; further requests wait in the socket.
#ifndef GLINT_SCENE_IMPORT_HELPER_H
#define GLINT_SCENE_IMPORT_HELPER_H

#include "scene/import.h"

#include <stdint.h>

#define GLINT_IMPORT_CHILDREN 8

// One message on the SOCK_SEQPACKET socket, with four descriptors: input, assets, output, reply.
struct glint_import_request {
    uint32_t type;   // enum glint_scene_type
    uint32_t assets; // there are some, laid out like an answer
    uint64_t size;   // of the input
    struct glint_import_limits limits;
    char boundary[GLINT_MAX_BOUNDARY + 2]; // of multipart
};

// Exit codes of a child.
enum { GLINT_CHILD_ANSWERED = 0, GLINT_CHILD_NOT_CONFINED = 3, GLINT_CHILD_NO_ROOM = 4 };

struct glint_import_reply {
    int32_t signal;    // that ended the child, or 0
    int32_t code;      // exit code where signal is 0
    int32_t timed_out; // the helper ended it by the wall clock
};

// Serves until the other end of the socket is closed.
void glint_helper_main(int socket) __attribute__((noreturn));

#endif
