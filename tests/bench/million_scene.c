// million_scene - prints the scene that embree-share renders, for benches over HTTP.
#include "tests/bench/bench.h"

#include <stdio.h>

int main(void)
{
    return puts(bench_million_scene()) < 0;
}
