#include "send_queue.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

// Constants of Linux, whose headers not every toolchain has: include/uapi/linux/in.h, tcp.h, include/linux/socket.h.
#define TCP_LEVEL 6
#define TCP_NOT_SENT_LOWAT 25
#define INET 2
#define INET6 10

/** sockaddr_in and sockaddr_in6, RFC 3493, 3.3: the port is at the same place. */
typedef union {
    struct {
        uint16_t family;
        uint8_t port[2];
        uint8_t ipv4[4];
    };
    struct {
        uint8_t before_ipv6[8];
        uint8_t ipv6[16];
    };
    uint8_t storage[128];
} socket_address;

/** The address of one end of a connection; an IPv4 address is mapped (RFC 4291, 2.5.5.2). */
typedef struct {
    uint8_t address[16];
    jint port;
} end_point;

typedef int (*get_name)(int socket, struct sockaddr *address, socklen_t *length);

static void map_ipv4(const void *ipv4, uint8_t mapped[static 16]) {
    memset(mapped, 0, 10);
    memset(mapped + 10, 0xff, 2);
    memcpy(mapped + 12, ipv4, 4);
}

static bool end_of(int file, get_name get, end_point *end) {
    socket_address name = {.family = 0};
    socklen_t length = sizeof name;
    if (get(file, (struct sockaddr *)&name, &length))
        return false;
    if (name.family == INET) {
        map_ipv4(name.ipv4, end->address);
    } else if (name.family == INET6) {
        memcpy(end->address, name.ipv6, sizeof end->address);
    } else {
        return false;
    }
    end->port = name.port[0] << 8 | name.port[1];
    return true;
}

static end_point end_from(JNIEnv *env, jbyteArray address, jint port) {
    end_point end = {.port = port};
    jbyte bytes[16] = {0};
    const jsize length = (*env)->GetArrayLength(env, address);
    (*env)->GetByteArrayRegion(env, address, 0, length, bytes);
    if (length == 4) {
        map_ipv4(bytes, end.address);
    } else {
        memcpy(end.address, bytes, sizeof end.address);
    }
    return end;
}

static bool is(int file, get_name get, const end_point *expected) {
    end_point found;
    return end_of(file, get, &found) && found.port == expected->port &&
           !memcmp(found.address, expected->address, sizeof found.address);
}

/** Returns how many bytes the peer has not acknowledged, tcp(7); -1 if the system does not tell. */
static jint unacknowledged(JNIEnv *, jclass, jint file) {
    int bytes = 0;
    return ioctl(file, TIOCOUTQ, &bytes) ? -1 : bytes;
}

/** Has writes wait while that many bytes were not sent, TCP_NOTSENT_LOWAT; returns false if the system cannot. */
static jboolean limit_unsent(JNIEnv *, jclass, jint file, jint bytes) {
    return !setsockopt(file, TCP_LEVEL, TCP_NOT_SENT_LOWAT, &bytes, sizeof bytes);
}

/** Returns that of the open files which connects two addresses; -1 without one, or if its queue is not told. */
static jint find(JNIEnv *env, jclass class, jintArray files, jbyteArray local_address, jint local_port,
                 jbyteArray remote_address, jint remote_port) {
    const end_point local = end_from(env, local_address, local_port);
    const end_point remote = end_from(env, remote_address, remote_port);
    const jsize count = (*env)->GetArrayLength(env, files);
    for (jsize i = 0; i < count; i++) {
        jint file;
        (*env)->GetIntArrayRegion(env, files, i, 1, &file);
        if (is(file, getsockname, &local) && is(file, getpeername, &remote)) {
            return unacknowledged(env, class, file) < 0 ? -1 : file;
        }
    }
    return -1;
}

jint send_queue_register(JNIEnv *env) {
    static const JNINativeMethod methods[] = {
        {(char *)"find", (char *)"([I[BI[BI)I", (void *)find},
        {(char *)"limitUnsent", (char *)"(II)Z", (void *)limit_unsent},
        {(char *)"unacknowledged", (char *)"(I)I", (void *)unacknowledged},
    };
    jclass class = (*env)->FindClass(env, "dev/ml2sensors/transport/SendQueue");
    return class ? (*env)->RegisterNatives(env, class, methods, sizeof methods / sizeof *methods) : JNI_ERR;
}
