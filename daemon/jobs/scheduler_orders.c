// scheduler_orders.c - what is at the workers: whose slices, and how they come back early.
#include "jobs/scheduler_parts.h"

#include "jobs/state.h"
#include "render/hold.h"

#include <string.h>

// One that is none of its orders'.
static atomic_uint *free_hold(struct glint_load *load)
{
    for (uint32_t h = 0; h < GLINT_CREW_DEPTH; h++) {
        bool used = false;
        for (uint32_t i = 0; i < load->orders; i++)
            used |= load->order[i].slice.hold == &load->hold[h];
        if (!used)
            return &load->hold[h];
    }
    return NULL;
}

void glint_load_add(struct glint_load *load, struct glint_entry *e, struct glint_slice *slice)
{
    slice->hold = free_hold(load);
    if (slice->hold)
        atomic_init(slice->hold, GLINT_HOLD_WAITING); // the queue's lock orders it
    load->order[load->orders++] = (struct glint_order){e, *slice, false};
}

const struct glint_entry *glint_load_next(struct glint_load *load)
{
    load->orders--;
    memmove(load->order, load->order + 1, load->orders * sizeof *load->order);
    return load->orders ? load->order[0].entry : NULL;
}

uint32_t glint_scheduler_idlest(const glint_scheduler *s)
{
    uint32_t best = GLINT_NONE, load = GLINT_CREW_DEPTH;
    for (uint32_t w = 0; w < glint_crew_workers(s->crew); w++)
        if (s->load[w].orders < load) {
            best = w;
            load = s->load[w].orders;
        }
    return best;
}

void glint_scheduler_recall(glint_scheduler *s)
{
    struct glint_entry *entry;
    struct glint_slice slice;
    for (uint32_t w = 0; w < glint_crew_workers(s->crew); w++)
        while (glint_crew_recall(s->crew, w, &entry, &slice)) {
            glint_render_give_back(entry->render, &slice, false);
            entry->out--;
            s->load[w].orders--; // the last one: what runs stays
        }
}

void glint_scheduler_revoke(glint_scheduler *s, struct glint_entry *e)
{
    for (uint32_t w = 0; w < glint_crew_workers(s->crew); w++)
        for (uint32_t i = 0; i < s->load[w].orders; i++) {
            struct glint_order *o = &s->load[w].order[i];
            if (o->entry != e || o->revoked || !glint_hold_revoke(o->slice.hold))
                continue;
            glint_render_give_back(e->render, &o->slice, false);
            glint_state_lend(s->table, glint_entry_retain(e), 1);
            o->revoked = true;
            e->out--;
        }
}

void glint_scheduler_forget(glint_scheduler *s, struct glint_order *o)
{
    if (!o->revoked)
        return;
    glint_state_lend(s->table, o->entry, -1);
    glint_entry_release(&o->entry);
}
