#include "send_queue.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

// More than Android lets a process open.
#define MOST_FILES 65536

/** Port at the same place in sockaddr_in and sockaddr_in6: RFC 3493, 3.3, and POSIX. */
typedef struct {
    uint16_t family;
    uint8_t port[2];
    uint8_t rest[124];
} socket_address;

typedef int (*get_name)(int socket, struct sockaddr *address, socklen_t *length);

static bool has_port(int file, get_name get, jint port) {
    socket_address address = {.family = 0};
    socklen_t length = sizeof address;
    return !get(file, (struct sockaddr *)&address, &length) && length >= 4 &&
           (address.port[0] << 8 | address.port[1]) == port;
}

/** Returns how many bytes the peer has not acknowledged, tcp(7); -1 if the system does not tell. */
static jint unacknowledged(JNIEnv *env, jclass class, jint file) {
    (void)env, (void)class;
    int bytes = 0;
    return ioctl(file, TIOCOUTQ, &bytes) ? -1 : bytes;
}

/** Returns the file descriptor of the connection between two ports; -1 without one, or if its queue is not told. */
static jint find(JNIEnv *env, jclass class, jint local_port, jint remote_port) {
    for (int file = 0; file < MOST_FILES; file++) {
        if (has_port(file, getsockname, local_port) && has_port(file, getpeername, remote_port)) {
            return unacknowledged(env, class, file) < 0 ? -1 : file;
        }
    }
    return -1;
}

jint send_queue_register(JNIEnv *env) {
    static const JNINativeMethod methods[] = {
        {(char *)"find", (char *)"(II)I", (void *)find},
        {(char *)"unacknowledged", (char *)"(I)I", (void *)unacknowledged},
    };
    jclass class = (*env)->FindClass(env, "dev/ml2sensors/transport/SendQueue");
    return class ? (*env)->RegisterNatives(env, class, methods, sizeof methods / sizeof *methods) : JNI_ERR;
}
