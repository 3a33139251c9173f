// screen.h - a terminal that is drawn over and over, and given back as it was.
//
// Thread-safety: one thread; there is one terminal.
#ifndef GLINT_CLI_SCREEN_H
#define GLINT_CLI_SCREEN_H

#include <stdbool.h>
#include <termios.h>

// Zero-initialise before use: closed.
struct glint_screen {
    bool open;
    bool raw; // the keys come one by one
    struct termios before;
};

// Takes the terminal of stdout: another page without a cursor, lines cut at its edge, and, where
// stdin is the terminal too, keys without Enter.
void glint_screen_open(struct glint_screen *screen);
void glint_screen_close(struct glint_screen *screen);

// What is printed to stdout next replaces the page.
void glint_screen_clear(const struct glint_screen *screen);

int glint_screen_lines(void);

// Waits; true if q was typed meanwhile. A signal or another key ends the wait early.
bool glint_screen_wait(const struct glint_screen *screen, double seconds);

#endif
