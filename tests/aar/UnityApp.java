import dev.ml2sensors.capture.NativeHeadsetClock;
import dev.ml2sensors.capture.NativeLibrary;
import dev.ml2sensors.cdr.Cdr;
import dev.ml2sensors.message.Header;
import dev.ml2sensors.message.Time;
import java.nio.file.Path;
import java.util.HexFormat;

/** Uses native methods and serialization, without Kotlin on the class path. The argument is libml2sensors.so. */
class UnityApp {
    public static void main(String[] arguments) {
        NativeLibrary.INSTANCE.load(Path.of(arguments[0]));
        var stamp = Time.Companion.ofNanos(1_700_000_000_123_456_789L);
        var header = new Header(stamp, "world_left_optical_frame");
        System.out.println(NativeHeadsetClock.INSTANCE.nowNanos());
        System.out.println(HexFormat.of().formatHex(Cdr.INSTANCE.encodeToByteArray(Header.Companion.serializer(), header)));
    }
}
