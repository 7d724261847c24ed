"use strict";
// Puts plotly's figures in the place of the drawn ones. Where anything fails, the drawn ones stay.
(async () => {
  const packed = document.getElementById("plotly");
  const bytes = Uint8Array.from(atob(packed.textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const library = document.createElement("script");
  library.textContent = await new Response(stream).text();
  document.head.append(library);

  // A finger that moves over a figure scrolls the page.
  const touch = matchMedia("(pointer: coarse)").matches;
  const config = {
    responsive: true,
    displaylogo: false,
    displayModeBar: touch ? false : "hover",
    // Named one by one: among plotly's own choice is one that sends the figure to its makers.
    modeBarButtons: [["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]],
    plotlyServerURL: "",
    toImageButtonOptions: { format: "svg" },
  };

  const plotsOf = (group) =>
    [...group.querySelectorAll(".drawn .live")].filter((plot) => plot.data);

  // The traces of one legend entry, in every figure of the channel.
  function toggle(group, entry, hide) {
    for (const plot of plotsOf(group)) {
      const places = plot.data.flatMap((trace, i) => (trace.legendgroup === entry ? [i] : []));
      if (places.length) Plotly.restyle(plot, { visible: hide ? "legendonly" : true }, places);
    }
  }

  function setAxis(group, axis, type) {
    for (const plot of plotsOf(group)) {
      const change = { [axis + ".type"]: type };
      if (type === "log") change[axis + ".range"] = plot.ranges[axis];
      else change[axis + ".autorange"] = true;
      Plotly.relayout(plot, change);
    }
  }

  // Every trace with a `meta` belongs to one of the models.
  function setModel(group, models) {
    for (const plot of plotsOf(group)) {
      plot.data.forEach((trace, i) => {
        if (!trace.meta) return;
        Plotly.restyle(plot, { visible: models.includes(trace.meta) ? true : "legendonly" }, [i]);
      });
    }
  }

  async function drawOne(group, plot) {
    const figure = JSON.parse(plot.querySelector("script").textContent);
    plot.ranges = { xaxis: figure.layout.xaxis.range, yaxis: figure.layout.yaxis.range.slice() };
    plot.ranges.xaxis = plot.ranges.xaxis.slice();
    figure.layout.dragmode = touch ? false : "zoom";
    // Plotly takes its size from an element that is seen.
    plot.parentElement.classList.add("drawn");
    await Plotly.newPlot(plot, figure.data, figure.layout, config);
    plot.on("plotly_legendclick", (click) => {
      const trace = plot.data[click.curveNumber];
      toggle(group, trace.legendgroup, trace.visible !== "legendonly");
      return false;
    });
    plot.on("plotly_legenddoubleclick", () => false);
    group.classList.add("answers");
  }

  async function draw(group) {
    for (const plot of group.querySelectorAll(".live")) {
      try {
        await drawOne(group, plot);
      } catch (error) {
        plot.parentElement.classList.remove("drawn");
        console.error(error);
      }
    }
  }

  document.addEventListener("click", (event) => {
    const button = event.target.closest(".switches button");
    if (!button) return;
    const group = button.closest(".interactive");
    if (button.dataset.axis) setAxis(group, button.dataset.axis, button.dataset.type);
    else setModel(group, button.dataset.models.split(" "));
    for (const other of button.parentElement.querySelectorAll("button")) {
      other.setAttribute("aria-pressed", String(other === button));
    }
  });

  // Many channels cost nothing until they are scrolled to.
  const watch = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) {
        if (!entry.isIntersecting) continue;
        watch.unobserve(entry.target);
        draw(entry.target);
      }
    },
    { rootMargin: "300px" },
  );
  document.querySelectorAll(".interactive").forEach((group) => watch.observe(group));
})();
