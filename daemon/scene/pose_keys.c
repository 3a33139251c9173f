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

void glint_pose_stray_point(struct glint_pose_stray *s, double (*track)[3])
{
    for (int c = 0; c < 4; c++) {
        double worst = 0;
        for (uint32_t m = 1; m + 1 < GLINT_POSE_MOMENTS; m++) {
            uint32_t a, b;
            double f, square = 0;
            segment(c, m, &a, &b, &f);
            for (int k = 0; k < 3; k++) {
                const double d = track[m][k] - track[a][k] - f * (track[b][k] - track[a][k]);
                square += d * d;
            }
            worst = fmax(worst, square);
        }
        s->worst[c] = fmax(s->worst[c], sqrt(worst));
    }
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

uint32_t glint_pose_box_keys(const glint_pose_matrix *m, const double lo[3], const double hi[3])
{
    struct glint_pose_stray stray = {{0}};
    double diagonal = 0;
    for (int corner = 0; corner < 8; corner++) {
        double track[GLINT_POSE_MOMENTS][3], across[3], opposite[3];
        const double p[3] = {corner & 1 ? hi[0] : lo[0], corner & 2 ? hi[1] : lo[1],
                             corner & 4 ? hi[2] : lo[2]};
        for (int k = 0; k < 3; k++)
            across[k] = lo[k] + hi[k] - p[k];
        for (uint32_t i = 0; i < GLINT_POSE_MOMENTS; i++)
            glint_pose_point(track[i], m[i], p);
        glint_pose_point(opposite, m[0], across);
        glint_pose_stray_point(&stray, track);
        diagonal = fmax(diagonal, hypot(hypot(opposite[0] - track[0][0], opposite[1] - track[0][1]),
                                        opposite[2] - track[0][2]));
    }
    return glint_pose_stray_keys(&stray, diagonal);
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
