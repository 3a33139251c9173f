// pose_keys.c - how many keys keep a motion straight enough between them.
#include "scene/pose_work.h"

#include <math.h>
#include <string.h>

#define TOLERANCE 1e-3

static const uint32_t choice[4] = {2, 3, 5, 9};

// Where moment m lies between the keys of choice c: their moments a and b, and the share f of b.
static void segment(int c, uint32_t m, uint32_t *a, uint32_t *b, double *f)
{
    const uint32_t step = (GLINT_POSE_MOMENTS - 1) / (choice[c] - 1);
    *a = m / step * step;
    *b = *a + step < GLINT_POSE_MOMENTS ? *a + step : *a;
    *f = (double)(m - *a) / step;
}

// Square of the greatest distance of the track from its chords with choice c.
static double strays(int c, double (*track)[3])
{
    double worst = 0;
    for (uint32_t m = 1; m + 1 < GLINT_POSE_MOMENTS; m++) {
        uint32_t a, b;
        double f, square = 0;
        segment(c, m, &a, &b, &f);
        for (int k = 0; k < 3; k++) {
            const double d = track[m][k] - track[a][k] - f * (track[b][k] - track[a][k]);
            square += d * d;
        }
        worst = square > worst ? square : worst;
    }
    return worst;
}

void glint_pose_stray_point(struct glint_pose_stray *s, double (*track)[3])
{
    for (int c = 0; c < 4; c++)
        s->worst[c] = fmax(s->worst[c], sqrt(strays(c, track)));
}

void glint_pose_stray_number(struct glint_pose_stray *s, const double *track)
{
    double point[GLINT_POSE_MOMENTS][3] = {{0}};
    for (uint32_t m = 0; m < GLINT_POSE_MOMENTS; m++)
        point[m][0] = track[m];
    glint_pose_stray_point(s, point);
}

uint32_t glint_pose_stray_keys(const struct glint_pose_stray *s, double size)
{
    for (int c = 0; c < 3; c++)
        if (!(s->worst[c] > TOLERANCE * size))
            return choice[c];
    return choice[3];
}

static double distance(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

// Where the corners go; opposite ones add up to 7.
static void follow(const glint_pose_matrix *m, const double lo[3], const double hi[3],
                   double track[8][GLINT_POSE_MOMENTS][3])
{
    for (int corner = 0; corner < 8; corner++) {
        const double p[3] = {corner & 1 ? hi[0] : lo[0], corner & 2 ? hi[1] : lo[1],
                             corner & 4 ? hi[2] : lo[2]};
        for (uint32_t i = 0; i < GLINT_POSE_MOMENTS; i++)
            glint_pose_point(track[corner][i], m[i], p);
    }
}

uint32_t glint_pose_box_keys(const glint_pose_matrix *m, const double lo[3], const double hi[3],
                             uint32_t least)
{
    double track[8][GLINT_POSE_MOMENTS][3], size = 0;
    follow(m, lo, hi, track);
    for (int corner = 0; corner < 4; corner++)
        size = fmax(size, distance(track[corner][0], track[7 - corner][0]));
    for (int c = 0; c < 3; c++) {
        bool straight = choice[c] >= least;
        for (int corner = 0; corner < 8 && straight; corner++)
            straight = sqrt(strays(c, track[corner])) <= TOLERANCE * size;
        if (straight)
            return choice[c];
    }
    return choice[3];
}

uint32_t glint_pose_frame_keys(const glint_pose_matrix *m)
{
    struct glint_pose_stray place = {{0}}, turn = {{0}};
    double track[4][GLINT_POSE_MOMENTS][3], path = 0;
    for (uint32_t i = 0; i < GLINT_POSE_MOMENTS; i++)
        for (int column = 0; column < 4; column++)
            memcpy(track[column][i], m[i] + 4 * column, sizeof track[column][i]);
    for (uint32_t i = 1; i < GLINT_POSE_MOMENTS; i++)
        path +=
            hypot(hypot(m[i][12] - m[i - 1][12], m[i][13] - m[i - 1][13]), m[i][14] - m[i - 1][14]);
    glint_pose_stray_point(&place, track[3]);
    for (int column = 0; column < 3; column++)
        glint_pose_stray_point(&turn, track[column]);
    const uint32_t a = glint_pose_stray_keys(&place, path), b = glint_pose_stray_keys(&turn, 1.0);
    return a > b ? a : b;
}
