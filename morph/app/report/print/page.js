"use strict";
(() => {
  const solids = JSON.parse(document.getElementById("solids").textContent);
  const place = document.getElementById("shape");
  const apart = document.getElementById("apart");
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

  function traces() {
    const share = Number(apart.value) / 100;
    return solids.map((s) => ({
      type: "mesh3d",
      x: s.x.map((v) => v + share * s.moved[0]),
      y: s.y.map((v) => v + share * s.moved[1]),
      z: s.z.map((v) => v + share * s.moved[2]),
      i: s.i, j: s.j, k: s.k,
      color: colour(s.kind === "bought" ? "quiet" : "corrected"),
      opacity: s.kind === "bought" ? 0.55 : 1,
      flatshading: true, hoverinfo: "skip",
      lighting: { ambient: 0.55, diffuse: 0.7, specular: 0.1 },
    }));
  }

  const layout = {
    scene: {
      xaxis: { visible: false }, yaxis: { visible: false }, zaxis: { visible: false },
      aspectmode: "data", camera: { eye: { x: 1.1, y: -1.5, z: 0.8 } },
    },
    margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false, uirevision: "same",
  };

  function draw() {
    Plotly.react(place, traces(), layout, { responsive: true, displayModeBar: false });
  }
  apart.addEventListener("input", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
})();
