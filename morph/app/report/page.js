"use strict";
(() => {
  const data = JSON.parse(document.getElementById("plots").textContent);
  const select = document.getElementById("episode");
  const boxes = [...document.querySelectorAll("[data-model]")];
  const dashes = { nominal: "dash", refitted: "dot", corrected: "solid", corrected_plus_residual: "dashdot" };
  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim() ||
    getComputedStyle(document.documentElement).getPropertyValue("--quiet").trim();

  function traces(curve) {
    const drawn = [];
    for (const box of boxes) {
      const index = Number(box.dataset.model);
      const values = index < 0 ? curve.measured : curve.models[index];
      if (!box.checked || !values) continue;
      const name = box.parentElement.textContent.trim();
      const key = box.dataset.key;
      const look = index < 0
        ? { mode: "markers", marker: { size: 3, color: colour("measured"), opacity: 0.6 } }
        : { mode: "lines", line: { width: 2, color: colour(key), dash: dashes[key] || "longdash" } };
      // Names of models are the page's own; nothing from a file is handed to plotly as text.
      drawn.push({ x: curve.time, y: values, name, ...look });
      if (index < 0) continue;
      const error = values.map((v, i) => (v === null || curve.measured[i] === null ? null : v - curve.measured[i]));
      drawn.push({ x: curve.time, y: error, name, yaxis: "y2", ...look });
    }
    return drawn;
  }

  function layout(curve) {
    const axis = { gridcolor: colour("rule"), zerolinecolor: colour("rule"), linecolor: colour("rule"), automargin: true };
    const font = { color: colour("quiet"), family: "inherit", size: 12 };
    return {
      font, showlegend: false, dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom", hovermode: "x", margin: { l: 56, r: 8, t: 8, b: 36 },
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      xaxis: { ...axis, title: { text: "time in the run, s" }, anchor: "y2" },
      yaxis: { ...axis, domain: [0.4, 1], range: curve.range || undefined },
      yaxis2: { ...axis, domain: [0, 0.3], range: curve.error_range || undefined, title: { text: "error" } },
    };
  }

  function draw() {
    for (const place of document.querySelectorAll(".plot")) {
      const curve = data.curves.find(
        (c) => c.episode === Number(select.value) && c.channel === Number(place.dataset.channel));
      place.parentElement.hidden = !curve;
      if (curve) Plotly.react(place, traces(curve), layout(curve), { responsive: true, displayModeBar: false });
    }
  }

  select.addEventListener("change", draw);
  boxes.forEach((box) => box.addEventListener("change", draw));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
})();
