#include "base/clock.h"
#include "base/queue.h"
#include "base/thread.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static glint_queue *make(size_t capacity)
{
    glint_queue *queue;
    assert_int_equal(glint_queue_create(&queue, capacity, sizeof(int), NULL), GLINT_OK);
    return queue;
}

static void messages_leave_in_the_order_they_came(void **state)
{
    (void)state;
    glint_queue *queue = make(3);
    int got, next = 0;
    for (int i = 0; i < 10; i++) { // round the ring more than three times
        assert_true(glint_queue_offer(queue, &i));
        if (i % 2) {
            assert_true(glint_queue_poll(queue, &got));
            assert_int_equal(got, next++);
            assert_true(glint_queue_pop(queue, &got));
            assert_int_equal(got, next++);
        }
    }
    assert_false(glint_queue_poll(queue, &got));
    glint_queue_destroy(&queue);
    assert_null(queue);
}

static void an_offer_to_a_full_queue_is_refused_and_changes_nothing(void **state)
{
    (void)state;
    glint_queue *queue = make(2);
    const int a = 1, b = 2, c = 3;
    int got;
    assert_true(glint_queue_offer(queue, &a));
    assert_true(glint_queue_offer(queue, &b));
    assert_false(glint_queue_offer(queue, &c));
    assert_true(glint_queue_pop(queue, &got));
    assert_int_equal(got, a);
    assert_true(glint_queue_offer(queue, &c));
    assert_true(glint_queue_pop(queue, &got));
    assert_int_equal(got, b);
    assert_true(glint_queue_pop(queue, &got));
    assert_int_equal(got, c);
    glint_queue_destroy(&queue);
}

static void a_closed_queue_gives_what_it_holds_and_takes_no_more(void **state)
{
    (void)state;
    glint_queue *queue = make(2);
    const int a = 7;
    int got = 0;
    assert_true(glint_queue_push(queue, &a));
    glint_queue_close(queue);
    assert_false(glint_queue_offer(queue, &a));
    assert_false(glint_queue_push(queue, &a));
    assert_true(glint_queue_pop(queue, &got));
    assert_int_equal(got, 7);
    assert_false(glint_queue_pop(queue, &got));
    glint_queue_destroy(&queue);
}

static void a_deadline_ends_the_wait_for_a_message(void **state)
{
    (void)state;
    glint_queue *queue = make(1);
    int got;
    const double start = glint_now();
    assert_false(glint_queue_pop_until(queue, &got, start - 1));
    assert_false(glint_queue_pop_until(queue, &got, start + 0.02));
    assert_true(glint_now() >= start + 0.02);
    glint_queue_destroy(&queue);
}

enum { PRODUCERS = 3, EACH = 2000 };

static void *produce(void *arg)
{
    for (int i = 1; i <= EACH; i++)
        glint_queue_push(arg, &i);
    return NULL;
}

static void *consume(void *arg)
{
    intptr_t sum = 0;
    for (int got; glint_queue_pop(arg, &got);)
        sum += got;
    return (void *)sum;
}

static void every_message_is_delivered_once_among_many_threads(void **state)
{
    (void)state;
    glint_queue *queue = make(4); // much smaller than the traffic: both ends wait
    pthread_t producer[PRODUCERS], consumer[2];
    for (int i = 0; i < 2; i++)
        assert_int_equal(glint_thread_start(&consumer[i], "consumer", consume, queue, NULL), 0);
    for (int i = 0; i < PRODUCERS; i++)
        assert_int_equal(glint_thread_start(&producer[i], "producer", produce, queue, NULL), 0);
    for (int i = 0; i < PRODUCERS; i++)
        pthread_join(producer[i], NULL);
    glint_queue_close(queue);
    void *sum[2];
    for (int i = 0; i < 2; i++)
        pthread_join(consumer[i], &sum[i]);
    assert_int_equal((intptr_t)sum[0] + (intptr_t)sum[1],
                     (intptr_t)PRODUCERS * EACH * (EACH + 1) / 2);
    glint_queue_destroy(&queue);
}

static void *own_name(void *arg)
{
    static char name[16];
    int go;
    glint_queue_pop(arg, &go); // the name is set once glint_thread_start has returned
    pthread_getname_np(pthread_self(), name, sizeof name);
    return name;
}

static void a_thread_bears_its_name_cut_to_fifteen_bytes(void **state)
{
    (void)state;
    glint_queue *queue = make(1);
    pthread_t thread;
    assert_int_equal(glint_thread_start(&thread, "a name much too long", own_name, queue, NULL), 0);
    const int go = 1;
    glint_queue_push(queue, &go);
    void *name;
    pthread_join(thread, &name);
    assert_string_equal(name, "a name much too");
    glint_queue_destroy(&queue);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(messages_leave_in_the_order_they_came),
        cmocka_unit_test(an_offer_to_a_full_queue_is_refused_and_changes_nothing),
        cmocka_unit_test(a_closed_queue_gives_what_it_holds_and_takes_no_more),
        cmocka_unit_test(a_deadline_ends_the_wait_for_a_message),
        cmocka_unit_test(every_message_is_delivered_once_among_many_threads),
        cmocka_unit_test(a_thread_bears_its_name_cut_to_fifteen_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
