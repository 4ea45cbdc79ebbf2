/* Watches and flies a drone over the link: C99 and POSIX sockets, no libraries, little-endian.
 *
 *   gcc -std=c99 -Wall -Wextra -o client client.c
 *   ./client HOST PORT watch [FRAMES]
 *   ./client HOST PORT fly V_X V_Y V_Z YAW_RATE [SECONDS [TAKE_OFF_HEIGHT]]
 *
 * Speeds are in m/s and rad/s in the world's axes, z up. It knows no SHA-256, so it speaks with
 * servers without a token only. See docs/protocol.md.
 */
#define _POSIX_C_SOURCE 200112L

#include <netdb.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { CONTROL = 0, DATA = 1, ACKNOWLEDGEMENT = 2, ACKNOWLEDGE = 2, HEADER = 24, LARGEST = 65536 };

typedef struct {
    uint8_t kind;
    uint16_t topic, flags;
    uint32_t seq, length;
    int64_t t_ns;
    char payload[LARGEST + 1]; /* ends with a zero, so that JSON is a string */
} Frame;

static int stream;
static uint32_t last_seq;
static Frame frame;
static const double TAKE_OFF_TIME = 4.0; /* simulated seconds until the first command to move */

static void fail(const char *said) {
    fprintf(stderr, "%s\n", said);
    exit(1);
}

static void send_frame(uint8_t kind, uint16_t topic, uint32_t seq, int64_t t_ns, const void *payload,
                       uint32_t length) {
    char bytes[HEADER + 512] = {'D', 'H', 1};
    bytes[3] = (char)kind;
    memcpy(bytes + 4, &topic, 2); /* flags, at 6, are 0 */
    memcpy(bytes + 8, &seq, 4);
    memcpy(bytes + 12, &length, 4);
    memcpy(bytes + 16, &t_ns, 8);
    if (length) memcpy(bytes + HEADER, payload, length);
    for (size_t done = 0, size = HEADER + length; done < size;) {
        ssize_t sent = send(stream, bytes + done, size - done, MSG_NOSIGNAL);
        if (sent <= 0) fail("the server has gone");
        done += (size_t)sent;
    }
}

static void say(const char *json) {
    send_frame(CONTROL, 0, ++last_seq, 0, json, (uint32_t)strlen(json));
}

static void read_all(char *bytes, size_t size) {
    while (size) {
        ssize_t got = recv(stream, bytes, size, 0);
        if (got <= 0) fail("the server has gone");
        bytes += got;
        size -= (size_t)got;
    }
}

/* Read the next frame, and acknowledge it if it is the last of a batch. */
static void receive(void) {
    char head[HEADER];
    read_all(head, HEADER);
    if (memcmp(head, "DH\1", 3)) fail("this is not a link of version 1");
    frame.kind = (uint8_t)head[3];
    memcpy(&frame.topic, head + 4, 2);
    memcpy(&frame.flags, head + 6, 2);
    memcpy(&frame.seq, head + 8, 4);
    memcpy(&frame.length, head + 12, 4);
    memcpy(&frame.t_ns, head + 16, 8);
    if (frame.length > LARGEST) fail("a frame is too long");
    read_all(frame.payload, frame.length);
    frame.payload[frame.length] = 0;
    if (frame.flags & ACKNOWLEDGE) send_frame(ACKNOWLEDGEMENT, 0, frame.seq, 0, NULL, 0);
}

/* The server writes JSON without blanks, and text has no bare quotes, so a search is enough. */
static int has(const char *json, const char *text) { return strstr(json, text) != NULL; }

static double number(const char *json, const char *key) {
    const char *found = strstr(json, key);
    return found ? strtod(found + strlen(key), NULL) : 0.0;
}

/* A topic's number comes before its name: {"id":3,"name":"/dh_drone/velocity_data",... */
static uint16_t topic_number(const char *hello, const char *name) {
    char wanted[96];
    snprintf(wanted, sizeof wanted, ",\"name\":\"%s\"", name);
    const char *found = strstr(hello, wanted);
    if (!found) fail("hello does not name a topic that is needed");
    while (found > hello && *found != ':') found--;
    return (uint16_t)atoi(found + 1);
}

static void hear(void) {
    printf("%s\n", frame.payload);
    fflush(stdout);
    int refused = has(frame.payload, "\"op\":\"nack\"") &&
                  (has(frame.payload, "\"id\":") || has(frame.payload, "\"not_holder\""));
    if (refused || has(frame.payload, "\"op\":\"error\"")) exit(1);
}

/* Say bye, and read to the end: closing the socket earlier could lose what we sent. */
static void leave(void) {
    say("{\"op\":\"bye\"}");
    shutdown(stream, SHUT_WR);
    while (recv(stream, frame.payload, LARGEST, 0) > 0) continue;
    close(stream);
}

static void watch(uint16_t velocity, long frames) {
    while (frames) {
        receive();
        if (frame.kind == DATA && frame.topic == velocity) {
            float v[6]; /* v_x, v_y, v_z and the angular velocity */
            memcpy(v, frame.payload, sizeof v);
            printf("%9.3f s  %7.3f %7.3f %7.3f m/s\n", 1e-9 * (double)frame.t_ns, v[0], v[1], v[2]);
            fflush(stdout);
            frames--;
        } else if (frame.kind == CONTROL) {
            hear();
        }
    }
}

/* Take control, answer each state with a command, and return control. */
static void fly(uint16_t velocity, uint16_t command, const float wanted[4], double seconds,
                double height) {
    struct {
        uint32_t lease, axes;
        float v[4];
    } asked = {0, 15, {0}};
    double wait = height > 0 ? TAKE_OFF_TIME : 0.25;
    int64_t begin = 0;
    char text[160];
    say("{\"op\":\"request_control\",\"id\":1,\"name\":\"example\"}");
    for (;;) {
        receive();
        if (frame.kind == CONTROL) {
            hear();
            if (has(frame.payload, "\"op\":\"request_control\"")) {
                asked.lease = (uint32_t)number(frame.payload, "\"lease\":");
            } else if (has(frame.payload, "\"op\":\"release_control\"") ||
                       has(frame.payload, "\"op\":\"bye\"")) {
                return;
            }
        } else if (asked.lease && frame.kind == DATA && frame.topic == velocity) {
            int first = begin == 0;
            if (first) begin = frame.t_ns;
            double age = 1e-9 * (double)(frame.t_ns - begin);
            if (age >= wait + seconds + 0.5) {
                snprintf(text, sizeof text, "{\"op\":\"release_control\",\"id\":3,\"lease\":%lu}",
                         (unsigned long)asked.lease);
                say(text);
                asked.lease = 0;
                continue;
            }
            int moving = age >= wait && age < wait + seconds;
            for (int i = 0; i < 4; i++) asked.v[i] = moving ? wanted[i] : 0.0f;
            send_frame(DATA, command, ++last_seq, frame.t_ns, &asked, sizeof asked);
            if (first && height > 0) {
                snprintf(text, sizeof text,
                         "{\"op\":\"flight\",\"id\":2,\"what\":\"take_off\",\"height\":%g,"
                         "\"lease\":%lu}",
                         height, (unsigned long)asked.lease);
                say(text);
            }
        }
    }
}

static void connect_to(const char *host, const char *port) {
    struct addrinfo hints = {0}, *found;
    hints.ai_socktype = SOCK_STREAM;
    if (getaddrinfo(host, port, &hints, &found)) fail("there is no such host");
    stream = socket(found->ai_family, found->ai_socktype, found->ai_protocol);
    if (stream < 0 || connect(stream, found->ai_addr, found->ai_addrlen)) fail("nobody listens there");
    freeaddrinfo(found);
}

int main(int count, char **words) {
    if (count < 4 || (strcmp(words[3], "watch") && (strcmp(words[3], "fly") || count < 8)))
        fail("usage: client HOST PORT watch [FRAMES]\n"
             "       client HOST PORT fly V_X V_Y V_Z YAW_RATE [SECONDS [TAKE_OFF_HEIGHT]]");
    connect_to(words[1], words[2]);
    receive();
    if (!has(frame.payload, "\"op\":\"hello\"")) hear();
    if (has(frame.payload, "\"login\":true")) fail("this server asks for a token: try client.py");
    uint16_t velocity = topic_number(frame.payload, "/dh_drone/velocity_data");
    uint16_t command = topic_number(frame.payload, "/dh_drone/command_velocity");
    say("{\"op\":\"subscribe\",\"topics\":[\"/dh_drone/velocity_data\"],\"rate\":20}");
    if (!strcmp(words[3], "watch")) {
        watch(velocity, count > 4 ? atol(words[4]) : -1);
    } else {
        float wanted[4];
        for (int i = 0; i < 4; i++) wanted[i] = strtof(words[4 + i], NULL);
        fly(velocity, command, wanted, count > 8 ? atof(words[8]) : 2.0,
            count > 9 ? atof(words[9]) : 0.0);
    }
    leave();
    return 0;
}
