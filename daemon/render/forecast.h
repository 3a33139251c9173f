// forecast.h - how many samples a job will need for the error that it is to reach.
//
// Source: ACCURACY 6. Model: E^2(n) = b^2 + V / n^g, where V / n^g is what the job sees of its error,
// and b what was measured of it elsewhere. g is 1 for independent samples and more where scrambled
// nets do better, which they do less and less: its slope over the last two octaves is fitted to the
// logarithms of the checkpoints by least squares, each weighted by its own spread and held close to
// what common scenes have there; from now on it goes, octave by octave, to what they have after many
// samples. Checkpoints share samples: the correlation of two is the ratio of their sample counts,
// which the fit takes out.
//
// The interval is that of a bootstrap over parts of the picture. Departure from ACCURACY: parts are
// not drawn again but moved by their own spread (Wu 1986), for a picture's own unevenness is no
// noise.
#ifndef GLINT_RENDER_FORECAST_H
#define GLINT_RENDER_FORECAST_H

#include "render/estimate.h"

#include <math.h>

#define GLINT_FORECAST_DRAWS 400
#define GLINT_FORECAST_PACES 8 // passes whose pace is remembered

struct glint_forecast_input {
    const struct glint_convergence_point *curve; // checkpoints, the newest last
    uint32_t points;
    const struct glint_film_estimate *now;
    uint32_t samples;   // `now` is of these
    const double *pace; // worker seconds for a sample, of each of the last passes
    uint32_t paces;
    double target; // error wanted, bias included
    double bias;   // b, an error that no sample takes away and that the curve does not show
    double limit;  // samples that the job takes at most
};

// Samples at which the error is reached, and worker seconds from now on: the middle, and the ends
// of the interval that holds in 9 of 10 cases. NAN: not known.
struct glint_forecast {
    double target; // error wanted, bias included, NAN: none
    double samples[3], seconds[3];
    bool reachable;   // with these settings
    bool lower_bound; // rare events, or an error that falls too slowly: it takes at least that
};

#define GLINT_NO_FORECAST                                  \
    (struct glint_forecast)                                \
    {                                                      \
        NAN, {NAN, NAN, NAN}, {NAN, NAN, NAN}, true, false \
    }

// Unknown before there are five checkpoints and 16 samples.
void glint_forecast_make(struct glint_forecast *out, const struct glint_forecast_input *in);

// The same as draws, ascending: samples[GLINT_FORECAST_DRAWS]. False: not known.
bool glint_forecast_draw(double *samples, const struct glint_forecast_input *in);

#endif
