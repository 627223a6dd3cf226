// Keeps charts and tables in step with the player, and the player with clicks on them.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const frame = document.querySelector("iframe");
  const cells = document.querySelectorAll(".live");
  const inPlayer = (what) => frame.contentDocument && frame.contentDocument.querySelector(what);
  let shown = -1;

  function show(time) {
    shown = time;
    const share = data.seconds > 0 ? Math.min(time / data.seconds, 1) : 0;
    document.documentElement.style.setProperty("--morph-now", share.toFixed(4));
    const at = Math.max(0, Math.floor(time / data.step + 1e-6));
    cells.forEach((cell, number) => {
      const texts = data.live[number];
      const text = texts[Math.min(at, texts.length - 1)];
      if (cell.textContent !== text) cell.textContent = text;
    });
  }

  function follow() {
    const slider = inPlayer('[role="slider"]');
    const time = slider ? Number(slider.getAttribute("aria-valuenow")) : NaN;
    if (Number.isFinite(time) && time !== shown) show(time);
  }

  function jump(time) {
    const box = inPlayer('[role="slider"]') && inPlayer('input[inputmode="decimal"], input[type="text"]');
    if (!box) return;
    // The player would give the box the keyboard, and the next key were not for this page any more.
    box.focus = () => {};
    // As if it were typed: the player's own program listens to nothing else.
    const set = Object.getOwnPropertyDescriptor(frame.contentWindow.HTMLInputElement.prototype, "value").set;
    const there = Math.min(Math.max(time, 0), data.seconds);
    set.call(box, there.toFixed(3));
    box.dispatchEvent(new frame.contentWindow.Event("input", { bubbles: true }));
    // The next key counts from here, even if it comes before the player has gone there.
    show(there);
    setTimeout(follow, 50);
  }

  for (const chart of document.querySelectorAll("svg.chart")) {
    chart.addEventListener("click", (event) => {
      const box = chart.getBoundingClientRect();
      const share = ((event.clientX - box.left) / box.width - chart.dataset.left) / chart.dataset.wide;
      if (share > -0.02 && share < 1.02) jump(share * data.seconds);
    });
  }
  for (const button of document.querySelectorAll("button[data-time]")) {
    button.addEventListener("click", () => jump(Number(button.dataset.time)));
  }
  document.addEventListener("keydown", (event) => {
    if (event.key === " " && event.target.tagName !== "BUTTON" && frame.contentWindow) {
      event.preventDefault();
      frame.contentWindow.dispatchEvent(new frame.contentWindow.KeyboardEvent("keydown", { code: "Space" }));
    } else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
      jump(shown + (event.key === "ArrowRight" ? 1 : -1) * (event.shiftKey ? 1 : 1 / 30));
    }
  });
  setInterval(follow, 66);
})();
