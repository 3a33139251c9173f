#include "jobs/turn.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static glint_render *const some_film = (glint_render *)&some_film; // only compared with NULL

static struct glint_entry make(int priority)
{
    return (struct glint_entry){.client = "",
                                .state = GLINT_JOB_RENDERING,
                                .render = some_film,
                                .priority = priority,
                                .slice_seconds = 0.02};
}

static struct glint_account *accounts;

static void enter(struct glint_entry *const *entry, size_t count)
{
    for (size_t i = 0; i < count; i++)
        assert_true(glint_turn_enter(&accounts, entry[i], entry[i]->priority));
}

static void leave(struct glint_entry *const *entry, size_t count)
{
    for (size_t i = 0; i < count; i++)
        glint_turn_leave(&accounts, entry[i]);
    assert_null(accounts);
}

// Runs `turns` slices that cost each job what `cost` says.
static void run(struct glint_entry *const *entry, size_t count, const double *cost, int turns,
                double *served)
{
    for (int t = 0; t < turns; t++) {
        struct glint_entry *next = glint_turn_next(entry, count);
        for (size_t i = 0; i < count; i++)
            if (entry[i] == next) {
                glint_turn_charge(next, cost[i]);
                served[i] += cost[i];
            }
    }
}

static void equals_share_by_worker_seconds_whatever_a_slice_costs(void **state)
{
    (void)state;
    struct glint_entry a = make(0), b = make(0), c = make(0);
    struct glint_entry *const entry[] = {&a, &b, &c};
    const double cost[] = {0.001, 0.020, 0.007};
    double served[3] = {0, 0, 0};
    enter(entry, 3);
    run(entry, 3, cost, 10000, served);
    for (int i = 1; i < 3; i++) // apart by no more than the longest slice
        assert_true(fabs(served[i] - served[0]) <= 0.0201);
    leave(entry, 3);
}

static void clients_share_alike_however_many_jobs_each_has(void **state)
{
    (void)state;
    enum { MANY = 20 };
    struct glint_entry e[MANY + 1];
    struct glint_entry *entry[MANY + 1];
    double cost[MANY + 1], served[MANY + 1] = {0};
    for (size_t i = 0; i <= MANY; i++) {
        e[i] = make(0);
        e[i].client = i < MANY ? "many" : "one";
        entry[i] = &e[i];
        cost[i] = 0.005 + 0.001 * (double)i; // 5 to 25 ms
    }
    enter(entry, MANY + 1);
    run(entry, MANY + 1, cost, 20000, served);
    double many = 0;
    for (size_t i = 0; i < MANY; i++) {
        many += served[i];
        assert_true(fabs(served[i] - served[0]) <= 0.026); // and the jobs of the client
    }
    assert_true(many > 100);
    assert_true(fabs(many - served[MANY]) <= 2 * 0.026);
    leave(entry, MANY + 1);
}

static void slices_that_are_out_count_for_the_client(void **state)
{
    (void)state;
    struct glint_entry a = make(0), b = make(0), c = make(0);
    struct glint_entry *const entry[] = {&a, &b, &c};
    c.client = "other";
    enter(entry, 3);
    a.out = 1;
    assert_ptr_equal(glint_turn_next(entry, 3), &c);
    c.out = 2;
    assert_ptr_equal(glint_turn_next(entry, 3), &b);
    leave(entry, 3);
}

static void a_higher_priority_goes_first_whatever_it_has_had(void **state)
{
    (void)state;
    struct glint_entry a = make(0), b = make(1);
    struct glint_entry *const entry[] = {&a, &b};
    enter(entry, 2);
    b.turn = b.account->turn = 100;
    assert_ptr_equal(glint_turn_next(entry, 2), &b);
    b.dry = true;
    assert_ptr_equal(glint_turn_next(entry, 2), &a);
    leave(entry, 2);
}

static void slices_that_are_out_count_as_served(void **state)
{
    (void)state;
    struct glint_entry a = make(0), b = make(0);
    struct glint_entry *const entry[] = {&a, &b};
    enter(entry, 2);
    assert_ptr_equal(glint_turn_next(entry, 2), &a);
    a.out = 1;
    assert_ptr_equal(glint_turn_next(entry, 2), &b);
    leave(entry, 2);
}

static void a_newcomer_has_neither_debt_nor_credit(void **state)
{
    (void)state;
    static const char *const client[] = {"", "late"}; // one of the same client, then another client
    for (int c = 0; c < 2; c++) {
        struct glint_entry a = make(0), b = make(0), late = make(0);
        struct glint_entry *const entry[] = {&a, &b, &late};
        const double cost[] = {0.01, 0.01, 0.01};
        double served[3] = {0, 0, 0};
        b.client = late.client = (char *)client[c];
        late.state = GLINT_JOB_PAUSED;
        b.state = c ? GLINT_JOB_PAUSED : GLINT_JOB_RENDERING;
        enter(entry, 3);
        run(entry, 3, cost, 1000, served);
        late.state = GLINT_JOB_RENDERING;
        glint_turn_join(entry, 3, &late);
        memset(served, 0, sizeof served);
        run(entry, 3, cost, 300, served);
        assert_true(fabs(served[2] - (c ? 1.5 : 1.0)) <= 0.011);
        assert_true(fabs(served[0] - (c ? 1.5 : 1.0)) <= 0.011);
        leave(entry, 3);
    }
}

static void who_comes_back_often_gains_nothing_by_it(void **state)
{
    (void)state;
    struct glint_entry a = make(0), b = make(0);
    struct glint_entry *const entry[] = {&a, &b};
    const double cost[] = {0.02, 0.02};
    double served[2] = {0, 0};
    b.client = "restless";
    enter(entry, 2);
    for (int i = 0; i < 1000; i++) {
        run(entry, 2, cost, 3, served);
        b.state = GLINT_JOB_PAUSED;
        b.state = GLINT_JOB_RENDERING;
        glint_turn_join(entry, 2, &b);
    }
    assert_true(fabs(served[1] - served[0]) <= 0.041);
    leave(entry, 2);
}

static void turns_taken_alone_are_no_debt(void **state)
{
    (void)state;
    struct glint_entry a = make(0), b = make(0);
    struct glint_entry *const entry[] = {&a, &b};
    const double cost[] = {0.02, 0.02};
    double served[2] = {0, 0};
    b.client = "other";
    b.state = GLINT_JOB_PAUSED;
    enter(entry, 2);
    run(entry, 2, cost, 10000, served); // a alone, 200 s
    a.state = GLINT_JOB_PAUSED;
    b.state = GLINT_JOB_RENDERING;
    glint_turn_join(entry, 2, &b); // nobody is there to be compared with
    run(entry, 2, cost, 10, served);
    a.state = GLINT_JOB_RENDERING;
    glint_turn_join(entry, 2, &a);
    memset(served, 0, sizeof served);
    run(entry, 2, cost, 100, served);
    assert_true(fabs(served[1] - served[0]) <= 0.061); // two slices and the turn under way
    leave(entry, 2);
}

static void a_client_has_an_account_for_each_priority(void **state)
{
    (void)state;
    struct glint_entry a = make(0), b = make(0), c = make(0);
    struct glint_entry *const entry[] = {&a, &b, &c};
    enter(entry, 3);
    assert_ptr_equal(a.account, b.account);
    assert_int_equal(a.account->entries, 3);
    assert_true(glint_turn_enter(&accounts, &b, 5));
    assert_ptr_not_equal(a.account, b.account);
    assert_int_equal(b.account->priority, 5);
    assert_true(glint_turn_enter(&accounts, &b, 5)); // where it is
    assert_int_equal(b.account->entries, 1);
    assert_true(glint_turn_enter(&accounts, &b, 0));
    assert_ptr_equal(a.account, b.account);
    assert_null(a.account->next);
    leave(entry, 3);
}

static void who_is_paused_ending_or_unprepared_gets_no_turn(void **state)
{
    (void)state;
    struct glint_entry a = make(0);
    struct glint_entry *const entry[] = {&a};
    enter(entry, 1);
    assert_ptr_equal(glint_turn_next(entry, 1), &a);
    a.state = GLINT_JOB_PAUSED;
    assert_null(glint_turn_next(entry, 1));
    a.state = GLINT_JOB_RENDERING;
    a.end = GLINT_JOB_CANCELLED;
    assert_null(glint_turn_next(entry, 1));
    a.end = GLINT_JOB_QUEUED;
    a.render = NULL;
    assert_null(glint_turn_next(entry, 1));
    leave(entry, 1);
}

static void who_is_paused_ending_or_being_prepared_gets_no_film(void **state)
{
    (void)state;
    struct glint_entry a = make(0);
    struct glint_entry *const entry[] = {&a};
    a.render = NULL;
    enter(entry, 1);
    assert_ptr_equal(glint_turn_prepare(entry, 1, GLINT_MAX_FILMS), &a);
    a.state = GLINT_JOB_PAUSED;
    assert_null(glint_turn_prepare(entry, 1, GLINT_MAX_FILMS));
    a.state = GLINT_JOB_QUEUED;
    a.end = GLINT_JOB_CANCELLED;
    assert_null(glint_turn_prepare(entry, 1, GLINT_MAX_FILMS));
    a.end = GLINT_JOB_QUEUED;
    a.preparing = true;
    assert_null(glint_turn_prepare(entry, 1, GLINT_MAX_FILMS));
    leave(entry, 1);
}

static void films_are_made_for_the_important_first_and_for_few_at_once(void **state)
{
    (void)state;
    enum { COUNT = GLINT_MAX_FILMS + 2 };
    struct glint_entry e[COUNT];
    struct glint_entry *entry[COUNT];
    for (size_t i = 0; i < COUNT; i++) {
        e[i] = make(0);
        entry[i] = &e[i];
    }
    struct glint_entry *low = &e[COUNT - 2], *high = &e[COUNT - 1];
    low->render = high->render = NULL;
    low->state = high->state = GLINT_JOB_QUEUED;
    high->priority = 5;
    enter(entry, COUNT);
    assert_ptr_equal(glint_turn_prepare(entry, COUNT, GLINT_MAX_FILMS), high);
    high->render = some_film;
    assert_null(glint_turn_prepare(entry, COUNT, GLINT_MAX_FILMS)); // one more matters as much
    e[0].state = e[1].state = GLINT_JOB_PAUSED;
    assert_ptr_equal(glint_turn_prepare(entry, COUNT, GLINT_MAX_FILMS), low);
    low->blocked = true;
    assert_null(glint_turn_prepare(entry, COUNT, GLINT_MAX_FILMS));
    leave(entry, COUNT);
}

static void a_client_without_a_film_gets_the_next_one(void **state)
{
    (void)state;
    enum { COUNT = GLINT_MAX_FILMS + 2 };
    struct glint_entry e[COUNT];
    struct glint_entry *entry[COUNT];
    for (size_t i = 0; i < COUNT; i++) {
        e[i] = make(0);
        e[i].client = i == COUNT - 1 ? "other" : "many";
        e[i].render = i < GLINT_MAX_FILMS - 1 ? some_film : NULL;
        entry[i] = &e[i];
    }
    struct glint_entry *other = &e[COUNT - 1];
    enter(entry, COUNT);
    assert_ptr_equal(glint_turn_prepare(entry, COUNT, GLINT_MAX_FILMS), other);
    e[GLINT_MAX_FILMS - 1].render = some_film; // all that there may be
    assert_ptr_equal(glint_turn_prepare(entry, COUNT, GLINT_MAX_FILMS), other);
    other->render = some_film;
    assert_null(glint_turn_prepare(entry, COUNT, GLINT_MAX_FILMS));
    leave(entry, COUNT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equals_share_by_worker_seconds_whatever_a_slice_costs),
        cmocka_unit_test(clients_share_alike_however_many_jobs_each_has),
        cmocka_unit_test(slices_that_are_out_count_for_the_client),
        cmocka_unit_test(a_higher_priority_goes_first_whatever_it_has_had),
        cmocka_unit_test(slices_that_are_out_count_as_served),
        cmocka_unit_test(a_newcomer_has_neither_debt_nor_credit),
        cmocka_unit_test(who_comes_back_often_gains_nothing_by_it),
        cmocka_unit_test(turns_taken_alone_are_no_debt),
        cmocka_unit_test(a_client_has_an_account_for_each_priority),
        cmocka_unit_test(who_is_paused_ending_or_unprepared_gets_no_turn),
        cmocka_unit_test(who_is_paused_ending_or_being_prepared_gets_no_film),
        cmocka_unit_test(films_are_made_for_the_important_first_and_for_few_at_once),
        cmocka_unit_test(a_client_without_a_film_gets_the_next_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
