// Image, pose and time of the depth camera agree: its points are on the walls.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <unistd.h>

#include "cameras_fixture.h"

/** Pixels to points of the world, by the frame's own intrinsics and pose and nothing of the simulator's. */
class DepthPoints : public Cameras<DepthPort> {
  protected:
    struct Wall {
        double normal[3];
        double offset_m;
    };

    static std::vector<Wall> walls() {
        std::vector<Wall> out;
        const std::string text = ml2sim_landmarks();
        for (size_t at = text.find("\"walls\""); (at = text.find("{\"normal", at)) != std::string::npos; at++) {
            Wall wall;
            auto *n = wall.normal;
            EXPECT_EQ(std::sscanf(text.c_str() + at, "{\"normal\": [%lf, %lf, %lf], \"offset_m\": %lf", n, n + 1, n + 2,
                                  &wall.offset_m),
                      4);
            out.push_back(wall);
        }
        return out;
    }

    /** The ray of a pixel, in camera axes, by fixed-point inversion of the plumb bob model. */
    static void rayOf(const MLDepthCameraIntrinsics &lens, double u, double v, double out[3]) {
        const double *d = lens.distortion;
        const double bentX = (u - lens.principal_point.x) / lens.focal_length.x;
        const double bentY = (v - lens.principal_point.y) / lens.focal_length.y;
        double x = bentX, y = bentY;
        for (int i = 0; i < 30; i++) {
            const double q = x * x + y * y, radial = 1 + q * (d[0] + q * (d[1] + q * d[4]));
            const double nextX = (bentX - 2 * d[2] * x * y - d[3] * (q + 2 * x * x)) / radial;
            y = (bentY - d[2] * (q + 2 * y * y) - 2 * d[3] * x * y) / radial;
            x = nextX;
        }
        const double length = std::sqrt(x * x + y * y + 1);
        out[0] = x / length;
        out[1] = -y / length;
        out[2] = -1 / length;
    }

    static void toWorld(const MLTransform &pose, const double ray[3], double distance, double out[3]) {
        const double q[3] = {pose.rotation.x, pose.rotation.y, pose.rotation.z}, w = pose.rotation.w;
        const double p[3] = {pose.position.x, pose.position.y, pose.position.z};
        double t[3], u[3];
        cross(q, ray, t);
        cross(q, t, u);
        for (int i = 0; i < 3; i++)
            out[i] = p[i] + distance * (ray[i] + 2 * w * t[i] + 2 * u[i]);
    }
    static void cross(const double a[3], const double b[3], double out[3]) {
        for (int i = 0; i < 3; i++)
            out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }

    static double toNearestWall(const std::vector<Wall> &walls, const double point[3]) {
        double nearest = 1e9;
        for (const auto &wall : walls) {
            double along = -wall.offset_m;
            for (int i = 0; i < 3; i++)
                along += wall.normal[i] * point[i];
            nearest = std::min(nearest, std::abs(along));
        }
        return nearest;
    }

    /** Boxes stand before the walls, so not every point is on one. */
    void expectMostPointsOnWalls(int64_t afterNanos) {
        getLongRange(afterNanos);
        const auto &frame = data.frames[0];
        const auto *distance = static_cast<const float *>(frame.depth_image->data);
        const auto *flags = static_cast<const uint32_t *>(frame.flags->data);
        const auto known = walls();
        ASSERT_EQ(known.size(), 6u);
        int points = 0, onWalls = 0;
        for (uint32_t v = 0; v < 480; v += 8) {
            for (uint32_t u = 0; u < 544; u += 8) {
                if (flags[v * 544 + u] != 0)
                    continue;
                double ray[3], point[3];
                rayOf(frame.intrinsics, u, v, ray);
                toWorld(frame.camera_pose, ray, distance[v * 544 + u], point);
                points++;
                onWalls += toNearestWall(known, point) < 1e-3;
            }
        }
        EXPECT_GT(points, 2000);
        EXPECT_GT(onWalls, points / 2);
    }

    void getLongRange(int64_t afterNanos) {
        set("depth_noise_m", "0");
        auto settings = DepthPort::settings();
        settings.streams = MLDepthCameraStream_LongRange;
        settings.stream_configs[MLDepthCameraFrameType_LongRange].flags =
            MLDepthCameraFlags_DepthImage | MLDepthCameraFlags_DepthFlags;
        ASSERT_EQ(MLDepthCameraConnect(&settings, &handle), MLResult_Ok);
        ml2sim_advance(afterNanos);
        ASSERT_EQ(get(), MLResult_Ok);
    }
};

TEST_F(DepthPoints, AreOnTheWallsToAMillimetreOnALoop) { expectMostPointsOnWalls(700 * kMillisecond); }

TEST_F(DepthPoints, AreOnTheWallsOnAPathFromAFile) {
    const auto path = testing::TempDir() + "ml2sim_depth_path_" + std::to_string(getpid()) + ".tum";
    std::ofstream(path) << "0 0 0 0 0 0 0 1\n1 0.4 0.2 0 0 0 0.3 0.95\n2 0.9 0 0.1 0 0 0 1\n";
    set("trajectory", path.c_str());
    expectMostPointsOnWalls(2100 * kMillisecond);
    EXPECT_NE(data.frames[0].camera_pose.position.x, 0);
}

TEST_F(DepthPoints, AreOnTheWallsOfANewSession) {
    set("fault.head.new_session", "1");
    expectMostPointsOnWalls(700 * kMillisecond);
}
