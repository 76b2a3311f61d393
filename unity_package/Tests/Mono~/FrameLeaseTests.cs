using System;
using System.Linq;
using Ml2Sensors.Interop;
using NUnit.Framework;

namespace Ml2Sensors.Tests
{
    /// <summary>Tests FrameLease on the native library, with frames that the test writes.</summary>
    [TestFixture]
    public sealed class FrameLeaseTests
    {
        private const StreamId Stream = StreamId.WorldLeft;
        private NativeSlots _slots;

        [SetUp]
        public void SetUp() => _slots = new NativeSlots(Stream);

        [TearDown]
        public void TearDown() => _slots.Dispose();

        [Test]
        public void TryAcquire_NothingCaptured_IsFalse()
        {
            using (var lease = new FrameLease(Stream))
            {
                Assert.IsFalse(lease.TryAcquire());
                Assert.Throws<InvalidOperationException>(() => lease.Pixels.ToString());
            }
        }

        [Test]
        public void TryAcquire_FrameCaptured_HasItsBytesSizeAndTime()
        {
            _slots.Publish(42, new byte[] { 1, 2, 3, 4, 5, 6 }, 3, 2, 3);
            using (var lease = new FrameLease(Stream))
            {
                Assert.IsTrue(lease.TryAcquire());
                Assert.AreEqual(42, lease.CaptureNanos);
                Assert.AreEqual(new[] { 3, 2, 3 }, new[] { lease.Width, lease.Height, lease.RowBytes });
                var pixels = lease.Pixels;
                Assert.AreEqual(new[] { 1, 2, 3, 4, 5, 6 }, Enumerable.Range(0, pixels.Length).Select(i => (int)pixels[i]).ToArray());
                Assert.IsNull(lease.Pose);
            }
        }

        [Test]
        public void TryAcquire_SeveralCaptured_TakesTheLatestAndEachOnce()
        {
            _slots.Publish(1, new byte[1]);
            _slots.Publish(2, new byte[1]);
            using (var lease = new FrameLease(Stream))
            {
                Assert.IsTrue(lease.TryAcquire());
                Assert.AreEqual(2, lease.CaptureNanos);
                Assert.IsFalse(lease.TryAcquire());
                Assert.IsTrue(lease.IsInvalid);
            }
        }

        [Test]
        public void Release_Twice_GivesBackOnce()
        {
            _slots.Publish(1, new byte[1]);
            using (var other = new FrameLease(Stream))
            using (var lease = new FrameLease(Stream))
            {
                Assert.IsTrue(other.TryAcquire());
                Assert.IsTrue(lease.TryAcquire());
                lease.Release();
                lease.Release();
                lease.Dispose();
                Assert.Throws<InvalidOperationException>(_slots.Dispose, "the other reader's lease was given back");
            }
        }

        [Test]
        public void TryAcquire_AfterDispose_Throws()
        {
            var lease = new FrameLease(Stream);
            lease.Dispose();
            Assert.Throws<ObjectDisposedException>(() => lease.TryAcquire());
        }

        [Test]
        public void Finaliser_LeaseForgotten_GivesBack()
        {
            _slots.Publish(1, new byte[1]);
            var thread = new System.Threading.Thread(() => new FrameLease(Stream).TryAcquire()); // its stack goes with it
            thread.Start();
            thread.Join();
            GC.Collect();
            GC.WaitForPendingFinalizers();
            Assert.DoesNotThrow(() => _slots.Dispose());
            _slots = new NativeSlots(Stream);
        }
    }
}
