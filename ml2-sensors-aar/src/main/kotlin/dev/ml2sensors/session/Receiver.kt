package dev.ml2sensors.session

import java.io.IOException

/** A receiver to stream to: a [ReceiverAddress], or one that is looked for by name. */
public interface Receiver {
    /**
     * Where it listens now; asked anew for every connection, from any thread.
     *
     * @throws IOException when it is not found, with what was found instead.
     */
    public suspend fun locate(): ReceiverAddress

    public companion object {
        /**
         * The receiver that announces itself by [name], as [browser] sees it; without a name the only one there is.
         * Several make a nameless search fail, with their names.
         */
        public fun discover(browser: ReceiverBrowser, name: String? = null): Receiver =
            DiscoveredReceiver(browser, name)
    }
}
