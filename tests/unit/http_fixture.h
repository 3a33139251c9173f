// http_fixture.h - an HTTP server over a house of fakes, and a client made of sockets.
#ifndef GLINT_TESTS_HTTP_FIXTURE_H
#define GLINT_TESTS_HTTP_FIXTURE_H

#include "fake_house.h"
#include "http/http.h"

#define HTTP_TILES 6
#define HTTP_PATIENCE 20.0 // seconds until a condition that must come counts as missing
#define HTTP_END "Host: localhost\r\nConnection: close\r\n\r\n"

extern struct fake_house http_house;
extern glint_http *http_server;

// Set-up and teardown of a test. strict: a header must be complete within 0.3 s, which a busy
// machine may not manage; impatient: who is idle for 1 s is ended, and pinged before.
int http_start(void **state);
int http_start_strict(void **state);
int http_start_impatient(void **state);
int http_stop(void **state);
// Serves again, after the server was destroyed.
void http_serve_again(void);

int http_dial(void);
void http_say(int fd, const char *text);
// Everything until `last` came or the server closes; malloc'd and terminated.
char *http_hear_until(int fd, const char *last);
char *http_hear(int fd); // closes it too
char *http_ask(const char *request);
char *http_get(const char *target);
char *http_post_job(const char *json);
int http_status(const char *answer);

// Submits a job, whose pixels exist or do not yet.
void http_submit_prepared(char id[GLINT_JOB_ID_BYTES]);
void http_submit(char id[GLINT_JOB_ID_BYTES]);

// The value of a metric by the start of its line, -1: there is none.
double http_metric(const char *name);
void http_await_metric(const char *name, double value);

#endif
