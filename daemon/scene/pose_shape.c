// pose_shape.c - one deforming mesh: what its skin and weights ask for, and its vertices at the keys.
#include "scene/pose_work.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define VERTEX_BYTES (sizeof(float[3]) * 2 + sizeof(float[4])) // position, normal, tangent

static const struct glint_mesh *mesh_of(const struct glint_pose_shape *s,
                                        const struct glint_scene *scene)
{
    return &scene->mesh[s->mesh];
}

static glint_status no_memory(const struct glint_mesh *mesh, struct glint_error *err)
{
    return glint_fail(err, GLINT_E_NOMEM, "", "no memory to deform the %u vertices of a mesh",
                      mesh->vertices);
}

static bool weights_at(const struct glint_pose_shape *s, const struct glint_mesh *mesh,
                       struct glint_pose_moment at, double *out)
{
    if (s->channel && s->channel->width == mesh->targets)
        glint_pose_channel(s->channel, at, NULL, out);
    else
        for (uint32_t t = 0; t < mesh->targets; t++)
            out[t] = s->rest ? s->rest[t] : 0;
    bool any = false;
    for (uint32_t t = 0; t < mesh->targets; t++)
        any |= out[t] != 0;
    return any;
}

// How far target t moves a vertex at most.
static double extent_of(const struct glint_mesh *mesh, uint32_t t)
{
    const float *d = mesh->target_position + (size_t)3 * mesh->vertices * t;
    double most = 0;
    for (size_t i = 0; i < mesh->vertices; i++, d += 3) {
        const double square = (double)d[0] * d[0] + (double)d[1] * d[1] + (double)d[2] * d[2];
        most = square > most ? square : most;
    }
    return sqrt(most);
}

static bool same(const double *a, const double *b, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (a[i] != b[i])
            return false;
    return true;
}

struct measure {
    const struct glint_pose_nodes *nodes;
    const struct glint_mesh *mesh;
    double lo[3], hi[3]; // of the mesh
    double swell;        // how far weights may carry a vertex
};

static double diagonal(const double lo[3], const double hi[3])
{
    return hypot(hypot(hi[0] - lo[0], hi[1] - lo[1]), hi[2] - lo[2]);
}

static void measure_weights(struct glint_pose_shape *s, struct measure *me)
{
    const uint32_t targets = me->mesh->targets;
    struct glint_pose_stray stray = {{0}};
    for (uint32_t t = 0; t < targets; t++) {
        double track[GLINT_POSE_ALL], most = 0;
        for (uint32_t m = 0; m < me->nodes->moments; m++) {
            track[m] = s->weight[(size_t)m * targets + t];
            most = fmax(most, fabs(track[m]));
        }
        if (most == 0)
            continue;
        const double extent = extent_of(me->mesh, t);
        me->swell += most * extent;
        struct glint_pose_stray one = {{0}};
        if (me->nodes->shutter > 1)
            glint_pose_stray_number(&one, track);
        for (int c = 0; c < 4; c++) // together at worst
            stray.worst[c] += one.worst[c] * extent;
    }
    s->keys = glint_pose_stray_keys(&stray, diagonal(me->lo, me->hi) + me->swell);
}

static glint_status prepare_weights(struct glint_pose_shape *s, struct glint_arena *arena,
                                    struct measure *me, struct glint_error *err)
{
    const uint32_t targets = me->mesh->targets;
    s->weight = glint_arena_array(arena, (size_t)me->nodes->moments * targets, sizeof *s->weight);
    if (!s->weight)
        return no_memory(me->mesh, err);
    for (uint32_t m = 0; m < me->nodes->moments; m++) {
        double *at = s->weight + (size_t)m * targets;
        s->morphed |= weights_at(s, me->mesh, me->nodes->moment[m], at);
        if (!same(at, s->weight, targets))
            *(m < me->nodes->shutter ? &s->bends : &s->flows) = true;
    }
    if (s->morphed)
        measure_weights(s, me);
    return GLINT_OK;
}

struct box {
    double lo[3], hi[3];
};

static void clear(struct box *b)
{
    for (int k = 0; k < 3; k++) {
        b->lo[k] = INFINITY;
        b->hi[k] = -INFINITY;
    }
}

static void include(struct box *b, const double p[3])
{
    for (int k = 0; k < 3; k++) {
        b->lo[k] = p[k] < b->lo[k] ? p[k] : b->lo[k];
        b->hi[k] = p[k] > b->hi[k] ? p[k] : b->hi[k];
    }
}

// The box of the vertices that each joint moves.
static glint_status joint_boxes(const struct glint_mesh *mesh, const struct glint_skin *skin,
                                struct box *box, struct glint_error *err)
{
    for (uint32_t j = 0; j < skin->joints; j++)
        clear(&box[j]);
    for (size_t i = 0; i < mesh->vertices; i++) {
        const double p[3] = {mesh->position[3 * i], mesh->position[3 * i + 1],
                             mesh->position[3 * i + 2]};
        for (size_t k = 4 * i; k < 4 * i + 4; k++) {
            if (mesh->joint[k] >= skin->joints)
                return glint_fail(err, GLINT_E_RANGE, "",
                                  "mesh %s uses joint %u of a skin that has %u", mesh->id,
                                  mesh->joint[k], skin->joints);
            if (mesh->weight[k] > 0)
                include(&box[mesh->joint[k]], p);
        }
    }
    return GLINT_OK;
}

static void joint_matrix(double out[16], const struct glint_pose_nodes *n,
                         const struct glint_skin *skin, uint32_t j, uint32_t moment)
{
    glint_pose_multiply_float(out, glint_pose_world(n, skin->joint[j], moment),
                              skin->inverse_bind + (size_t)16 * j);
}

static void corner_of(const struct box *b, int corner, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = corner >> k & 1 ? b->hi[k] : b->lo[k];
}

struct joints {
    struct glint_pose_stray stray;
    struct box whole; // at the first moment
    double middle[3]; // sums
    double sides;     // of signs of determinants
    uint32_t used;
};

static void follow_corners(struct joints *all, const struct box *b, const glint_pose_matrix *m,
                           bool moves)
{
    for (int corner = 0; corner < 8; corner++) {
        double p[3], track[GLINT_POSE_MOMENTS][3];
        corner_of(b, corner, p);
        glint_pose_point(track[0], m[0], p);
        include(&all->whole, track[0]);
        for (int k = 0; k < 3; k++)
            all->middle[k] += track[0][k] / 8;
        for (uint32_t i = 1; moves && i < GLINT_POSE_MOMENTS; i++)
            glint_pose_point(track[i], m[i], p);
        if (moves)
            glint_pose_stray_point(&all->stray, track);
    }
}

static void measure_joint(struct glint_pose_shape *s, const struct measure *me,
                          const struct glint_skin *skin, uint32_t j, struct box b,
                          struct joints *all)
{
    const struct glint_pose_nodes *n = me->nodes;
    glint_pose_matrix m[GLINT_POSE_ALL];
    bool moves = false;
    const uint32_t moments = glint_pose_touches(n, skin->joint[j]) ? n->moments : 1;
    for (uint32_t i = 0; i < moments; i++) {
        joint_matrix(m[i], n, skin, j, i);
        if (!same(m[i], m[0], 16))
            *(i < n->shutter ? &moves : &s->flows) = true;
    }
    for (int k = 0; k < 3; k++) {
        b.lo[k] -= me->swell;
        b.hi[k] += me->swell;
    }
    s->bends |= moves;
    follow_corners(all, &b, m, moves);
    all->sides += glint_matrix_determinant(m[0]) < 0 ? -1 : 1;
    all->used++;
}

// Vertices are kept relative to the middle of the shape, and mirrored where the joints mirror them:
// `transform` then tells so, as it does for what is rigid.
static void set_frame(struct glint_pose_shape *s, const struct joints *all)
{
    const double side = all->sides < 0 ? -1 : 1;
    double middle[3] = {0};
    for (int k = 0; k < 3 && all->used; k++) {
        const double mean = all->middle[k] / all->used;
        middle[k] = fabs(mean) <= (double)GLINT_MAX_COORDINATE ? mean : 0;
    }
    const double frame[16] = {side, 0, 0, 0, 0,         1,         0,         0,
                              0,    0, 1, 0, middle[0], middle[1], middle[2], 1};
    const double back[16] = {
        side, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -side * middle[0], -middle[1], -middle[2], 1};
    memcpy(s->frame, frame, sizeof frame);
    memcpy(s->back, back, sizeof back);
}

static glint_status measure_skin(struct glint_pose_shape *s, const struct measure *me,
                                 struct glint_error *err)
{
    const struct glint_skin *skin = &me->nodes->scene->skin[s->skin];
    struct box *box = malloc(skin->joints * sizeof *box);
    if (!box)
        return no_memory(me->mesh, err);
    const glint_status st = joint_boxes(me->mesh, skin, box, err);
    struct joints all = {.stray = {{0}}};
    clear(&all.whole);
    for (uint32_t j = 0; !st && j < skin->joints; j++)
        if (box[j].lo[0] <= box[j].hi[0])
            measure_joint(s, me, skin, j, box[j], &all);
    free(box);
    set_frame(s, &all);
    const uint32_t keys = glint_pose_stray_keys(&all.stray, diagonal(all.whole.lo, all.whole.hi));
    s->keys = keys > s->keys ? keys : s->keys;
    return st;
}

glint_status glint_pose_shape_measure(struct glint_pose_shape *s, struct glint_arena *arena,
                                      const struct glint_pose_nodes *n, const double lo[3],
                                      const double hi[3], struct glint_error *err)
{
    struct measure me = {.nodes = n, .mesh = mesh_of(s, n->scene)};
    memcpy(me.lo, lo, sizeof me.lo);
    memcpy(me.hi, hi, sizeof me.hi);
    s->skinned = s->skin != GLINT_NONE;
    s->keys = 2;
    set_frame(s, &(struct joints){.used = 0});
    glint_status st = GLINT_OK;
    if (me.mesh->targets)
        st = prepare_weights(s, arena, &me, err);
    if (!st && s->skinned)
        st = measure_skin(s, &me, err);
    return st;
}

static bool deforms(const struct glint_pose_shape *s)
{
    return s->skinned || s->morphed;
}

double glint_pose_shape_bytes(const struct glint_pose_shape *s, const struct glint_scene *scene,
                              uint32_t keys)
{
    if (!deforms(s))
        return 0;
    const double vertices = mesh_of(s, scene)->vertices;
    return vertices * (VERTEX_BYTES * (s->bends ? keys : 1) + 2 * sizeof(float[3]));
}

struct filling {
    const struct glint_pose_nodes *nodes;
    const struct glint_mesh *mesh;
    float *matrix;                   // [joints][16], or NULL
    struct glint_pose_deformed rest; // what is to be skinned
    float *scratch;                  // of the morphed, before they are skinned
};

static void fill_matrices(const struct glint_pose_shape *s, struct filling *f, uint32_t moment)
{
    const struct glint_skin *skin = &f->nodes->scene->skin[s->skin];
    for (uint32_t j = 0; j < skin->joints; j++) {
        double to_world[16], m[16];
        joint_matrix(to_world, f->nodes, skin, j, moment);
        glint_matrix_multiply(m, s->back, to_world);
        for (int i = 0; i < 16; i++)
            f->matrix[(size_t)16 * j + i] = (float)m[i];
    }
}

static void fill_moment(const struct glint_pose_shape *s, struct filling *f, uint32_t moment,
                        const struct glint_pose_deformed *out)
{
    const double *weight = s->weight + (size_t)moment * f->mesh->targets;
    if (s->morphed)
        glint_pose_morph(f->mesh, weight, s->skinned ? &f->rest : out);
    if (s->skinned) {
        fill_matrices(s, f, moment);
        glint_pose_skin(f->mesh, f->matrix, &f->rest, out);
    }
}

static bool prepare_filling(const struct glint_pose_shape *s, struct filling *f)
{
    const size_t vertices = f->mesh->vertices;
    f->rest = (struct glint_pose_deformed){(float *)f->mesh->position, (float *)f->mesh->normal,
                                           (float *)f->mesh->tangent};
    if (!s->skinned)
        return true;
    f->matrix = aligned_alloc(64, f->nodes->scene->skin[s->skin].joints * sizeof(float[16]));
    if (!s->morphed)
        return f->matrix;
    f->scratch = malloc(vertices * VERTEX_BYTES);
    if (!f->scratch)
        return false;
    f->rest.position = f->scratch;
    f->rest.normal = f->mesh->normal ? f->scratch + 3 * vertices : NULL;
    f->rest.tangent = f->mesh->tangent ? f->scratch + 6 * vertices : NULL;
    return f->matrix;
}

static bool allocate(struct glint_pose_shape *s, struct glint_arena *arena,
                     const struct glint_mesh *mesh, uint32_t sets, bool flow)
{
    const size_t count = (size_t)mesh->vertices * sets;
    s->position = glint_arena_array(arena, count, sizeof(float[3]));
    s->normal = mesh->normal ? glint_arena_array(arena, count, sizeof(float[3])) : NULL;
    s->tangent = mesh->tangent ? glint_arena_array(arena, count, sizeof(float[4])) : NULL;
    s->flow_position =
        flow ? glint_arena_array(arena, (size_t)mesh->vertices * 2, sizeof(float[3])) : NULL;
    return s->position && (s->normal || !mesh->normal) && (s->tangent || !mesh->tangent) &&
           (s->flow_position || !flow);
}

static void fill_all(struct glint_pose_shape *s, struct filling *f, uint32_t sets, bool flow)
{
    const size_t vertices = f->mesh->vertices;
    for (uint32_t k = 0; k < sets; k++) {
        const struct glint_pose_deformed out = {s->position + 3 * vertices * k,
                                                s->normal ? s->normal + 3 * vertices * k : NULL,
                                                s->tangent ? s->tangent + 4 * vertices * k : NULL};
        fill_moment(s, f, glint_pose_moment_of(k, sets), &out);
    }
    f->rest.normal = f->rest.tangent = NULL; // motion vectors want positions alone
    for (uint32_t k = 0; flow && k < 2; k++) {
        const struct glint_pose_deformed out = {s->flow_position + 3 * vertices * k, NULL, NULL};
        fill_moment(s, f, f->nodes->shutter + k, &out);
    }
}

glint_status glint_pose_shape_fill(struct glint_pose_shape *s, struct glint_arena *arena,
                                   const struct glint_pose_nodes *n, uint32_t keys,
                                   struct glint_error *err)
{
    if (!deforms(s))
        return GLINT_OK;
    struct filling f = {.nodes = n, .mesh = mesh_of(s, n->scene)};
    const uint32_t sets = s->bends ? keys : 1;
    const bool flow = n->moments > n->shutter && (s->bends || s->flows);
    const bool ready = prepare_filling(s, &f) && allocate(s, arena, f.mesh, sets, flow);
    if (ready)
        fill_all(s, &f, sets, flow);
    free(f.matrix);
    free(f.scratch);
    return ready ? GLINT_OK : no_memory(f.mesh, err);
}
