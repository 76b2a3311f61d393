using System.Collections.Generic;

namespace Ml2Sensors
{
    /// <summary>What the stream table says of a stream.</summary>
    public sealed class StreamRow
    {
        /// <summary>As topics and CONFIGURE name it, such as "world_left".</summary>
        public readonly string Id;

        /// <summary>Of config.yaml.</summary>
        public readonly string Section;

        /// <summary>Of the images, as ROS writes it, such as "mono8"; empty for what is no image.</summary>
        public readonly string Encoding;

        /// <summary>Android's, which the app must declare.</summary>
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
