#include "tests/render/bounced.h"

#include "tests/stability/stable.h"

#include <math.h>
#include <stdlib.h>

void bounced_take(struct shot *s, const char *scene, const char *job)
{
    char *scene_text = stable_text("%s", scene), *job_text = stable_text("%s", job);
    glint_resident *resident = offline_load_text(&things_crew, scene_text);
    shoot(s, resident, job_text);
    glint_resident_release(&resident);
    free(scene_text);
    free(job_text);
}

double bounced_mean(const struct shot *s, const char *type, const char *name, double *error)
{
    double sum = 0.0, square = 0.0;
    const double n = (double)pixels(s->frame);
    for (size_t p = 0; p < pixels(s->frame); p++) {
        const double c = coverage_of(s->frame, type, name, p);
        sum += c;
        square += c * c;
    }
    *error = sqrt(fmax(square / n - sum / n * (sum / n), 0.0) / (n - 1.0));
    return sum / n;
}

double plain_variance(double pdf)
{
    const double e = fmin(1.0 / (2.0 * M_PI * pdf), 1.0);
    return e * (2.0 - e) / (2.0 * (1.0 - e) * (1.0 - e));
}

double plain_weight(double variance, double spread, double alpha, bool cut)
{
    const double square = spread * spread;
    const double w = isinf(variance) ? 0.0 : pow(1.0 + square * variance, -0.5 * alpha);
    const double flat = pow(1.0 + square * 1.5, -0.5 * alpha);
    return cut ? fmax(0.0, (w - flat) / (1.0 - flat)) : w;
}

enum { RINGS = 2000, TURNS = 720 };

// Sum over the directions of one ring of the hemisphere; density: of the pdf, else of W f.
static double ring(const struct ceiling *c, const struct gk_surface *s, struct gk_vec wo, double z,
                   double side, bool density)
{
    const double way = c->height / z, spread = way / fabs(c->radius + c->slope * way);
    double sum = 0.0;
    for (int j = 0; j < TURNS; j++) {
        const struct gk_bsdf_value f = gk_bsdf_eval(s, wo, direction(z, (j + 0.5) / TURNS));
        if (f.pdf > 0.0f)
            sum += density ? f.pdf
                           : gk_mean3(f.f) * plain_weight(plain_variance(f.pdf / side), spread,
                                                          c->alpha, c->cut);
    }
    return sum * 2.0 * M_PI / ((double)RINGS * TURNS);
}

double ceiling_share(const struct ceiling *c)
{
    const struct gk_vec wo =
        gk_vec((float)sqrt(1.0 - c->cosine * c->cosine), 0.0f, (float)c->cosine);
    const struct gk_surface s = make_surface_at(&c->material, wo);
    double side = 0.0, sum = 0.0;
    for (int i = 0; i < RINGS; i++)
        side += c->shared ? ring(c, &s, wo, (i + 0.5) / RINGS, 1.0, true) : 1.0 / RINGS;
    for (int i = 0; i < RINGS; i++)
        sum += ring(c, &s, wo, (i + 0.5) / RINGS, side, false);
    return sum;
}
