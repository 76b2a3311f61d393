using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using NUnit.Framework;

namespace Ml2Sensors.Tests
{
    /// <summary>Compares the public types and members with the list in Api~.</summary>
    public sealed class PublicApiTests
    {
        private const BindingFlags Declared =
            BindingFlags.Public | BindingFlags.NonPublic | BindingFlags.Instance | BindingFlags.Static | BindingFlags.DeclaredOnly;

        [Test]
        public void Runtime_Public_IsCommitted()
        {
            string file = Environment.GetEnvironmentVariable("ML2_PUBLIC_API");
            IEnumerable<string> lines = new[] { typeof(Ml2SensorStreamer), typeof(RosTcp.ROSConnection) }
                .SelectMany(type => type.Assembly.GetExportedTypes())
                .OrderBy(type => type.FullName, StringComparer.Ordinal).SelectMany(Describe);
            string found = string.Concat(lines.Select(line => line + "\n"));
            if (Environment.GetEnvironmentVariable("REWRITE_API") != null) File.WriteAllText(file, found);
            Assert.AreEqual(File.ReadAllText(file), found, $"{file}: `make api` rewrites it");
        }

        private static IEnumerable<string> Describe(Type type)
        {
            IEnumerable<string> parents = new[] { type.BaseType }.Concat(type.GetInterfaces())
                .Where(parent => parent != null && parent.IsVisible).Select(parent => parent.ToString());
            yield return $"{type} : {string.Join(", ", parents)}";
            IEnumerable<string> members = type.GetMembers(Declared).Where(IsVisible).Select(Describe);
            foreach (string line in members.OrderBy(line => line, StringComparer.Ordinal)) yield return "  " + line;
        }

        private static string Describe(MemberInfo member)
        {
            var field = member as FieldInfo;
            string shared = (field?.IsStatic ?? ((MethodBase)member).IsStatic) ? "static " : "";
            string value = field?.IsLiteral == true ? $" = {field.GetRawConstantValue()}" : "";
            return shared + member + value;
        }

        /// <summary>Returns true for public members. Properties and events are listed by their accessors.</summary>
        private static bool IsVisible(MemberInfo member)
        {
            if (member is FieldInfo field) return field.IsPublic || field.IsFamily;
            return member is MethodBase method && (method.IsPublic || method.IsFamily);
        }
    }
}
