// outlook.h - what a job knows of its own error, in sentences: its member `estimate`.
//
// Thread-safety: reentrant but for what it prints.
#ifndef GLINT_CLI_OUTLOOK_H
#define GLINT_CLI_OUTLOOK_H

#include <cjson/cJSON.h>

#include <stddef.h>

// Lines on stdout: the error's interval, what it does not see, and what is to come.
void glint_outlook_print(const cJSON *estimate);

// The forecast in a few words, for a line of progress: "0.01 at 1200 samples"; "" where there is
// none.
void glint_outlook_short(const cJSON *estimate, char *text, size_t size);

#endif
