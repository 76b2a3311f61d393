namespace Ml2Sensors.Messages
{
    /// <summary>A message that begins with a header, whose stamp Ml2Publisher writes.</summary>
    public interface IStamped
    {
        /// <summary>The one that it begins with.</summary>
        HeaderMsg Header { get; }
    }
}
