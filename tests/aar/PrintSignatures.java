import java.io.FileInputStream;
import java.io.ObjectInputStream;
import java.util.zip.GZIPInputStream;
import org.codehaus.mojo.animal_sniffer.Clazz;

/** Prints a file of animal-sniffer's, one class a line: its name, parents and members, between tabs and spaces. */
class PrintSignatures {
    public static void main(String[] arguments) throws Exception {
        try (var in = new ObjectInputStream(new GZIPInputStream(new FileInputStream(arguments[0])))) {
            for (Clazz c; (c = (Clazz) in.readObject()) != null; ) {
                var parents = c.getSuperClass() + " " + String.join(" ", c.getSuperInterfaces());
                System.out.println(c.getName() + "\t" + parents + "\t" + String.join(" ", c.getSignatures()));
            }
        }
    }
}
