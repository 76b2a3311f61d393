// Starts the page, and says so if a file of it does not arrive.
import("./main.js").catch((error) => {
  document.getElementById("notice").textContent = `The page could not start (${error.message}). Reload it.`;
});
