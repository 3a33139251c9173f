#include "base/thread.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmocka.h>

#define ITEMS 1000

static void count_call(void *user, size_t i)
{
    atomic_uint *calls = user;
    atomic_fetch_add(&calls[i], 1);
}

static void every_item_is_called_once_and_all_have_returned(void **state)
{
    (void)state;
    static atomic_uint calls[ITEMS];
    for (unsigned round = 1; round <= 3; round++) {
        glint_thread_each("items", ITEMS, count_call, calls);
        for (size_t i = 0; i < ITEMS; i++)
            assert_int_equal(atomic_load(&calls[i]), round);
    }
    glint_thread_each("items", 0, count_call, NULL);
}

// As sched_getattr() fills it in: words of 32 bits, the length of a turn in the seventh and eighth.
enum { TURN_LOW = 6, TURN_HIGH = 7, WORDS = 12 };

static uint64_t turn_ns(void)
{
    uint32_t word[WORDS] = {sizeof word};
    assert_int_equal(syscall(SYS_sched_getattr, 0, word, sizeof word, 0), 0);
    return (uint64_t)word[TURN_HIGH] << 32 | word[TURN_LOW];
}

static void *ask(void *arg)
{
    int *nice = arg;
    glint_thread_yield_to_others(2);
    glint_thread_turns(0.003);
    *nice = getpriority(PRIO_PROCESS, (id_t)gettid());
    return (void *)(uintptr_t)turn_ns();
}

static void a_thread_has_its_own_nice_and_the_turns_it_asks_for(void **state)
{
    (void)state;
    pthread_t thread;
    void *turn;
    int nice = 0;
    const int mine = getpriority(PRIO_PROCESS, 0);
    const uint64_t usual = turn_ns();
    assert_int_equal(glint_thread_start(&thread, "asks", ask, &nice, NULL), GLINT_OK);
    pthread_join(thread, &turn);
    assert_int_equal(nice, mine + 2 > 19 ? 19 : mine + 2);
    assert_int_equal(getpriority(PRIO_PROCESS, 0), mine);
    assert_int_equal(turn_ns(), usual);
    if (!usual) // a system before 6.12
        skip();
    assert_int_equal((uintptr_t)turn, 3000000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_is_called_once_and_all_have_returned),
        cmocka_unit_test(a_thread_has_its_own_nice_and_the_turns_it_asks_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
