#include "screen.h"
#include "interrupt.h"

#include <stdio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define FEWEST_LINES 8

void glint_screen_open(struct glint_screen *screen)
{
    *screen = (struct glint_screen){.open = true};
    screen->raw = tcgetattr(STDIN_FILENO, &screen->before) == 0;
    if (screen->raw) {
        struct termios keys = screen->before;
        keys.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
        tcsetattr(STDIN_FILENO, TCSANOW, &keys);
    }
    fputs("\033[?1049h\033[?25l\033[?7l", stdout);
}

void glint_screen_close(struct glint_screen *screen)
{
    if (!screen->open)
        return;
    fputs("\033[?7h\033[?25h\033[?1049l", stdout);
    fflush(stdout);
    if (screen->raw)
        tcsetattr(STDIN_FILENO, TCSANOW, &screen->before);
    *screen = (struct glint_screen){0};
}

void glint_screen_clear(const struct glint_screen *screen)
{
    if (screen->open)
        fputs("\033[H\033[J", stdout);
}

int glint_screen_lines(void)
{
    struct winsize size;
    const int lines =
        ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row ? size.ws_row : 24;
    return lines < FEWEST_LINES ? FEWEST_LINES : lines;
}

bool glint_screen_wait(const struct glint_screen *screen, double seconds)
{
    char key = 0;
    const int milliseconds = (int)(1e3 * seconds);
    if (!glint_interrupt_wait(screen->raw ? STDIN_FILENO : -1, milliseconds))
        return false;
    // Nobody types any more: the end of the input is an end of the watching.
    return read(STDIN_FILENO, &key, 1) <= 0 || key == 'q' || key == 'Q';
}
