/* A client of the link for link_age.py, in C: what it reads is as old as the link makes it, without
 * an interpreter that has to wake up. It prints what it saw as JSON, as link_client.py does.
 *
 *   cc -std=c99 -O2 -Wall -Wextra -o link_client link_client.c
 *   ./link_client HOST PORT SECONDS 0
 *
 * It reads all that comes, at no other pace than 0, and acknowledges as docs/protocol.md asks;
 * little-endian machines alone.
 */
#define _POSIX_C_SOURCE 200112L

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { HEADER = 24, CONTROL = 0, DATA = 1, ACKNOWLEDGE = 2, TIME_TOPIC = 1, TOPICS = 256 };
enum { LARGEST = 1 << 20, MOST = 1 << 17 };

static int stream;
static char buffer[LARGEST];
static size_t filled;
static double ages[MOST];
static long aged, frames, gaps;
static int64_t newest[TOPICS], period[TOPICS];
static const double WARM_UP = 2.0; /* gaps count from then on, as other clients start until then */

static void fail(const char *said) {
    fprintf(stderr, "%s\n", said);
    exit(1);
}

static int64_t now_ns(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return 1000000000LL * now.tv_sec + now.tv_nsec;
}

static void send_frame(uint8_t kind, uint32_t seq, const char *payload) {
    char bytes[HEADER + 512] = {'D', 'H', 1};
    uint32_t length = (uint32_t)strlen(payload);
    bytes[3] = (char)kind;
    memcpy(bytes + 8, &seq, 4);
    memcpy(bytes + 12, &length, 4);
    memcpy(bytes + HEADER, payload, length);
    if (send(stream, bytes, HEADER + length, MSG_NOSIGNAL) != (ssize_t)(HEADER + length))
        fail("the server has gone");
}

/* A gap is a step in time over half a period too long; the shortest step so far is the period. */
static void take(uint16_t topic, int64_t t_ns, const char *payload, int warm) {
    frames++;
    if (topic == TIME_TOPIC && aged < MOST) {
        int64_t sampled; /* behind int32 and uint32 */
        memcpy(&sampled, payload + 8, 8);
        ages[aged++] = 1e-9 * (double)(now_ns(CLOCK_REALTIME) - sampled);
    }
    if (!warm || topic >= TOPICS) return;
    if (newest[topic]) {
        int64_t step = t_ns - newest[topic];
        if (!period[topic] || step < period[topic]) period[topic] = step;
        gaps += (step + period[topic] / 2) / period[topic] - 1;
    }
    newest[topic] = t_ns;
}

/* Take the whole frames that have come, and acknowledge where a batch ends. */
static void take_all(int warm) {
    size_t begin = 0;
    while (filled - begin >= HEADER) {
        uint16_t topic, flags;
        uint32_t seq, length;
        int64_t t_ns;
        const char *head = buffer + begin;
        memcpy(&topic, head + 4, 2);
        memcpy(&flags, head + 6, 2);
        memcpy(&seq, head + 8, 4);
        memcpy(&length, head + 12, 4);
        memcpy(&t_ns, head + 16, 8);
        if (filled - begin < HEADER + length) break;
        if (head[3] == DATA) take(topic, t_ns, head + HEADER, warm);
        if (flags & ACKNOWLEDGE) send_frame(2, seq, "");
        begin += HEADER + length;
    }
    filled -= begin;
    memmove(buffer, buffer + begin, filled);
}

static void connect_to(const char *host, const char *port) {
    struct addrinfo hints = {0}, *found;
    int on = 1;
    hints.ai_socktype = SOCK_STREAM;
    if (getaddrinfo(host, port, &hints, &found)) fail("there is no such host");
    stream = socket(found->ai_family, found->ai_socktype, found->ai_protocol);
    if (stream < 0 || connect(stream, found->ai_addr, found->ai_addrlen)) fail("nobody listens there");
    setsockopt(stream, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    freeaddrinfo(found);
}

int main(int count, char **words) {
    if (count != 5 || atof(words[4]) != 0.0) fail("usage: link_client HOST PORT SECONDS 0");
    connect_to(words[1], words[2]);
    send_frame(CONTROL, 1,
               "{\"op\":\"subscribe\",\"topics\":[\"/dh_drone/time_data\",\"/dh_drone/position_data\","
               "\"/dh_drone/velocity_data\",\"/dh_drone/acceleration_data\","
               "\"/dh_drone/force_torque_data\",\"/dh_drone/rotors\","
               "\"/dh_drone/command_velocity\",\"/dh_drone/imu\"]}");
    double begun = 1e-9 * (double)now_ns(CLOCK_MONOTONIC), lasted = 0.0, seconds = atof(words[3]);
    while (lasted < seconds) {
        ssize_t got = recv(stream, buffer + filled, LARGEST - filled, 0);
        if (got <= 0) break;
        filled += (size_t)got;
        take_all(lasted > WARM_UP);
        lasted = 1e-9 * (double)now_ns(CLOCK_MONOTONIC) - begun;
    }
    printf("{\"gaps\": %ld, \"frames\": %ld, \"ended\": \"%s\", \"lasted\": %.6f, \"ages\": [", gaps,
           frames, lasted < seconds ? "closed" : "", lasted);
    for (long i = 0; i < aged; i++) printf(i ? ", %.7f" : "%.7f", ages[i]);
    printf("]}\n");
    close(stream);
    return 0;
}
