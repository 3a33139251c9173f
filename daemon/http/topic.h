// topic.h - the events of one job.
//
// Thread-safety: any thread, but for create and destroy; `next` and `users` belong to the list that
// a topic is in.
#ifndef GLINT_HTTP_TOPIC_H
#define GLINT_HTTP_TOPIC_H

#include "http/stream.h"

#include <pthread.h>

struct glint_topic;

#define GLINT_TOPIC_RING 256 // events that can be sent again

struct glint_topic_event {
    uint64_t id;
    struct glint_blob *text; // as it is sent
};

struct glint_topic {
    struct glint_topic *next;
    unsigned users;
    char job[GLINT_JOB_ID_BYTES];
    glint_stream_news news; // what readers wait for
    atomic_bool quiet;      // the job did not render when it was looked at last

    pthread_mutex_t mutex;                           // guards the rest; a leaf but for the jobs'
    struct glint_topic_event ring[GLINT_TOPIC_RING]; // event i is ring[i % GLINT_TOPIC_RING]
    uint64_t count;                                  // events so far
    uint64_t last;                                   // id of the newest
    uint64_t looked_at;                              // the job's sequence then
    char state[16];
    double samples, progress, progress_at;
    int warnings;
    bool ended; // nothing follows `done`, unless the job goes on
    bool gone;
};

struct glint_topic *glint_topic_create(const char *job); // NULL without memory
void glint_topic_destroy(struct glint_topic *topic);

// Looks at the job and publishes what is new with ids from cause_us on.
void glint_topic_look(struct glint_topic *topic, glint_jobs *jobs, uint64_t cause_us);

enum glint_topic_answer {
    GLINT_TOPIC_EVENT,   // *event, a reference; *cursor is its id
    GLINT_TOPIC_NOTHING, // yet
    GLINT_TOPIC_LOST,    // the cursor is not in the ring any more
    GLINT_TOPIC_OVER     // the job has ended, or is forgotten
};
enum glint_topic_answer glint_topic_read(struct glint_topic *topic, uint64_t *cursor,
                                         struct glint_blob **event);

bool glint_topic_knows(struct glint_topic *topic, uint64_t id); // it is in the ring

// The id is the last that an ended job's topic will have.
bool glint_topic_ended_with(struct glint_topic *topic, uint64_t id);

// The job's whole state as event `name` after `before`, which stands for every event up to now, but
// for the end: that has an event of its own, so that who is cut off before it still gets it. NULL:
// the job is gone, or there is no memory.
struct glint_blob *glint_topic_state(struct glint_topic *topic, glint_jobs *jobs, const char *name,
                                     const char *before, uint64_t *cursor);

#endif
