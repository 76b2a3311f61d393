// Measures the simulated device alone in the capture benchmark: gets and gives back frames of the three world cameras,
// looks at none, and prints the CPU time of one in microseconds. Linked against the simulated libperception.
#include <stdio.h>
#include <time.h>

#include "../../native/sdk/ml_perception.h"
#include "../../native/sdk/ml_world_camera.h"

enum { FRAMES = 900 };

static double cpu_seconds(void) {
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + (double)time.tv_nsec / 1e9;
}

int main(void) {
    MLWorldCameraSettings settings;
    MLWorldCameraSettingsInit(&settings);
    MLHandle camera;
    if (MLWorldCameraConnect(&settings, &camera)) {
        return 1;
    }
    double begin = cpu_seconds();
    int frames = 0;
    while (frames < FRAMES) {
        MLWorldCameraData data, *got = &data;
        MLWorldCameraDataInit(&data);
        MLResult result = MLWorldCameraGetLatestWorldCameraData(camera, 1000, &got);
        if (result != MLResult_Ok) {
            return 1;
        }
        frames += data.frame_count;
        MLWorldCameraReleaseCameraData(camera, got);
    }
    printf("%.1f\n", (cpu_seconds() - begin) * 1e6 / frames);
    return MLWorldCameraDisconnect(camera) != MLResult_Ok;
}
