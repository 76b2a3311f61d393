using System;
using System.Linq;
using Ml2Sensors.Geometry;
using Ml2Sensors.Interop;
using NUnit.Framework;
using UnityEngine;

namespace Ml2Sensors.Tests
{
    /// <summary>Tests frames of the simulated headset, from the native library to the texture.</summary>
    [TestFixture]
    public sealed class SimulatedFramesTests
    {
        private const long FrameNanos = 1000000000 / 30;

        [SetUp]
        public void SetUp() => Simulation.Begin();

        [TearDown]
        public void TearDown() => Simulation.AssertNothingLeaked();

        [Test]
        public void WorldCamera_OneCapture_ShowsThePictureThatTheLibraryHas()
        {
            using (new NativeSlots(StreamId.WorldLeft))
            using (var world = new NativeSensor(NativeSensor.World, StreamId.WorldLeft))
            using (var shown = new CameraTextureScene(StreamId.WorldLeft))
            using (var lease = new FrameLease(StreamId.WorldLeft))
            {
                CaptureOnce(world);
                shown.Update();
                Assert.IsTrue(lease.TryAcquire());
                Texture2D texture = shown.Texture;
                Assert.AreEqual(new[] { 1016, 1016 }, new[] { texture.width, texture.height });
                Assert.AreEqual(TextureFormat.R8, texture.format);
                var pixels = lease.Pixels;
                for (int row = 0; row < 1016; row += 7)
                    for (int x = 0; x < 1016; x += 13)
                        Assert.AreEqual(pixels[row * 1016 + x], texture.Raw[(1015 - row) * 1016 + x], "upright in Unity");
                Assert.Greater(texture.Raw.Distinct().Count(), 50, "a rendered scene has many grey values");
                Pose pose = shown.Component.CameraPose.Value;
                Pose<UnitySpace> expected = lease.Pose.Value.ToUnity();
                Assert.AreEqual((float)expected.Position.Z, pose.position.z);
                Assert.AreEqual((float)expected.Rotation.W, pose.rotation.w);
                CameraIntrinsics lens = shown.Component.Intrinsics.Value;
                Assert.AreEqual(LensModel.FisheyeTangential, lens.Distortion.Model);
                Assert.AreEqual(1016, lens.Width);
                Assert.That(lens.Cx, Is.InRange(400, 600));
                Assert.That(lens.Fx, Is.InRange(200, 900));
            }
        }

        [Test]
        public void Depth_OneCapture_IsMetresOfTheRoom()
        {
            using (new NativeSlots(StreamId.Depth))
            using (var depth = new NativeSensor(NativeSensor.Depth, StreamId.Depth))
            using (var shown = new CameraTextureScene(StreamId.Depth))
            {
                CaptureOnce(depth);
                shown.Update();
                Assert.AreEqual(TextureFormat.RFloat, shown.Texture.format);
                var metres = new float[544 * 480];
                Buffer.BlockCopy(shown.Texture.Raw, 0, metres, 0, shown.Texture.Raw.Length);
                float[] valid = metres.Where(z => !float.IsNaN(z)).ToArray();
                Assert.Greater(valid.Length, 1000);
                Assert.Greater(valid.Min(), 0.1f);
                Assert.Less(valid.Max(), 10f);
            }
        }

        [Test]
        public void Update_TenThousandFrames_LeaksNothingAndMakesNoGarbage()
        {
            using (new NativeSlots(StreamId.EyeNasalLeft))
            using (var eye = new NativeSensor(NativeSensor.Eye, StreamId.EyeNasalLeft))
            using (var shown = new CameraTextureScene(StreamId.EyeNasalLeft))
            {
                Action update = shown.Component.Bind("Update");
                for (int i = 0; i < 10; i++) Step(eye, update);
                int applied = shown.Texture.Applied;
                long before = GC.GetAllocatedBytesForCurrentThread();
                for (int i = 0; i < 10000; i++) Step(eye, update);
                Assert.AreEqual(0, GC.GetAllocatedBytesForCurrentThread() - before, "bytes of garbage");
                Assert.AreEqual(10000, shown.Texture.Applied - applied, "frames shown");
            }
        }

        [Test]
        public void Update_FrameShown_IsGivenBackAtOnce()
        {
            using (var shown = new CameraTextureScene(StreamId.WorldLeft))
            {
                var slots = new NativeSlots(StreamId.WorldLeft);
                slots.Publish(1, new byte[4], 2, 2, 2);
                shown.Update();
                Assert.AreEqual(1, shown.Texture.Applied);
                Assert.DoesNotThrow(slots.Dispose, "a slot is still leased");
            }
        }

        [Test]
        public void Update_RowsWithPadding_AreShownWithoutItAndUpright()
        {
            using (var shown = new CameraTextureScene(StreamId.WorldLeft))
            using (var slots = new NativeSlots(StreamId.WorldLeft))
            {
                slots.Publish(1, new byte[] { 1, 2, 99, 3, 4 }, 2, 2, 3);
                shown.Update();
                Assert.AreEqual(new byte[] { 3, 4, 1, 2 }, shown.Texture.Raw);
            }
        }

        [Test]
        public void Update_FewerBytesThanRows_ThrowsAndGivesTheFrameBack()
        {
            using (var shown = new CameraTextureScene(StreamId.WorldLeft))
            {
                var slots = new NativeSlots(StreamId.WorldLeft);
                slots.Publish(1, new byte[4], 2, 2, 3);
                Assert.Throws<NotSupportedException>(shown.Update);
                Assert.DoesNotThrow(slots.Dispose, "a slot is still leased");
            }
        }

        [Test]
        public void Update_Jpeg_IsDecodedFromABufferThatIsKept()
        {
            using (var shown = new CameraTextureScene(StreamId.Color))
            using (var slots = new NativeSlots(StreamId.Color))
            {
                slots.Publish(1, new byte[] { 0xff, 0xd8, 3, 4 }, 640, 480);
                shown.Update();
                byte[] first = shown.Texture.Jpeg;
                slots.Publish(2, new byte[] { 0xff, 0xd8, 5 }, 640, 480);
                shown.Update();
                Assert.AreSame(first, shown.Texture.Jpeg);
                Assert.Greater(shown.Component.DecodeMilliseconds, 0);
                Assert.IsNull(shown.Component.CameraPose);
                Assert.IsNull(shown.Component.Intrinsics);
                Assert.AreEqual(5, first[2]);
            }
        }

        [Test]
        public unsafe void Update_FrameWithPosesAndLens_ShowsThemInUnitysAxes()
        {
            using (var shown = new CameraTextureScene(StreamId.Color))
            using (var slots = new NativeSlots(StreamId.Color))
            {
                NativeFrame frame = NativeFrame.Sized();
                frame.Has = FrameFields.Pose | FrameFields.Intrinsics | FrameFields.HeadPose;
                frame.Position[2] = -3;
                frame.Rotation[3] = 1;
                frame.HeadPosition[0] = 1;
                frame.HeadPosition[2] = -2;
                frame.HeadRotation[1] = 1;
                frame.FocalLength[0] = 500;
                slots.Publish(1, new byte[] { 0xff, 0xd8, 3, 4 }, frame, 640, 480);
                shown.Update();
                Assert.AreEqual(3, shown.Component.CameraPose.Value.position.z);
                Assert.AreEqual(1, shown.Component.HeadPose.Value.position.x);
                Assert.AreEqual(2, shown.Component.HeadPose.Value.position.z);
                Assert.AreEqual(1, Math.Abs(shown.Component.HeadPose.Value.rotation.y));
                Assert.AreEqual(500, shown.Component.Intrinsics.Value.Fx);
                slots.Publish(2, new byte[] { 0xff, 0xd8, 3, 4 }, 640, 480);
                shown.Update();
                Assert.IsNull(shown.Component.HeadPose);
                Assert.IsNull(shown.Component.CameraPose);
            }
        }

        private static void CaptureOnce(NativeSensor sensor)
        {
            int count = 0;
            for (int i = 0; i < 100 && count == 0; i++)
            {
                Simulation.Advance(FrameNanos);
                count = sensor.Capture();
            }
            Assert.AreEqual(1, count);
        }

        private static void Step(NativeSensor sensor, Action update)
        {
            Simulation.Advance(FrameNanos + 1000);
            sensor.Capture();
            update();
        }
    }
}
