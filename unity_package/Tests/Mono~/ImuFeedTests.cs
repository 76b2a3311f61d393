using System;
using System.Collections.Generic;
using NUnit.Framework;
using UnityEngine;

namespace Ml2Sensors.Tests
{
    [TestFixture]
    public sealed class ImuFeedTests
    {
        [Test]
        public void Update_OverlappingBatches_GivesEachSampleOnceAndInOrder()
        {
            var scene = new GameObject("scene");
            var streamer = scene.AddComponent<Ml2SensorStreamer>();
            streamer.OpenBridge = changed => new ScriptedBridge(changed);
            var feed = scene.AddComponent<Ml2ImuFeed>();
            feed.Read(streamer, StreamId.GyroLeft);
            var found = new List<double>();
            feed.Sampled += sample => found.Add(sample.CaptureNanos + sample.Value.Z / 10);
            using (var slots = new NativeSlots(StreamId.GyroLeft))
            {
                feed.enabled = true;
                slots.Publish(2, Batch(1, 2));
                feed.Send("Update");
                feed.Send("Update");
                slots.Publish(4, Batch(2, 3, 4));
                feed.Send("Update");
                feed.enabled = false;
            }
            Assert.AreEqual(new[] { 1.1, 2.2, 3.3, 4.4 }, found.ToArray());
        }

        [Test]
        public void Read_StreamThatIsNoImu_Throws() =>
            Assert.Throws<ArgumentException>(() => new Ml2ImuFeed().Read(null, StreamId.Depth));

        /// <summary>Samples with their time as z.</summary>
        private static byte[] Batch(params long[] captureNanos)
        {
            var bytes = new byte[32 * captureNanos.Length];
            for (int i = 0; i < captureNanos.Length; i++)
            {
                BitConverter.GetBytes(captureNanos[i]).CopyTo(bytes, 32 * i);
                BitConverter.GetBytes((double)captureNanos[i]).CopyTo(bytes, 32 * i + 24);
            }
            return bytes;
        }
    }
}
