import java.nio.file.Path;
import org.jetbrains.kotlin.buildtools.api.KotlinToolchains;
import org.jetbrains.kotlin.buildtools.api.jvm.JvmPlatformToolchain;

/**
 * {@code Abi CLASSES FILE}: writes what code that uses the compiled classes depends on, by the snapshots with which
 * Kotlin's Gradle plugin decides the same: signatures, constants and inline functions, but no other bodies.
 */
class Abi {
    public static void main(String[] arguments) throws Exception {
        var kotlin = KotlinToolchains.loadImplementation(Abi.class.getClassLoader());
        var classes = JvmPlatformToolchain.from(kotlin).classpathSnapshottingOperationBuilder(Path.of(arguments[0]));
        try (var session = kotlin.createBuildSession()) {
            session.executeOperation(classes.build()).saveSnapshot(Path.of(arguments[1]));
        }
    }
}
