using System.Collections.Generic;

namespace Ml2Sensors
{
    /// <summary>A stream's row of the stream table.</summary>
    public sealed class StreamRow
    {
        /// <summary>The id in topics and CONFIGURE, such as "world_left".</summary>
        public readonly string Id;

        /// <summary>The section of config.yaml.</summary>
        public readonly string Section;

        /// <summary>The ROS encoding of its images, such as "mono8"; empty for other streams.</summary>
        public readonly string Encoding;

        /// <summary>The Android permissions that the app must declare.</summary>
        public readonly IReadOnlyList<string> Permissions;

        internal StreamRow(string id, string section, string encoding, params string[] permissions)
        {
            Id = id;
            Section = section;
            Encoding = encoding;
            Permissions = permissions;
        }
    }
}
