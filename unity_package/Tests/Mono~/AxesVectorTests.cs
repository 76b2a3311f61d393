using System;
using System.IO;
using System.Linq;
using Ml2Sensors.Geometry;
using Newtonsoft.Json.Linq;
using NUnit.Framework;

namespace Ml2Sensors.Tests
{
    /// <summary>Conversions of the poses in tests/conformance/vectors/axes, which all languages read.</summary>
    [TestFixture]
    public sealed class AxesVectorTests
    {
        private static readonly JArray Cases =
            JArray.Parse(File.ReadAllText(Path.Combine(Environment.GetEnvironmentVariable("ML2_VECTORS"), "axes", "poses.json")));

        [Test]
        public void ToRos_Vectors_AreTheirBodyPoses() => ForEach("ml", "ros", (Pose<MlRub> pose) => pose.ToRos());

        [Test]
        public void ToRos_OfUnity_IsTheSameBodyPose() => ForEach("unity", "ros", (Pose<UnitySpace> pose) => pose.ToRos());

        [Test]
        public void ToUnity_Vectors_AreTheirUnityPoses() => ForEach("ml", "unity", (Pose<MlRub> pose) => pose.ToUnity());

        [Test]
        public void ToUnity_OfRos_IsTheSameUnityPose() => ForEach("ros", "unity", (Pose<Ros> pose) => pose.ToUnity());

        [Test]
        public void ToOpticalFrame_Vectors_AreTheirOpticalPoses() =>
            ForEach("ml", "optical", (Pose<MlRub> pose) => pose.ToOpticalFrame());

        [Test]
        public void Vectors_ThroughEverySystem_ComeBack()
        {
            var v = new Vector3<Optical>(1, 2, 3);
            AssertClose(new double[] { 1, 2, 3 }, Components(v.ToUnity().ToMl().ToRos().ToOptical()));
        }

        [Test]
        public void Rotation_OfZero_Throws() =>
            Assert.Throws<InvalidOperationException>(() => new Rotation<MlRub>(0, 0, 0, 0).ToRos().ToString());

        private static void ForEach<TFrom, TTo>(string from, string to, Func<Pose<TFrom>, Pose<TTo>> convert)
            where TFrom : struct where TTo : struct
        {
            Assert.Greater(Cases.Count, 20);
            foreach (JToken one in Cases)
            {
                Pose<TTo> actual = convert(PoseOf<TFrom>(one[from]));
                AssertClose(Numbers(one[to]["position"]), Components(actual.Position));
                double[] expected = Numbers(one[to]["rotation"]);
                double[] found = { actual.Rotation.X, actual.Rotation.Y, actual.Rotation.Z, actual.Rotation.W };
                double sign = Math.Sign(expected.Zip(found, (a, b) => a * b).Sum());
                AssertClose(expected, found.Select(value => sign * value).ToArray());
            }
        }

        private static Pose<T> PoseOf<T>(JToken pose) where T : struct
        {
            double[] p = Numbers(pose["position"]);
            double[] q = Numbers(pose["rotation"]);
            return new Pose<T>(new Vector3<T>(p[0], p[1], p[2]), new Rotation<T>(q[0], q[1], q[2], q[3]));
        }

        private static double[] Numbers(JToken array) => array.Select(value => (double)value).ToArray();

        private static double[] Components<T>(Vector3<T> v) where T : struct => new[] { v.X, v.Y, v.Z };

        private static void AssertClose(double[] expected, double[] actual)
        {
            for (int i = 0; i < expected.Length; i++) Assert.AreEqual(expected[i], actual[i], 1e-12);
        }
    }
}
