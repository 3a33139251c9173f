// stream_load.c - many clients of one job's streams in one process and thread.
//
//   stream_load PORT JOB EVENTS TILES STALLED_EVENTS STALLED_TILES
//
// Connects that many clients and prints "ready" once all have their first bytes; then reads what
// comes until its input ends, and prints one JSON object about that time. A stalled client reads
// nothing after its first bytes. What a tile stream brings is counted and dropped in the kernel, so
// that hundreds of clients fit beside the daemon on a small machine.
//
// An event's latency is the time from its id, which is when its cause became known in the daemon,
// until the call that read it returned, both on CLOCK_REALTIME.
#include <arpa/inet.h>
#include <errno.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define MAX_LATENCIES (1u << 20)
#define LINE 64
#define MOST_EVENTS 256

struct client {
    int fd;
    bool tiles, stalled, begun;
    // Of events: the chunked coding and the line in it.
    bool in_header;              // of the answer
    uint64_t chunk;              // bytes of the chunk that are to come
    char coding[24], text[LINE]; // of the line so far, cut
    unsigned coded, length;
};

static struct {
    double *latency; // seconds
    size_t latencies;
    uint64_t bytes;
    unsigned begun, ended;
    bool measuring;
} seen;

static void fail(const char *what)
{
    perror(what);
    exit(1);
}

static uint64_t now_us(void)
{
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    return (uint64_t)t.tv_sec * 1000000 + (uint64_t)t.tv_nsec / 1000;
}

static void connect_client(struct client *c, int port, const char *job)
{
    struct sockaddr_in a = {.sin_family = AF_INET,
                            .sin_port = htons((uint16_t)port),
                            .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    char request[256];
    const int n =
        snprintf(request, sizeof request, "GET /v1/jobs/%s/%s HTTP/1.1\r\nHost: localhost\r\n\r\n",
                 job, c->tiles ? "tiles" : "events");
    c->fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (c->fd < 0 || connect(c->fd, (struct sockaddr *)&a, sizeof a))
        fail("connect");
    if (write(c->fd, request, (size_t)n) != n)
        fail("write");
    c->in_header = true;
}

static void take_line(struct client *c, uint64_t arrived)
{
    unsigned long long id;
    c->text[c->length < LINE ? c->length : LINE - 1] = 0;
    if (c->in_header)
        c->in_header = c->length > 1; // an empty line is "\r"
    else if (seen.measuring && seen.latencies < MAX_LATENCIES &&
             sscanf(c->text, "id: %llu", &id) == 1)
        seen.latency[seen.latencies++] = ((double)arrived - (double)id) * 1e-6;
    c->length = 0;
}

static void take_byte(struct client *c, char byte, uint64_t arrived)
{
    if (byte == '\n') {
        take_line(c, arrived);
        return;
    }
    if (c->length < LINE)
        c->text[c->length] = byte;
    c->length++;
}

// The line that says how long the next chunk is; an empty one ends the chunk before.
static void take_coding(struct client *c, char byte)
{
    if (byte != '\n') {
        c->coding[c->coded] = byte;
        c->coded += c->coded + 1 < sizeof c->coding;
        return;
    }
    c->coding[c->coded] = 0;
    c->chunk = strtoull(c->coding, NULL, 16);
    c->coded = 0;
}

static void take_events(struct client *c, const char *bytes, size_t size)
{
    const uint64_t arrived = now_us();
    for (size_t i = 0; i < size; i++)
        if (!c->in_header && !c->chunk) {
            take_coding(c, bytes[i]);
        } else {
            c->chunk -= !c->in_header;
            take_byte(c, bytes[i], arrived);
        }
}

static void begin(struct client *c)
{
    seen.begun += !c->begun;
    c->begun = true;
}

static void end(struct client *c)
{
    close(c->fd);
    c->fd = -1;
    seen.ended++;
}

static void read_client(struct client *c, int poll)
{
    static char buffer[1 << 18];
    const ssize_t n =
        recv(c->fd, buffer, sizeof buffer, MSG_DONTWAIT | (c->tiles && c->begun ? MSG_TRUNC : 0));
    if (n < 0 && errno == EAGAIN)
        return;
    if (n <= 0) {
        end(c);
        return;
    }
    if (!c->tiles)
        take_events(c, buffer, (size_t)n);
    seen.bytes += seen.measuring ? (uint64_t)n : 0;
    begin(c);
    if (c->stalled)
        epoll_ctl(poll, EPOLL_CTL_DEL, c->fd, NULL);
}

// Until input comes, or its end.
static void serve(struct client *client, unsigned count, int poll, bool until_ready)
{
    struct epoll_event event[MOST_EVENTS];
    while (!until_ready || seen.begun < count) {
        if (until_ready && seen.ended)
            fail("a client was cut off before its first bytes");
        const int n = epoll_wait(poll, event, MOST_EVENTS, -1);
        for (int i = 0; i < n; i++) {
            if (event[i].data.u32 == count)
                return;
            read_client(&client[event[i].data.u32], poll);
        }
    }
}

static void attend(int poll, int fd, uint32_t number)
{
    struct epoll_event event = {.events = EPOLLIN, .data.u32 = number};
    if (epoll_ctl(poll, EPOLL_CTL_ADD, fd, &event))
        fail("epoll_ctl");
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile_ms(double q)
{
    return seen.latencies ? 1e3 * seen.latency[(size_t)(q * (double)(seen.latencies - 1))] : 0;
}

static void report(double seconds)
{
    qsort(seen.latency, seen.latencies, sizeof *seen.latency, by_value);
    printf(
        "{\"seconds\": %.3f, \"events\": %zu, \"p50_ms\": %.3f, \"p90_ms\": %.3f, "
        "\"p99_ms\": %.3f, \"max_ms\": %.3f, \"bytes\": %llu, \"ended\": %u, \"latencies_ms\": [",
        seconds, seen.latencies, quantile_ms(0.5), quantile_ms(0.9), quantile_ms(0.99),
        quantile_ms(1), (unsigned long long)seen.bytes, seen.ended);
    for (size_t i = 0; i < seen.latencies; i++)
        printf("%s%.3f", i ? "," : "", 1e3 * seen.latency[i]);
    printf("]}\n");
}

int main(int argc, char **argv)
{
    if (argc != 7)
        return 64;
    unsigned kind[4], count = 0;
    for (int k = 0; k < 4; k++)
        count += kind[k] = (unsigned)strtoul(argv[3 + k], NULL, 10);
    struct client *client = calloc(count, sizeof *client);
    seen.latency = calloc(MAX_LATENCIES, sizeof *seen.latency);
    const int poll = epoll_create1(EPOLL_CLOEXEC);
    if (!client || !seen.latency || poll < 0)
        fail("memory");
    for (unsigned i = 0, k = 0, left = kind[0]; i < count; i++, left--) {
        while (!left)
            left = kind[++k];
        client[i].tiles = k % 2;
        client[i].stalled = k >= 2;
        connect_client(&client[i], (int)strtol(argv[1], NULL, 10), argv[2]);
        attend(poll, client[i].fd, i);
    }
    serve(client, count, poll, true);
    printf("ready\n");
    fflush(stdout);
    attend(poll, STDIN_FILENO, count);
    const uint64_t start = now_us();
    seen.measuring = true;
    serve(client, count, poll, false);
    report((double)(now_us() - start) * 1e-6);
    return 0;
}
