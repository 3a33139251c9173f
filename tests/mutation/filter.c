// filter.c - loaded before a test program, has it run the tests alone whose name fits MUTATION_CLAIM.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>

__attribute__((constructor)) static void choose(void)
{
    cmocka_set_test_filter(getenv("MUTATION_CLAIM"));
}
