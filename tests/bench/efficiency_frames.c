// efficiency_frames - frames of one scene by several seeds, for tests/bench/efficiency.
//
// usage: efficiency_frames SCENE MEMBERS WIDTH HEIGHT SAMPLES FIRST_SEED SEEDS OUT
// MEMBERS: of the job, beginning with a comma, or empty. OUT: [SEEDS][HEIGHT][WIDTH][R G B] floats.
// The only line printed is a JSON list: CPU seconds of each frame, by one worker.
#include "tests/render/offline.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double process_cpu(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static glint_render *make(const struct offline *o, const struct glint_posed *posed,
                          struct glint_job *job)
{
    struct glint_error err = {0};
    glint_render *render = NULL;
    if (glint_render_create(&render, o->devices, posed->resident, posed->pose, job, &err))
        offline_die("render", &err);
    return render;
}

static void write_pixels(FILE *out, glint_render *render, const struct glint_job *job)
{
    struct glint_error err = {0};
    struct glint_frame *frame = NULL;
    if (glint_render_frame(render, job->outputs, &frame, NULL, &err))
        offline_die("frame", &err);
    const float *channel[3] = {glint_frame_find(frame, "R"), glint_frame_find(frame, "G"),
                               glint_frame_find(frame, "B")};
    const size_t pixels = (size_t)job->width * job->height;
    for (size_t i = 0; i < 3 * pixels; i++)
        if (fwrite(&channel[i % 3][i / 3], sizeof(float), 1, out) != 1) {
            perror("efficiency_frames");
            exit(1);
        }
    glint_frame_destroy(&frame);
}

// Returns its CPU seconds.
static double render_frame(const struct offline *o, const struct glint_posed *posed, char **word,
                           int seed, FILE *out)
{
    char text[1024];
    snprintf(text, sizeof text,
             "{\"scene\":\"s\",\"outputs\":[\"beauty\"],\"resolution\":[%s,%s],"
             "\"stop\":{\"samples\":%s},\"seed\":%d%s}",
             word[3], word[4], word[5], seed, word[2]);
    struct glint_job *job = offline_job(text);
    glint_render *render = make(o, posed, job);
    const double start = process_cpu();
    offline_render(o, render);
    const double seconds = process_cpu() - start;
    write_pixels(out, render, job);
    glint_render_destroy(&render);
    glint_job_destroy(&job);
    return seconds;
}

int main(int argc, char **argv)
{
    if (argc != 9)
        return fprintf(stderr, "usage: efficiency_frames SCENE MEMBERS WIDTH HEIGHT SAMPLES "
                               "FIRST_SEED SEEDS OUT\n"),
               64;
    struct offline o;
    offline_start(&o, 1);
    struct glint_posed posed = offline_load_posed(&o, argv[1]);
    FILE *out = fopen(argv[8], "wb");
    if (!out)
        return perror(argv[8]), 1;
    const int first = atoi(argv[6]), seeds = atoi(argv[7]);
    for (int i = 0; i < seeds; i++)
        printf("%s%.6f", i ? "," : "[", render_frame(&o, &posed, argv, first + i, out));
    puts("]");
    glint_resident_release(&posed.resident);
    offline_finish(&o);
    return fclose(out) != 0;
}
