// Saves what the headset sends at present, as the zip file that the server makes of it.
export class Snapshot {
  #button = document.getElementById("snapshot");

  constructor(ask) {
    this.#button.onclick = () => {
      if (this.#button.hasAttribute("aria-busy")) return;
      this.#button.setAttribute("aria-busy", "true");
      ask({ snapshot: true });
    };
  }

  // Forgets a request that a lost connection leaves without an answer.
  reset() {
    this.#button.removeAttribute("aria-busy");
  }

  save(bytes) {
    this.reset();
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([bytes], { type: "application/zip" }));
    link.download = `ml2-snapshot-${new Date().toISOString().slice(0, 19).replaceAll(":", "-")}.zip`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }
}
