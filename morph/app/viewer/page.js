// Tells the server which control of the panel the pointer or the keyboard is at: viser's own
// controls have no such event. The number of the control goes into a text field that the server
// labels "pointed at" and hides. Nothing from a file is read as script or as HTML.
(() => {
  "use strict";
  let told = "";

  // A control and its label stand in one row; the label names the control by its number.
  const numberOf = (element) => {
    for (let node = element; node && node !== document.body; node = node.parentElement) {
      const labels = node.querySelectorAll("label[for]");
      if (labels.length > 1) return "";
      if (labels.length === 1) return labels[0].htmlFor;
    }
    return "";
  };

  const field = () => {
    for (const label of document.querySelectorAll("label[for]")) {
      if (label.textContent === "pointed at") {
        for (let node = label; node; node = node.parentElement) {
          const input = node.querySelector("input");
          if (input) return input;
        }
      }
    }
    return null;
  };

  const tell = (number) => {
    if (number === told) return;
    const input = field();
    if (!input) return;
    told = number;
    // React listens to what the browser's own setter is followed by.
    const own = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value");
    own.set.call(input, number);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  };

  const at = (event) =>
    tell(event.target instanceof Element ? numberOf(event.target) : "");
  document.addEventListener("mouseover", at, { passive: true });
  document.addEventListener("focusin", at, { passive: true });
  document.documentElement.addEventListener("mouseleave", () => tell(""), { passive: true });
})();

// The arrows to the sides step the clock, and with shift the others set its speed. viser's camera would turn by them, too: it listens at
// the document, which is reached after the element that its hotkeys listen at.
document.documentElement.addEventListener("keydown", (event) => {
  const sideways = event.key === "ArrowLeft" || event.key === "ArrowRight";
  const upright = event.key === "ArrowUp" || event.key === "ArrowDown";
  if (sideways || (upright && event.shiftKey)) event.stopPropagation();
});
