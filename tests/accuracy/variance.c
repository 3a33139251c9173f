// variance - what Eq. 3 of Yoshimura et al. 2022 costs in the place of Eq. 2, the exact one.
//
//   variance WIDTHxHEIGHT SAMPLES SCENE.json ..
//
// First the weights alone: random paths of 2 to 8 segments of 0.3 to 10 m with lobes of GGX-like
// variances 1e-4 to 1, at alpha 0.1; then mattes of whole scenes, the same deposits but for that.
#include "tests/accuracy/replay.h"

#include "kernels/gk_coverage.h"
#include "tests/kernel/check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATHS = 200000 };

static double log_between(uint64_t *seed, double low, double high)
{
    return low * pow(high / low, check_uniform(seed));
}

// The product of the weights of a path of so many segments, by both forms.
static void weigh(uint64_t *seed, int segments, double product[2])
{
    const float slope = 0.0005f;
    struct gk_spread spread[2] = {gk_spread_none(), gk_spread_none()};
    struct gk_cone cone = {0.0f, slope, 0.0f};
    product[0] = product[1] = 1.0;
    for (int m = 0; m < segments; m++) {
        const float t = (float)log_between(seed, 0.3, 10.0);
        const float v2 = (float)log_between(seed, 1e-4, 1.0);
        gk_cone_advance(&cone, t);
        for (int eq3 = 0; eq3 < 2; eq3++) {
            const struct gk_weight_rule rule = {0.1f, 0.0f, slope, 1, 1, eq3, 0};
            spread[eq3] = gk_spread_advance(spread[eq3], t, eq3);
            if (m > 0)
                product[eq3] *= gk_path_weight(&spread[eq3], &cone, &rule, 0);
            spread[eq3] = gk_spread_scatter(spread[eq3], v2);
        }
    }
}

static void print_weights(void)
{
    uint64_t seed = 1;
    for (int segments = 3; segments <= 9; segments++) {
        double sum = 0.0, worst = 0.0, mean = 0.0;
        for (int i = 0; i < PATHS; i++) {
            double w[2];
            weigh(&seed, segments, w);
            sum += w[1] - w[0];
            mean += w[0];
            worst = fmax(worst, fabs(w[1] - w[0]));
        }
        printf("weights,%d,%.5f,%.5f,%.4f\n", segments - 1, mean / PATHS, sum / PATHS, worst);
    }
}

static uint64_t *take(struct replay *r, const struct offline *o, const struct glint_posed *scene,
                      struct glint_job *job, bool eq3)
{
    job->dial[GLINT_DIAL_VARIANCE] = eq3;
    glint_render *render = replay_render(r, o, scene, job);
    uint64_t *exact = r->exact;
    r->exact = NULL;
    glint_render_destroy(&render);
    return exact;
}

static void print_scene(const struct offline *o, const char *path, struct glint_job *job)
{
    static const struct replay_setting one = {GK_MATTE_DROP, 4, "drop"};
    struct replay r = {.setting = &one, .settings = 1};
    struct glint_posed scene = offline_load_posed(o, path);
    uint64_t *exact = take(&r, o, &scene, job, false), *eq3 = take(&r, o, &scene, job, true);
    double sum = 0.0, worst = 0.0;
    const double unit = 1.0 / ((double)GK_MATTE_ONE * job->stop.samples);
    for (size_t i = 0; i < (size_t)r.pixels * r.keys; i++) {
        const double d = fabs((double)eq3[i] - (double)exact[i]) * unit;
        sum += d;
        worst = fmax(worst, d);
    }
    const char *slash = strrchr(path, '/');
    printf("%s,,,%.3e,%.4f\n", slash ? slash + 1 : path,
           0.5 * sum / ((double)job->width * job->height), worst);
    free(exact);
    free(eq3);
    replay_finish(&r);
    glint_resident_release(&scene.resident);
}

int main(int argc, char **argv)
{
    struct offline o;
    char text[256];
    int size[2];
    if (argc < 4 || sscanf(argv[1], "%dx%d", &size[0], &size[1]) != 2)
        return fprintf(stderr, "usage: variance WxH SAMPLES SCENE.json ..\n"), 64;
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"resolution\":[%d,%d],\"stop\":{\"samples\":%d},"
             "\"outputs\":[\"beauty\",\"crypto_object\"],"
             "\"mattes\":{\"through\":\"glossy\",\"eviction\":\"exact\"}}",
             size[0], size[1], atoi(argv[2]));
    struct glint_job *job = offline_job(text);
    puts("what,bounces,exact,difference,worst");
    print_weights();
    offline_start(&o, 0);
    for (int i = 3; i < argc; i++)
        print_scene(&o, argv[i], job);
    glint_job_destroy(&job);
    offline_finish(&o);
    return 0;
}
